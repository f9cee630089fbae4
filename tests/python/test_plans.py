import json
import os
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import jaculus
from jaculus._command import program

INTEGRATOR = {
    "format": "jaculus-problem/1",
    "extends": "double_integrator.yaml",
    "name": "from_a_dict",
}


def test_a_plan_has_named_arrays_of_one_length(leap):
    samples = len(leap.time)
    assert leap.converged and leap.status == "optimal"
    assert leap.states.shape == (samples, len(leap.state_names))
    assert leap.inputs.shape == (samples, len(leap.input_names))
    assert leap.forces.shape == (samples, len(leap.foot_names), 2)
    assert len(leap.phase) == samples
    assert np.all(np.diff(leap.time) >= 0.0)


def test_states_and_inputs_are_columns_of_the_table(leap):
    for name in ("x", "pitch", "tail", "x_velocity"):
        np.testing.assert_array_equal(leap.states[:, leap.state_names.index(name)], leap[name])
    np.testing.assert_array_equal(leap.inputs[:, leap.input_names.index("tail")], leap["tail_torque"])
    assert leap.units["tail_torque"] == "N m" and leap.units["pitch"] == "rad"


def test_the_rates_of_a_plan_are_those_of_its_motion(leap):
    x, rate = leap["x"], leap["x_velocity"]
    gained = np.sum(np.diff(leap.time) * (rate[1:] + rate[:-1]) / 2)
    assert x[-1] - x[0] == pytest.approx(gained, rel=1e-3)


def test_figures_are_those_of_the_command(leap, tmp_path):
    leap.save(tmp_path)
    assert json.loads((tmp_path / "summary.json").read_text()) == leap.figures
    for file in ("plan.csv", "solution.json", "report.html"):
        assert (tmp_path / file).stat().st_size > 0
    assert "optimal" in leap.summary and leap.figures["name"] == "leap_tail"


def test_a_plan_becomes_a_frame_with_units(leap):
    frame = leap.to_pandas()
    assert frame.index.name == "time" and len(frame) == len(leap.time)
    assert frame.attrs["units"]["x"] == "m"
    np.testing.assert_array_equal(frame["x"].to_numpy(), leap["x"])


def test_an_unknown_column_is_told_with_those_there_are(leap):
    with pytest.raises(KeyError, match="tail_torque"):
        leap["tial_torque"]


def test_a_plan_is_drawn_and_shown(leap):
    figure = leap.plot()
    assert [axis.get_ylabel() for axis in figure.axes][1] == "torque [N m]"
    assert leap._repr_html_().startswith("<iframe") and "leap_tail" in leap._repr_html_()


def test_a_dict_is_a_problem():
    plan = jaculus.solve(INTEGRATOR)
    assert plan.converged and plan.problem.name == "from_a_dict"
    assert plan.figures["objective"] == pytest.approx(jaculus.solve("double_integrator").objective)


def test_an_override_changes_the_robot_of_the_plan():
    heavy = jaculus.load_problem("leap_tail", override={"bodies.base.mass": 9.0})
    plain = jaculus.load_problem("leap_tail")
    base = float(plain.robot.values["bodies.base.mass"].split()[0])
    assert heavy.robot.mass - plain.robot.mass == pytest.approx(9.0 - base)


def test_progress_is_called_and_its_exception_ends_the_solve():
    seen = []
    jaculus.solve("double_integrator", progress=lambda *figures: seen.append(figures))
    assert [figures[0] for figures in seen] == list(range(len(seen))) and len(seen) > 2

    class Enough(Exception):
        pass

    def stop(iteration, objective, infeasibility):
        raise Enough(f"at {iteration}")

    with pytest.raises(Enough, match="at 0"):
        jaculus.solve("leap_tail", progress=stop)
    assert jaculus.solve("double_integrator").converged  # the flag is down again


def test_other_threads_run_while_it_solves():
    counted = []
    done = threading.Event()

    def count():
        while not done.wait(0.005):
            counted.append(time.monotonic())

    thread = threading.Thread(target=count)
    thread.start()
    jaculus.solve("leap_tail")
    done.set()
    thread.join()
    assert len(counted) > 10


def test_two_threads_solve_one_after_the_other():
    plans = [None, None]

    def work(k):
        plans[k] = jaculus.solve("double_integrator")

    threads = [threading.Thread(target=work, args=(k,)) for k in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    np.testing.assert_array_equal(plans[0].states, plans[1].states)


INTERRUPTED = """
import signal, time, jaculus
signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored in a shell's background
def ctrl_c(iteration, objective, infeasibility):
    if iteration == 3:
        signal.raise_signal(signal.SIGINT)
try:
    jaculus.solve("leap_tail", progress=ctrl_c)
except KeyboardInterrupt as stop:
    print(type(stop).__name__, stop.result.status, stop.result.converged, len(stop.result.time) > 0)
try:
    signal.raise_signal(signal.SIGINT)
    time.sleep(5)
except KeyboardInterrupt:
    print("Python's handler is back")
"""


def test_ctrl_c_leaves_the_last_iterate():
    out = subprocess.run([sys.executable, "-c", INTERRUPTED], capture_output=True, text=True, check=True)
    assert out.stdout.splitlines() == ["Interrupted interrupted False True", "Python's handler is back"]


STARTS = """
import signal, sys, threading, time, pathlib, jaculus
signal.signal(signal.SIGINT, signal.default_int_handler)
problem = {"format": "jaculus-problem/1", "extends": "double_integrator.yaml", "name": "many"}
def ctrl_c():
    time.sleep(0.5)
    signal.raise_signal(signal.SIGINT)
threading.Thread(target=ctrl_c).start()
try:
    jaculus.solve(problem, starts=10000, jobs=2)
except jaculus.Interrupted as stop:
    plan = stop.result
    print(stop)
    print(plan.converged, plan.status, next(w for w in plan.figures["warnings"] if "interrupted" in w))
"""


def test_ctrl_c_leaves_the_best_of_the_starts_that_ended():
    out = subprocess.run([sys.executable, "-c", STARTS], capture_output=True, text=True, check=True)
    message, plan = out.stdout.splitlines()
    assert message == "many: interrupted; result has the best plan until then"
    assert plan.startswith("True optimal interrupted: ") and "of 10000 starts had ended" in plan


def test_a_comparison_has_gains_over_the_first(leap):
    comparison = jaculus.compare(["leap_tailless", leap])
    frame = comparison.to_pandas()
    assert len(frame) == 2 and comparison.plans[1] is leap
    assert "leap_tailless" in comparison.summary
    assert comparison.figures["problems"][1]["name"] == "leap_tail"
    assert len(comparison.plot().axes[0].lines) == 2


def test_a_comparison_writes_what_the_command_writes(leap, tmp_path):
    subprocess.run([program(), "compare", "leap_tailless", "leap_tail", "--quiet", "--out",
                    tmp_path / "command"], check=True)
    comparison = jaculus.compare(["leap_tailless", leap])
    assert comparison.save(tmp_path / "package") == tmp_path / "package"
    for file in ("compare.json", "compare.csv", "leap_tail/plan.csv", "leap_tailless/summary.json"):
        ours, theirs = ((tmp_path / of / file).read_text() for of in ("package", "command"))
        assert ours == theirs
    assert (tmp_path / "package/report.html").stat().st_size > 0
    with pytest.raises(jaculus.InputError, match="'leap_tail' names two of these plans") as caught:
        jaculus.compare([leap, leap]).save(tmp_path / "twice")
    assert caught.value.key == "name" and not (tmp_path / "twice").exists()


def test_one_problem_alone_can_be_compared():
    assert len(jaculus.compare("double_integrator").plans) == 1
    with pytest.raises(jaculus.InputError, match="one or more"):
        jaculus.compare([])


@pytest.mark.skipif(os.cpu_count() == 1, reason="forks beside each other")
def test_several_starts_run_in_processes_of_their_own():
    plan = jaculus.solve("double_integrator", starts=3, jobs=2)
    assert plan.converged
