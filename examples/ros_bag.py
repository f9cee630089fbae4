"""Logs as ROS 2 records them: a pendulum's bag becomes a dataset and is diagnosed.

The bag is written here with rosbags, from a simulation, as a driver's node would publish it. Takes half
a minute; needs `pip install rosbags`.
"""

# %% A log, as a robot would publish it: sensor_msgs/JointState with stamps
import pathlib
import shutil

import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

import jaculus

joints = jaculus.simulate(
    "pendulum_trials", trials=1, seed=3, effects={"joint_viscous_friction": {"coefficient": 0.05}}
).trials[0]["joints"]
print("measured:", ", ".join(joints.channels))

ros = get_typestore(Stores.ROS2_HUMBLE)
kind = "sensor_msgs/msg/JointState"
Time, Header, JointState = (
    ros.types[name] for name in ("builtin_interfaces/msg/Time", "std_msgs/msg/Header", kind)
)
shutil.rmtree("pendulum_bag", ignore_errors=True)
with Writer("pendulum_bag", version=9, storage_plugin=StoragePlugin.MCAP) as bag:
    topic = bag.add_connection("/joint_states", kind, typestore=ros)
    for k, time in enumerate(joints.time):
        now = 1_700_000_000 * 10**9 + round(time * 1e9)
        stamp = Time(sec=now // 10**9, nanosec=now % 10**9)
        one = {
            name: (
                np.array([joints[f"pendulum{suffix}"][k]])
                if f"pendulum{suffix}" in joints.channels
                else np.zeros(0)
            )
            for name, suffix in (("position", ""), ("velocity", "_velocity"), ("effort", "_torque"))
        }
        message = JointState(header=Header(stamp=stamp, frame_id=""), name=["motor_1"], **one)
        bag.write(topic, now + 800_000, ros.serialize_cdr(message, kind))

# %% Import it: the driver calls the joint motor_1
columns = {
    "format": "jaculus-bag/1",
    "topics": {"/joint_states": {"joints": {"motor_1": "pendulum"}}},
}
dataset = jaculus.import_bag(
    "pendulum_bag",
    "pendulum_log",
    robot="ak80_pendulum",
    experiment="pendulum",
    columns=columns,
    controller="{kind: measured, input: torque}",
)
print(dataset.summary)
# prints: pendulum is motor_1
back = dataset.trials[0]["joints"]
assert np.array_equal(back["pendulum"], joints["pendulum"])

# %% Diagnose it
diagnosis = jaculus.diagnose(dataset)
print(diagnosis.summary)
# prints: joint_viscous_friction
print(pathlib.Path("pendulum_log/dataset.yaml").read_text())
