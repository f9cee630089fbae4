"""One bag as one trial: which topics are taken, as which streams, from which time zero."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable
from pathlib import Path
from typing import Optional, Union

import numpy as np

from . import _core
from ._bags import PathLike, Topic, open_bag, read_topics
from ._errors import InputError
from ._messages import (
    JOINT_STATE,
    ODOMETRY,
    POSE,
    TRAJECTORY,
    Joints,
    Series,
    in_order,
    joint_state,
    joint_values,
    keep_fields,
    mapped,
    near,
    poses,
    stamps_of,
)

Start = Union[str, float]

KNOWN = {
    JOINT_STATE: "joints",
    ODOMETRY: "mocap",
    POSE: "mocap",
}  # and the stream of the first such topic


def _read_stream(
    topic: Topic,
    entry: Optional[_core.BagTopic],
    stream: str,
    robot: Joints,
    place: str,
    notes: list[str],
) -> Series:
    """One topic as a stream."""
    rate = entry.rate_hz if entry else math.nan
    stamps = stamps_of(topic, entry.stamp if entry else "", place, notes)
    if entry and entry.channels:
        names, units, values = mapped(topic, entry.channels, place, notes)
        return in_order(Series(stream, rate, stamps, names, units, values), topic.name, notes)

    if topic.kind == JOINT_STATE:
        names, units, values = joint_state(
            topic, robot, entry.joints if entry else {}, place, notes
        )
        return in_order(Series(stream, rate, stamps, names, units, values), topic.name, notes)

    position, rotation = poses(topic, place, notes)
    series = in_order(
        Series(stream, rate, stamps, [], [], np.vstack([position, rotation])), topic.name, notes
    )
    # REP-105: odometry's frame begins with x ahead. A motion capture's frame is anyone's.
    forward = (entry.forward if entry else "") or ("+x" if topic.kind == ODOMETRY else "auto")
    rest = entry.rest if entry and entry.rest is not None else 0.1
    seconds = (series.stamps - series.stamps[0]) / 1e9
    pose, told = _core.planar_pose(
        "base", seconds, series.values[:3], series.values[3:], forward, rest
    )
    if not any(note.startswith("forward") for note in told):
        told.append(f"forward is taken as {forward} of its frame")
    notes += [f"{topic.name}: {note}" for note in told]
    notes.append(f"{topic.name}: x, y and the angles count from the mean of the first {rest:g} s")
    series.channels, series.units, series.values = pose.channels, pose.units, np.array(pose.values)
    return series


class Command:
    """What a JointTrajectory commands.

    Attributes:
        zero: when it begins [ns].
        columns, values: of plan.csv, (n, c).
    """

    def __init__(
        self,
        topic: Topic,
        entry: Optional[_core.BagTopic],
        robot: Joints,
        place: str,
        notes: list[str],
    ):
        message = topic.messages[0]
        where = f"{place}: {topic.name}"
        if len(topic.messages) > 1:
            notes.append(
                f"{topic.name}: of {len(topic.messages)} trajectories the first is the plan"
            )
        stamp = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
        self.zero = stamp if stamp else topic.times[0]
        since = [p.time_from_start.sec * 10**9 + p.time_from_start.nanosec for p in message.points]
        if len(since) < 2 or np.min(np.diff(since)) <= 0:
            raise InputError(f"{where}: {len(since)} points; allowed: two or more, at rising times")

        samples = [
            (message.joint_names, {"": p.positions, "_velocity": p.velocities, "_torque": p.effort})
            for p in message.points
        ]
        names, values = joint_values(
            samples, robot, entry.joints if entry else {}, where, notes, measured=False
        )
        if any(len(p.accelerations) for p in message.points):
            notes.append(f"{topic.name}: accelerations are left out: a plan has none")
        units = [robot.unit(name) for name in names]
        self.columns = ["time [s]"] + [f"{name} [{unit}]" for name, unit in zip(names, units)]
        self.values = np.column_stack([np.array(since) / 1e9, values.T])
        notes.append(
            f"{topic.name} ({topic.kind}): the plan, {len(since)} points, from its "
            f"{'header' if stamp else 'recording'} on; effort is taken as torque at the joint"
        )

    def write(self, file: Path) -> None:
        rows = [
            ",".join("" if math.isnan(v) else repr(float(v)) for v in row) for row in self.values
        ]
        file.write_text("\n".join([",".join(self.columns), *rows]) + "\n")

    def same(self, other: Command) -> bool:
        return self.columns == other.columns and np.array_equal(
            self.values, other.values, equal_nan=True
        )


class Bag:
    """One bag: a trial. `series` and perhaps `plan`; `notes` on all that was assumed or left out."""

    def __init__(
        self,
        path: PathLike,
        entries: dict[str, _core.BagTopic],
        robot: Joints,
        take_plan: bool,
        definitions: Iterable[PathLike],
    ):
        self.notes: list[str] = []
        self.place = os.fspath(path)
        with open_bag(path, definitions) as (reader, told):
            self.notes += told
            kinds = {c.topic: c.msgtype for c in reader.connections}
            wanted = self._wanted(kinds, entries, take_plan)
            keep = {
                name: keep_fields(name, entry.channels, self.place)
                for name, entry in entries.items()
                if entry.channels
            }
            topics = read_topics(reader, {name: keep.get(name) for name in wanted}, self.place)

        self.plan: Optional[Command] = None
        self.series: list[Series] = []
        names: dict[str, str] = {}
        for name in wanted:
            topic, entry = topics[name], entries.get(name)
            if not topic.messages:
                self.notes.append(f"{name} ({topic.kind}) has no message")
                continue
            if entry:
                robot.check(entry.joints, f"{name} of the map")
            if topic.kind == TRAJECTORY and not (entry and entry.channels):
                self._take_plan(topic, entry, robot, take_plan)
                continue
            stream = self._stream_name(topic, entry, names)
            self.series.append(_read_stream(topic, entry, stream, robot, self.place, self.notes))
            self.notes.append(f"{name}: stream {stream}, {len(self.series[-1].stamps)} samples")

        left = [
            f"{t.name} ({t.kind}, {t.count} messages)"
            for t in topics.values()
            if t.name not in wanted
        ]
        if left:
            self.notes.append(f"topics left out: {', '.join(sorted(left))}")
        if not self.series:
            raise InputError(
                f"{self.place}: no topic to take, of {', '.join(sorted(kinds)) or 'none'}; allowed: "
                f"messages of {', '.join(KNOWN)}, or `columns`, a map of fields"
            )
        self._check_clocks()

    def _wanted(
        self, kinds: dict[str, str], entries: dict[str, _core.BagTopic], take_plan: bool
    ) -> list[str]:
        """Topics that are read, in the map's order or by name."""
        if not entries:
            return sorted(
                t
                for t, kind in kinds.items()
                if kind in KNOWN or (kind == TRAJECTORY and take_plan)
            )
        for name, entry in entries.items():
            if name not in kinds:
                raise InputError(
                    f"{self.place}: there is no topic '{name}'{near(name, kinds)}; allowed: "
                    f"{', '.join(sorted(kinds))}"
                )
            if not entry.channels and kinds[name] not in (*KNOWN, TRAJECTORY):
                raise InputError(
                    f"{self.place}: {name} has messages of {kinds[name]}; allowed: `channels` in "
                    f"the map, or messages of {', '.join([*KNOWN, TRAJECTORY])}"
                )
        return list(entries)

    def _take_plan(
        self, topic: Topic, entry: Optional[_core.BagTopic], robot: Joints, take: bool
    ) -> None:
        if not take or self.plan:
            self.notes.append(
                f"{topic.name} ({topic.kind}) is left out: "
                f"{'another topic is the plan' if take else 'a plan is given or none is asked for'}"
            )
            return
        self.plan = Command(topic, entry, robot, self.place, self.notes)

    def _stream_name(
        self, topic: Topic, entry: Optional[_core.BagTopic], taken: dict[str, str]
    ) -> str:
        """As the map says; else joints or mocap, or the topic's name where these are taken."""
        usual = "joints" if entry and entry.channels else KNOWN[topic.kind]
        own = topic.name.strip("/").replace("/", "_")
        name = (entry.stream if entry else "") or (own if usual in taken else usual)
        if name in taken:
            raise InputError(
                f"{self.place}: {taken[name]} and {topic.name} are both the stream '{name}'; "
                "allowed: `stream` of its own in the map"
            )
        taken[name] = topic.name
        return name

    def _check_clocks(self) -> None:
        """Streams by headers and streams by the recorder's clock must mean the same clock."""
        if len(self.series) < 2:
            return
        first, last = max(s.stamps[0] for s in self.series), min(s.stamps[-1] for s in self.series)
        if first > last:
            spans = ", ".join(
                f"{s.stream} {s.stamps[0] / 1e9:.3f} to {s.stamps[-1] / 1e9:.3f} s"
                for s in self.series
            )
            raise InputError(
                f"{self.place}: streams don't overlap in time ({spans}); allowed: stamps of one "
                "clock, `stamp: log` in the map takes the recorder's"
            )

    def zero(self, start: Start) -> int:
        """Time zero [ns] by `start`."""
        first = min(int(s.stamps[0]) for s in self.series)
        if start == "plan":
            if not self.plan:
                raise InputError(
                    f"{self.place}: start: plan, but the bag has no plan; allowed: first, seconds, "
                    "CHANNEL>VALUE"
                )
            self.notes.append("time zero is where the plan begins")
            return self.plan.zero
        if start == "first":
            return first
        name, above, value = str(start).partition(">")
        try:
            number = float(value if above else name)
        except ValueError:
            number = math.nan
        if not math.isfinite(number):
            raise InputError.of(
                "start", f"'{start}' given; allowed: first, plan, seconds of the log, CHANNEL>VALUE"
            )
        if not above:
            return first + round(number * 1e9)
        return self._passes(name.strip(), number, first)

    def _passes(self, name: str, value: float, first: int) -> int:
        channels = {c: s for s in reversed(self.series) for c in s.channels}
        if name not in channels:
            raise InputError.of(
                "start", f"there is no channel '{name}'{near(name, channels)}; allowed: "
                f"{', '.join(channels)}"
            )
        series = channels[name]
        passing = np.flatnonzero(series.values[series.channels.index(name)] > value)
        if not len(passing):
            raise InputError(f"{self.place}: {name} never passes {value:g}; allowed: another start")
        at = int(series.stamps[passing[0]])
        self.notes.append(
            f"time zero where {name} first passes {value:g}: {(at - first) / 1e9:.6g} s of the log"
        )
        return at
