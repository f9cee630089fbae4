"""jaculus.preflight is the command's answer, with arrays and tables of it."""
import json
import subprocess

import numpy as np
import pytest

import jaculus
from jaculus._command import program


@pytest.fixture(scope="module")
def planned():
    return jaculus.preflight("pendulum_trials", alternatives=False)


def test_it_is_that_of_the_command(planned, tmp_path):
    subprocess.run([program(), "preflight", "pendulum_trials", "--planned-only", "--quiet", "--out",
                    tmp_path / "command"], check=True)
    planned.save(tmp_path / "package")
    ours, theirs = ((tmp_path / of / "preflight.json").read_bytes() for of in ("package", "command"))
    assert ours == theirs and json.loads(ours) == planned.figures
    assert "Which could not be told apart" in (tmp_path / "package/report.html").read_text()


def test_it_says_what_would_be_named_and_told_apart(planned):
    assert planned.possible and not planned.reasons
    frame = planned.to_pandas()
    friction = frame.loc["joint_coulomb_friction"]
    assert friction["visible"] and friction["unit"] == "N m" and 0.0 < friction["least"] < 1.0
    assert 0.0 < planned.information < planned.uncertainty

    factors = planned.log_bayes_factors
    assert factors.shape == (len(planned.effects),) * 2 and np.isnan(np.diag(factors)).all()
    pairs = planned.pairs_to_pandas()
    assert len(pairs) == len(planned.pairs) > 0
    for pair in pairs.itertuples():
        a, b = planned.names.index(pair.a), planned.names.index(pair.b)
        np.testing.assert_equal(factors[[a, b], [b, a]], [pair.a_from_b, pair.b_from_a])
    mixed = {name for of in planned.sets for name in of}
    assert mixed == set(pairs[~pairs.tellable][["a", "b"]].to_numpy().ravel())
    assert planned.plot().axes and "not told apart" in repr(planned)


def test_one_trial_tells_nothing_and_says_why():
    alone = jaculus.preflight("pendulum_trials", trials=1)
    assert not alone.possible and "one trial" in alone.reasons[0]
    assert alone.log_bayes_factors.shape == (0, 0) and np.isnan(alone.information)
    assert alone.to_pandas().empty and "one trial" in repr(alone)


def test_stages_are_told_and_an_exception_ends_it():
    def stop(stage):
        raise LookupError(stage)

    with pytest.raises(LookupError, match="simulating"):
        jaculus.preflight("pendulum_trials", progress=stop)


@pytest.mark.parametrize("wrong", [{"size": 0.0}, {"trials": 0}, {"settings": {"no_such": 1}}])
def test_wrong_arguments_are_named(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong)) if "settings" not in wrong else "no_such"):
        jaculus.preflight("pendulum_trials", **wrong)
