"""Logs of robots as others keep them, into datasets: ROS 2 bags, Parquet, tables of pandas."""

from __future__ import annotations

import math
import os
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any, Optional, Union

import numpy as np

from . import _core
from ._bags import PathLike
from ._errors import InputError, reading
from ._inputs import Source, node_of
from ._messages import Joints, Series, near
from ._tables import pandas
from ._trials import Bag, Start
from .datasets import Dataset, load_dataset


def _as_list(given: Any) -> list[Any]:
    return (
        [given]
        if isinstance(given, (str, os.PathLike)) or hasattr(given, "columns")
        else list(given)
    )


def _kept(time: np.ndarray, cut: Optional[tuple[float, float]], place: str) -> np.ndarray:
    """Which samples lie within `cut`; times count from time zero [s]."""
    if cut is None:
        return np.ones(len(time), bool)
    kept = (time >= cut[0] - 1e-9) & (time <= cut[1] + 1e-9)
    if not kept.any():
        raise InputError(
            f"{place}: no sample lies within cut {cut[0]:g},{cut[1]:g} s of time zero"
        )
    return kept


def _core_streams(
    series: Iterable[Series], zero: int, cut: Optional[tuple[float, float]], place: str
) -> list[_core.Stream]:
    streams = []
    for s in series:
        time = (s.stamps - zero) / 1e9
        kept = _kept(time, cut, f"{place}: {s.stream}")
        streams.append(
            _core.make_stream(
                s.stream,
                s.rate_hz,
                time[kept],
                s.channels,
                s.units,
                np.asfortranarray(s.values[:, kept]),
            )
        )
    return streams


def _finish(
    dataset: _core.Dataset, out: PathLike, notes: list[str], source: str, provenance: str
) -> Dataset:
    """Writes the dataset, and reads it as any other."""
    assumed = list(dataset.notes)
    told = " ".join(f"{note.rstrip('.')}." for note in notes)
    _core.write_dataset(dataset, os.fspath(out), f"{provenance or source} {told}".strip())
    written = load_dataset(out)
    written.notes = assumed + notes + [note for note in written.notes if note not in assumed]
    return written


def _check_cut(cut: Optional[tuple[float, float]]) -> None:
    if cut is not None and not cut[0] < cut[1]:
        raise InputError.of(
            "cut", f"{tuple(cut)} given; allowed: (FROM, TO) in seconds, FROM below TO"
        )


def import_bag(
    path: Union[PathLike, Iterable[PathLike]],
    out: PathLike,
    *,
    robot: PathLike,
    columns: Optional[Source] = None,
    experiment: str = "leap",
    plan: PathLike = "",
    controller: str = "",
    start: Optional[Start] = None,
    cut: Optional[tuple[float, float]] = None,
    definitions: Iterable[PathLike] = (),
    provenance: str = "",
) -> Dataset:
    """Makes a dataset of ROS 2 bags: MCAP and sqlite3, by PyPI's rosbags.

    Without `columns` all topics of these types are taken; anything else is left out, with a note:
    sensor_msgs/JointState (joints by the robot's names, planar or of its file; effort is a motor's torque
    at the joint), nav_msgs/Odometry and geometry_msgs/PoseStamped (the base: x, y, z, pitch, roll, yaw,
    x and angles from rest), trajectory_msgs/JointTrajectory (the plan, where no other is given). Times
    are headers' stamps where these are set, else the recorder's.

    Args:
        path: a bag's folder, its .mcap or .db3 file; or several, a trial each.
        out: the dataset's folder, written.
        robot: a folder of models/, or a path.
        columns: a YAML file or a dict, format jaculus-bag/1: which topics are taken, in which streams;
            joints' names; of any type of message, fields by their path as channels with units.
        experiment: "leap", "self_righting", "tail_bench" or "pendulum".
        plan: plan.csv of what was commanded.
        controller: as in dataset.yaml: "{kind: measured, input: torque}".
        start: time zero: "first" (stamp), "plan" (where a plan of the bag begins; the default where there
            is one), seconds since the first stamp, or "CHANNEL>VALUE".
        cut: (from, to) [s] about time zero that are kept; None: everything.
        definitions: files PACKAGE/msg/NAME.msg, or folders of such, for types that the bag doesn't
            define (bags of ROS 2 Humble and before in sqlite3 define none).
        provenance: where the logs come from; what was assumed is written after it.

    Returns:
        The `Dataset` as it was read back; its `notes` say all that was assumed or left out.

    Raises:
        InputError: with the file and what is allowed.
        ImportError: where rosbags isn't installed.
    """
    _check_cut(cut)
    entries = {} if columns is None else {e.topic: e for e in _core.read_bag_map(node_of(columns))}
    joints = Joints(_core.load_robot(os.fspath(robot)))
    paths = _as_list(path)
    take_plan = not plan and "measured" not in controller
    bags = []
    for p in paths:
        with reading(p):
            bags.append(Bag(p, entries, joints, take_plan, definitions))
    if not bags:
        raise InputError.of("path", "no bag given; allowed: one or more")

    plans = [bag.plan for bag in bags if bag.plan]
    if plans and (len(plans) < len(bags) or not all(plans[0].same(p) for p in plans)):
        raise InputError(
            "the bags don't command the same trajectory; allowed: bags of one plan in a dataset"
        )
    with tempfile.TemporaryDirectory() as scratch:
        file = Path(scratch, "plan.csv")
        if plans:
            plans[0].write(file)
        dataset = _core.begin_import(
            experiment, os.fspath(robot), file if plans else os.fspath(plan), controller
        )

    notes: list[str] = []
    for k, bag in enumerate(bags, 1):
        with reading(bag.place):
            zero = bag.zero(start if start is not None else "plan" if bag.plan else "first")
            streams = _core_streams(bag.series, zero, cut, bag.place)
        _core.add_trial(dataset, f"trial_{k:02}", streams)
        notes += [f"trial_{k:02}: {note}" for note in bag.notes]
    source = f"Imported by jaculus from ROS 2 bags: {', '.join(Path(p).name for p in paths)}."
    return _finish(dataset, out, notes, source, provenance)


def _frame(path: Any, columns: _core.ColumnMap) -> Any:
    """A table of pandas."""
    if hasattr(path, "columns"):
        return path
    file = Path(path)
    if not file.exists():
        raise InputError(f"{file}: there is no such file")
    try:
        if file.suffix == ".parquet":
            return pandas().read_parquet(file)
        separator = r"\s+" if columns.separator == " " else columns.separator
        frame = pandas().read_csv(
            file,
            sep=separator,
            skiprows=columns.skip_lines,
            na_values=columns.gaps,
            header=0 if columns.header else None,
        )
    except (ValueError, OSError) as fault:
        raise InputError(f"{file}: {fault}; allowed: Parquet, or CSV as the map says") from fault
    return (
        frame
        if columns.header
        else frame.set_axis([str(i + 1) for i in range(frame.shape[1])], axis=1)
    )


def _column(frame: Any, name: str, place: str) -> np.ndarray:
    """A column as numbers; times of day in seconds since the first [s]."""
    if name not in frame.columns:
        raise InputError(
            f"{place}: there is no column '{name}'{near(name, map(str, frame.columns))}; allowed: "
            f"{', '.join(map(str, frame.columns))}"
        )
    values = frame[name]
    if pandas().api.types.is_datetime64_any_dtype(values):
        return (values - values.iloc[0]).dt.total_seconds().to_numpy()
    if not pandas().api.types.is_numeric_dtype(values):
        raise InputError(
            f"{place}: column '{name}' holds {values.dtype}; allowed: numbers, gaps as the map says"
        )
    return values.to_numpy(dtype=float, na_value=math.nan)


def import_table(
    path: Any,
    out: PathLike,
    *,
    columns: Source,
    robot: PathLike,
    experiment: str = "leap",
    plan: PathLike = "",
    controller: str = "",
    start: Start = "first",
    cut: Optional[tuple[float, float]] = None,
    provenance: str = "",
) -> Dataset:
    """Makes a dataset of tables: Parquet, CSV, or pandas' own, through a map of their columns.

    Args:
        path: a .parquet or CSV file or a pandas.DataFrame; or several, a trial each.
        columns: a YAML file or a dict, format jaculus-columns/1, as of `jaculus import csv`.
        out, robot, experiment, plan, controller, cut, provenance: see `import_bag`.
        start: time zero: "first" (sample), seconds of the file, or "CHANNEL>VALUE".

    Raises:
        InputError: with the file, the column and what is allowed.
        ImportError: where pandas isn't installed, or for Parquet pyarrow.
    """
    _check_cut(cut)
    layout = _core.read_column_map(node_of(columns))
    dataset = _core.begin_import(experiment, os.fspath(robot), os.fspath(plan), controller)
    notes: list[str] = []
    tables = _as_list(path)
    for k, table in enumerate(tables, 1):
        with reading("table" if hasattr(table, "columns") else table):
            frame = _frame(table, layout)
            stream = _table_stream(table, frame, layout, start, cut)
        _core.add_trial(dataset, f"trial_{k:02}", [stream])
        used = {name for channel in layout.channels for name in channel.columns}
        left = [str(name) for name in frame.columns if str(name) not in used]
        notes += [f"trial_{k:02}: columns left out: {', '.join(left)}"] if left else []
    names = ", ".join("a table" if hasattr(t, "columns") else Path(t).name for t in tables)
    return _finish(dataset, out, notes, f"Imported by jaculus from {names}.", provenance)


def _table_stream(
    table: Any,
    frame: Any,
    layout: _core.ColumnMap,
    start: Start,
    cut: Optional[tuple[float, float]],
) -> _core.Stream:
    """The channels of a map, of one table."""
    place = "table" if hasattr(table, "columns") else os.fspath(table)
    rows = {
        c.channel: c.scale * np.mean([_column(frame, name, place) for name in c.columns], axis=0)
        + c.shift
        for c in layout.channels
    }
    time = rows.pop("time")
    if not len(time) or not np.all(np.diff(time) > 0.0):
        raise InputError(f"{place}: time: allowed: rising times in every row")
    time = time - _table_zero(start, time, rows, place)
    kept = _kept(time, cut, place)

    units = {c.channel: c.unit for c in layout.channels}
    return _core.make_stream(
        layout.stream,
        layout.rate_hz,
        time[kept],
        list(rows),
        [units[name] for name in rows],
        np.asfortranarray(np.array(list(rows.values()))[:, kept]),
    )


def _table_zero(start: Start, time: np.ndarray, rows: dict[str, np.ndarray], place: str) -> float:
    if start == "first":
        return float(time[0])
    name, above, value = str(start).partition(">")
    try:
        number = float(value if above else name)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise InputError.of(
            "start", f"'{start}' given; allowed: first, seconds of the file, CHANNEL>VALUE"
        )
    if not above:
        return number
    if name.strip() not in rows:
        raise InputError.of(
            "start", f"there is no channel '{name.strip()}'; allowed: {', '.join(rows)}"
        )
    passing = np.flatnonzero(rows[name.strip()] > number)
    if not len(passing):
        raise InputError(f"{place}: {name.strip()} never passes {number:g}; allowed: another start")
    return float(time[passing[0]])
