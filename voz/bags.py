"""Bags, the recordings of ROS: keeps what a run publishes, and reads what another one heard.

No ROS is needed; the package rosbags writes and reads them. Its ending tells what a bag is: `.mcap`
and `.db3` are files of ROS 2, no ending is a folder as `ros2 bag` makes it, `.bag` is of ROS 1.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from voz.errors import ConfigError
from voz.events import Event, Receiver, SelectedObject, Twist, Utterance

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore


ENDINGS = (".mcap", ".db3", ".bag", "")
HEARD = "/recognizer/output"
STRING, INT16 = "std_msgs/msg/String", "std_msgs/msg/Int16"
TWIST, VECTOR = "geometry_msgs/msg/Twist", "geometry_msgs/msg/Vector3"
TOPICS = {"/cmd_vel": TWIST, "/selected_object": INT16, HEARD: STRING}

METADATA_VERSION: Literal[8] = 8
"""Of ROS 2's bags; the oldest that rosbags writes is read by the most."""


class Saying(NamedTuple):
    """A sentence that a recogniser published: when, s after the bag begins, and what."""

    t: float
    text: str


class Sayings(NamedTuple):
    """All sentences in a bag, in order, and how long the bag is, s."""

    said: list[Saying]
    seconds: float


def check_bag(path: Path) -> None:
    """Find out whether a bag can be written, before the run that it will keep.

    Raises:
        ConfigError: the name or the place does not do, it is there already, or rosbags is missing.
    """
    _check_installed()
    if path.suffix not in ENDINGS:
        raise ConfigError(f"{path}: is no name for a bag; end it with .mcap, .db3, .bag or nothing")
    if path.exists():
        raise ConfigError(f"{path}: is there already; name a new bag")
    if not path.parent.is_dir():
        raise ConfigError(f"{path}: there is no folder {path.parent}; make it first")


@contextmanager
def bag_of(path: Path) -> Iterator[Receiver]:
    """Keep what a run publishes for the length of a `with` block, however that ends.

    Args:
        path: the new bag; its times are those of the events, from now on.

    Yields:
        What takes the events.

    Raises:
        ConfigError: as in `check_bag`.
    """
    check_bag(path)
    writing = _bag_of_ros1 if path.suffix == ".bag" else _bag_of_ros2
    try:
        with writing(path) as receive:
            yield receive
    except OSError as error:
        raise ConfigError(f"{path}: cannot be written ({error.strerror or error})") from error


def read_sayings(path: Path) -> Sayings:
    """Read what a recogniser published on `recognizer/output`, in any namespace.

    Args:
        path: a bag of ROS 1 or 2.

    Raises:
        ConfigError: there is no such bag, it cannot be read, or it holds no such topic.
    """
    _check_installed()
    if not path.exists():
        raise ConfigError(f"{path}: there is no such bag")
    from rosbags.highlevel import AnyReader

    try:
        with AnyReader([path], default_typestore=_types()) as bag:
            heard = [c for c in bag.connections if c.topic.endswith(HEARD) and c.msgtype == STRING]
            topics = sorted({c.topic for c in bag.connections})
            said = [
                Saying(_seconds(t - bag.start_time), _text(bag.deserialize(data, STRING)))
                for _, t, data in (bag.messages(heard) if heard else ())
            ]
            seconds = _seconds(bag.end_time - bag.start_time)
    except Exception as error:  # a broken bag makes its readers fail in any way
        raise ConfigError(f"{path}: is no bag that can be read ({error})") from error
    if not heard:
        has = ", ".join(topics) or "nothing"
        raise ConfigError(f"{path}: has no strings on {HEARD[1:]}; it has {has}")
    return Sayings(said, seconds)


def _receiver(types: Typestore, write: Callable[[str, float, object], None]) -> Receiver:
    """What publishes events as the ROS robots do; what was refused is not published."""
    make = types.types

    def receive(event: Event) -> None:
        if isinstance(event, Twist):
            linear = make[VECTOR](event.linear, 0.0, 0.0)
            angular = make[VECTOR](0.0, 0.0, event.angular)
            write("/cmd_vel", event.t, make[TWIST](linear, angular))
        elif isinstance(event, SelectedObject):
            write("/selected_object", event.t, make[INT16](event.value))
        elif isinstance(event, Utterance) and event.accepted:
            write(HEARD, event.t, make[STRING](event.text))

    return receive


@contextmanager
def _bag_of_ros1(path: Path) -> Iterator[Receiver]:
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_typestore

    types = get_typestore(Stores.ROS1_NOETIC)
    with _written(Writer(path), types, types.serialize_ros1) as receive:
        yield receive


@contextmanager
def _bag_of_ros2(path: Path) -> Iterator[Receiver]:
    from rosbags.rosbag2 import StoragePlugin, Writer

    types = _types()
    plugin = StoragePlugin.MCAP if path.suffix == ".mcap" else StoragePlugin.SQLITE3
    with _folder_for(path) as folder:
        writer = Writer(folder, version=METADATA_VERSION, storage_plugin=plugin)
        with _written(writer, types, types.serialize_cdr) as receive:
            yield receive


@contextmanager
def _written(
    writer: Any, types: Typestore, serialize: Callable[[object, str], Any]
) -> Iterator[Receiver]:
    """What writes events into a bag; at the end the bag is finished."""
    writer.open()
    try:
        topics = {
            topic: writer.add_connection(topic, kind, typestore=types)
            for topic, kind in TOPICS.items()
        }
        stamp = _stamps()
        yield _receiver(
            types,
            lambda topic, t, message: writer.write(
                topics[topic], stamp(t), serialize(message, TOPICS[topic])
            ),
        )
    finally:  # as a context manager it would leave the bag unfinished at Ctrl-C
        writer.close()


@contextmanager
def _folder_for(path: Path) -> Iterator[Path]:
    """The folder that rosbags writes into; a bag that is a file is taken out of it at the end."""
    if not path.suffix:
        yield path
        return
    with tempfile.TemporaryDirectory(prefix=f".{path.name}.", dir=path.parent) as around:
        folder = Path(around) / path.stem
        try:
            yield folder
        finally:
            written = folder / f"{folder.name}{path.suffix}"
            if written.exists():
                written.replace(path)


def _stamps() -> Callable[[float], int]:
    """Make what gives a time of the run, s, as one of the world, ns: a bag's times are of it."""
    begun = time.time_ns()
    return lambda t: begun + round(t * 1e9)


def _types() -> Typestore:
    from rosbags.typesys import Stores, get_typestore

    return get_typestore(Stores.ROS2_HUMBLE)


def _text(message: Any) -> str:
    return str(message.data)


def _seconds(nanoseconds: int) -> float:
    return round(nanoseconds / 1e9, 3)


def _check_installed() -> None:
    if find_spec("rosbags") is None:
        raise ConfigError("rosbags is not installed; run `pip install 'voz[bags]'`")
