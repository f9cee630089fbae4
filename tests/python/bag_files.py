"""Bags that tests import, written by libraries that the importer does not use."""

import csv
import math
import pathlib
import sqlite3

import numpy as np
from mcap_ros2._dynamic import serialize_dynamic
from mcap_ros2.writer import Writer

import jaculus

HEADER = """std_msgs/Header header
"""
STD_HEADER = """================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
"""
JOINT_STATE = (
    HEADER
    + "string[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n"
    + STD_HEADER
)
EPOCH = 1_700_000_000 * 10**9  # of recordings [ns]


def stamp(time_ns):
    return {"sec": time_ns // 10**9, "nanosec": time_ns % 10**9}


def write_mcap(file, messages):
    """messages: (topic, kind, definition, message, log time [ns]), by mcap-ros2-support."""
    schemas = {}
    with open(file, "wb") as out:
        writer = Writer(out)
        for topic, kind, definition, message, time in messages:
            if kind not in schemas:
                schemas[kind] = writer.register_msgdef(kind, definition)
            writer.write_message(topic, schemas[kind], message, log_time=time)
        writer.finish()
    return pathlib.Path(file)


def joint_states(rows, joint, epoch=EPOCH, delay=1_500_000):
    """Messages of a CSV's rows (time, position, velocity, torque) in SI; recorded `delay` ns late."""
    for time, position, velocity, torque in rows:
        now = epoch + round(time * 1e9)
        message = {
            "header": {"stamp": stamp(now), "frame_id": ""},
            "name": [joint],
            "position": [position],
            "velocity": [velocity],
            "effort": [torque],
        }
        yield "/joint_states", "sensor_msgs/msg/JointState", JOINT_STATE, message, now + delay


def rows_of(file):
    with open(file, newline="") as text:
        reader = csv.reader(text)
        next(reader)
        return [[float(cell) for cell in row] for row in reader]


def separate(kind):
    return "=" * 80 + f"\nMSG: {kind}\n"


CONTROLLER_STATUS = """float32 pos_estimate
float32 vel_estimate
float32 torque_target
float32 torque_estimate
float32 iq_setpoint
float32 iq_measured
uint32 active_errors
uint8 axis_state
uint8 procedure_result
bool trajectory_done_flag
"""  # ODrive's odrive_can
# The first and some other fields of Unitree's unitree_go: a bag's own definition counts, whatever it is.
LOW_STATE = (
    """uint8[2] head
uint8 level_flag
MotorState[20] motor_state
uint32 tick
float32 power_v
"""
    + separate("unitree_go/MotorState")
    + """uint8 mode
float32 q
float32 dq
float32 ddq
float32 tau_est
float32 q_raw
float32 dq_raw
float32 ddq_raw
int8 temperature
uint32 lost
uint32[2] reserve
"""
)


def write_sqlite3(folder, messages, definitions):
    """A bag as ROS 2's sqlite3 plugin has it, by sqlite3 and mcap-ros2-support's CDR: of Humble without
    definitions (metadata 5), of Jazzy with them (metadata 9)."""
    folder.mkdir()
    messages = list(messages)
    base = sqlite3.connect(folder / "log_0.db3")
    base.execute(
        "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, "
        "serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL"
        + (", type_description_hash TEXT NOT NULL)" if definitions else ")")
    )
    base.execute(
        "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, "
        "timestamp INTEGER NOT NULL, data BLOB NOT NULL)"
    )
    if definitions:
        base.execute(
            "CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL)"
        )
        base.execute(
            "CREATE TABLE metadata(id INTEGER PRIMARY KEY, metadata_version INTEGER NOT NULL, "
            "metadata TEXT NOT NULL)"
        )
        base.execute(
            "CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT NOT NULL, "
            "encoding TEXT NOT NULL, encoded_message_definition TEXT NOT NULL, "
            "type_description_hash TEXT NOT NULL)"
        )
        base.execute("INSERT INTO schema VALUES (4, 'jazzy')")
    topics = {}
    for topic, kind, definition, message, time in messages:
        if topic not in topics:
            topics[topic] = (len(topics) + 1, kind, serialize_dynamic(kind, definition)[kind])
            row = [topics[topic][0], topic, kind, "cdr", ""] + ([""] if definitions else [])
            base.execute(f"INSERT INTO topics VALUES ({','.join('?' * len(row))})", row)
            if definitions:
                base.execute(
                    "INSERT INTO message_definitions VALUES (?, ?, 'ros2msg', ?, '')",
                    (topics[topic][0], kind, definition),
                )
        number, _, encode = topics[topic]
        base.execute(
            "INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)",
            (number, time, encode(message)),
        )
    base.commit()
    base.close()

    times = [message[4] for message in messages]
    listed = "".join(
        f"    - topic_metadata: {{name: {topic}, type: {kind}, serialization_format: cdr, "
        f"offered_qos_profiles: ''}}\n      message_count: {sum(m[0] == topic for m in messages)}\n"
        for topic, (_, kind, _) in topics.items()
    )
    (folder / "metadata.yaml").write_text(
        f"rosbag2_bagfile_information:\n  version: {8 if definitions else 5}\n  storage_identifier: sqlite3\n"
        f"  relative_file_paths: [log_0.db3]\n  duration: {{nanoseconds: {max(times) - min(times)}}}\n"
        f"  starting_time: {{nanoseconds_since_epoch: {min(times)}}}\n  message_count: {len(messages)}\n"
        f"  topics_with_message_count:\n{listed}  compression_format: ''\n  compression_mode: ''\n"
    )
    return folder


def file_joints(robot):
    """Joints of the robot's file, with signs, by joint in the plane."""
    found = jaculus._core.robot_joints(jaculus._core.load_robot(robot))
    return {name: dict(file) for name, _, file in found}


MEASURED = "{kind: measured, input: torque}"
PENDULUM = {"robot": "ak80_pendulum", "experiment": "pendulum", "controller": MEASURED}
ROWS = [(0.002 * k, math.sin(k), 2.0 * math.cos(k), 0.1 * k) for k in range(50)]
TIMES = np.arange(0.0, 0.6, 0.01)


def mcap(folder, messages, name="log.mcap"):
    return write_mcap(folder / name, messages)


def header(time_s, frame=""):
    return {"stamp": stamp(EPOCH + round(time_s * 1e9)), "frame_id": frame}


def has(dataset, text):
    return any(text in note for note in dataset.notes)


def low_state(time):
    motors = [
        {
            "mode": 1,
            "q": math.sin(time + k),
            "dq": 0.0,
            "ddq": 0.0,
            "tau_est": 0.5 * k,
            "q_raw": 0.0,
            "dq_raw": 0.0,
            "ddq_raw": 0.0,
            "temperature": 30,
            "lost": 0,
            "reserve": [0, 0],
        }
        for k in range(20)
    ]
    message = {
        "head": [254, 239],
        "level_flag": 255,
        "motor_state": motors,
        "tick": round(time * 1000),
        "power_v": 29.5,
    }
    return (
        "/lowstate",
        "unitree_go/msg/LowState",
        LOW_STATE,
        message,
        EPOCH + round(time * 1e9),
    )


def odrive(time):
    message = {
        "pos_estimate": 0.25 * time,
        "vel_estimate": 0.25,
        "torque_target": 1.0,
        "torque_estimate": -1.5,
        "iq_setpoint": 0.0,
        "iq_measured": 2.0,
        "active_errors": 0,
        "axis_state": 8,
        "procedure_result": 0,
        "trajectory_done_flag": False,
    }
    return (
        "/odrive_axis0/controller_status",
        "odrive_can/msg/ControllerStatus",
        CONTROLLER_STATUS,
        message,
        EPOCH + round(time * 1e9),
    )
