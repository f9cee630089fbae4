"""Bags that tests import, written by libraries that the importer does not use."""
import csv
import pathlib

from mcap_ros2.writer import Writer

HEADER = """std_msgs/Header header
"""
STD_HEADER = """================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
"""
JOINT_STATE = HEADER + "string[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n" + STD_HEADER
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
        message = {"header": {"stamp": stamp(now), "frame_id": ""}, "name": [joint], "position": [position],
                   "velocity": [velocity], "effort": [torque]}
        yield "/joint_states", "sensor_msgs/msg/JointState", JOINT_STATE, message, now + delay


def rows_of(file):
    with open(file, newline="") as text:
        reader = csv.reader(text)
        next(reader)
        return [[float(cell) for cell in row] for row in reader]
