"""A cart-pole swung up with least effort: CasADi's program, and the library's problem file, of the
same nonlinear program: torques linear over an interval, a straight line as guess, for `intervals`
equal ones."""

import math

import casadi
import numpy

from peers.minitaur import ROOT

# models/cart_pole
CART, POLE, LENGTH, INERTIA, GRAVITY = (
    1.0,
    0.3,
    0.5,
    1e-6,
    9.81,
)  # kg, kg, m to the centre of mass, kg m^2 about it, m/s^2
DURATION, REACH, SPEED, RATE, FORCE = 2.0, 1.0, 10.0, 20.0, 20.0  # s, m, m/s, rad/s, N


def problem(intervals):
    return f"""format: jaculus-problem/1
name: cart_pole
robot: {ROOT}/models/cart_pole
bounds:
  position: {{cart: [-{REACH} m, {REACH} m], pole: [-360 deg, 360 deg]}}
  velocity: {{cart: [-{SPEED} m/s, {SPEED} m/s], pole: [-{RATE} rad/s, {RATE} rad/s]}}
phases: [{{name: swing, contacts: [], intervals: {intervals}, duration: {DURATION} s}}]
initial: {{at_rest: true, position: {{cart: 0, pole: 0}}}}
final: {{at_rest: true, position: {{cart: 0, pole: 180 deg}}}}
objective: {{minimise: [{{type: torque_squared}}]}}
transcription: {{scheme: hermite_simpson, inputs: linear}}
guess: {{kind: line, poses: [{{cart: 0, pole: 0}}, {{cart: 0, pole: 180 deg}}]}}
"""


def interval_function(h):
    """Defects and cost of one interval from the states at its ends and the force at its ends."""
    x, u = casadi.SX.sym("x", 4), casadi.SX.sym("u")
    s, c = (
        casadi.sin(x[1]),
        casadi.cos(x[1]),
    )  # pole hanging at 0; a positive angle turns it from -z towards -x
    a11, a12, a22 = CART + POLE, -POLE * LENGTH * c, INERTIA + POLE * LENGTH**2
    b1 = u - POLE * LENGTH * s * x[3] ** 2
    b2 = -POLE * GRAVITY * LENGTH * s
    det = a11 * a22 - a12**2
    f = casadi.Function(
        "f",
        [x, u],
        [casadi.vertcat(x[2:], (a22 * b1 - a12 * b2) / det, (a11 * b2 - a12 * b1) / det)],
    )
    x0, x1 = casadi.SX.sym("x0", 4), casadi.SX.sym("x1", 4)
    u0, u1 = casadi.SX.sym("u0"), casadi.SX.sym("u1")
    f0, f1, um = f(x0, u0), f(x1, u1), 0.5 * (u0 + u1)
    fm = f(0.5 * (x0 + x1) + h / 8 * (f0 - f1), um)
    cost = h / 6 * (u0**2 + 4 * um**2 + u1**2)
    return casadi.Function(
        "interval", [x0, x1, u0, u1], [x1 - x0 - h / 6 * (f0 + 4 * fm + f1), cost]
    )


def make(intervals):
    """Variables: all states, then all forces."""
    y = casadi.MX.sym("y", 5 * (intervals + 1))
    X, U = casadi.reshape(y[: 4 * (intervals + 1)], 4, intervals + 1), y[4 * (intervals + 1) :].T
    step = interval_function(DURATION / intervals).map(intervals)
    defects, cost = step(X[:, :-1], X[:, 1:], U[:, :-1], U[:, 1:])
    lower, upper = [], []
    for k in range(intervals + 1):
        bound = [REACH, 2 * math.pi, SPEED, RATE]
        pose = [0.0, math.pi * (k > 0), 0.0, 0.0]
        lower += pose if k in (0, intervals) else [-b for b in bound]
        upper += pose if k in (0, intervals) else bound
    force = [FORCE] * (intervals + 1)
    return {
        "start": list,
        "nlp": {"x": y, "f": casadi.sum2(cost), "g": casadi.vec(defects)},
        "derivatives": {},
        "scale": numpy.ones(y.numel()),
        "lbx": numpy.array(lower + [-v for v in force]),
        "ubx": numpy.array(upper + force),
        "lbg": 0.0,
        "ubg": 0.0,
    }


def guess(intervals):
    states = [[0.0, math.pi * k / intervals, 0.0, math.pi / DURATION] for k in range(intervals + 1)]
    return sum(states, []) + [0.0] * (intervals + 1)
