"""ROS messages into channels: stamps, joints, poses, fields by their path."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Optional

import numpy as np

from . import _core
from ._bags import Topic
from ._errors import InputError

JOINT_STATE = "sensor_msgs/msg/JointState"
ODOMETRY = "nav_msgs/msg/Odometry"
POSE = "geometry_msgs/msg/PoseStamped"
TRAJECTORY = "trajectory_msgs/msg/JointTrajectory"


@dataclass
class Series:
    """Channels of one topic. n samples, c channels.

    Attributes:
        stamps: (n,) rising [ns].
        values: (c, n) SI, NaN where nothing was measured.
    """

    stream: str
    rate_hz: float
    stamps: np.ndarray
    channels: list[str]
    units: list[str]
    values: np.ndarray


class Joints:
    """Joints of a robot by the names that a message may have for them.

    A joint in the plane that stands for a left and a right one has the mean of both, each with its
    sign, as all logs have it.
    """

    def __init__(self, robot: _core.Robot):
        joints = _core.robot_joints(robot)
        self.slides: dict[str, bool] = {name: slides for name, slides, _ in joints}
        self._file = {
            theirs: (name, sign) for name, _, file in joints for theirs, sign in file.items()
        }

    def find(self, theirs: str, renamed: dict[str, str]) -> Optional[tuple[str, float]]:
        """The robot's joint and the sign of its value; None where the robot has no such joint."""
        if theirs in renamed:  # a joint in the plane, else one of the file
            name = renamed[theirs]
            return (name, 1.0) if name in self.slides else self._file.get(name)
        if theirs in self._file:
            return self._file[theirs]
        return (theirs, 1.0) if theirs in self.slides else None

    def check(self, renamed: dict[str, str], place: str) -> None:
        for ours in renamed.values():
            if ours not in self.slides and ours not in self._file:
                raise InputError.of(
                    "joints",
                    f"the robot has no joint '{ours}'{near(ours, self.slides)}; allowed: "
                    f"{', '.join(self.slides)}",
                    place,
                )

    def unit(self, channel: str) -> str:
        joint, _, quantity = channel.rpartition("_")
        if joint in self.slides and quantity == "apart":
            return self.unit(joint)
        if joint in self.slides and quantity in ("velocity", "torque"):
            slides = self.slides[joint]
            return {"velocity": "m/s" if slides else "rad/s", "torque": "N" if slides else "N m"}[
                quantity
            ]
        return "m" if self.slides.get(channel) else "rad"


def near(name: str, names: Iterable[str]) -> str:
    found = difflib.get_close_matches(name, list(names), 1)
    return f", did you mean '{found[0]}'?" if found else ""


def header_stamps(topic: Topic) -> Optional[np.ndarray]:
    """Stamps of the headers [ns]; None where messages have none or none is set."""
    stamps: list[Any] = [getattr(getattr(m, "header", None), "stamp", None) for m in topic.messages]
    if any(stamp is None for stamp in stamps):
        return None
    times = np.array([stamp.sec * 10**9 + stamp.nanosec for stamp in stamps], dtype=np.int64)
    return times if times.any() else None


def stamps_of(topic: Topic, asked: str, place: str, notes: list[str]) -> np.ndarray:
    """Time of every message [ns], as asked: header's or recorder's."""
    headers = header_stamps(topic)
    logged = np.array(topic.times, dtype=np.int64)
    if asked == "header" and headers is None:
        raise InputError(
            f"{place}: {topic.name}: stamp: header, but no header's stamp is set; allowed: log"
        )
    if headers is None or asked == "log":
        why = "as asked" if asked == "log" else "no header's stamp is set"
        notes.append(f"{topic.name}: times are the recorder's ({why})")
        return logged
    late = (logged - headers) / 1e6
    notes.append(
        f"{topic.name}: times are the headers' stamps (recorded {np.median(late):.3g} ms later at "
        f"the median, {late.max():.3g} ms at most)"
    )
    return headers


def in_order(series: Series, topic: str, notes: list[str]) -> Series:
    """By rising stamps, the first of equal ones: what a stream needs."""
    order = np.argsort(series.stamps, kind="stable")
    late = int(np.sum(np.diff(series.stamps) < 0))
    if late:
        notes.append(f"{topic}: {late} messages have an earlier stamp than the one before: sorted")
    stamps = series.stamps[order]
    first = np.concatenate([[True], np.diff(stamps) > 0])
    if not first.all():
        notes.append(
            f"{topic}: {int(np.sum(~first))} messages repeat a stamp: the first of each is kept"
        )
    return Series(
        series.stream,
        series.rate_hz,
        stamps[first],
        series.channels,
        series.units,
        series.values[:, order[first]],
    )


def field_of(path: str) -> Callable[[Any], float]:
    """A function that takes the number at a path out of a message: "motor_state[0].q",
    "position[shoulder]" (its place in the message's `name`)."""
    parts = re.findall(r"\.?([A-Za-z_]\w*)|\[([^\]]+)\]", path)
    whole = "".join(f"[{index}]" if index else f".{name}" for name, index in parts).lstrip(".")
    if not parts or whole != path.lstrip("."):
        raise InputError(
            f"field '{path}': allowed: names with dots and [places], as motor_state[0].q"
        )

    def take(message: Any) -> float:
        value = message
        for name, index in parts:
            if name:
                if not hasattr(value, name):
                    fields = [
                        f for f in getattr(value, "__annotations__", {}) if not f.startswith("__")
                    ]
                    raise InputError(
                        f"field '{path}': there is no '{name}'{near(name, fields)}; "
                        f"allowed: {', '.join(fields) or 'nothing, it is a value'}"
                    )
                value = getattr(value, name)
                continue
            if not index.isdigit() and index not in getattr(message, "name", ()):
                return math.nan  # this message doesn't have the joint
            place = int(index) if index.isdigit() else list(message.name).index(index)
            if not hasattr(value, "__len__"):
                raise InputError(f"field '{path}': [{index}] of a value that is no list")
            if place >= len(value):
                if not index.isdigit():
                    return math.nan  # an empty list: not measured
                raise InputError(f"field '{path}': [{place}] of {len(value)} entries")
            value = value[place]
        if isinstance(value, (bool, int, float, np.bool_, np.integer, np.floating)):
            return float(value)
        raise InputError(f"field '{path}' is no number ({type(value).__name__.split('__')[-1]})")

    return take


@dataclass
class Row:
    """What is kept of a message by a map: its header, None where it has none, and numbers in the
    order of the map's fields."""

    __slots__ = ("header", "values")
    header: Any
    values: tuple[float, ...]


def keep_fields(
    topic: str, channels: Sequence[_core.MappedChannel], place: str
) -> Callable[[Any], Row]:
    """A function that takes what a map reads out of a message."""
    takes = []
    for channel in channels:
        where = f"{place}: {topic}: {channel.channel}"
        try:
            takes += [(where, field_of(path)) for path in channel.columns]
        except InputError as fault:
            raise InputError(f"{where}: {fault}") from None

    def keep(message: Any) -> Row:
        values = []
        for where, take in takes:
            try:
                values.append(take(message))
            except InputError as fault:
                raise InputError(f"{where}: {fault}") from None
        return Row(getattr(message, "header", None), tuple(values))

    return keep


def mapped(
    topic: Topic, channels: Sequence[_core.MappedChannel], place: str, notes: list[str]
) -> tuple[list[str], list[str], np.ndarray]:
    """Names, units and (c, n) of a topic whose messages were kept by `keep_fields`. Of two fields
    that make up a joint's position the first less the second is a channel of its own."""
    kept = np.array([row.values for row in topic.messages]).T
    rows, first = [], 0
    aparts = {}
    for channel in channels:
        fields = kept[first : first + len(channel.columns)]
        first += len(channel.columns)
        if np.isnan(fields).all():
            raise InputError(
                f"{place}: {topic.name}: {channel.channel}: no message has "
                f"{' or '.join(channel.columns)}"
            )
        if len(channel.columns) > 1:
            notes.append(f"{channel.channel} is the mean of {', '.join(channel.columns)}")
        rows.append(channel.scale * fields.mean(axis=0) + channel.shift)
        if channel.apart:
            aparts[channel.apart] = channel.unit, channel.scale * (fields[0] - fields[1])
            notes.append(f"{channel.apart} is {channel.columns[0]} less {channel.columns[1]}")
    read = sorted({path for channel in channels for path in channel.columns})
    notes.append(f"{topic.name} ({topic.kind}): of its fields are read {', '.join(read)}")
    names = [channel.channel for channel in channels] + list(aparts)
    units = [channel.unit for channel in channels] + [unit for unit, _ in aparts.values()]
    return names, units, np.array(rows + [row for _, row in aparts.values()])


def _sorted_names(names: Iterable[str], robot: Joints) -> list[str]:
    """Position, what sides differ by, velocity, torque of a joint side by side, joints in the
    robot's order."""
    order = list(robot.slides)
    rank = {"apart": 1, "velocity": 2, "torque": 3}

    def key(channel: str) -> tuple[int, int]:
        joint, _, quantity = channel.rpartition("_")
        if channel in order:
            return order.index(channel), 0
        return order.index(joint), rank[quantity]

    return sorted(names, key=key)


def joint_values(
    samples: Sequence[tuple[Sequence[str], dict[str, Sequence[float]]]],
    robot: Joints,
    renamed: dict[str, str],
    place: str,
    notes: list[str],
    measured: bool = True,
) -> tuple[list[str], np.ndarray]:
    """Channels of named joints over samples of (names, values by suffix "", "_velocity", "_torque").

    Returns:
        Names, and (c, n); NaN where a sample lacks a joint or has no values of a kind. Of a joint
        whose position two sides make up, the first less the second by name stands beside it,
        "_apart", where they were `measured`.
    """
    sums: dict[str, np.ndarray] = {}
    positions: dict[str, dict[str, np.ndarray]] = {}  # of a joint's sides
    counts: dict[str, np.ndarray] = {}
    sides: dict[str, set[str]] = {}
    unknown: set[str] = set()
    for k, (names, kinds) in enumerate(samples):
        for suffix, values in kinds.items():
            if len(values) not in (0, len(names)):
                raise InputError(
                    f"{place}: sample {k + 1}: {len(values)} values for {len(names)} joints"
                )
            for theirs, value in zip(names, values):
                found = robot.find(theirs, renamed)
                if found is None:
                    unknown.add(theirs)
                    continue
                channel = found[0] + suffix
                if channel not in sums:
                    sums[channel], counts[channel] = np.zeros(len(samples)), np.zeros(len(samples))
                sums[channel][k] += found[1] * value
                counts[channel][k] += 1
                sides.setdefault(found[0], set()).add(theirs)
                if not suffix:
                    own = positions.setdefault(found[0], {})
                    own.setdefault(theirs, np.full(len(samples), np.nan))[k] = found[1] * value

    if unknown:
        notes.append(
            f"{place}: left out, as the robot has no such joints: {', '.join(sorted(unknown))}"
        )
    if not sums:
        raise InputError(
            f"{place}: none of its joints is one of the robot's; allowed: "
            f"{', '.join(robot.slides)}, or `joints` of the map"
        )
    apart: dict[str, np.ndarray] = {}
    for joint, given in sides.items():
        if len(given) > 1:
            notes.append(
                f"{place}: {joint} is the mean of {', '.join(sorted(given))}, each with its sign"
            )
            own = positions.get(joint, {})
            if measured and len(own) == 2:
                first, second = sorted(own)
                difference = own[first] - own[second]
                if not np.isnan(difference).all():
                    apart[joint + "_apart"] = difference
                    notes.append(f"{place}: {joint}_apart is {first} less {second}")
        elif given != {joint}:
            notes.append(f"{place}: {joint} is {next(iter(given))}")

    with np.errstate(invalid="ignore"):
        values = {channel: sums[channel] / counts[channel] for channel in sums} | apart
    channels = _sorted_names(values, robot)
    return channels, np.array([values[c] for c in channels])


def joint_state(
    topic: Topic, robot: Joints, renamed: dict[str, str], place: str, notes: list[str]
) -> tuple[list[str], list[str], np.ndarray]:
    """Channels, units and values of sensor_msgs/JointState. Effort is the torque at the joint."""
    samples = [
        (m.name, {"": m.position, "_velocity": m.velocity, "_torque": m.effort})
        for m in topic.messages
    ]
    channels, values = joint_values(samples, robot, renamed, f"{place}: {topic.name}", notes)
    if any(channel.endswith("_torque") for channel in channels):
        notes.append(
            f"{topic.name}: effort is taken as the torque of one motor at its joint, behind the gear"
        )
    units = [robot.unit(channel) for channel in channels]
    notes.append(
        f"{topic.name} ({topic.kind}): " + ", ".join(f"{c} [{u}]" for c, u in zip(channels, units))
    )
    return channels, units, values


def poses(topic: Topic, place: str, notes: list[str]) -> tuple[np.ndarray, np.ndarray]:
    """(3, n) positions [m] and (4, n) quaternions x, y, z, w of Odometry or PoseStamped."""
    odometry = topic.kind == ODOMETRY
    given = [m.pose.pose if odometry else m.pose for m in topic.messages]
    position = np.array([[p.position.x, p.position.y, p.position.z] for p in given]).T
    rotation = np.array(
        [[p.orientation.x, p.orientation.y, p.orientation.z, p.orientation.w] for p in given]
    ).T
    norm = np.linalg.norm(rotation, axis=0)
    gaps = ~(np.isfinite(position).all(axis=0) & (np.abs(norm - 1.0) < 0.01))
    if gaps.all():
        raise InputError(
            f"{place}: {topic.name}: no message has a unit quaternion and a finite position"
        )
    if gaps.any():
        notes.append(f"{topic.name}: {int(gaps.sum())} messages have no unit quaternion: gaps")
    position[:, gaps] = np.nan
    rotation = np.where(gaps, np.nan, rotation / np.where(norm > 0.0, norm, 1.0))

    frames = sorted({m.header.frame_id for m in topic.messages})
    body = (
        f" of {topic.messages[0].child_frame_id}"
        if odometry and topic.messages[0].child_frame_id
        else ""
    )
    notes.append(
        f"{topic.name} ({topic.kind}): pose{body} in frame '{', '.join(frames)}', z taken as up "
        "(REP-103); metres, rad"
    )
    if odometry:
        notes.append(
            f"{topic.name}: twist and covariances are left out: rates follow from the poses"
        )
    return position, rotation
