import pickle
from importlib import metadata

import numpy as np
import pytest

import jaculus


def test_a_fault_names_file_line_and_key(tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text("format: jaculus-problem/1\nextends: leap_tail.yaml\nname: mine\n"
                    "limits:\n  voltage: 16 N m\n")
    with pytest.raises(jaculus.InputError) as caught:
        jaculus.solve(file)
    error = caught.value
    assert (error.file, error.line, error.key) == (str(file), 5, "limits.voltage")
    assert str(error).startswith(f"{file}:5: limits.voltage: ")
    assert isinstance(error, ValueError)


def test_a_fault_of_a_dict_names_its_key():
    with pytest.raises(jaculus.InputError) as caught:
        jaculus.solve({"format": "jaculus-problem/1", "extends": "leap_tail.yaml", "name": "mine",
                       "limits": {"voltage": "16 N m"}})
    assert caught.value.file == "dict" and caught.value.key == "limits.voltage"


def test_a_fault_in_a_table_names_its_line(tmp_path):
    jaculus.simulate("pendulum_trials", trials=1).save(tmp_path)
    table = next(tmp_path.glob("*/*.csv"))
    lines = table.read_text().splitlines()
    lines[4] = lines[3]  # a time that stands twice
    table.write_text("\n".join(lines) + "\n")
    with pytest.raises(jaculus.InputError) as caught:
        jaculus.load_dataset(tmp_path)
    assert (caught.value.file, caught.value.line, caught.value.key) == (str(table), 5, "time")


def test_an_unknown_name_is_told_with_the_nearest():
    with pytest.raises(jaculus.InputError, match="did you mean 'leap_tail'") as caught:
        jaculus.solve("leap_tial")
    assert caught.value.line is None
    with pytest.raises(jaculus.InputError, match="minitaur_tail"):
        jaculus.load_robot("minitaur_tial")


def test_a_dict_may_hold_numpy_values_and_paths(tmp_path):
    problem = jaculus.load_problem({"format": "jaculus-problem/1", "extends": "leap_tail.yaml",
                                    "name": "mine", "limits": {"voltage": np.float64(14.5)}})
    assert problem.to_dict()["limits"]["voltage"] == 14.5
    with pytest.raises(TypeError, match="set"):
        jaculus.load_problem({"name": {1, 2}})


def test_a_robot_tells_what_it_is():
    robot = jaculus.load_robot("minitaur_tail")
    assert robot.coordinates[:3] == ["x", "z", "pitch"] and "tail" in robot.motors
    assert robot.mass == pytest.approx(sum(
        float(value.split()[0]) for path, value in robot.values.items()
        if path.startswith("bodies.") and path.endswith(".mass")))
    assert robot.name in robot.summary


def test_a_file_of_others_becomes_a_robot_with_a_tail_and_its_leap(tmp_path):
    file = jaculus.load_robot("quadruped25").folder / "robot.urdf"
    robot = jaculus.import_robot(file, tmp_path / "mine", tail="2 kg", pose={"front_left_hip": 0.6})
    assert robot.mass == pytest.approx(jaculus.load_robot("quadruped25").mass + 2.0)
    assert "tail" in robot.motors
    assert any("friction" in line for line in robot.imported["to_fill_in"])
    leap = jaculus.load_problem(tmp_path / "mine/leap.yaml", override={"attach.tail.kind": "none"})
    assert leap.robot.mass == pytest.approx(robot.mass - 2.0)


def test_a_robot_that_is_there_is_kept_and_faults_of_a_file_are_told(tmp_path):
    file = jaculus.load_robot("pendulum").folder / "robot.urdf"
    jaculus.import_robot(file, tmp_path / "mine")
    with pytest.raises(jaculus.InputError, match="has a robot.yaml already"):
        jaculus.import_robot(file, tmp_path / "mine")
    assert jaculus.import_robot(file, tmp_path / "mine", replace=True).folder == tmp_path / "mine"
    with pytest.raises(jaculus.InputError, match="no_such.urdf"):
        jaculus.import_robot("no_such.urdf", tmp_path / "other")


def test_what_ships_can_be_named():
    assert {"leap_tail", "leap_trials", "fig4_shaft"} <= set(jaculus.shipped())
    assert "minitaur_tail" in jaculus.shipped("models") and "lugre" in jaculus.shipped("effects")
    for name in jaculus.shipped("models"):
        assert jaculus.load_robot(name).mass > 0.0


def test_the_version_is_the_packages():
    try:
        installed = metadata.version("jaculus")
    except metadata.PackageNotFoundError:
        pytest.skip("run from a build folder")
    assert jaculus.__version__ == installed


def test_an_error_keeps_its_message_in_a_pickle():
    try:
        jaculus.load_problem("nothing_like_it")
    except jaculus.InputError as error:
        assert str(pickle.loads(pickle.dumps(error))) == str(error)


@pytest.mark.parametrize("call, key", [
    (lambda: jaculus.solve("double_integrator", starts=0), "starts"),
    (lambda: jaculus.solve("double_integrator", jobs=-1), "jobs"),
    (lambda: jaculus.solve("double_integrator", jobs=1.5), "jobs"),
    (lambda: jaculus.solve("double_integrator", seed=-1), "seed"),
    (lambda: jaculus.simulate("pendulum_trials", trials=0), "trials"),
    (lambda: jaculus.simulate("pendulum_trials", seed=True), "seed"),
    (lambda: jaculus.simulate("pendulum_trials", effects=[("lugre", 1.0)]), "effects"),
    (lambda: jaculus.diagnose("no_such", jobs=0), "jobs"),
    (lambda: jaculus.diagnose("no_such", tolerances=0.01), "tolerances"),
    (lambda: jaculus.preflight("pendulum_trials", jobs=0), "jobs"),
    (lambda: jaculus.preflight("pendulum_trials", size=0.0), "size"),
    (lambda: jaculus.study("drag_bench", jobs=2000), "jobs"),
    (lambda: jaculus.check_derivatives("double_integrator", seed=-1), "seed"),
    (lambda: jaculus.check_derivatives("double_integrator", spread=-0.1), "spread"),
])
def test_a_number_that_means_nothing_is_refused(call, key):
    with pytest.raises(jaculus.InputError, match=f"^{key}: .* given; allowed: ") as caught:
        call()
    assert caught.value.key == key


def test_numpys_whole_numbers_are_whole():
    assert len(jaculus.simulate("pendulum_trials", trials=np.int64(1), seed=np.int32(2)).trials) == 1


def test_a_fault_of_a_robots_file_names_its_line(tmp_path):
    file = tmp_path / "broken.urdf"
    file.write_text("<robot name='broken'>\n<link name='a'/>\n<joint>\n</robot>\n")
    with pytest.raises(jaculus.InputError) as caught:
        jaculus.import_robot(file, tmp_path / "out")
    assert caught.value.file == str(file) and str(caught.value).startswith(str(file))
