"""The hop from standing to standing (problems/hop.yaml) in CasADi: stance, flight, plastic impact,
stance."""

import math

import casadi

from peers.leap import friction, with_bounds
from peers.minitaur import LEGS, Minitaur
from peers.program import INFINITY, Phase, Program, Rows

VOLTAGE, FRICTION, RESISTANCE = 12.0, 0.5, 0.186  # V, -, ohm
POSE = (1.2, 0.0, 1.2, 0.0)  # of the legs at the start
LAST_EXTENSION = (0.8, 1.8)


def equal(intervals):
    return [1.0 / intervals] * intervals


class Hop:
    def __init__(self, lifted=True):
        far, fast, quarter = (-1.0, 1.0), (-10.0, 10.0), 0.25 * math.pi
        extension = (0.4, 2.74)
        self.robot = with_bounds(
            Minitaur("none", RESISTANCE),
            {
                "x": far,
                "z": (0.05, 0.8),
                "pitch": (-quarter, quarter),
                "front_extension": extension,
                "rear_extension": extension,
            },
            {"x": fast, "z": fast, "pitch": (-50.0, 50.0)},
        )
        self.voltages = casadi.Function(
            "voltages", [self.robot.v, self.robot.u], [self.robot.voltages()]
        )
        self.heights = [self.robot.foot_height(leg) for leg in LEGS]
        feet = list(LEGS)
        self.program = Program(
            self.robot,
            [
                Phase(feet, equal(15), (0.15, 0.15), self.standing, ends=True),
                Phase([], equal(10), (0.12, 0.12), self.flying, (1e-9, 1.0 - 1e-9), ends=True),
                Phase(feet, equal(15), (0.05, 0.6), self.standing, ends=True, lands=True),
            ],
            lifted,
        )
        self._boundaries()

    def standing(self, point, s, place):
        rows = self.electric(point) + Rows.same(point.force[1::2], 0.0, INFINITY, self.robot.weight)
        return (
            rows
            + friction(point.force, 0, FRICTION, self.robot.weight)
            + friction(point.force, 1, FRICTION, self.robot.weight)
        )

    def flying(self, point, s, place):
        rows = self.electric(point)
        if (
            place == "last" or place == "end" or s < 1e-9
        ):  # feet take off from the ground and land on it
            return rows
        return rows + Rows.same(
            casadi.vertcat(*[height(point.q) for height in self.heights]), 0.0, INFINITY, 0.1
        )

    def electric(self, point):
        return Rows.same(self.voltages(point.v, point.u), -VOLTAGE, VOLTAGE, VOLTAGE)

    def _boundaries(self):
        program, n = self.program, self.robot.n
        start, end = program.nodes[0], program.nodes[-1]
        for i, value in ((0, 0.0), (2, 0.0), *zip(range(3, 7), POSE)):
            program.fix(start + i, value)
        for i in range(n):
            program.fix(start + n + i, 0.0)
        program.fix(end + 2, 0.0)
        program.fix(end + 3, *LAST_EXTENSION)
        program.fix(end + 5, *LAST_EXTENSION)
        for i in range(3):  # with the feet at rest the others follow
            program.fix(end + n + i, 0.0)

    def impact(self, before, after):
        """Rows between the nodes before and after: the pose stays, rates jump, the floor pushes."""
        (q, v), (q_after, v_after) = before, after
        jump, impulse = self.robot.impact(list(LEGS))(q, v)
        scales, n = self.robot.scales, self.robot.n
        stays = Rows(
            casadi.vertcat(q_after - q, v_after - v - jump),
            [0.0] * 2 * n,
            [0.0] * 2 * n,
            list(scales),
        )
        return stays + Rows.same(impulse[1::2], 0.0, INFINITY, 0.1 * self.robot.weight)

    def make(self):
        program = self.program
        landed = 26  # its first node; 25 is the flight's last one

        def node_rows(x):
            before, after = program.node(x, landed - 1), program.node(x, landed)
            ground = [Rows.same(height(before[0]), 0.0, 0.0, 0.1) for height in self.heights]
            return [
                Rows.same(self.heights[0](program.node(x, 0)[0]), 0.0, 0.0, 0.1),
                *ground,
                self.impact(before, after),
            ]

        squared = casadi.Function("squared", [self.robot.u], [self.robot.squared_torque()])
        return program.build(lambda x: casadi.MX(0.0), node_rows, squared, 1.0)
