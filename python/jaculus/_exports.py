"""Plans for the tools of ROS: bags for PlotJuggler, Foxglove and players, recordings for Rerun."""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from pathlib import Path
from typing import Any, Union

import numpy as np

from . import _core
from ._bags import rosbags
from ._errors import InputError

PathLike = Union[str, "os.PathLike[str]"]

TRAJECTORY_TOPIC, STATES_TOPIC = "/joint_trajectory", "/joint_states"


def _by_sample(rows: list[Any]) -> np.ndarray:
    """(n, j), a sample's values side by side in memory, as messages need them."""
    return np.ascontiguousarray(np.vstack(rows).T)


class JointTrajectory:
    """A plan resampled for a robot's joints, as `jaculus export` does. n samples, j joints of the robot's
    file by the names, signs and zeros that they have there, left and right written out, held ones last.

    Attributes:
        names: j names.
        time: (n,) [s].
        position, velocity, effort: (n, j) at the joint [rad, rad/s, N m; m, m/s, N where it slides];
            effort is the torque of one motor, zero where a joint is held.
        planned: of the joints that move, by name: the plan's joint, and the sign between the two.
            ``sign * plan[joint]`` is the angle of the file's joint at the plan's own samples.
    """

    def __init__(self, plan: _core.Plan, rate: float, even_unsolved: bool):
        if not 1.0 <= rate <= 1e6:
            raise InputError.of("rate", f"{rate} given; allowed: 1 to 1e6 Hz")
        if not plan.converged and not even_unsolved:
            raise InputError(
                "the plan's solve did not converge; allowed: a converged plan, or any with "
                "even_unsolved=True"
            )
        given = json.loads(plan.export_json(float(rate)))
        moving, held = given["joints"], given["held_joints"]
        self.names: list[str] = [joint["name"] for joint in moving + held]
        self.planned: dict[str, tuple[str, float]] = {
            joint["name"]: (joint["motor"], joint["sign"]) for joint in moving
        }
        self.time: np.ndarray = np.array(given["time_s"])
        still = np.zeros((len(held), len(self.time)))
        self.position: np.ndarray = _by_sample(
            [
                [joint["position"] for joint in moving],
                still + np.array([joint["position"] for joint in held]).reshape(-1, 1),
            ]
        )
        self.velocity: np.ndarray = _by_sample([[joint["velocity"] for joint in moving], still])
        self.effort: np.ndarray = _by_sample([[joint["torque"] for joint in moving], still])

    @property
    def nanoseconds(self) -> np.ndarray:
        """(n,) since the plan's start."""
        return np.round(self.time * 1e9).astype(np.int64)

    def __repr__(self) -> str:
        return f"<jaculus.JointTrajectory: {len(self.names)} joints, {len(self.time)} samples>"


def _messages(sampled: JointTrajectory, start: int, store: Any) -> Any:
    """(topic, kind, message, time [ns]) of a bag."""
    types = store.types
    clock, duration = types["builtin_interfaces/msg/Time"], types["builtin_interfaces/msg/Duration"]
    header = types["std_msgs/msg/Header"]
    point = types["trajectory_msgs/msg/JointTrajectoryPoint"]
    none = np.zeros(0)

    def stamped(time: int) -> Any:
        return header(stamp=clock(sec=time // 10**9, nanosec=time % 10**9), frame_id="")

    samples = list(
        zip(map(int, sampled.nanoseconds), sampled.position, sampled.velocity, sampled.effort)
    )
    points = [
        point(
            positions=p,
            velocities=v,
            accelerations=none,
            effort=e,
            time_from_start=duration(sec=t // 10**9, nanosec=t % 10**9),
        )
        for t, p, v, e in samples
    ]
    kind = "trajectory_msgs/msg/JointTrajectory"
    yield TRAJECTORY_TOPIC, kind, types[kind](
        header=stamped(start), joint_names=sampled.names, points=points
    ), start
    kind = "sensor_msgs/msg/JointState"
    for t, p, v, e in samples:
        message = types[kind](
            header=stamped(start + t), name=sampled.names, position=p, velocity=v, effort=e
        )
        yield STATES_TOPIC, kind, message, start + t


def write_bag(
    plan: _core.Plan, path: PathLike, rate: float, start: float, even_unsolved: bool
) -> Path:
    sampled, library, target = JointTrajectory(plan, rate, even_unsolved), rosbags(), Path(path)
    if start < 0.0:
        raise InputError.of("start", f"{start} given; allowed: 0 or later, in seconds since the epoch")
    single = target.suffix == ".mcap"
    if target.exists() and (target.is_dir() or not single):
        raise InputError(f"{target}: exists; allowed: a new folder for a bag, or a file NAME.mcap")
    store = library.typesys.get_typestore(library.typesys.Stores.ROS2_HUMBLE)
    plugins = library.rosbag2.StoragePlugin

    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch, target.stem) if single else target
        with library.rosbag2.Writer(
            folder, version=9, storage_plugin=plugins.MCAP if single else plugins.SQLITE3
        ) as bag:
            connections: dict[str, Any] = {}
            for topic, kind, message, time in _messages(sampled, round(start * 1e9), store):
                if topic not in connections:
                    connections[topic] = bag.add_connection(topic, kind, typestore=store)
                bag.write(connections[topic], time, store.serialize_cdr(message, kind))
        if single:
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.move(next(folder.glob("*.mcap")), target)
    return target


def write_rerun(plan: Any, path: PathLike, rate: float, even_unsolved: bool) -> Path:
    try:
        import rerun
    except ImportError as missing:
        raise ImportError("to_rerun() needs Rerun: pip install rerun-sdk") from missing
    sampled = JointTrajectory(plan._core, rate, even_unsolved)
    recording = rerun.RecordingStream(f"jaculus_{plan.problem.name}")
    recording.save(os.fspath(path))

    def send(entity: str, seconds: np.ndarray, values: np.ndarray) -> None:
        rerun.send_columns(
            entity,
            indexes=[rerun.TimeColumn("time", duration=seconds)],
            columns=rerun.Scalars.columns(scalars=values),
            recording=recording,
        )

    for j, name in enumerate(sampled.names):
        for quantity in ("position", "velocity", "effort"):
            send(
                f"joints/{name}/{quantity}",
                sampled.nanoseconds / 1e9,
                getattr(sampled, quantity)[:, j],
            )
    for column in plan.columns:
        if column != "time":
            send(f"plan/{column}", plan.time, plan[column])
    recording.flush()
    recording.disconnect()
    return Path(path)
