"""A leap as an optimal control problem for FATROP, which PyPI's CasADi carries.

FATROP's recursion wants x_{k+1} = F(x_k, u_k), and a compressed interval has no such F. So the next
node is an input as well: stage k has the state (node, durations, extra variables) and the input
(next node, torques, accelerations and forces), F hands the next node over, and the defects are
equalities of the stage. CasADi takes derivatives of FATROP's problems by itself; what FATROP needs
beside them is its recursion and its line search."""

import dataclasses
import time

import casadi
import numpy

from peers.leap import COST, Leap
from peers.program import INFINITY

# The library's, as far as FATROP has them.
OPTIONS = {"tolerance": 1e-6, "mu_init": 1e-2, "max_iter": 300}


class Stages:
    """All stages of a leap in FATROP's order, in variables and rows over their scales."""

    def __init__(self, leap):
        self.leap, self.program, self.width = leap, leap.program, 2 * leap.program.n
        self.y, self.columns, self.lower, self.upper = [], [], [], []
        self.g, self.lbg, self.ubg = [], [], []
        self.cost, self.nx, self.nu, self.ng = casadi.MX(0.0), [], [], []
        self.handed, self.gap = None, None  # to the next stage, and the place of its rows

        program = self.program
        program.add_lifted()
        self.shared = program.durations + list(range(program.durations[-1] + 1, program.own))
        kinds = {}
        for p, interval, members, fractions in program.intervals(self.spent):
            for k, fraction in zip(members, fractions):
                kinds[k] = (p, interval, fraction)
        for k in range(len(kinds)):
            self.add_interval(k, *kinds[k])
        self.add_end(len(kinds))

    def spent(self, u):
        return COST * self.leap.squared_torque(u)

    def span(self, first, count):
        return list(range(first, first + count))

    def variables(self, columns, bounded):
        """Variables at the program's columns, scaled and in SI units. Bounds of equal values are
        rows to FATROP, and those of the first `bounded` alone are left out."""
        program = self.program
        scale = numpy.array(program.scale)[columns]
        lower, upper = (numpy.array(b)[columns] / scale for b in (program.lower, program.upper))
        free = lower == upper
        free[: len(columns) - bounded] = True
        y = casadi.MX.sym("y", len(columns))
        self.y.append(y)
        self.columns += columns
        self.lower += list(numpy.where(free, -INFINITY, lower))
        self.upper += list(numpy.where(free, INFINITY, upper))
        return y, y * casadi.DM(scale)

    def add_rows(self, rows, scaled=False):
        scale = numpy.array(rows.scale)
        self.g.append(rows.value if scaled else rows.value / casadi.DM(scale))
        self.lbg += list(numpy.array(rows.lower) / scale)
        self.ubg += list(numpy.array(rows.upper) / scale)
        return rows.value.numel()

    def add_fixed(self, columns, y):
        program, fixed = self.program, 0
        for i, column in enumerate(columns):
            if program.lower[column] != program.upper[column]:
                continue
            value = program.lower[column] / program.scale[column]
            self.g.append(y[i])
            self.lbg.append(value)
            self.ubg.append(value)
            fixed += 1
        return fixed

    def add_state(self, k):
        """The state of stage k, and the rows that were left open for what is handed to it."""
        columns = self.span(self.program.nodes[k], self.width) + self.shared
        y, x = self.variables(columns, len(columns))
        if self.handed is not None:
            self.g[self.gap] = y - self.handed
        self.nx.append(len(columns))
        return columns, y, x

    def add_interval(self, k, p, interval, fraction):
        program, width, n = self.program, self.width, self.program.n
        columns, y, x = self.add_state(k)
        inputs = self.span(program.inputs[k], program.robot.n_u)
        own = inputs + self.span(program.extra[k], interval.extra)
        y_u, u = self.variables(self.span(program.nodes[k + 1], width) + own, len(own))
        self.nu.append(width + len(own))

        self.gap, self.handed = len(self.g), casadi.vertcat(y_u[:width], y[width:])
        self.g.append(None)
        self.lbg += [0.0] * len(columns)
        self.ubg += [0.0] * len(columns)

        torque, extra = u[width : width + len(inputs)], u[width + len(inputs) :]
        value, cost = interval.values(x[:width], u[:width], torque, x[width + p], extra, fraction)
        self.cost += cost
        count = self.add_rows(dataclasses.replace(interval.rows, value=value), scaled=True)
        if k == 0:
            count += self.add_fixed(columns, y) + self.add_rows(self.leap.standing(x[:n]))
        self.ng.append(count)

    def add_end(self, k):
        width, n = self.width, self.program.n
        columns, y, x = self.add_state(k)
        self.nu.append(0)
        rows = self.leap.touchdown(x[:n], x[n:width], x[width + 2])
        self.ng.append(self.add_fixed(columns, y) + self.add_rows(rows))
        self.cost -= x[n] / (x[width] + x[width + 1])


def prepare(name):
    """A function (the library's variables as start) -> figures."""
    stages = Stages(Leap(name))
    scale = numpy.array(stages.program.scale)[stages.columns]
    solver = casadi.nlpsol(
        "solver",
        "fatrop",
        {
            "x": casadi.vertcat(*stages.y),
            "f": stages.cost,
            "g": casadi.vertcat(*stages.g),
        },
        {
            "structure_detection": "manual",
            "N": len(stages.nx) - 1,
            "nx": stages.nx,
            "nu": stages.nu,
            "ng": stages.ng,
            "equality": [low == high for low, high in zip(stages.lbg, stages.ubg)],
            "print_time": False,
            "error_on_fail": False,
            "fatrop": {**OPTIONS, "print_level": 0},
        },
    )

    def run(start):
        x0 = numpy.array(stages.program.start(start))[stages.columns] / scale
        before = time.process_time()
        result = solver(
            x0=x0, lbx=stages.lower, ubx=stages.upper, lbg=stages.lbg, ubg=stages.ubg
        )
        cpu, stats = time.process_time() - before, solver.stats()
        functions = sum(value for key, value in stats.items() if key.startswith("t_proc_nlp_"))
        return {
            "converged": bool(stats["success"]),
            "iterations": stats["iter_count"],
            "cpu": cpu,
            "outside_ms": 1e3 * (cpu - functions) / max(stats["iter_count"], 1),
            "objective": float(result["f"]),
        }

    return run
