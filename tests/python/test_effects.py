"""Effects in Python: the same motion as of formulas in a file, found by a diagnosis, faults told."""
import numpy as np
import pytest

import jaculus

PARAMETERS = {"rub": {"unit": "N m s/rad", "nominal": 0, "bounds": [0, 1], "scale": 0.05}}


class Rub(jaculus.Effect):
    name = "own_rub"
    caption = "drag that lags behind the rate"
    at = {"joint": "pendulum"}
    parameters = {**PARAMETERS, "lag": {"unit": "s", "nominal": 0.05, "bounds": [0.01, 1], "scale": 0.05}}
    states = {"w": {"unit": "rad/s", "initial": 0}}

    def torque(self, rub, w):
        return -rub * w

    def rates(self, lag, qd, w):
        return (qd - w) / lag


FILE = """
format: jaculus-effect/1
name: own_rub
caption: drag that lags behind the rate
at: {joint: pendulum}
parameters:
  rub: {unit: N m s/rad, nominal: 0, bounds: [0, 1], scale: 0.05}
  lag: {unit: s, nominal: 0.05, bounds: [0.01, 1], scale: 0.05}
states:
  w: {unit: rad/s, initial: 0, derivative: (qd - w)/lag}
torque: -rub*w
"""
AT_WORK = {"own_rub": {"rub": 0.08, "lag": 0.1}}


def joints(dataset):
    return dataset.trials[0]["joints"].values


def test_it_moves_the_robot_as_the_same_formulas_do(tmp_path):
    file = tmp_path / "own_rub.yaml"
    file.write_text(FILE)
    ours = jaculus.simulate("pendulum_trials", trials=1, effects=AT_WORK, own_effects=[Rub()])
    written = jaculus.simulate("pendulum_trials", trials=1, effects=AT_WORK, effect_files=[file])
    without = jaculus.simulate("pendulum_trials", trials=1)
    np.testing.assert_allclose(joints(ours), joints(written), rtol=0, atol=1e-9)
    assert np.abs(joints(ours) - joints(without)).max() > 0.1
    assert "own_rub" in ours.summary


def test_checks_of_it_are_those_of_files(tmp_path):
    file = tmp_path / "own_rub.yaml"
    file.write_text(FILE)
    ours = jaculus.check_effect(Rub(), "pendulum_trials")
    written = jaculus.check_effect(file, "pendulum_trials")
    assert ours.passed and ours.to_pandas().what.tolist() == written.to_pandas().what.tolist()
    assert "nominal changes nothing: bit for bit" in ours.summary and "0 failed" in repr(ours)


class Kick(Rub):
    """Not smooth in its parameter: at work at once, however small."""
    name, parameters, states = "own_kick", PARAMETERS, {}

    def torque(self, rub):
        return 0.5 if rub > 0 else 0.0


def test_checks_tell_what_is_no_effect():
    failed = jaculus.check_effect(Kick(), "pendulum_trials")
    assert not failed.passed
    assert not next(c for c in failed.checks if c["what"] == "fades to nothing")["passed"]


class Drag(Rub):
    name, parameters, states = "own_drag", PARAMETERS, {}
    reads = {"rate": "pendulum.qd"}

    def torque(self, rate, rub):
        return -rub * rate * abs(rate)

    rates = None


QUICK = {"largest_model": 1, "kept_singles": 1}


def test_a_diagnosis_names_it_and_its_augmented_model_plays(tmp_path):
    trials = jaculus.simulate("pendulum_trials", trials=3, effects={"own_drag": {"rub": 0.03}},
                              own_effects=Drag())
    found = jaculus.diagnose(trials, settings=QUICK, own_effects=[Drag()])
    assert [effect["name"] for effect in found.effects] == ["own_drag"]
    file = tmp_path / "augmented.yaml"
    file.write_text(found.augmented)
    again = jaculus.simulate("pendulum_trials", trials=1, augmented=file, own_effects=[Drag()])
    assert "own_drag rub=" in again.provenance
    with pytest.raises(jaculus.InputError, match="unknown effect 'own_drag'"):
        jaculus.simulate("pendulum_trials", trials=1, augmented=file)


def test_one_that_is_given_must_be_named():
    with pytest.raises(jaculus.InputError, match="none names 'own_drag'"):
        jaculus.simulate("pendulum_trials", own_effects=Drag())


class Push(jaculus.Effect):
    name = "own_push"
    caption = "wind"
    at = {"body": "base", "point": [0.0, 0.0]}
    parameters = {"force_per_time": {"unit": "N/s", "nominal": 0, "bounds": [-100, 100], "scale": 5}}

    def force(self, t, force_per_time):
        return force_per_time * t, 0.0


def test_a_force_acts_on_a_body():
    with_it, without = (
        jaculus.simulate("leap_trials", trials=1, effects=effects, own_effects=own)
        for effects, own in (({"own_push": {"force_per_time": 40.0}}, [Push()]), (None, [])))
    moved = with_it.trials[0]["mocap"]["x"] - without.trials[0]["mocap"]["x"]
    assert np.nanmax(moved) > 0.003


class Weak(jaculus.Effect):
    name = "own_weakness"
    caption = "the motor gives less"
    at = {"joint": "pendulum"}
    parameters = {"lost": {"unit": "-", "nominal": 0, "bounds": [0, 0.9], "scale": 0.1}}

    def torque_scale(self, lost):
        return 1.0 - lost


def test_a_motor_is_weakened_as_by_the_catalogue():
    ours = jaculus.simulate("pendulum_trials", trials=1, effects={"own_weakness": {"lost": 0.5}},
                            own_effects=Weak())
    full = jaculus.simulate("pendulum_trials", trials=1)
    reach = [np.nanmax(np.abs(d.trials[0]["joints"]["pendulum"])) for d in (ours, full)]
    assert 0.2 < reach[0] / reach[1] < 0.8


def changed(**attributes):
    return type("Changed", (Drag,), attributes)()


def raises(self, rate, rub):
    raise ZeroDivisionError("by my own fault")


@pytest.mark.parametrize("effect, error, message", [
    (changed(torque=lambda self, speed, rub: 0.0), jaculus.InputError, "unknown name 'speed'; allowed"),
    (changed(torque=lambda self, rub: rub + 0.2), jaculus.InputError, r"torque is 0.2 at nominal"),
    (changed(torque=lambda self, rub: (rub, rub)), ValueError, "Changed.torque gave 2 values; allowed: 1"),
    (changed(torque=lambda self, *numbers: 0.0), TypeError, r"\*numbers given; allowed"),
    (changed(at={"joint": "elbow"}), jaculus.InputError, "no joint 'elbow'; allowed: pendulum"),
    (changed(name="payload"), jaculus.InputError, "'payload' is an effect of jaculus"),
    (changed(parameters={"rub": {**PARAMETERS["rub"], "unit": "Nms"}}), jaculus.InputError, "a unit of SI"),
    (changed(torque=None, force=lambda self, rub: rub), jaculus.InputError, "'pendulum' turns"),
    (changed(torque=raises), ZeroDivisionError, "by my own fault"),
    ("own_drag", TypeError, "that is a jaculus.Effect"),
])
def test_faults_are_told(effect, error, message):
    with pytest.raises(error, match=message):
        jaculus.check_effect(effect, "pendulum_trials") if isinstance(effect, jaculus.Effect) else \
            jaculus.simulate("pendulum_trials", own_effects=[effect])


class Late(Drag):
    """Whose fault shows in the middle of a run."""

    def torque(self, t, rub):
        return -rub if t < 0.5 else 1.0 / (rub - rub)


def test_an_exception_within_a_run_reaches_the_caller():
    with pytest.raises(ZeroDivisionError):
        jaculus.simulate("pendulum_trials", effects={"own_drag": {"rub": 0.03}}, own_effects=Late())
