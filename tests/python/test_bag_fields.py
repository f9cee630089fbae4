"""Fields of any message by their path; stamps."""

import pathlib
import re

import numpy as np
import pytest

import jaculus

pytest.importorskip("rosbags", reason="bags need rosbags")
pytest.importorskip("mcap_ros2", reason="tests of bags need mcap-ros2-support")
import bag_files  # noqa: E402
from bag_files import (
    EPOCH,
    MEASURED,
    PENDULUM,
    ROWS,
    TIMES,
    has,
    header,
    low_state,
    mcap,
    odrive,
    stamp,
)  # noqa: E402

# Messages of other packages


LOW_STATE_MAP = {
    "format": "jaculus-bag/1",
    "topics": {
        "/lowstate": {
            "rate_hz": 500,
            "channels": {
                "front_a": {
                    "fields": ["motor_state[0].q", "motor_state[3].q"],
                    "unit": "rad",
                    "scale": -1,
                    "offset": 0.5,
                },
                "front_a_torque": {"field": "motor_state[4].tau_est", "unit": "N m"},
                "bus_voltage": {"field": "power_v", "unit": "V"},
            },
        }
    },
}


def test_fields_of_any_message_become_channels_by_the_bags_own_definitions(tmp_path):
    bag = mcap(tmp_path, map(low_state, TIMES))
    dataset = jaculus.import_bag(
        bag, tmp_path / "out", robot="minitaur_tail", columns=LOW_STATE_MAP, controller=MEASURED
    )
    stream = dataset.trials[0]["joints"]
    left, right = (np.sin(TIMES + k).astype(np.float32).astype(float) for k in (0, 3))
    np.testing.assert_allclose(stream["front_a"], 0.5 - 0.5 * (left + right), rtol=0, atol=1e-15)
    np.testing.assert_array_equal(stream["front_a_torque"], 2.0)
    assert stream.rate_hz == 500.0 and np.all(stream["bus_voltage"] == 29.5)
    assert has(dataset, "the recorder's (no header's stamp is set)")
    assert has(dataset, "of its fields are read motor_state[0].q")


def test_units_of_fields_are_converted(tmp_path):
    fields = {
        "pendulum": {"field": "pos_estimate", "unit": "rev"},
        "pendulum_torque": {"field": "torque_estimate", "unit": "N m", "scale": 9},
    }
    columns = {
        "format": "jaculus-bag/1",
        "topics": {"/odrive_axis0/controller_status": {"channels": fields}},
    }
    dataset = jaculus.import_bag(
        mcap(tmp_path, map(odrive, TIMES)), tmp_path / "out", columns=columns, **PENDULUM
    )
    stream = dataset.trials[0]["joints"]
    given = (0.25 * TIMES).astype(np.float32).astype(float)
    np.testing.assert_allclose(stream["pendulum"], 2.0 * np.pi * given, rtol=1e-15)
    np.testing.assert_array_equal(stream["pendulum_torque"], -13.5)


def test_types_that_a_bag_does_not_define_are_given_by_files(tmp_path):
    bag = bag_files.write_sqlite3(tmp_path / "bag", map(odrive, TIMES), definitions=False)
    columns = {
        "format": "jaculus-bag/1",
        "topics": {
            "/odrive_axis0/controller_status": {
                "channels": {"pendulum_torque": {"field": "torque_estimate", "unit": "N m"}}
            }
        },
    }
    with pytest.raises(
        jaculus.InputError, match="doesn't define odrive_can/msg/ControllerStatus; allowed: defin"
    ):
        jaculus.import_bag(bag, tmp_path / "out", columns=columns, **PENDULUM)
    folder = tmp_path / "odrive_can/msg"
    folder.mkdir(parents=True)
    (folder / "ControllerStatus.msg").write_text(bag_files.CONTROLLER_STATUS)
    dataset = jaculus.import_bag(
        bag, tmp_path / "out", columns=columns, definitions=[tmp_path], **PENDULUM
    )
    assert np.all(dataset.trials[0]["joints"]["pendulum_torque"] == -1.5)


def test_a_field_by_a_name_is_found_wherever_it_stands(tmp_path):
    def message(k, names):
        values = {"other": 7.0, "pendulum": float(k)}
        return (
            "/joint_states",
            "sensor_msgs/msg/JointState",
            bag_files.JOINT_STATE,
            {
                "header": header(0.1 * k),
                "name": names,
                "position": [values[n] for n in names],
                "velocity": [],
                "effort": [0.0] * len(names),
            },
            EPOCH + k,
        )

    orders = [["other", "pendulum"], ["pendulum", "other"], ["other"]]
    columns = {
        "format": "jaculus-bag/1",
        "topics": {
            "/joint_states": {
                "channels": {
                    "pendulum": {"field": "position[pendulum]", "unit": "rad"},
                    "pendulum_torque": {"field": "effort[0]", "unit": "N m"},
                }
            }
        },
    }
    dataset = jaculus.import_bag(
        mcap(tmp_path, [message(k, n) for k, n in enumerate(orders)]),
        tmp_path / "out",
        columns=columns,
        **PENDULUM,
    )
    np.testing.assert_array_equal(dataset.trials[0]["joints"]["pendulum"], [0.0, 1.0, np.nan])


def test_the_map_of_the_page_on_commands_is_one():
    page = (pathlib.Path(__file__).parents[2] / "docs/commands.md").read_text()
    (text,) = re.findall(r"```yaml\n(format: jaculus-bag/1\n.*?)```", page, re.S)
    topics = jaculus._core.read_bag_map(jaculus._core.Node.parse(text, "commands.md"))
    assert [topic.topic for topic in topics] == ["/joint_states", "/mocap/base", "/lowstate"]
    assert topics[2].channels[0].columns == ["motor_state[0].q", "motor_state[3].q"]


# Time


def test_stamps_are_sorted_and_repeated_ones_left_out_and_both_are_said(tmp_path):
    rows = [ROWS[k] for k in (0, 2, 1, 1, 3)]
    logged = [
        (*message[:4], EPOCH + k)
        for k, message in enumerate(bag_files.joint_states(rows, "pendulum"))
    ]
    dataset = jaculus.import_bag(mcap(tmp_path, logged), tmp_path / "out", **PENDULUM)
    np.testing.assert_array_equal(
        dataset.trials[0]["joints"]["pendulum"], [row[1] for row in ROWS[:4]]
    )
    assert has(dataset, "1 messages have an earlier stamp") and has(
        dataset, "1 messages repeat a stamp"
    )


def test_headers_that_are_never_set_leave_the_recorders_times(tmp_path):
    messages = list(bag_files.joint_states(ROWS, "pendulum"))
    for message in messages:
        message[3]["header"]["stamp"] = stamp(0)
    bag = mcap(tmp_path, messages)
    dataset = jaculus.import_bag(bag, tmp_path / "out", **PENDULUM)
    np.testing.assert_allclose(
        dataset.trials[0]["joints"].time, [row[0] for row in ROWS], atol=1e-15
    )
    assert has(dataset, "no header's stamp is set")
    columns = {"format": "jaculus-bag/1", "topics": {"/joint_states": {"stamp": "header"}}}
    with pytest.raises(jaculus.InputError, match="no header's stamp is set; allowed: log"):
        jaculus.import_bag(bag, tmp_path / "out", columns=columns, **PENDULUM)


def test_streams_of_two_clocks_are_refused(tmp_path):
    simulated = bag_files.joint_states(ROWS, "pendulum", epoch=5 * 10**9)
    bag = mcap(tmp_path, [*simulated, *map(odrive, TIMES)])
    columns = {
        "format": "jaculus-bag/1",
        "topics": {
            "/joint_states": {},
            "/odrive_axis0/controller_status": {
                "channels": {"bus_voltage": {"field": "iq_measured", "unit": "V"}}
            },
        },
    }
    with pytest.raises(jaculus.InputError, match="streams don't overlap in time"):
        jaculus.import_bag(bag, tmp_path / "out", columns=columns, **PENDULUM)


def test_start_and_cut_count_from_what_is_asked_for(tmp_path):
    bag = mcap(tmp_path, bag_files.joint_states(ROWS, "pendulum"))
    dataset = jaculus.import_bag(
        bag, tmp_path / "out", start="pendulum_torque>0.95", cut=(-0.004, 0.01), **PENDULUM
    )
    stream = dataset.trials[0]["joints"]
    np.testing.assert_allclose(stream.time, np.arange(-2, 6) * 0.002, atol=1e-15)
    assert stream["pendulum_torque"][2] == 1.0 and has(dataset, "0.02 s of the log")
    for wrong, told in (
        ("pendulum>9", "never passes 9"),
        ("pendulom>0", "did you mean 'pendulum'"),
        ("now", "allowed: first, plan, seconds"),
        ("plan", "the bag has no plan"),
    ):
        with pytest.raises(jaculus.InputError, match=told):
            jaculus.import_bag(bag, tmp_path / "out", start=wrong, **PENDULUM)
