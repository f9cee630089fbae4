"""Runs a program of CasADi's and says what it took."""

import os
import pathlib
import re
import tempfile
import time

import casadi
import numpy

# The library's own (docs/speed.md): tolerances, and a monotone barrier whose first value leaves a
# guess where it is; or one that follows the iterates, up to that value.
BARRIERS = {
    "adaptive": {
        "mu_strategy": "adaptive",
        "mu_max": 1e-2,
        "quality_function_max_section_steps": 4,
    },
    "monotone": {"mu_strategy": "monotone", "mu_init": 1e-2},
}
OPTIONS = {
    "tol": 1e-6,
    "constr_viol_tol": 1e-6,
    "dual_inf_tol": 1e10,
    "compl_inf_tol": 1e10,
    "max_iter": 1000,
    "nlp_scaling_method": "none",
    "linear_solver": "mumps",
}


def functions_seconds(stats):
    return sum(value for key, value in stats.items() if key.startswith("t_wall_nlp_"))


def linear_seconds(report):
    """Of Ipopt's statistics, wall: assembly, factorisation and solves of the augmented system."""
    found = re.search(r"StdAugSystemSolverMultiSolve\.*:.*wall:\s*([0-9.eE+-]+)", report)
    return float(found.group(1)) if found else float("nan")


def prepare_ipopt(program, barrier="monotone"):
    """A function (start) -> figures; what CasADi does once, derivatives of expressions, is done
    here."""
    folder = tempfile.TemporaryDirectory()
    report = pathlib.Path(folder.name) / "ipopt.txt"
    ipopt = {
        **OPTIONS,
        **BARRIERS[barrier],
        "print_level": 0,
        "sb": "yes",
        "output_file": str(report),
        "file_print_level": 5,
        "print_timing_statistics": "yes",
    }
    begin = time.perf_counter()
    solver = casadi.nlpsol(
        "solver",
        "ipopt",
        program["nlp"],
        {"ipopt": ipopt, "print_time": False, "error_on_fail": False, **program["derivatives"]},
    )
    prepared = time.perf_counter() - begin

    def run(start, keep=folder):
        report.write_text("")
        before, begin = os.times(), time.perf_counter()
        result = solver(
            x0=numpy.array(program["start"](start)) / program["scale"],
            lbx=program["lbx"],
            ubx=program["ubx"],
            lbg=program["lbg"],
            ubg=program["ubg"],
        )
        wall, after, stats = time.perf_counter() - begin, os.times(), solver.stats()
        return {
            "converged": bool(stats["success"]),
            "status": stats["return_status"],
            "iterations": stats["iter_count"],
            "total": wall,
            "cpu": after.user + after.system - before.user - before.system,
            "functions": functions_seconds(stats),
            "linear": linear_seconds(report.read_text()),
            "objective": float(result["f"]),
            "x": numpy.array(result["x"]).ravel() * program["scale"],
        }

    run.prepared = prepared
    return run
