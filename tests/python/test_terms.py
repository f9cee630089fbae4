"""Terms in Python: derivatives by the user, by CasADi, by JAX, and what a plan makes of them."""
import pathlib
import subprocess
import sys

import numpy as np
import pytest

import jaculus

LIMIT = {"limit": {"unit": "rad/s", "meaning": "largest rate either way"}}


class PitchRate(jaculus.Term):
    name = "own_pitch_rate"
    meaning = "how fast the body may pitch"
    keys = LIMIT
    reads = ("velocity",)
    linear = True

    def rows(self, keys):
        return [jaculus.Row("pitch rate", "rad/s", -keys["limit"], keys["limit"], keys["limit"])]

    def value(self, point, keys):
        return point.velocity["pitch"]

    def jacobian(self, point, keys):
        return {("velocity", "pitch"): 1.0}


class Swing(jaculus.Term):
    """Two curved rows of three blocks: s = sin(tail) w, p = w u/limit, w the tail's rate, u its torque."""
    name = "own_swing"
    meaning = "rows that are curved"
    keys = LIMIT
    reads = ("position", "velocity", "input")

    def rows(self, keys):
        return [jaculus.Row("s", "rad/s", -1e3, 1e3, 10.0), jaculus.Row("p", "N m", -1e3, 1e3, 10.0)]

    def value(self, point, keys):
        tail, rate, torque = point.position["tail"], point.velocity["tail"], point.input["tail"]
        return [self.sin(tail) * rate, rate * torque / keys["limit"]]

    sin = staticmethod(np.sin)

    def jacobian(self, point, keys):
        tail, rate, torque = point.position["tail"], point.velocity["tail"], point.input["tail"]
        return [{("position", "tail"): np.cos(tail) * rate, ("velocity", "tail"): np.sin(tail)},
                {("velocity", "tail"): torque / keys["limit"], ("input", "tail"): rate / keys["limit"]}]


class ExactSwing(Swing):
    def hessian(self, point, keys, multipliers):
        tail, rate = point.position["tail"], point.velocity["tail"]
        q, w, u = ("position", "tail"), ("velocity", "tail"), ("input", "tail")
        return {(q, q): -multipliers[0] * np.sin(tail) * rate, (q, w): multipliers[0] * np.cos(tail),
                (u, w): multipliers[1] / keys["limit"]}


def casadi_swing():
    casadi = pytest.importorskip("casadi")
    return type("Swing", (Swing,), {"derivatives": "casadi", "sin": staticmethod(casadi.sin)})()


def jax_swing():
    jax = pytest.importorskip("jax")
    return type("Swing", (Swing,), {"derivatives": "jax", "sin": staticmethod(jax.numpy.sin)})()


class Effort(jaculus.Term):
    name = "own_effort"
    meaning = "squares of the motors' torques"
    cost, unit = True, "N^2 m^2 s"
    reads = ("input",)

    def value(self, point, keys):
        return sum(torque**2 for torque in point.input.values())

    def jacobian(self, point, keys):
        return {("input", name): 2.0 * torque for name, torque in point.input.items()}


def leap(*constraints, **more):
    """The leap on a coarse mesh."""
    return {"format": "jaculus-problem/1", "extends": "leap_tail.yaml", "name": "own_leap",
            "constraints": list(constraints), **more}


SWING = leap({"type": "own_swing", "limit": 2.0})


@pytest.mark.parametrize("swing", [Swing, ExactSwing, casadi_swing, jax_swing])
def test_derivatives_agree_with_differences(swing):
    found = jaculus.check_derivatives(SWING, terms=[swing()])
    assert found.error < 1e-6, found.summary


def test_a_wrong_derivative_is_found():
    def jacobian(self, point, keys):
        rows = Swing.jacobian(self, point, keys)
        rows[1][("input", "tail")] *= 1.001
        return rows

    found = jaculus.check_derivatives(SWING, terms=type("Wrong", (Swing,), {"jacobian": jacobian})())
    assert found.jacobian["error"] > 1e-5 and "p" in found.jacobian["row"]
    assert found.gradient["error"] < 1e-6 and found.jacobian["row"] in found.summary


def test_a_plan_keeps_to_a_constraint_and_pays_for_a_tighter_one(leap_rates):
    free, limit = leap_rates
    plans = [jaculus.solve(leap({"type": "own_pitch_rate", "limit": of}), terms=[PitchRate()])
             for of in (limit, 0.9 * limit)]
    for plan, of in zip(plans, (limit, 0.9 * limit)):
        assert plan.converged
        assert np.abs(plan["pitch_velocity"]).max() < 1.02 * of < 0.85 * np.abs(free["pitch_velocity"]).max()
    # A maximised one. That of the plan without a limit is another local optimum, lower than both.
    assert plans[1].objective < plans[0].objective


@pytest.fixture(scope="module")
def leap_rates():
    """The leap without the limit, and a limit that binds."""
    free = jaculus.solve("leap_tail")
    return free, 0.8 * np.abs(free["pitch_velocity"]).max()


def test_a_cost_is_that_of_the_catalogue():
    weighed = {"extends": "double_integrator.yaml", "format": "jaculus-problem/1", "name": "own_cost"}
    own = {**weighed, "objective": {"minimise": [{"type": "own_effort", "weight": 0.5}]}}
    theirs = {**weighed, "objective": {"minimise": [{"type": "torque_squared", "at": "joint",
                                                     "weight": 0.5}]}}
    ours, catalogue = jaculus.solve(own, terms=Effort()), jaculus.solve(theirs)
    assert ours.converged and ours.objective == pytest.approx(catalogue.objective, rel=1e-8)
    assert jaculus.check_derivatives(own, terms=Effort()).error < 1e-6


def changed(base=PitchRate, **attributes):
    return type("Changed", (base,), attributes)()


def fails(self, point, keys):
    raise ZeroDivisionError("by my own fault")


RATE = {"type": "own_pitch_rate", "limit": 3}


@pytest.mark.parametrize("term, keys, error, message", [
    (changed(), {"type": "own_pitch_rate"}, jaculus.InputError, "'limit' is missing"),
    (changed(), {**RATE, "limit": "5 m/s"}, jaculus.InputError, "rad/s"),
    (changed(), {**RATE, "phases": ["rear_fet"]}, jaculus.InputError, "did you mean 'rear_feet'"),
    (changed(name="friction"), RATE, jaculus.InputError, "'friction' is a term of jaculus"),
    (changed(reads=("force",)), RATE, ValueError, r"reads \['force'\]; allowed: position"),
    (changed(derivatives="hand"), RATE, ValueError, "allowed: None, \"casadi\", \"jax\""),
    (changed(rows=lambda self, keys: [jaculus.Row("r", "rad/s", 1.0, -1.0)]), RATE, ValueError,
     "the lower one first"),
    (changed(value=lambda self, point, keys: [1.0, 2.0]), RATE, ValueError, "gave 2 rows; allowed: 1"),
    (changed(jacobian=lambda self, point, keys: {("input", "tail"): 1.0}), RATE, KeyError, "is not read"),
    (changed(value=fails), RATE, ZeroDivisionError, "by my own fault"),
    ("own_pitch_rate", RATE, TypeError, "that is a jaculus.Term"),
])
def test_faults_are_told(term, keys, error, message):
    with pytest.raises(error, match=message):
        jaculus.solve(leap(keys), terms=[term])


def test_after_its_exception_a_term_is_called_no_more():
    calls = []

    def counted(self, point, keys):
        calls.append(point)
        return fails(self, point, keys)

    with pytest.raises(ZeroDivisionError):
        jaculus.solve(leap(RATE), terms=[changed(value=counted)])
    assert len(calls) == 1
    assert jaculus.check_derivatives(leap(RATE), terms=[PitchRate()]).error < 1e-6  # is called again


PROGRAM = """
import jaculus
from test_terms import RATE, PitchRate, leap

class Own(PitchRate):
    def value(self, point, keys):
        return point.velocity["pitch"]

plan = jaculus.solve(leap(RATE), terms=[Own()])
print(plan.status)
"""


def test_a_program_that_keeps_its_plan_ends_without_a_word():
    done = subprocess.run([sys.executable, "-c", PROGRAM], cwd=pathlib.Path(__file__).parent,
                          capture_output=True, text=True)
    assert (done.stdout, done.stderr) == ("optimal\n", "")


def test_several_starts_are_refused():
    with pytest.raises(ValueError, match="1 with terms in Python"):
        jaculus.solve(leap(RATE), terms=[PitchRate()], starts=3)
    with pytest.raises(jaculus.InputError, match="unknown constraint type 'own_pitch_rate'"):
        jaculus.solve(leap(RATE))
