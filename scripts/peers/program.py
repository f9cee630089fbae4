"""A plan's nonlinear program in CasADi: compressed Hermite-Simpson, inputs held over an interval,
variables in the library's order (nodes and inputs along time, durations, extra variables) and
divided by the library's scales.

Accelerations and forces are no variables, as in the library: an interval is one SX function of its
ends, its input and its duration, mapped over a phase's intervals."""

import dataclasses

import casadi
import numpy

from peers.assembly import Assembly

INFINITY = float("inf")


@dataclasses.dataclass
class Rows:
    """Expressions with bounds and scales, one each."""

    value: object
    lower: list
    upper: list
    scale: list

    @staticmethod
    def same(value, lower, upper, scale):
        count = value.numel()
        return Rows(value, [lower] * count, [upper] * count, [scale] * count)

    def __add__(self, other):
        return Rows(
            casadi.vertcat(self.value, other.value),
            self.lower + other.lower,
            self.upper + other.upper,
            self.scale + other.scale,
        )


NONE = Rows(casadi.SX(0, 1), [], [], [])


@dataclasses.dataclass
class Phase:
    """`path(point, s, place)`: Rows that hold at a point, s its fraction of the phase; place is
    start, middle, last (the phase's end) or, where `ends`, end: an interval's other end, with its
    own input."""

    feet: list
    mesh: list  # fractions
    duration: tuple  # bounds [s]
    path: object
    breaks: tuple = ()  # fractions of the phase at which its rows change
    ends: bool = False
    lands: bool = False  # begins with an impact: has a first node of its own

    @property
    def intervals(self):
        return len(self.mesh)


@dataclasses.dataclass
class Point:
    q: object
    v: object
    u: object
    force: object  # x, z of each foot in contact


class Interval:
    """One kind of interval of a phase as a Function (x0, x1, u, T, w; its fraction of T) -> rows,
    cost. `lifted`: accelerations and forces at its start, middle and end are variables w, and the
    equations of motion are rows."""

    def __init__(self, robot, phase, index, cost, lifted):
        n, fraction = robot.n, casadi.SX.sym("fraction")
        x0, x1 = casadi.SX.sym("x0", 2 * n), casadi.SX.sym("x1", 2 * n)
        u, T = casadi.SX.sym("u", robot.n_u), casadi.SX.sym("T")
        own = n + 2 * len(phase.feet)  # accelerations and forces of a point
        w = casadi.SX.sym("w", 3 * own if lifted else 0)
        solve, residual = robot.dynamics(phase.feet), robot.residual(phase.feet)
        h, motion = fraction * T, NONE

        def at(point, state):
            nonlocal motion
            if not lifted:
                return solve(state[:n], state[n:], u)
            a, f = w[point * own : point * own + n], w[point * own + n : (point + 1) * own]
            left = residual(state[:n], state[n:], u, a, f)
            motion = motion + Rows.same(left, 0.0, 0.0, robot.residual_scale)
            return a, f

        def rate(state, a):
            return casadi.vertcat(state[n:], a)

        (a0, f0), (a1, f1) = at(0, x0), at(2, x1)
        middle = 0.5 * (x0 + x1) + h / 8 * (rate(x0, a0) - rate(x1, a1))
        a, f = at(1, middle)
        defect = x1 - x0 - h / 6 * (rate(x0, a0) + 4 * rate(middle, a) + rate(x1, a1))
        rows = (
            Rows(defect, [0.0] * (2 * n), [0.0] * (2 * n), [0.1 * s for s in robot.scales]) + motion
        )

        begin, last = sum(phase.mesh[:index]), index == phase.intervals - 1
        points = [(x0, f0, begin, "start"), (middle, f, begin + 0.5 * phase.mesh[index], "middle")]
        if last or phase.ends:
            points.append((x1, f1, begin + phase.mesh[index], "last" if last else "end"))
        for state, force, s, place in points:
            rows = rows + phase.path(Point(state[:n], state[n:], u, force), s, place)
        self.rows, self.extra = rows, w.numel()
        self._differentiate(
            [x0, x1, u, T, w], fraction, rows.value / casadi.DM(rows.scale), h * cost(u)
        )

    def _differentiate(self, inputs, fraction, rows, cost):
        """Functions of one interval: values; first derivatives; second ones of multiplier . rows +
        factor cost. CasADi alone would take second derivatives of the whole program, colour by
        colour, in ten times the time."""
        z = casadi.vertcat(*inputs)
        factor, multiplier = casadi.SX.sym("factor"), casadi.SX.sym("multiplier", rows.numel())
        gradient, jacobian = casadi.jacobian(cost, z).T, casadi.jacobian(rows, z)
        hessian = casadi.tril(casadi.hessian(factor * cost + casadi.dot(multiplier, rows), z)[0])

        def function(name, more, outputs):
            return casadi.Function(name, [*inputs, fraction, *more], casadi.cse(outputs))

        self.values = function("values", [], [rows, cost])
        self.first = function("first", [], [rows, cost, jacobian, casadi.densify(gradient)])
        self.second = function("second", [factor, multiplier], [hessian])


class Program:
    """What a leap or a hop is made of; `build()` makes it CasADi's."""

    def __init__(self, robot, phases, lifted=False, made=None):
        """`made`: kinds of intervals that another mesh of the same problem has made already; those
        of this one are added."""
        self.robot, self.phases, self.lifted, self.n = robot, phases, lifted, robot.n
        self.made = {} if made is None else made
        self.nodes, self.inputs, self.ends = (
            [],
            [],
            [],
        )  # columns; (first node, last node) of each interval
        self.lower, self.upper, self.scale = [], [], []
        for p, phase in enumerate(phases):
            if p == 0 or phase.lands:
                self._add_node()
            for _ in range(phase.intervals):
                self.inputs.append(
                    self._add([-t for t in robot.torques], robot.torques, robot.torques, robot.n_u)
                )
                self._add_node()
                self.ends.append((len(self.nodes) - 2, len(self.nodes) - 1))
        self.durations = [
            self._add(
                [phase.duration[0]],
                [phase.duration[1]],
                [min(max((phase.duration[0] * phase.duration[1]) ** 0.5, 1e-3), 10.0)],
                1,
            )
            for phase in phases
        ]

    def _add(self, lower, upper, scale, count):
        at = len(self.lower)
        self.lower += lower
        self.upper += upper
        self.scale += scale
        assert len(self.lower) == at + count == len(self.scale)
        return at

    def _add_node(self):
        low, high = zip(*(self.robot.position_bounds + self.robot.velocity_bounds))
        self.nodes.append(
            self._add(list(low), list(high), list(self.robot.scales), 2 * self.robot.n)
        )

    def add_variable(self, lower, upper, scale):
        return self._add([lower], [upper], [scale], 1)

    def fix(self, column, lower, upper=None):
        self.lower[column], self.upper[column] = lower, lower if upper is None else upper

    def node(self, x, k):
        return x[self.nodes[k] : self.nodes[k] + self.n], x[
            self.nodes[k] + self.n : self.nodes[k] + 2 * self.n
        ]

    def intervals(self, cost):
        """(phase, kind of interval, the intervals that are of that kind, their fractions of the
        phase)."""
        for p, phase in enumerate(self.phases):
            kinds = {}
            first = sum(other.intervals for other in self.phases[:p])
            for k in range(phase.intervals):
                begin, fraction = sum(phase.mesh[:k]), phase.mesh[k]
                sides = tuple(
                    begin + half * fraction > at for at in phase.breaks for half in (0.0, 0.5)
                )
                kinds.setdefault((p, k == phase.intervals - 1, sides), []).append(k)
            for kind, members in kinds.items():
                if kind not in self.made:
                    self.made[kind] = Interval(self.robot, phase, members[0], cost, self.lifted)
                fractions = [phase.mesh[k] for k in members]
                yield p, self.made[kind], [first + k for k in members], fractions

    def add_lifted(self):
        """Appends the variables of lifted intervals: the library's own come first."""
        self.own = len(self.lower)
        self.extra = []
        for phase in self.phases:
            for _ in range(phase.intervals):
                scale = 3 * (
                    [10.0 * s for s in self.robot.scales[self.n :]]
                    + 2 * len(phase.feet) * [self.robot.weight]
                )
                self.extra.append(
                    self._add([-INFINITY] * len(scale), [INFINITY] * len(scale), scale, len(scale))
                    if self.lifted
                    else None
                )

    def start(self, x):
        """The library's variables as a start, accelerations and forces as they follow."""
        start, n = list(x), self.n
        if not self.lifted:
            return start
        k = 0
        for p, phase in enumerate(self.phases):
            dynamics = self.robot.dynamics(phase.feet)
            for fraction in phase.mesh:
                x0, x1 = (x[self.nodes[end] : self.nodes[end] + 2 * n] for end in self.ends[k])
                u, h = (
                    x[self.inputs[k] : self.inputs[k] + self.robot.n_u],
                    fraction * x[self.durations[p]],
                )
                a0, a1 = (dynamics(state[:n], state[n:], u) for state in (x0, x1))
                rates = [
                    numpy.concatenate([state[n:], numpy.array(a[0]).ravel()])
                    for state, a in ((x0, a0), (x1, a1))
                ]
                middle = 0.5 * (x0 + x1) + h / 8 * (rates[0] - rates[1])
                for a, f in (a0, dynamics(middle[:n], middle[n:], u), a1):
                    start += list(numpy.array(a).ravel()) + list(numpy.array(f).ravel())
                k += 1
        return start

    def build(self, objective, node_rows, cost=lambda u: 0.0, weight=0.0):
        """`objective(x)` and `node_rows(x)` of the unscaled variables; `weight` of the integral of
        `cost(u)`."""
        self.add_lifted()
        kinds = list(self.intervals(lambda u: weight * cost(u)))
        rows = sum(kind[1].values.size1_out(0) * len(kind[2]) for kind in kinds)
        ends = node_rows(casadi.MX.sym("x", len(self.lower)))
        assembly = Assembly(self, rows + sum(each.value.numel() for each in ends))

        for p, interval, members, fractions in kinds:
            columns = [self.columns(p, interval, k) for k in members]
            assembly.add_intervals(interval, columns, fractions)
        for each in node_rows(assembly.x):
            assembly.add_node_rows(each)
        assembly.add_objective(objective(assembly.x))
        return assembly.program_of()

    def columns(self, p, interval, k):
        """Of the variables of interval k, in the order of its functions' inputs."""
        first, last = (self.nodes[end] for end in self.ends[k])
        spans = [
            (first, 2 * self.n),
            (last, 2 * self.n),
            (self.inputs[k], self.robot.n_u),
            (self.durations[p], 1),
            (self.extra[k] if self.lifted else 0, interval.extra),
        ]
        return [at + i for at, count in spans for i in range(count)]
