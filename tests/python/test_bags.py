"""Bags written by mcap-ros2-support, or by sqlite3 and its CDR, imported by way of rosbags."""
import math
import os
import pathlib
import subprocess
import sys

import numpy as np
import pytest

import jaculus

pytest.importorskip("rosbags", reason="bags need rosbags")
pytest.importorskip("mcap_ros2", reason="tests of bags need mcap-ros2-support")
import bag_files  # noqa: E402
from bag_files import EPOCH, HEADER, STD_HEADER, stamp  # noqa: E402

SHARED = pathlib.Path(os.environ.get("JACULUS_DATA", "../shared/data"))
MEASURED = "{kind: measured, input: torque}"
ROWS = [(0.002 * k, math.sin(k), 2.0 * math.cos(k), 0.1 * k) for k in range(50)]
PENDULUM = {"robot": "ak80_pendulum", "experiment": "pendulum", "controller": MEASURED}


def mcap(folder, messages, name="log.mcap"):
    return bag_files.write_mcap(folder / name, messages)


def header(time_s, frame=""):
    return {"stamp": stamp(EPOCH + round(time_s * 1e9)), "frame_id": frame}


def has(dataset, text):
    return any(text in note for note in dataset.notes)


# Joints

def test_joint_states_come_over_exactly_with_the_stamps_of_their_headers(tmp_path):
    bag = mcap(tmp_path, bag_files.joint_states(ROWS, "pendulum"))
    dataset = jaculus.import_bag(bag, tmp_path / "out", **PENDULUM)
    stream = dataset.trials[0]["joints"]
    np.testing.assert_array_equal(stream.values, [row[1:] for row in ROWS])
    np.testing.assert_allclose(stream.time, [row[0] for row in ROWS], rtol=0, atol=1e-15)
    assert stream.units == {"pendulum": "rad", "pendulum_velocity": "rad/s", "pendulum_torque": "N m"}
    assert has(dataset, "headers' stamps (recorded 1.5 ms later") and has(dataset, "effort is taken as the torque")
    assert "effort is taken" in (tmp_path / "out/dataset.yaml").read_text()


@pytest.mark.parametrize("definitions", [False, True])
def test_sqlite3_bags_are_read_with_definitions_and_without(tmp_path, definitions):
    bag = bag_files.write_sqlite3(tmp_path / "bag", bag_files.joint_states(ROWS, "pendulum"), definitions)
    dataset = jaculus.import_bag(bag, tmp_path / "out", **PENDULUM)
    np.testing.assert_array_equal(dataset.trials[0]["joints"].values, [row[1:] for row in ROWS])
    assert has(dataset, "doesn't define sensor_msgs/msg/JointState: read as in ROS 2 Humble") != definitions


def test_left_and_right_joints_of_the_robots_file_become_one_with_their_signs(tmp_path):
    signs = bag_files.file_joints("minitaur_tail")["front_a"]
    names = [*signs, "gripper"]
    message = {"header": header(0.0), "name": names, "velocity": [],
               "position": [*(sign * 0.3 for sign in signs.values()), 1.0], "effort": []}
    later = {**message, "header": header(0.1), "name": names[:1], "position": [list(signs.values())[0] * 0.5]}
    bag = mcap(tmp_path, [("/joint_states", "sensor_msgs/msg/JointState", bag_files.JOINT_STATE, m, EPOCH + k)
                          for k, m in enumerate((message, later))])
    dataset = jaculus.import_bag(bag, tmp_path / "out", robot="minitaur_tail", controller=COMMANDED,
                                 plan=two_point_plan(tmp_path))
    stream = dataset.trials[0]["joints"]
    assert stream.channels == ["front_a"] and len(signs) == 2
    np.testing.assert_allclose(stream["front_a"], [0.3, 0.5], rtol=1e-15)
    assert has(dataset, "left out, as the robot has no such joints: gripper")
    assert has(dataset, f"front_a is the mean of {', '.join(sorted(signs))}")


def test_joints_are_renamed_by_the_map_and_unknown_ones_told(tmp_path):
    bag = mcap(tmp_path, bag_files.joint_states(ROWS, "axis0"))
    renamed = {"format": "jaculus-bag/1", "topics": {"/joint_states": {"joints": {"axis0": "pendulum"}}}}
    dataset = jaculus.import_bag(bag, tmp_path / "out", columns=renamed, **PENDULUM)
    np.testing.assert_array_equal(dataset.trials[0]["joints"]["pendulum"], [row[1] for row in ROWS])
    with pytest.raises(jaculus.InputError, match="none of its joints is one of the robot's; allowed: pendulum"):
        jaculus.import_bag(bag, tmp_path / "out", **PENDULUM)
    renamed["topics"]["/joint_states"]["joints"]["axis0"] = "pendulun"
    with pytest.raises(jaculus.InputError, match="no joint 'pendulun', did you mean 'pendulum'"):
        jaculus.import_bag(bag, tmp_path / "out", columns=renamed, **PENDULUM)


# Poses

POSE = ("geometry_msgs/Pose pose\n" + STD_HEADER + bag_files.separate("geometry_msgs/Pose")
        + "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n"
        + bag_files.separate("geometry_msgs/Point") + "float64 x\nfloat64 y\nfloat64 z\n"
        + bag_files.separate("geometry_msgs/Quaternion") + "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n")
ODOMETRY = (HEADER + "string child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n"
            "geometry_msgs/TwistWithCovariance twist\n" + bag_files.separate("geometry_msgs/PoseWithCovariance")
            + "geometry_msgs/Pose pose\nfloat64[36] covariance\n"
            + bag_files.separate("geometry_msgs/TwistWithCovariance")
            + "geometry_msgs/Twist twist\nfloat64[36] covariance\n" + bag_files.separate("geometry_msgs/Twist")
            + "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n"
            + bag_files.separate("geometry_msgs/Vector3") + "float64 x\nfloat64 y\nfloat64 z\n"
            + POSE.removeprefix("geometry_msgs/Pose pose\n"))
COMMANDED = "{kind: feedforward_pd, rate_hz: 500}"


def two_point_plan(folder):
    (folder / "plan.csv").write_text("time [s],front_a [rad],front_a_torque [N m]\n0,0,0\n1,0,0\n")
    return folder / "plan.csv"


def leap_pose(time, ahead):
    """A body that rests for 0.2 s, then goes `ahead`, rises and pitches nose-down."""
    moved = max(0.0, time - 0.2)
    half = 0.5 * moved  # pitch = moved [rad]
    axis = np.cross([0.0, 0.0, 1.0], ahead)  # to the left: pitch turns about it
    x, y, z = 3.0 + moved * np.array(ahead)[:2] @ [1, 0], moved * ahead[1], 0.2 + 0.5 * moved
    qx, qy, qz = math.sin(half) * axis
    return {"position": {"x": x, "y": y, "z": z},
            "orientation": {"x": qx, "y": qy, "z": qz, "w": math.cos(half)}}


TIMES = np.arange(0.0, 0.6, 0.01)


def odometry(time):
    zero = {"x": 0.0, "y": 0.0, "z": 0.0}
    message = {"header": header(time, "odom"), "child_frame_id": "base_link",
               "pose": {"pose": leap_pose(time, [1.0, 0.0, 0.0]), "covariance": [0.0] * 36},
               "twist": {"twist": {"linear": zero, "angular": zero}, "covariance": [0.0] * 36}}
    return "/odom", "nav_msgs/msg/Odometry", ODOMETRY, message, EPOCH + round(time * 1e9)


def posed(time):
    message = {"header": header(time, "mocap"), "pose": leap_pose(time, [0.0, 1.0, 0.0])}
    return "/mocap/base", "geometry_msgs/msg/PoseStamped", HEADER + POSE, message, EPOCH + round(time * 1e9)


@pytest.mark.parametrize("message, told", [(odometry, "forward is taken as +x of its frame"),
                                           (posed, "forward is taken as +y of the file")])
def test_poses_become_motion_in_the_plane(tmp_path, message, told):
    bag = mcap(tmp_path, map(message, TIMES))
    dataset = jaculus.import_bag(bag, tmp_path / "out", robot="minitaur_tail", plan=two_point_plan(tmp_path))
    stream = dataset.trials[0]["mocap"]
    moved = np.maximum(0.0, TIMES - 0.2)
    np.testing.assert_allclose(stream["x"], moved, atol=1e-12)
    np.testing.assert_allclose(stream["z"], 0.2 + 0.5 * moved, atol=1e-12)
    np.testing.assert_allclose(stream["pitch"], moved, atol=1e-12)
    for still in ("y", "roll", "yaw"):
        np.testing.assert_allclose(stream[still], 0.0, atol=1e-12)
    assert has(dataset, told) and has(dataset, "z taken as up") and has(dataset, "first 0.1 s")
    assert has(dataset, "twist and covariances are left out") == (message is odometry)


def test_two_topics_of_a_kind_are_two_streams(tmp_path):
    both = [m(t) for t in TIMES for m in (odometry, posed)]
    dataset = jaculus.import_bag(mcap(tmp_path, both), tmp_path / "out", robot="minitaur_tail",
                                 plan=two_point_plan(tmp_path))
    assert sorted(dataset.trials[0].streams) == ["mocap", "odom"]


# Plans

TRAJECTORY = (HEADER + "string[] joint_names\ntrajectory_msgs/JointTrajectoryPoint[] points\n" + STD_HEADER
              + bag_files.separate("trajectory_msgs/JointTrajectoryPoint")
              + "float64[] positions\nfloat64[] velocities\nfloat64[] accelerations\nfloat64[] effort\n"
              "builtin_interfaces/Duration time_from_start\n")


def trajectory(time, last=0.4):
    points = [{"positions": [0.1 * k], "velocities": [0.2 * k], "accelerations": [], "effort": [-0.3 * k],
               "time_from_start": {"sec": 0, "nanosec": k * 10**8}} for k in range(4)]
    points.append({**points[-1], "positions": [last], "time_from_start": {"sec": 1, "nanosec": 5}})
    return ("/command", "trajectory_msgs/msg/JointTrajectory", TRAJECTORY,
            {"header": header(time), "joint_names": ["pendulum"], "points": points}, EPOCH)


def test_a_trajectory_is_the_plan_and_its_stamp_is_time_zero(tmp_path):
    bag = mcap(tmp_path, [*bag_files.joint_states(ROWS, "pendulum"), trajectory(0.02)])
    dataset = jaculus.import_bag(bag, tmp_path / "out", robot="ak80_pendulum", experiment="pendulum")
    stream = dataset.trials[0]["joints"]
    np.testing.assert_allclose(stream.time[0], -0.02, rtol=0, atol=1e-15)
    plan = np.genfromtxt(tmp_path / "out/plan.csv", delimiter=",", names=True, deletechars="")
    assert plan.dtype.names == ("time_[s]", "pendulum_[rad]", "pendulum_velocity_[rad/s]", "pendulum_torque_[N_m]")
    np.testing.assert_array_equal(plan["pendulum_torque_[N_m]"], [-0.3 * k for k in (0, 1, 2, 3, 3)])
    assert plan["time_[s]"][-1] == 1.000000005
    assert has(dataset, "time zero is where the plan begins")


def test_bags_of_unlike_plans_are_refused(tmp_path):
    bags = [mcap(tmp_path, [*bag_files.joint_states(ROWS, "pendulum"), trajectory(0.0, last)], f"{last}.mcap")
            for last in (0.4, 0.5)]
    with pytest.raises(jaculus.InputError, match="don't command the same trajectory"):
        jaculus.import_bag(bags, tmp_path / "out", robot="ak80_pendulum", experiment="pendulum")


# Messages of other packages

def low_state(time):
    motors = [{"mode": 1, "q": math.sin(time + k), "dq": 0.0, "ddq": 0.0, "tau_est": 0.5 * k, "q_raw": 0.0,
               "dq_raw": 0.0, "ddq_raw": 0.0, "temperature": 30, "lost": 0, "reserve": [0, 0]} for k in range(20)]
    message = {"head": [254, 239], "level_flag": 255, "motor_state": motors, "tick": round(time * 1000),
               "power_v": 29.5}
    return "/lowstate", "unitree_go/msg/LowState", bag_files.LOW_STATE, message, EPOCH + round(time * 1e9)


def odrive(time):
    message = {"pos_estimate": 0.25 * time, "vel_estimate": 0.25, "torque_target": 1.0, "torque_estimate": -1.5,
               "iq_setpoint": 0.0, "iq_measured": 2.0, "active_errors": 0, "axis_state": 8,
               "procedure_result": 0, "trajectory_done_flag": False}
    return ("/odrive_axis0/controller_status", "odrive_can/msg/ControllerStatus", bag_files.CONTROLLER_STATUS,
            message, EPOCH + round(time * 1e9))


LOW_STATE_MAP = {"format": "jaculus-bag/1", "topics": {"/lowstate": {"rate_hz": 500, "channels": {
    "front_a": {"fields": ["motor_state[0].q", "motor_state[3].q"], "unit": "rad", "scale": -1, "offset": 0.5},
    "front_a_torque": {"field": "motor_state[4].tau_est", "unit": "N m"},
    "bus_voltage": {"field": "power_v", "unit": "V"}}}}}


def test_fields_of_any_message_become_channels_by_the_bags_own_definitions(tmp_path):
    bag = mcap(tmp_path, map(low_state, TIMES))
    dataset = jaculus.import_bag(bag, tmp_path / "out", robot="minitaur_tail", columns=LOW_STATE_MAP,
                                 controller=MEASURED)
    stream = dataset.trials[0]["joints"]
    left, right = (np.sin(TIMES + k).astype(np.float32).astype(float) for k in (0, 3))
    np.testing.assert_allclose(stream["front_a"], 0.5 - 0.5 * (left + right), rtol=0, atol=1e-15)
    np.testing.assert_array_equal(stream["front_a_torque"], 2.0)
    assert stream.rate_hz == 500.0 and np.all(stream["bus_voltage"] == 29.5)
    assert has(dataset, "the recorder's (no header's stamp is set)")
    assert has(dataset, "of its fields are read motor_state[0].q")


def test_units_of_fields_are_converted(tmp_path):
    fields = {"pendulum": {"field": "pos_estimate", "unit": "rev"},
              "pendulum_torque": {"field": "torque_estimate", "unit": "N m", "scale": 9}}
    columns = {"format": "jaculus-bag/1", "topics": {"/odrive_axis0/controller_status": {"channels": fields}}}
    dataset = jaculus.import_bag(mcap(tmp_path, map(odrive, TIMES)), tmp_path / "out", columns=columns, **PENDULUM)
    stream = dataset.trials[0]["joints"]
    given = (0.25 * TIMES).astype(np.float32).astype(float)
    np.testing.assert_allclose(stream["pendulum"], 2.0 * np.pi * given, rtol=1e-15)
    np.testing.assert_array_equal(stream["pendulum_torque"], -13.5)


def test_types_that_a_bag_does_not_define_are_given_by_files(tmp_path):
    bag = bag_files.write_sqlite3(tmp_path / "bag", map(odrive, TIMES), definitions=False)
    columns = {"format": "jaculus-bag/1", "topics": {"/odrive_axis0/controller_status": {
        "channels": {"pendulum_torque": {"field": "torque_estimate", "unit": "N m"}}}}}
    with pytest.raises(jaculus.InputError, match="doesn't define odrive_can/msg/ControllerStatus; allowed: defin"):
        jaculus.import_bag(bag, tmp_path / "out", columns=columns, **PENDULUM)
    folder = tmp_path / "odrive_can/msg"
    folder.mkdir(parents=True)
    (folder / "ControllerStatus.msg").write_text(bag_files.CONTROLLER_STATUS)
    dataset = jaculus.import_bag(bag, tmp_path / "out", columns=columns, definitions=[tmp_path], **PENDULUM)
    assert np.all(dataset.trials[0]["joints"]["pendulum_torque"] == -1.5)


def test_a_field_by_a_name_is_found_wherever_it_stands(tmp_path):
    def message(k, names):
        values = {"other": 7.0, "pendulum": float(k)}
        return ("/joint_states", "sensor_msgs/msg/JointState", bag_files.JOINT_STATE,
                {"header": header(0.1 * k), "name": names, "position": [values[n] for n in names], "velocity": [],
                 "effort": [0.0] * len(names)}, EPOCH + k)
    orders = [["other", "pendulum"], ["pendulum", "other"], ["other"]]
    columns = {"format": "jaculus-bag/1", "topics": {"/joint_states": {"channels": {
        "pendulum": {"field": "position[pendulum]", "unit": "rad"},
        "pendulum_torque": {"field": "effort[0]", "unit": "N m"}}}}}
    dataset = jaculus.import_bag(mcap(tmp_path, [message(k, n) for k, n in enumerate(orders)]), tmp_path / "out",
                                 columns=columns, **PENDULUM)
    np.testing.assert_array_equal(dataset.trials[0]["joints"]["pendulum"], [0.0, 1.0, np.nan])


# Time

def test_stamps_are_sorted_and_repeated_ones_left_out_and_both_are_said(tmp_path):
    rows = [ROWS[k] for k in (0, 2, 1, 1, 3)]
    logged = [(*message[:4], EPOCH + k) for k, message in enumerate(bag_files.joint_states(rows, "pendulum"))]
    dataset = jaculus.import_bag(mcap(tmp_path, logged), tmp_path / "out", **PENDULUM)
    np.testing.assert_array_equal(dataset.trials[0]["joints"]["pendulum"], [row[1] for row in ROWS[:4]])
    assert has(dataset, "1 messages have an earlier stamp") and has(dataset, "1 messages repeat a stamp")


def test_headers_that_are_never_set_leave_the_recorders_times(tmp_path):
    messages = list(bag_files.joint_states(ROWS, "pendulum"))
    for message in messages:
        message[3]["header"]["stamp"] = stamp(0)
    bag = mcap(tmp_path, messages)
    dataset = jaculus.import_bag(bag, tmp_path / "out", **PENDULUM)
    np.testing.assert_allclose(dataset.trials[0]["joints"].time, [row[0] for row in ROWS], atol=1e-15)
    assert has(dataset, "no header's stamp is set")
    columns = {"format": "jaculus-bag/1", "topics": {"/joint_states": {"stamp": "header"}}}
    with pytest.raises(jaculus.InputError, match="no header's stamp is set; allowed: log"):
        jaculus.import_bag(bag, tmp_path / "out", columns=columns, **PENDULUM)


def test_streams_of_two_clocks_are_refused(tmp_path):
    simulated = bag_files.joint_states(ROWS, "pendulum", epoch=5 * 10**9)
    bag = mcap(tmp_path, [*simulated, *map(odrive, TIMES)])
    columns = {"format": "jaculus-bag/1", "topics": {"/joint_states": {}, "/odrive_axis0/controller_status": {
        "channels": {"bus_voltage": {"field": "iq_measured", "unit": "V"}}}}}
    with pytest.raises(jaculus.InputError, match="streams don't overlap in time"):
        jaculus.import_bag(bag, tmp_path / "out", columns=columns, **PENDULUM)


def test_start_and_cut_count_from_what_is_asked_for(tmp_path):
    bag = mcap(tmp_path, bag_files.joint_states(ROWS, "pendulum"))
    dataset = jaculus.import_bag(bag, tmp_path / "out", start="pendulum_torque>0.95", cut=(-0.004, 0.01), **PENDULUM)
    stream = dataset.trials[0]["joints"]
    np.testing.assert_allclose(stream.time, np.arange(-2, 6) * 0.002, atol=1e-15)
    assert stream["pendulum_torque"][2] == 1.0 and has(dataset, "0.02 s of the log")
    for wrong, told in (("pendulum>9", "never passes 9"), ("pendulom>0", "did you mean 'pendulum'"),
                        ("now", "allowed: first, plan, seconds"), ("plan", "the bag has no plan")):
        with pytest.raises(jaculus.InputError, match=told):
            jaculus.import_bag(bag, tmp_path / "out", start=wrong, **PENDULUM)


# What is left out, and faults

def test_topics_that_are_not_taken_are_named(tmp_path):
    bag = mcap(tmp_path, [*bag_files.joint_states(ROWS, "pendulum"), *map(odrive, TIMES)])
    dataset = jaculus.import_bag(bag, tmp_path / "out", **PENDULUM)
    assert has(dataset, "topics left out: /odrive_axis0/controller_status (odrive_can/msg/ControllerStatus, 60 mess")


@pytest.mark.parametrize("topics, told", [
    ({"/joint_stats": {}}, "no topic '/joint_stats', did you mean '/joint_states'"),
    ({"/odrive_axis0/controller_status": {}}, "allowed: `channels` in the map"),
    ({"/odrive_axis0/controller_status": {"channels": {"pendulum": {"field": "pos_estimat", "unit": "rev"}}}},
     "no 'pos_estimat', did you mean 'pos_estimate'"),
    ({"/odrive_axis0/controller_status": {"channels": {"pendulum": {"field": "pos_estimate", "unit": "V m"}}}},
     "dict:.*pendulum"),
    ({"/joint_states": {"stream": "a"}, "/odrive_axis0/controller_status": {"stream": "a"}}, "another topic has it"),
    ({"/joint_states": {"channels": {"pendulum": {"field": "position[9]", "unit": "rad"}}}}, r"\[9\] of 1 entries"),
    ({"/joint_states": {"channels": {"pendulum": {"field": "header", "unit": "rad"}}}}, "'header' is no number"),
    ({"/joint_states": {"chanels": {}}}, "chanels.*did you mean|did you mean.*channels"),
])
def test_faults_of_a_map_are_named_with_what_is_allowed(tmp_path, topics, told):
    bag = mcap(tmp_path, [*bag_files.joint_states(ROWS, "pendulum"), *map(odrive, TIMES)])
    with pytest.raises(jaculus.InputError, match=told):
        jaculus.import_bag(bag, tmp_path / "out", columns={"format": "jaculus-bag/1", "topics": topics}, **PENDULUM)


def test_a_file_that_is_no_bag_is_refused(tmp_path):
    (tmp_path / "no.mcap").write_text("no bag")
    for given in ("no.mcap", "absent.mcap"):
        with pytest.raises(jaculus.InputError, match=f"{given}.*"):
            jaculus.import_bag(tmp_path / given, tmp_path / "out", **PENDULUM)


def test_a_bag_that_was_cut_off_or_has_foreign_messages_says_what_to_do(tmp_path):
    whole = mcap(tmp_path, bag_files.joint_states(ROWS, "pendulum"))
    (tmp_path / "cut.mcap").write_bytes(whole.read_bytes()[:-200])
    with pytest.raises(jaculus.InputError, match="cut.mcap: .*mcap recover"):
        jaculus.import_bag(tmp_path / "cut.mcap", tmp_path / "out", **PENDULUM)

    from mcap.writer import Writer
    with open(tmp_path / "json.mcap", "wb") as file:
        writer = Writer(file)
        writer.start(profile="ros2")
        schema = writer.register_schema("Log", "jsonschema", b"{}")
        channel = writer.register_channel(topic="/log", message_encoding="json", schema_id=schema)
        writer.add_message(channel, log_time=EPOCH, publish_time=EPOCH, data=b"{}")
        writer.finish()
    with pytest.raises(jaculus.InputError, match="not ROS's .schema encoding 'jsonschema'.*mcap filter"):
        jaculus.import_bag(tmp_path / "json.mcap", tmp_path / "out", **PENDULUM)


# The command

def run(*arguments, code="import runpy; runpy.run_module('jaculus', run_name='__main__')"):
    return subprocess.run([sys.executable, "-c", code, *map(str, arguments)], capture_output=True, text=True)


def test_the_command_imports_bags_and_says_what_it_assumed(tmp_path):
    bag = mcap(tmp_path, bag_files.joint_states(ROWS, "pendulum"))
    options = ("--robot", "ak80_pendulum", "--experiment", "pendulum", "--controller", MEASURED)
    done = run("import", "mcap", bag, "--out", tmp_path / "out", *options)
    assert done.returncode == 0, done.stderr
    assert "headers' stamps" in done.stdout and f"written to {tmp_path}/out" in done.stdout
    assert run("check", tmp_path / "out").returncode == 0
    wrong = run("import", "mcap", tmp_path / "absent", "--out", tmp_path / "out", *options)
    assert wrong.returncode == 2 and wrong.stderr.startswith("jaculus: ")
    assert run("import", "mcap", bag, "--out", tmp_path / "out", "--robt", "x").returncode == 2


def test_without_rosbags_the_command_says_what_to_install(tmp_path):
    absent = "import sys, runpy; sys.modules['rosbags'] = None; runpy.run_module('jaculus', run_name='__main__')"
    done = run("import", "bag", mcap(tmp_path, bag_files.joint_states(ROWS, "pendulum")), "--robot", "ak80_pendulum",
               "--out", tmp_path / "out", code=absent)
    assert done.returncode == 2 and "pip install rosbags" in done.stderr


def test_the_program_alone_says_where_the_importer_is():
    from jaculus._command import program
    done = subprocess.run([program(), "import", "mcap", "x"], capture_output=True, text=True)
    assert done.returncode == 2 and "the command of the Python package" in done.stderr


# The diagnosis

@pytest.mark.skipif(not (SHARED / "pendulum/ak80").is_dir(), reason="no shared data")
def test_a_diagnosis_from_bags_is_the_one_from_the_csv(tmp_path):
    """Of the first 0.4 s; scripts/check_bag_diagnosis has the whole log."""
    source = SHARED / "pendulum/ak80"
    bags = []
    for trial in ("trial_01", "trial_02"):
        rows = [row for row in bag_files.rows_of(source / trial / "joints.csv") if row[0] <= 0.4]
        rows = [[round(row[0] * 1e9) / 1e9, *row[1:]] for row in rows]  # as a bag can have them
        bags.append(mcap(tmp_path, bag_files.joint_states(rows, "pendulum"), f"{trial}.mcap"))
        (tmp_path / "csv" / trial).mkdir(parents=True)
        text = "\n".join(",".join(map(repr, row)) for row in rows)
        head = (source / trial / "joints.csv").read_text().splitlines()[0]
        (tmp_path / "csv" / trial / "joints.csv").write_text(f"{head}\n{text}\n")
    text = (source / "dataset.yaml").read_text().replace("robot: robot ", f"robot: {source}/robot ")
    (tmp_path / "csv/dataset.yaml").write_text(text)

    dataset = jaculus.import_bag(bags, tmp_path / "bag/csv", robot=source / "robot", experiment="pendulum",
                                 controller=MEASURED)
    found, same = jaculus.diagnose(dataset), jaculus.diagnose(tmp_path / "csv")
    assert found.json == same.json
    assert found.effects and found.gap["after"] < 0.5 * found.gap["before"]
