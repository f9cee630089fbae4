"""Runs the program on the same problem and says what it took."""

import json
import os
import resource
import subprocess

import numpy

# A guess as it is: no iteration, and no push off its bounds.
AS_GUESSED = (
    "max_iter 0;bound_push 1e-16;bound_frac 1e-16;slack_bound_push 1e-16;slack_bound_frac 1e-16"
)


def solve(program, text, folder, environment=""):
    """Figures of one solve of the problem that `text` states; its variables in SI units."""
    problem, out = folder / "problem.yaml", folder / "out"
    problem.write_text(text)
    for name in ("timing.json", "summary.json", "solution.json"):
        (out / name).unlink(missing_ok=True)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(
        [program, "solve", problem, "--out", out, "--quiet", "--jobs", "1"],
        check=False,
        capture_output=True,
        text=True,
        env={**os.environ, "JACULUS_IPOPT_OPTIONS": environment},
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode > 1:
        raise SystemExit(f"jaculus ended with {done.returncode}: {done.stderr}")
    summary, timing = (
        json.loads((out / "summary.json").read_text()),
        json.loads((out / "timing.json").read_text()),
    )
    wall = timing["wall_seconds"]
    return {
        "converged": summary["status"] in ("optimal", "acceptable"),
        "status": summary["status"],
        "iterations": timing["iterations"],
        "total": wall["total"],
        "functions": wall["functions"],
        "linear": wall["linear_solver"],
        "objective": summary["objective"],
        "cpu": after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime,
        "x": numpy.array(json.loads((out / "solution.json").read_text())["variables"]["values"]),
    }


def guess(program, text, folder):
    """The variables of the problem's own guess."""
    return solve(program, text, folder, AS_GUESSED)["x"]
