"""Bags by mcap-ros2-support, or by sqlite3 and its CDR, imported by way of rosbags."""

import math

import numpy as np
import pytest

import jaculus

pytest.importorskip("rosbags", reason="bags need rosbags")
pytest.importorskip("mcap_ros2", reason="tests of bags need mcap-ros2-support")
import bag_files  # noqa: E402
from bag_files import (
    EPOCH,
    HEADER,
    PENDULUM,
    ROWS,
    STD_HEADER,
    TIMES,
    has,
    header,
    mcap,
)  # noqa: E402

# Joints


def test_joint_states_come_over_exactly_with_the_stamps_of_their_headers(tmp_path):
    bag = mcap(tmp_path, bag_files.joint_states(ROWS, "pendulum"))
    dataset = jaculus.import_bag(bag, tmp_path / "out", **PENDULUM)
    stream = dataset.trials[0]["joints"]
    np.testing.assert_array_equal(stream.values, [row[1:] for row in ROWS])
    np.testing.assert_allclose(stream.time, [row[0] for row in ROWS], rtol=0, atol=1e-15)
    assert stream.units == {
        "pendulum": "rad",
        "pendulum_velocity": "rad/s",
        "pendulum_torque": "N m",
    }
    assert has(dataset, "headers' stamps (recorded 1.5 ms later") and has(
        dataset, "effort is taken as the torque"
    )
    assert "effort is taken" in (tmp_path / "out/dataset.yaml").read_text()


@pytest.mark.parametrize("definitions", [False, True])
def test_sqlite3_bags_are_read_with_definitions_and_without(tmp_path, definitions):
    bag = bag_files.write_sqlite3(
        tmp_path / "bag", bag_files.joint_states(ROWS, "pendulum"), definitions
    )
    dataset = jaculus.import_bag(bag, tmp_path / "out", **PENDULUM)
    np.testing.assert_array_equal(dataset.trials[0]["joints"].values, [row[1:] for row in ROWS])
    assert (
        has(dataset, "doesn't define sensor_msgs/msg/JointState: read as in ROS 2 Humble")
        != definitions
    )


def test_left_and_right_joints_of_the_robots_file_become_one_with_their_signs(tmp_path):
    signs = bag_files.file_joints("minitaur_tail")["front_a"]
    names = [*signs, "gripper"]
    message = {
        "header": header(0.0),
        "name": names,
        "velocity": [],
        "position": [*(sign * at for sign, at in zip(signs.values(), (0.4, 0.2))), 1.0],
        "effort": [],
    }
    later = {
        **message,
        "header": header(0.1),
        "name": names[:1],
        "position": [list(signs.values())[0] * 0.5],
    }
    bag = mcap(
        tmp_path,
        [
            ("/joint_states", "sensor_msgs/msg/JointState", bag_files.JOINT_STATE, m, EPOCH + k)
            for k, m in enumerate((message, later))
        ],
    )
    dataset = jaculus.import_bag(
        bag,
        tmp_path / "out",
        robot="minitaur_tail",
        controller=COMMANDED,
        plan=two_point_plan(tmp_path),
    )
    stream = dataset.trials[0]["joints"]
    assert stream.channels == ["front_a", "front_a_apart"] and len(signs) == 2
    np.testing.assert_allclose(stream["front_a"], [0.3, 0.5], rtol=1e-15)
    first, second = sorted(signs)
    apart = 0.2 if list(signs) == [first, second] else -0.2
    np.testing.assert_allclose(stream["front_a_apart"], [apart, np.nan], rtol=1e-12)
    assert has(dataset, f"front_a_apart is {first} less {second}")
    assert has(dataset, "left out, as the robot has no such joints: gripper")
    assert has(dataset, f"front_a is the mean of {', '.join(sorted(signs))}")


def test_joints_are_renamed_by_the_map_and_unknown_ones_told(tmp_path):
    bag = mcap(tmp_path, bag_files.joint_states(ROWS, "axis0"))
    renamed = {
        "format": "jaculus-bag/1",
        "topics": {"/joint_states": {"joints": {"axis0": "pendulum"}}},
    }
    dataset = jaculus.import_bag(bag, tmp_path / "out", columns=renamed, **PENDULUM)
    np.testing.assert_array_equal(dataset.trials[0]["joints"]["pendulum"], [row[1] for row in ROWS])
    with pytest.raises(
        jaculus.InputError, match="none of its joints is one of the robot's; allowed: pendulum"
    ):
        jaculus.import_bag(bag, tmp_path / "out", **PENDULUM)
    renamed["topics"]["/joint_states"]["joints"]["axis0"] = "pendulun"
    with pytest.raises(jaculus.InputError, match="no joint 'pendulun', did you mean 'pendulum'"):
        jaculus.import_bag(bag, tmp_path / "out", columns=renamed, **PENDULUM)


# Poses


POSE = (
    "geometry_msgs/Pose pose\n"
    + STD_HEADER
    + bag_files.separate("geometry_msgs/Pose")
    + "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n"
    + bag_files.separate("geometry_msgs/Point")
    + "float64 x\nfloat64 y\nfloat64 z\n"
    + bag_files.separate("geometry_msgs/Quaternion")
    + "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"
)
ODOMETRY = (
    HEADER + "string child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n"
    "geometry_msgs/TwistWithCovariance twist\n"
    + bag_files.separate("geometry_msgs/PoseWithCovariance")
    + "geometry_msgs/Pose pose\nfloat64[36] covariance\n"
    + bag_files.separate("geometry_msgs/TwistWithCovariance")
    + "geometry_msgs/Twist twist\nfloat64[36] covariance\n"
    + bag_files.separate("geometry_msgs/Twist")
    + "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n"
    + bag_files.separate("geometry_msgs/Vector3")
    + "float64 x\nfloat64 y\nfloat64 z\n"
    + POSE.removeprefix("geometry_msgs/Pose pose\n")
)
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
    return {
        "position": {"x": x, "y": y, "z": z},
        "orientation": {"x": qx, "y": qy, "z": qz, "w": math.cos(half)},
    }


def odometry(time):
    zero = {"x": 0.0, "y": 0.0, "z": 0.0}
    message = {
        "header": header(time, "odom"),
        "child_frame_id": "base_link",
        "pose": {"pose": leap_pose(time, [1.0, 0.0, 0.0]), "covariance": [0.0] * 36},
        "twist": {"twist": {"linear": zero, "angular": zero}, "covariance": [0.0] * 36},
    }
    return "/odom", "nav_msgs/msg/Odometry", ODOMETRY, message, EPOCH + round(time * 1e9)


def posed(time):
    message = {"header": header(time, "mocap"), "pose": leap_pose(time, [0.0, 1.0, 0.0])}
    return (
        "/mocap/base",
        "geometry_msgs/msg/PoseStamped",
        HEADER + POSE,
        message,
        EPOCH + round(time * 1e9),
    )


@pytest.mark.parametrize(
    "message, told",
    [
        (odometry, "forward is taken as +x of its frame"),
        (posed, "forward is taken as +y of the file"),
    ],
)
def test_poses_become_motion_in_the_plane(tmp_path, message, told):
    bag = mcap(tmp_path, map(message, TIMES))
    dataset = jaculus.import_bag(
        bag, tmp_path / "out", robot="minitaur_tail", plan=two_point_plan(tmp_path)
    )
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
    dataset = jaculus.import_bag(
        mcap(tmp_path, both), tmp_path / "out", robot="minitaur_tail", plan=two_point_plan(tmp_path)
    )
    assert sorted(dataset.trials[0].streams) == ["mocap", "odom"]


# Plans


TRAJECTORY = (
    HEADER
    + "string[] joint_names\ntrajectory_msgs/JointTrajectoryPoint[] points\n"
    + STD_HEADER
    + bag_files.separate("trajectory_msgs/JointTrajectoryPoint")
    + "float64[] positions\nfloat64[] velocities\nfloat64[] accelerations\nfloat64[] effort\n"
    "builtin_interfaces/Duration time_from_start\n"
)


def trajectory(time, last=0.4):
    points = [
        {
            "positions": [0.1 * k],
            "velocities": [0.2 * k],
            "accelerations": [],
            "effort": [-0.3 * k],
            "time_from_start": {"sec": 0, "nanosec": k * 10**8},
        }
        for k in range(4)
    ]
    points.append({**points[-1], "positions": [last], "time_from_start": {"sec": 1, "nanosec": 5}})
    return (
        "/command",
        "trajectory_msgs/msg/JointTrajectory",
        TRAJECTORY,
        {"header": header(time), "joint_names": ["pendulum"], "points": points},
        EPOCH,
    )


def test_a_trajectory_is_the_plan_and_its_stamp_is_time_zero(tmp_path):
    bag = mcap(tmp_path, [*bag_files.joint_states(ROWS, "pendulum"), trajectory(0.02)])
    dataset = jaculus.import_bag(
        bag, tmp_path / "out", robot="ak80_pendulum", experiment="pendulum"
    )
    stream = dataset.trials[0]["joints"]
    np.testing.assert_allclose(stream.time[0], -0.02, rtol=0, atol=1e-15)
    plan = np.genfromtxt(tmp_path / "out/plan.csv", delimiter=",", names=True, deletechars="")
    assert plan.dtype.names == (
        "time_[s]",
        "pendulum_[rad]",
        "pendulum_velocity_[rad/s]",
        "pendulum_torque_[N_m]",
    )
    np.testing.assert_array_equal(
        plan["pendulum_torque_[N_m]"], [-0.3 * k for k in (0, 1, 2, 3, 3)]
    )
    assert plan["time_[s]"][-1] == 1.000000005
    assert has(dataset, "time zero is where the plan begins")


def test_bags_of_unlike_plans_are_refused(tmp_path):
    bags = [
        mcap(
            tmp_path,
            [*bag_files.joint_states(ROWS, "pendulum"), trajectory(0.0, last)],
            f"{last}.mcap",
        )
        for last in (0.4, 0.5)
    ]
    with pytest.raises(jaculus.InputError, match="don't command the same trajectory"):
        jaculus.import_bag(bags, tmp_path / "out", robot="ak80_pendulum", experiment="pendulum")
