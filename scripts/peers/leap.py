"""The four leaps as published (problems/leap_*_as_published.yaml) in CasADi."""

import math

import casadi

from peers.minitaur import GRAVITY, Minitaur
from peers.program import INFINITY, NONE, Phase, Program, Rows

VOLTAGE, FRICTION, LEAST_FORCE = (
    7.0,
    0.5 / math.sqrt(2.0),
    2 * 8.0,
)  # V, -, N of left and right together
HEIGHT, SPEED, COST = 0.2078, (1.3, 20.0), 1e-4  # m, m/s, weight of the squared torques
EXTENSION = (0.4, math.pi - 0.4)
LEAPS = {
    "tailless": ("none", 0.0),
    "inactive": ("held", 15.0),
    "inertial": ("inertial", 0.0),
    "tail": ("drag", 0.0),
}


def with_bounds(robot, position, velocity):
    """Bounds and scales of a node's variables on the robot."""
    quarter = (-0.5 * math.pi, 0.5 * math.pi)
    own = {"front_extension": EXTENSION, "rear_extension": EXTENSION, **position}
    robot.position_bounds = [own.get(c, quarter) for c in robot.coordinates]
    robot.velocity_bounds = [velocity.get(c, (-100.0, 100.0)) for c in robot.coordinates]
    linear = [c in "xz" for c in robot.coordinates]
    robot.scales = [0.3 if straight else 1.0 for straight in linear] + [
        1.0 if straight else 10.0 for straight in linear
    ]
    robot.torques = robot.torque_limits()
    robot.residual_scale = 10.0  # N, N m, m/s^2: of equations of motion as rows
    return robot


def friction(force, slot, coefficient, scale):
    f_x, f_z = force[2 * slot], force[2 * slot + 1]
    return Rows.same(
        casadi.vertcat(coefficient * f_z - f_x, coefficient * f_z + f_x), 0.0, INFINITY, scale
    )


def meshes(intervals, published):
    """Fractions of both phases' intervals: as published, a short last one in the first phase, or
    all equal."""
    first = [1.0] * intervals
    if published:
        first[-1] = 0.6
    return [length / sum(first) for length in first], [1.0 / intervals] * intervals


class Leap:
    """One leap; `make()` is CasADi's program of it."""

    def __init__(self, name, intervals=15, published=True, lifted=True, made=None):
        tail, self.pitch = LEAPS[name]
        far, fast = (-1.0, 2.0), (-20.0, 20.0)
        self.robot = with_bounds(
            Minitaur(tail), {"x": far, "z": (0.05, 0.6)}, {"x": fast, "z": fast}
        )
        self.voltages = casadi.Function(
            "voltages", [self.robot.v, self.robot.u], [self.robot.voltages()]
        )
        self.weight = self.robot.weight
        first, second = meshes(intervals, published)
        # The last three points of the first phase, those of its last interval, unload the front
        # feet.
        self.unloading = sum(first[:-1]) - 1e-9
        self.program = Program(
            self.robot,
            [
                Phase(["front", "rear"], first, (1e-3, 0.5), self.on_four, (self.unloading,)),
                Phase(["rear"], second, (1e-3, 0.5), self.on_two),
            ],
            lifted,
            made,
        )
        self._boundaries()

    def on_four(self, point, s, place):
        if place == "last":  # the front feet leave without a force
            front = Rows.same(point.force[:2], 0.0, 0.0, self.weight)
        else:
            front = friction(point.force, 0, FRICTION, self.weight)
        rows = front + friction(point.force, 1, FRICTION, self.weight) + self.electric(point)
        loaded = s < self.unloading
        return rows + (
            Rows.same(point.force[1::2], LEAST_FORCE, INFINITY, self.weight) if loaded else NONE
        )

    def on_two(self, point, s, place):
        return friction(point.force, 0, FRICTION, self.weight) + self.electric(point)

    def electric(self, point):
        return Rows.same(self.voltages(point.v, point.u), -VOLTAGE, VOLTAGE, VOLTAGE)

    def _boundaries(self):
        program, robot, n = self.program, self.robot, self.robot.n
        start, end = program.nodes[0], program.nodes[-1]
        for i, value in ((0, 0.0), (2, 0.0), (3, 1.0), (4, 0.0), (5, 1.0), (6, 0.0)):
            program.fix(start + i, value)
        for i in range(n):
            program.fix(start + n + i, 0.0)
        program.fix(end + n, *SPEED)
        program.fix(end + n + 3, 0.0)
        program.fix(end + n + 4, 0.0)
        self.flight = program.add_variable(0.0, 2.0, 0.1)

    def standing(self, q):
        """Height of a foot at the start; the others' follows from the fixed pose."""
        return Rows.same(self.robot.foot_height("front")(q), 0.0, 0.0, 0.1)

    def touchdown(self, q, v, t):
        pitch = math.radians(self.pitch)
        value = casadi.vertcat(
            q[1] + v[1] * t - 0.5 * GRAVITY * t**2, q[2] + v[2] * t, v[1] - GRAVITY * t
        )
        return Rows(value, [HEIGHT, pitch, -INFINITY], [HEIGHT, pitch, 0.0], [0.1, 0.1, 1.0])

    def squared_torque(self, u):
        return casadi.Function("squared", [self.robot.u], [self.robot.squared_torque()])(u)

    def make(self):
        program = self.program
        last = len(program.nodes) - 1

        def objective(x):
            duration = x[program.durations[0]] + x[program.durations[1]]
            return -program.node(x, last)[1][0] / duration

        def node_rows(x):
            return [
                self.standing(program.node(x, 0)[0]),
                self.touchdown(*program.node(x, last), x[self.flight]),
            ]

        return program.build(objective, node_rows, self.squared_torque, COST)
