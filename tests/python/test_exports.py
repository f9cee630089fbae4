"""Plans written by way of rosbags, read back by mcap-ros2-support, sqlite3 and Rerun's own program."""

import json
import re
import sqlite3
import subprocess
import sys

import numpy as np
import pytest

import jaculus

RATE = 200.0


@pytest.fixture(scope="session")
def exported(leap, tmp_path_factory):
    """The same plan as the program exports it."""
    from jaculus._command import program

    folder = tmp_path_factory.mktemp("exported")
    leap.save(folder / "leap")
    subprocess.run(
        [
            program(),
            "export",
            folder / "leap",
            "--as",
            "json",
            "--rate",
            str(RATE),
            "--out",
            folder / "leap.json",
        ],
        check=False,
        capture_output=True,
    )
    return json.loads((folder / "leap.json").read_text())


def fields(message):
    """Of mcap-ros2-support's messages and of rosbags'."""
    names = getattr(message, "__dataclass_fields__", None) or message.__slots__
    return [name for name in names if name != "__msgtype__"]


def nanoseconds(time):
    return time.sec * 10**9 + time.nanosec


def check(messages, exported, start):
    """Every field of (topic, type, message, log time), against what the program exports."""
    moving, held = exported["joints"], exported["held_joints"]
    names = [joint["name"] for joint in moving + held]
    nothing = [[0.0] * len(exported["time_s"])] * len(held)
    positions = np.array(
        [j["position"] for j in moving] + [[j["position"]] * len(exported["time_s"]) for j in held]
    ).T
    velocities = np.array([j["velocity"] for j in moving] + nothing).T
    efforts = np.array([j["torque"] for j in moving] + nothing).T
    times = [round(t * 1e9) for t in exported["time_s"]]

    (_, kind, plan, logged), *states = messages
    assert kind == "trajectory_msgs/msg/JointTrajectory" and logged == start
    assert fields(plan) == ["header", "joint_names", "points"] and list(plan.joint_names) == names
    assert nanoseconds(plan.header.stamp) == start and plan.header.frame_id == ""
    assert len(plan.points) == len(times)
    for k, point in enumerate(plan.points):
        assert fields(point) == [
            "positions",
            "velocities",
            "accelerations",
            "effort",
            "time_from_start",
        ]
        np.testing.assert_array_equal(point.positions, positions[k])
        np.testing.assert_array_equal(point.velocities, velocities[k])
        np.testing.assert_array_equal(point.effort, efforts[k])
        assert len(point.accelerations) == 0 and nanoseconds(point.time_from_start) == times[k]

    assert len(states) == len(times)
    for k, (topic, kind, state, logged) in enumerate(states):
        assert (topic, kind, logged) == (
            "/joint_states",
            "sensor_msgs/msg/JointState",
            start + times[k],
        )
        assert fields(state) == ["header", "name", "position", "velocity", "effort"]
        assert nanoseconds(state.header.stamp) == logged and state.header.frame_id == ""
        assert list(state.name) == names
        np.testing.assert_array_equal(state.position, positions[k])
        np.testing.assert_array_equal(state.velocity, velocities[k])
        np.testing.assert_array_equal(state.effort, efforts[k])


def test_mcap_holds_the_plan_for_another_reader(leap, exported, tmp_path):
    pytest.importorskip("rosbags", reason="bags need rosbags")
    decoder = pytest.importorskip("mcap_ros2.decoder", reason="needs mcap-ros2-support")
    from mcap.reader import make_reader

    file = leap.to_bag(tmp_path / "leap.mcap", rate=RATE, start=12.5)
    with open(file, "rb") as stream:
        reader = make_reader(stream, decoder_factories=[decoder.DecoderFactory()])
        assert reader.get_header().profile == "ros2"
        read = [(c.topic, s.name, m, r.log_time) for s, c, r, m in reader.iter_decoded_messages()]
    first = [entry for entry in read if entry[0] == "/joint_trajectory"]
    check(
        first + [entry for entry in read if entry[0] != "/joint_trajectory"],
        exported,
        12_500_000_000,
    )
    leap.to_bag(file, rate=10.0)  # is replaced
    assert len(exported["joints"]) > len(leap.input_names)  # left and right


def test_sqlite3_holds_the_plan_for_another_reader(leap, exported, tmp_path):
    pytest.importorskip("rosbags", reason="bags need rosbags")
    dynamic = pytest.importorskip("mcap_ros2._dynamic", reason="needs mcap-ros2-support")
    folder = leap.to_bag(tmp_path / "leap", rate=RATE)
    (file,) = folder.glob("*.db3")
    base = sqlite3.connect(file)
    definitions = dict(
        base.execute("SELECT topic_type, encoded_message_definition FROM message_definitions")
    )
    topics = {
        i: (name, kind) for i, name, kind in base.execute("SELECT id, name, type FROM topics")
    }
    decoders = {
        kind: dynamic.generate_dynamic(kind, text)[kind] for kind, text in definitions.items()
    }
    rows = base.execute("SELECT topic_id, timestamp, data FROM messages ORDER BY id").fetchall()
    check([(*topics[i], decoders[topics[i][1]](data), time) for i, time, data in rows], exported, 0)
    with pytest.raises(jaculus.InputError, match="exists; allowed: a new folder"):
        leap.to_bag(folder)


@pytest.mark.parametrize("name", ["leap.mcap", "leap"])
def test_rosbags_reads_every_field_by_the_bags_own_definitions(leap, exported, tmp_path, name):
    highlevel = pytest.importorskip("rosbags.highlevel", reason="bags need rosbags")
    file = leap.to_bag(tmp_path / name, rate=RATE, start=12.5)
    with highlevel.AnyReader([file]) as reader:
        read = [
            (c.topic, c.msgtype, reader.deserialize(raw, c.msgtype), time)
            for c, time, raw in reader.messages()
        ]
    read.sort(key=lambda entry: entry[0] != "/joint_trajectory")
    check(read, exported, 12_500_000_000)


def test_definitions_in_the_bag_are_those_of_ros(leap, tmp_path):
    """Fields and types in order, as common_interfaces has them."""
    pytest.importorskip("rosbags", reason="bags need rosbags")
    reader = pytest.importorskip("mcap.reader", reason="needs mcap")
    with open(leap.to_bag(tmp_path / "leap.mcap", rate=RATE), "rb") as stream:
        schemas = {
            s.name: s.data.decode()
            for s in reader.make_reader(stream).get_summary().schemas.values()
        }
    whole = {
        name: re.sub(r"\s+", " ", re.split("=+\n", text)[0]).strip()
        for name, text in schemas.items()
    }
    assert whole == {
        "trajectory_msgs/msg/JointTrajectory": "std_msgs/Header header string[] joint_names trajectory_msgs/JointTrajectoryPoint[] points",
        "sensor_msgs/msg/JointState": "std_msgs/Header header string[] name float64[] position float64[] velocity float64[] effort",
    }


def test_a_plan_comes_back_as_the_plan_of_a_dataset(leap, exported, tmp_path):
    """Left and right become one again."""
    pytest.importorskip("rosbags", reason="bags need rosbags")
    bag = leap.to_bag(tmp_path / "leap.mcap", rate=RATE)
    dataset = jaculus.import_bag(bag, tmp_path / "out", robot="minitaur_tail")
    stream = dataset.trials[0]["joints"]
    for joint in exported["joints"]:
        if joint["motor"] in stream.channels:
            np.testing.assert_allclose(
                stream[joint["motor"]],
                joint["sign"] * np.array(joint["position"]),
                rtol=0,
                atol=1e-15,
            )
    assert set(leap.input_names) <= set(stream.channels)
    np.testing.assert_allclose(stream.time, exported["time_s"], rtol=0, atol=1e-9)


def test_an_unsolved_plan_is_exported_only_on_request(tmp_path):
    pytest.importorskip("rosbags", reason="bags need rosbags")
    plan = jaculus.solve(
        {
            "format": "jaculus-problem/1",
            "extends": "double_integrator.yaml",
            "name": "cut_short",
            "solver": {"max_iterations": 1},
        }
    )
    assert not plan.converged
    with pytest.raises(jaculus.InputError, match="did not converge"):
        plan.to_bag(tmp_path / "plan.mcap")
    with pytest.raises(jaculus.InputError, match="allowed: 1 to 1e6 Hz"):
        plan.to_bag(tmp_path / "plan.mcap", rate=0.0, even_unsolved=True)
    assert plan.to_bag(tmp_path / "plan.mcap", even_unsolved=True).is_file()


def scalars(file):
    """(times [ns], values) by entity of a recording, by Rerun's own reader."""
    reader = pytest.importorskip("rerun.chunk", reason="needs a rerun-sdk that reads recordings")
    read = {}
    for chunk in reader.RrdReader(str(file)).stream().to_chunks():
        columns = chunk.to_record_batch().to_pydict()
        if "Scalars:scalars" in columns:
            times, values = read.setdefault(str(chunk.entity_path), ([], []))
            times += [round(time.total_seconds() * 1e9) for time in columns["time"]]
            values += [value for (value,) in columns["Scalars:scalars"]]
    return read


def test_rerun_reads_the_recording(leap, exported, tmp_path):
    pytest.importorskip("rerun", reason="needs rerun-sdk")
    file = leap.to_rerun(tmp_path / "leap.rrd", rate=RATE)
    subprocess.run([sys.executable, "-m", "rerun", "rrd", "verify", file], check=True)

    read = scalars(file)
    for joint in exported["joints"]:
        for quantity, ours in (
            ("position", "position"),
            ("velocity", "velocity"),
            ("effort", "torque"),
        ):
            times, values = read[f"/joints/{joint['name']}/{quantity}"]
            np.testing.assert_array_equal(values, joint[ours])
            np.testing.assert_allclose(times, np.array(exported["time_s"]) * 1e9, rtol=0, atol=1.0)
    for joint in exported["held_joints"]:
        assert set(read[f"/joints/{joint['name']}/position"][1]) == {joint["position"]}
    for column in leap.columns[1:]:
        np.testing.assert_array_equal(read[f"/plan/{column}"][1], leap[column])


def test_xarray_has_the_arrays_with_their_names(leap, pendulum_trials):
    pytest.importorskip("xarray", reason="needs xarray")
    plan = leap.to_xarray()
    assert plan.states.shape == leap.states.shape and plan.forces.dims == ("time", "foot", "axis")
    np.testing.assert_array_equal(plan.states.sel(state="pitch"), leap["pitch"])
    assert str(plan.state_units.sel(state="x_velocity").item()) == "m/s"
    np.testing.assert_array_equal(plan.inputs.sel(input="tail"), leap["tail_torque"])
    stream = pendulum_trials.trials[0]["joints"]
    np.testing.assert_array_equal(stream.to_xarray()["pendulum"], stream["pendulum"])
    assert stream.to_xarray()["pendulum"].attrs["units"] == "rad"


def test_joints_of_the_robots_file_have_what_the_program_exports(leap, exported):
    joints = leap.to_joints(rate=RATE)
    moving, held = exported["joints"], exported["held_joints"]
    assert joints.names == [joint["name"] for joint in moving + held]
    np.testing.assert_array_equal(joints.time, exported["time_s"])
    for k, joint in enumerate(moving):
        for values, key in (
            (joints.position, "position"),
            (joints.velocity, "velocity"),
            (joints.effort, "torque"),
        ):
            np.testing.assert_allclose(values[:, k], joint[key], atol=1e-12)


def test_joints_name_the_plans_joint_and_sign(leap):
    joints = leap.to_joints(rate=RATE)
    for k, name in enumerate(joints.names):
        joint, sign = joints.planned[name]
        column = joint if joint in leap.columns else None
        if column:
            assert joints.position[0, k] == pytest.approx(sign * leap[column][0], abs=1e-9)
    with pytest.raises(jaculus.InputError, match="rate: 0 given"):
        leap.to_joints(rate=0)
