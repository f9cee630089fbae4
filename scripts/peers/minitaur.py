"""Minitaur in the sagittal plane as CasADi expressions, written apart from the library.

A leg's two upper links turn by extension -+ angle about the hip, so that its knees lie mirrored
about the leg's axis and the pin of its lower links on it: all bodies follow in closed form. The
equations of motion are those of Lagrange from the bodies' places, with the forces of standing feet
from J a = -dJ/dt v, mass and stance factorised as L D L^T. Lengths, masses and inertias are read
from models/minitaur_tail/robot.urdf."""

import math
import pathlib
import xml.etree.ElementTree

import casadi

ROOT = pathlib.Path(__file__).resolve().parents[2]
GRAVITY = 9.81
LEGS = ("front", "rear")
SMOOTHING = 0.02  # m/s, of |u| in the law of drag
DENSITY, TAIL_DRAG, DRAG_AT, DRAG_AREA = (
    1.225,
    2.3,
    0.8,
    0.072,
)  # kg/m^3, C_D, m, m^2: problems/leap_tail.yaml
RESISTANCE, TORQUE_CONSTANT, LINEAR, CUBIC = (
    0.22,
    0.0954,
    8.93,
    0.539,
)  # of a motor, warm: problems/leap_tail.yaml
TAIL_GEAR, TAIL_EFFICIENCY = 4.0, 0.8
MOTOR_TORQUE = 3.0  # N m


def turn(angle, x, z):
    """(x, z) of a body turned about +y by the angle."""
    s, c = casadi.sin(angle), casadi.cos(angle)
    return casadi.vertcat(x * c + z * s, z * c - x * s)


def urdf_links():
    """Mass, place of the centre of mass and inertia about it of every link, and places of
    joints."""
    robot = xml.etree.ElementTree.parse(ROOT / "models/minitaur_tail/robot.urdf").getroot()
    links, joints = {}, {}
    for link in robot.iter("link"):
        inertial = link.find("inertial")
        z = float(inertial.find("origin").get("xyz").split()[2])
        links[link.get("name")] = (
            float(inertial.find("mass").get("value")),
            z,
            float(inertial.find("inertia").get("iyy")),
        )
    for joint in robot.iter("joint"):
        x, _, z = (float(v) for v in joint.find("origin").get("xyz").split())
        joints[joint.get("name")] = (x, z)
    return links, joints


class Minitaur:
    """`tail`: none, held, inertial (without drag) or drag. `resistance` of the motors [ohm]."""

    def __init__(self, tail, resistance=RESISTANCE):
        self.tail, self.moves_tail, self.resistance = tail, tail in ("inertial", "drag"), resistance
        self.coordinates = [
            "x",
            "z",
            "pitch",
            "front_extension",
            "front_angle",
            "rear_extension",
            "rear_angle",
        ]
        self.motors = [(leg, side) for leg in LEGS for side in "ab"]
        if self.moves_tail:
            self.coordinates.append("tail")
            self.motors.append(("tail", ""))
        self.n, self.n_u = len(self.coordinates), len(self.motors)
        self.q, self.v, self.u = (
            casadi.SX.sym(name, size)
            for name, size in (("q", self.n), ("v", self.n), ("u", self.n_u))
        )
        self._place_bodies()

    def _place_bodies(self):
        links, joints = urdf_links()
        q, base = self.q, self.q[:2]
        self.bodies, self.feet = [], {}  # (mass, inertia, centre of mass, angle)
        mass, _, inertia = links["base"]
        self.bodies.append((mass, inertia, base, q[2]))
        for k, leg in enumerate(LEGS):
            extension, axis = q[3 + 2 * k], q[2] + q[4 + 2 * k]
            hip = base + turn(q[2], *joints[f"{leg}_left_a"])
            upper = joints[f"{leg}_left_a_knee"][1]  # length of an upper link
            fold = casadi.asin(
                0.5 * casadi.sin(extension)
            )  # of a lower link to the leg's axis: pins 0.2 m from the knees
            for side, sign in (("a", -1), ("b", 1)):
                up, low = axis + sign * extension, axis + sign * fold
                knee = hip + turn(up, 0, upper)
                for name, at, angle in (("upper", hip, up), ("lower", knee, low)):
                    mass, z, inertia = links[f"{leg}_left_{side}_{name}"]
                    self.bodies.append((2 * mass, 2 * inertia, at + turn(angle, 0, z), angle))
                if side == "a":
                    self.feet[leg] = knee + turn(low, 0, -0.24)
        if self.tail != "none":
            self._place_tail(links, joints)
        self.weight = GRAVITY * sum(body[0] for body in self.bodies)

    def _place_tail(self, links, joints):
        pivot = self.q[:2] + turn(self.q[2], *joints["tail"])
        for name in ("tail_mount", "tail_rotor"):
            mass, _, inertia = links[name]
            self.bodies.append((mass, inertia, pivot, self.q[2]))
        self.tail_angle = self.q[2] + (self.q[7] if self.moves_tail else -0.5 * math.pi)
        mass, z, inertia = links["tail"]
        self.bodies.append((mass, inertia, pivot + turn(self.tail_angle, 0, z), self.tail_angle))
        mass, _, inertia = links["tail_scoop"]
        scoop = pivot + turn(self.tail_angle, 0, joints["tail_scoop_joint"][1])
        self.bodies.append((mass, inertia, scoop, self.tail_angle))
        self.drag_point = pivot + turn(self.tail_angle, 0, DRAG_AT)
        self.rotor = links["tail_rotor"][2] * TAIL_GEAR**2

    def joint_rates(self):
        """Of each motor's joint [rad/s]."""
        rates = []
        for leg, side in self.motors:
            if leg == "tail":
                rates.append(self.v[7])
            else:
                at = 3 + 2 * LEGS.index(leg)
                rates.append(self.v[at] + (-1 if side == "a" else 1) * self.v[at + 1])
        return casadi.vertcat(*rates)

    def torque_limits(self):
        """Of each motor, at its joint [N m]."""
        return [
            MOTOR_TORQUE * (TAIL_GEAR * TAIL_EFFICIENCY if leg == "tail" else 1.0)
            for leg, _ in self.motors
        ]

    def motor_torques(self):
        """Before the gear [N m]."""
        limits = casadi.DM(self.torque_limits()) / MOTOR_TORQUE
        return self.u / limits

    def voltages(self):
        torque = self.motor_torques()
        current = LINEAR * torque + CUBIC * torque**3
        gear = casadi.DM([TAIL_GEAR if leg == "tail" else 1.0 for leg, _ in self.motors])
        return self.resistance * current + TORQUE_CONSTANT * gear * self.joint_rates()

    def squared_torque(self):
        count = casadi.DM([1.0 if leg == "tail" else 2.0 for leg, _ in self.motors])
        return casadi.dot(count, self.motor_torques() ** 2)

    def foot_height(self, leg):
        return casadi.Function("height", [self.q], [self.feet[leg][1]])

    def foot_velocity(self, leg):
        return casadi.Function(
            "velocity", [self.q, self.v], [casadi.jtimes(self.feet[leg], self.q, self.v)]
        )

    def _rate(self, of):
        """d(J v)/dt at a = 0."""
        velocity = casadi.jtimes(of, self.q, self.v)
        return casadi.jtimes(velocity, self.q, self.v)

    def _mass_and_force(self):
        M = casadi.SX.zeros(self.n, self.n)
        counts = casadi.DM([1.0 if leg == "tail" else 2.0 for leg, _ in self.motors])
        force = casadi.mtimes(casadi.jacobian(self.joint_rates(), self.v).T, counts * self.u)
        for mass, inertia, place, angle in self.bodies:
            J, J_turn = casadi.jacobian(place, self.q), casadi.jacobian(angle, self.q)
            M += mass * casadi.mtimes(J.T, J) + inertia * casadi.mtimes(J_turn.T, J_turn)
            force -= mass * casadi.mtimes(J.T, self._rate(place) + casadi.vertcat(0, GRAVITY))
            force -= inertia * casadi.mtimes(J_turn.T, self._rate(angle))
        if self.moves_tail:
            M[7, 7] += self.rotor
        if self.tail in ("held", "drag"):
            force += self._drag()
        return M, force

    def _drag(self):
        J = casadi.jacobian(self.drag_point, self.q)
        across = casadi.vertcat(casadi.cos(self.tail_angle), -casadi.sin(self.tail_angle))
        speed = casadi.dot(across, casadi.mtimes(J, self.v))
        size = -0.5 * DENSITY * TAIL_DRAG * DRAG_AREA * speed * casadi.sqrt(speed**2 + SMOOTHING**2)
        return casadi.mtimes(J.T, across * size)

    def _stance(self, feet):
        """J and -dJ/dt v of the feet."""
        if not feet:
            return casadi.SX(0, self.n), casadi.SX(0, 1)
        J = casadi.vertcat(*[casadi.jacobian(self.feet[foot], self.q) for foot in feet])
        return J, casadi.vertcat(*[-self._rate(self.feet[foot]) for foot in feet])

    def _solve(self, M, right, J, jump):
        """a and f from M a - J^T f = right, J a = jump."""
        factors = casadi.ldl(M)
        free = casadi.ldl_solve(right, *factors)
        if J.size1() == 0:
            return free, casadi.SX(0, 1)
        by_force = casadi.ldl_solve(J.T, *factors)
        f = casadi.ldl_solve(jump - casadi.mtimes(J, free), *casadi.ldl(casadi.mtimes(J, by_force)))
        return free + casadi.mtimes(by_force, f), f

    def dynamics(self, feet):
        """Function (q, v, u) -> accelerations, forces of the feet (x, z of each)."""
        return casadi.Function(
            "dynamics",
            [self.q, self.v, self.u],
            self._solve(*self._mass_and_force(), *self._stance(feet)),
        )

    def residual(self, feet):
        """Function (q, v, u, a, f) -> what the equations of motion leave, those of the standing
        feet below."""
        M, force = self._mass_and_force()
        J, jump = self._stance(feet)
        a, f = casadi.SX.sym("a", self.n), casadi.SX.sym("f", 2 * len(feet))
        left = casadi.vertcat(
            casadi.mtimes(M, a) - casadi.mtimes(J.T, f) - force, casadi.mtimes(J, a) - jump
        )
        return casadi.Function("residual", [self.q, self.v, self.u, a, f], [left])

    def impact(self, feet):
        """Function (q, v) -> jump of the rates, impulses, where the feet stop dead."""
        M, _ = self._mass_and_force()
        J, _ = self._stance(feet)
        return casadi.Function(
            "impact",
            [self.q, self.v],
            self._solve(M, casadi.SX.zeros(self.n), J, -casadi.mtimes(J, self.v)),
        )
