"""ROS 2 bags, MCAP and sqlite3, through PyPI's rosbags."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Optional, Union

from ._errors import InputError

PathLike = Union[str, "os.PathLike[str]"]


def rosbags() -> Any:
    """The package's parts that are used here, or an ImportError that says what to install."""
    try:
        import rosbags.highlevel
        import rosbags.rosbag2
        import rosbags.typesys
    except ImportError as missing:
        raise ImportError("ROS 2 bags need rosbags: pip install rosbags") from missing
    return rosbags


@dataclass
class Topic:
    """The messages of one topic, in the order of the log.

    Attributes:
        name, kind: "/joint_states", "sensor_msgs/msg/JointState".
        count: how many messages there are, read or not.
        times: the recorder's, a message each [ns].
        messages: as objects with the message's fields, or what was kept of them; empty where the topic
            isn't read.
    """

    name: str
    kind: str
    count: int
    times: list[int] = field(default_factory=list)
    messages: list[Any] = field(default_factory=list)


def _kind_of(file: Path) -> str:
    """ "trajectory_msgs/msg/JointTrajectory" of .../trajectory_msgs/msg/JointTrajectory.msg."""
    parts = file.resolve().with_suffix("").parts
    if file.suffix != ".msg" or len(parts) < 4 or parts[-2] != "msg":
        raise InputError.of(
            "definitions", f"'{file}' given; allowed: PACKAGE/msg/NAME.msg, or a folder of such"
        )
    return "/".join(parts[-3:])


def _given_types(definitions: Iterable[PathLike]) -> dict[str, Any]:
    """Message definitions by files or folders of files."""
    found: dict[str, Any] = {}
    for given in map(Path, definitions):
        if not given.exists():
            raise InputError.of("definitions", f"there is no '{given}'")
        files = sorted(given.glob("**/msg/*.msg")) if given.is_dir() else [given]
        if not files:
            raise InputError.of("definitions", f"no PACKAGE/msg/NAME.msg in '{given}'")
        for file in files:
            found.update(rosbags().typesys.get_types_from_msg(file.read_text(), _kind_of(file)))
    return found


@contextmanager
def open_bag(path: PathLike, definitions: Iterable[PathLike]) -> Iterator[tuple[Any, list[str]]]:
    """rosbags' reader of a bag, and what was taken for what the bag leaves open. Types are the bag's
    own; those that it doesn't define are `definitions`, then ROS 2 Humble's."""
    library, file = rosbags(), Path(path)
    if not file.exists():
        raise InputError(f"{file}: there is no such file or folder")
    given = _given_types(definitions)
    humble = library.typesys.get_typestore(library.typesys.Stores.ROS2_HUMBLE)
    reader = _opened(file, humble)
    try:
        own = {c.msgtype for c in reader.connections if c.msgdef.data}
        own_types = set(reader.typestore.fielddefs) if own else set()
        reader.typestore.register({k: v for k, v in given.items() if k not in own_types})
        reader.typestore.register(
            {k: v for k, v in humble.fielddefs.items() if k not in reader.typestore.fielddefs}
        )
        assumed = sorted({c.msgtype for c in reader.connections} - own_types - set(given))
        assumed = [kind for kind in assumed if kind in humble.fielddefs]
        notes = (
            [f"the bag doesn't define {', '.join(assumed)}: read as in ROS 2 Humble"]
            if assumed
            else []
        )
        yield reader, notes
    finally:
        reader.close()


def _opened(file: Path, humble: Any) -> Any:
    """rosbags' reader, open."""
    allowed = (
        "allowed: a ROS 2 bag, its folder or its .mcap or .db3 file; of one that was cut off what `mcap "
        "recover` or `ros2 bag reindex` makes"
    )
    try:
        reader = rosbags().highlevel.AnyReader([file], default_typestore=humble)
        reader.open()
    except (
        KeyError
    ) as encoding:  # of a schema that isn't ROS's: rosbags then reads none of the file
        raise InputError(
            f"{file}: has messages that are not ROS's (schema encoding {encoding}); allowed: ROS 2 "
            "messages alone, as `mcap filter --include-topic-regex TOPIC` makes"
        ) from encoding
    except Exception as fault:  # whatever a damaged file may raise
        raise InputError(f"{file}: {fault or type(fault).__name__}; {allowed}") from fault
    return reader


Keep = Callable[[Any], Any]


def read_topics(reader: Any, wanted: dict[str, Optional[Keep]], place: str) -> dict[str, Topic]:
    """All topics of a bag by name. Of those that are wanted the messages, or what is to be kept of
    each: a large message of which few fields are read would fill the memory."""
    topics: dict[str, Topic] = {}
    for connection in reader.connections:
        topic = topics.setdefault(connection.topic, Topic(connection.topic, connection.msgtype, 0))
        topic.count += connection.msgcount
        if connection.topic not in wanted:
            continue
        if connection.msgtype != topic.kind:
            raise InputError(
                f"{place}: {topic.name} has messages of {topic.kind} and {connection.msgtype}; "
                "allowed: one type a topic"
            )
        if connection.msgtype not in reader.typestore.fielddefs:
            raise InputError(
                f"{place}: {topic.name}: the bag doesn't define {topic.kind}; allowed: "
                "definitions=[...], files PACKAGE/msg/NAME.msg"
            )

    used = [c for c in reader.connections if c.topic in wanted]
    for connection, time, raw in reader.messages(used) if used else ():
        topic = topics[connection.topic]
        try:
            message = reader.deserialize(raw, connection.msgtype)
        except Exception as fault:  # whatever cut messages may raise
            raise InputError(
                f"{place}: {topic.name}: message {len(topic.messages) + 1} is no {topic.kind}: "
                f"{fault}"
            ) from fault
        topic.times.append(time)
        keep = wanted[connection.topic]
        topic.messages.append(keep(message) if keep else message)
    return topics
