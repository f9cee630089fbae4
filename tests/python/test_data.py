import json
import os
import pathlib
import signal
import subprocess
import sys

import numpy as np
import pytest

import jaculus
from jaculus._command import program

SHARED = pathlib.Path(os.environ.get("JACULUS_DATA", "../shared/data"))


def test_a_simulation_has_streams_of_named_channels(pendulum_trials):
    assert [trial.name for trial in pendulum_trials.trials] == ["trial_01", "trial_02"]
    stream = pendulum_trials.trials[0]["joints"]
    assert stream.values.shape == (len(stream.time), len(stream.channels))
    assert stream.units[stream.channels[0]] == "rad"
    frame = pendulum_trials.to_pandas("joints")
    assert frame.index.names == ["trial", "time"]
    assert "joint_viscous_friction" in pendulum_trials.summary


def test_a_saved_dataset_comes_back(pendulum_trials, tmp_path):
    pendulum_trials.save(tmp_path)
    back = jaculus.load_dataset(tmp_path)
    for ours, theirs in zip(pendulum_trials.trials, back.trials):
        np.testing.assert_array_equal(ours["joints"].values, theirs["joints"].values)


def test_effects_are_given_as_dicts_or_as_texts(pendulum_trials):
    again = jaculus.simulate("pendulum_trials", trials=2, seed=3,
                             effects=["joint_viscous_friction:coefficient=0.05"])
    np.testing.assert_array_equal(again.trials[1]["joints"].values,
                                  pendulum_trials.trials[1]["joints"].values)
    with pytest.raises(jaculus.InputError, match="unknown effect"):
        jaculus.simulate("pendulum_trials", effects={"no_such_thing": {"a": 1}})


def test_an_experiment_may_be_a_dict():
    given = {"format": "jaculus-experiment/1", "name": "swing", "experiment": "pendulum",
             "robot": "ak80_pendulum", "input": {"torque": {"pendulum": [[0, 0.5], [0.2, 0]]}},
             "initial": {"pendulum": 0}, "controller": {"kind": "torque"}, "duration": 0.5,
             "streams": {"joints": {"rate_hz": 200, "channels": ["*"], "noise": {"*": 1e-9}}}}
    stream = jaculus.simulate(given).trials[0]["joints"]
    assert np.max(stream["pendulum"]) > 0.01  # pushed that way


def test_a_plan_is_played_on_its_robot(leap, tmp_path):
    dataset = jaculus.simulate(leap.save(tmp_path), robot="minitaur_tail", trials=1)
    assert dataset.figures["trials"][0]["status"] == "done"
    assert dataset.plot().axes


def test_a_diagnosis_finds_what_was_planted(pendulum_trials, tmp_path):
    stages = []
    found = jaculus.diagnose(pendulum_trials, progress=stages.append)
    assert found.verdict == "effect" and found.effects[0]["name"] == "joint_viscous_friction"
    assert found.gap["after"] < found.gap["before"]
    assert stages and "verdict: effect" in found.summary
    assert "joint_viscous_friction" in set(found.to_pandas()["effect"])
    found.save(tmp_path)
    assert json.loads((tmp_path / "diagnosis.json").read_text()) == found.figures


def test_a_horizon_and_tolerances_are_texts_or_numbers_in_si(pendulum_trials):
    quick = {"largest_model": 1, "kept_singles": 1}
    ways = [{"horizon": "200 ms", "tolerances": {"pendulum": "0.01 rad"}},
            {"horizon": 0.2, "tolerances": {"pendulum": np.float64(0.01)}}]
    texts, numbers = (jaculus.diagnose(pendulum_trials, settings=quick, **way) for way in ways)
    assert texts.json == numbers.json
    with pytest.raises(jaculus.InputError, match="horizon: '-1.0 s' given; allowed: ") as caught:
        jaculus.diagnose(pendulum_trials, horizon=-1)
    assert caught.value.key == "horizon"


CHECKED = """
import signal, threading, time, jaculus
signal.signal(signal.SIGINT, signal.default_int_handler)
def ctrl_c():
    time.sleep(0.3)
    signal.raise_signal(signal.SIGINT)
threading.Thread(target=ctrl_c).start()
try:
    for _ in range(100):
        jaculus.check_derivatives("leap_tail")
except KeyboardInterrupt as stop:
    print(type(stop).__name__)
"""


def test_ctrl_c_is_not_lost_in_work_that_takes_no_notice():
    out = subprocess.run([sys.executable, "-c", CHECKED], capture_output=True, text=True, check=True)
    assert out.stdout == "KeyboardInterrupt\n"


def test_an_exception_of_the_progress_ends_a_diagnosis(pendulum_trials):
    def stop(stage):
        raise LookupError(stage)

    with pytest.raises(LookupError):
        jaculus.diagnose(pendulum_trials, progress=stop)


DIAGNOSED = """
import signal, sys, jaculus
signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored in a shell's background
jaculus.diagnose(sys.argv[1], progress=lambda stage: print(stage, flush=True))
"""


def test_ctrl_c_ends_a_diagnosis(pendulum_trials, tmp_path):
    pendulum_trials.save(tmp_path)
    diagnosing = subprocess.Popen([sys.executable, "-c", DIAGNOSED, tmp_path], text=True,
                                  stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert diagnosing.stdout.readline()  # a first stage has begun
    diagnosing.send_signal(signal.SIGINT)
    _, told = diagnosing.communicate(timeout=20)
    assert told.rstrip().endswith("KeyboardInterrupt")
    assert diagnosing.returncode == -signal.SIGINT


@pytest.mark.skipif(not (SHARED / "pendulum/ak80").is_dir(), reason="the shared data are absent")
def test_a_diagnosis_of_a_log_is_that_of_the_command(tmp_path):
    folder = SHARED / "pendulum/ak80"
    told = subprocess.run([program(), "diagnose", folder, "--json"], capture_output=True, text=True,
                          check=True).stdout
    assert jaculus.diagnose(folder).json == told


def test_a_study_has_a_row_a_point(tmp_path):
    study = jaculus.study("drag_bench", out=tmp_path)
    assert study.complete and len(study.to_pandas()) == len(study.figures["rows"])
    assert list(study.to_pandas().columns) == study.columns
    assert (tmp_path / "study.csv").is_file() and study.summary.startswith("drag_bench")
