"""Each file of the bindings once, and what it gives: seconds, no package but NumPy. CI runs it."""
import numpy as np
import pytest

import jaculus
from jaculus import _core

RUB = {"joint_viscous_friction": {"coefficient": 0.05}}


@pytest.fixture(scope="module")
def plan():
    return jaculus.solve("double_integrator")


@pytest.fixture(scope="module")
def trials():
    return jaculus.simulate("pendulum_trials", trials=2, seed=3, effects=RUB)


def test_robots_problems_and_faults():
    assert jaculus.load_problem("leap_tail").robot.name == jaculus.load_robot("minitaur_tail").name
    with pytest.raises(jaculus.InputError, match="leap_tail") as caught:
        jaculus.solve("leap_tial")
    assert caught.value.line is None


def test_a_plan_its_table_and_its_files(plan, tmp_path):
    assert plan.converged and plan.states.shape == (len(plan.time), len(plan.state_names))
    np.testing.assert_array_equal(plan["time"], plan.time)
    plan.save(tmp_path)
    assert (tmp_path / "plan.csv").is_file() and (tmp_path / "report.html").is_file()
    assert plan.objective == pytest.approx(jaculus.compare([plan]).plans[0].objective)


def test_joints_of_a_leap():
    leap = jaculus.solve("leap_tail")
    joints = leap.to_joints(rate=200)
    assert joints.position.shape == joints.effort.shape == (len(joints.time), len(joints.names))
    assert np.abs(joints.effort).max() > 1.0 and leap.forces.shape[2] == 2


def test_trials_saved_and_read_again(trials, tmp_path):
    trials.save(tmp_path)
    back = jaculus.load_dataset(tmp_path)
    ours, theirs = (of.trials[1]["joints"].values for of in (trials, back))
    np.testing.assert_array_equal(ours, theirs)


def test_a_log_becomes_a_dataset(tmp_path):
    time = np.arange(0.0, 0.1, 0.01)
    values = np.array([np.sin(time), 0.1 * time])
    channels, units = ["pendulum", "pendulum_torque"], ["rad", "N m"]
    stream = _core.make_stream("joints", 100.0, time, channels, units, values)
    dataset = _core.begin_import("pendulum", "ak80_pendulum", "", "{kind: measured, input: torque}")
    _core.add_trial(dataset, "trial_01", [stream])
    _core.write_dataset(dataset, str(tmp_path), "made by a test")
    back = jaculus.load_dataset(tmp_path).trials[0]["joints"]
    np.testing.assert_allclose(back["pendulum"], values[0], atol=1e-15)


def test_an_effect_in_python_is_that_of_the_catalogue(trials):
    class Rub(jaculus.Effect):
        name, caption, at = "own_rub", "viscous friction", {"joint": "pendulum"}
        parameters = {"rub": {"unit": "N m s/rad", "nominal": 0, "bounds": [0, 1], "scale": 0.05}}

        def torque(self, qd, rub):
            return -rub * qd

    own = jaculus.simulate("pendulum_trials", trials=2, seed=3, own_effects=Rub(),
                           effects={"own_rub": {"rub": 0.05}})
    ours, theirs = (of.trials[0]["joints"].values for of in (own, trials))
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-6)


def test_derivatives_of_a_term_in_python():
    class Speed(jaculus.Term):
        name, meaning, reads = "own_speed", "how fast it may be", ("velocity",)

        def rows(self, keys):
            return [jaculus.Row("speed squared", "m^2/s^2", 0.0, 100.0)]

        def value(self, point, keys):
            return point.velocity["slide"] ** 2

        def jacobian(self, point, keys):
            return {("velocity", "slide"): 2.0 * point.velocity["slide"]}

    problem = {"format": "jaculus-problem/1", "extends": "double_integrator.yaml", "name": "own",
               "constraints": [{"type": "own_speed"}]}
    assert jaculus.check_derivatives(problem, terms=Speed()).error < 1e-6


def test_a_diagnosis_a_preflight_and_a_study(trials):
    found = jaculus.diagnose(trials)
    assert found.verdict == "effect" and found.effects[0]["name"] == "joint_viscous_friction"
    assert not jaculus.preflight("pendulum_trials", trials=1).possible
    study = jaculus.study("drag_bench")
    assert study.complete and len(study.figures["rows"]) > 1
