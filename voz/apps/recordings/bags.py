"""Bags, the recordings of ROS: writes what a run publishes, and reads what was heard.

The package rosbags does it, without ROS. `.mcap` and `.db3` are files of ROS 2, no ending is a
folder as `ros2 bag` makes it, `.bag` is of ROS 1.
"""

from __future__ import annotations

import sqlite3
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from voz.apps.recordings.bag_files import open_bag
from voz.errors import ConfigError
from voz.events import Event, Receiver, SelectedObject, Twist, Utterance
from voz.extras import require
from voz.run.sources import BagContent, BagSentence

if TYPE_CHECKING:
    from rosbags.highlevel import AnyReader
    from rosbags.typesys.store import Typestore


BAG_ENDINGS = (".mcap", ".db3", ".bag", "")
HEARD_TOPIC = "/recognizer/output"
STRING, INT16 = "std_msgs/msg/String", "std_msgs/msg/Int16"
TWIST, VECTOR = "geometry_msgs/msg/Twist", "geometry_msgs/msg/Vector3"
BAG_SOURCE = "bag"
"""The source of a sentence in a bag: only its text is there."""

BAG_TOPICS = {"/cmd_vel": TWIST, "/selected_object": INT16, HEARD_TOPIC: STRING}

SAVE_INTERVAL, SAVE_INTERVAL_SHARE = 5.0, 0.002
"""A bag is saved after this time, s, or this share of its length if that is longer: each save
writes the list of all messages again."""


SECONDS_PER_DAY = 24 * 60 * 60.0
LONGEST_BAG = 7 * SECONDS_PER_DAY
"""A longer bag, s, has a damaged time stamp."""


def check_bag(path: Path) -> None:
    """Check that a bag can be written, before the run that it will keep.

    Raises:
        ConfigError: the name or the folder cannot be used, it exists, or rosbags is missing.
    """
    require("bags", "rosbags")
    if path.suffix not in BAG_ENDINGS:
        raise ConfigError(
            f"{path}: invalid name of a bag; end it with .mcap, .db3, .bag or nothing"
        )
    if path.exists():
        raise ConfigError(f"{path}: is there already; name a new bag")
    if not path.parent.is_dir():
        raise ConfigError(f"{path}: there is no folder {path.parent}; make it first")


@contextmanager
def write_bag(path: Path) -> Iterator[Receiver]:
    """Write what a run publishes into a new bag, for the length of a `with` block.

    It is saved every few seconds: a kill or a full disk costs only what came after.

    Raises:
        ConfigError: as `check_bag`, or it cannot be written; the receiver raises it too.
    """
    check_bag(path)
    types = _types(path)
    serialize = types.serialize_ros1 if path.suffix == ".bag" else types.serialize_cdr
    stamp = _stamps()
    bag = _Bag(path, types)
    try:
        yield _receiver(
            types,
            lambda topic, t, message: bag.write(
                topic, stamp(t), serialize(message, BAG_TOPICS[topic])
            ),
        )
    except Exception:  # a second failure would hide it
        with suppress(ConfigError):
            bag.close()
        raise
    except BaseException:  # a signal ends the run
        bag.close()
        raise
    bag.close()


def read_sayings(path: Path) -> BagContent:
    """Read what a recognizer published on `recognizer/output`, in any namespace.

    Raises:
        ConfigError: the bag of ROS 1 or 2 cannot be read, has no such topic, or is too long.
    """
    with _opened(path) as bag:
        heard = [
            c for c in bag.connections if c.topic.endswith(HEARD_TOPIC) and c.msgtype == STRING
        ]
        topics = sorted({c.topic for c in bag.connections})
        said = [
            BagSentence(_seconds(t - bag.start_time), _text(bag.deserialize(data, STRING)))
            for _, t, data in (bag.messages(heard) if heard else ())
        ]
        seconds = _seconds(bag.end_time - bag.start_time)
    if not heard:
        has = ", ".join(topics) or "nothing"
        raise ConfigError(f"{path}: has no strings on {HEARD_TOPIC[1:]}; it has {has}")
    times = [0.0, seconds, *(each.t for each in said)]
    if (longest := max(times) - min(times)) > LONGEST_BAG:
        raise ConfigError(
            f"{path}: lasts {longest / SECONDS_PER_DAY:.0f} days by the times in it, one of which "
            "must be damaged; name another bag"
        )
    return BagContent(said, seconds)


def is_bag(path: Path) -> bool:
    """Whether a path is a bag, by its name; a file without an ending is none."""
    return path.is_dir() or (path.suffix != "" and path.suffix in BAG_ENDINGS)


def read_events(path: Path) -> list[Event]:
    """Read velocities, objects and sentences of a bag, in any namespace, with times from its start.

    Raises:
        ConfigError: the bag of ROS 1 or 2 cannot be read.
    """
    with _opened(path) as bag:
        known = [c for c in bag.connections if _is_known(c.topic, c.msgtype)]
        return [
            _event(c.msgtype, _seconds(t - bag.start_time), bag.deserialize(data, c.msgtype))
            for c, t, data in (bag.messages(known) if known else ())
        ]


def _is_known(topic: str, kind: str) -> bool:
    return any(topic.endswith(name) and kind == of for name, of in BAG_TOPICS.items())


def _event(kind: str, t: float, message: Any) -> Event:
    if kind == TWIST:
        return Twist(t, message.linear.x, message.angular.z)
    if kind == INT16:
        return SelectedObject(t, message.data)
    return Utterance(t, _text(message), 1.0, True, t, t, BAG_SOURCE, obeyed=True)


@contextmanager
def _opened(path: Path) -> Iterator[AnyReader]:
    """Read a bag in a `with` block; raises ConfigError if that fails."""
    require("bags", "rosbags")
    if not path.exists():
        raise ConfigError(f"{path}: there is no such bag")
    from rosbags.highlevel import AnyReader

    try:
        with AnyReader([path], default_typestore=_types(path)) as bag:
            yield bag
    except Exception as error:  # rosbags raises anything for a damaged bag
        raise ConfigError(f"{path}: cannot be read as a bag ({error})") from error


class _Bag:
    """A bag that is saved every few seconds; raises ConfigError when it cannot be written."""

    def __init__(self, path: Path, types: Typestore) -> None:
        self._path = path
        self._begun = self._next = time.monotonic()
        self._first: int | None = None
        self._last = 0
        self._kept = "nothing is kept"
        self._usable = True
        with self._errors_as_config_error():
            self._file = open_bag(path, BAG_TOPICS, types)

    def write(self, topic: str, stamp: int, data: Any) -> None:
        """Add a message; does nothing once a write has failed."""
        if not self._usable:
            return
        with self._errors_as_config_error():
            self._file.write(topic, stamp, data)
            self._first, self._last = self._first or stamp, stamp
            now = time.monotonic()
            if now >= self._next:
                self._save()
                self._next = now + max(SAVE_INTERVAL, (now - self._begun) * SAVE_INTERVAL_SHARE)

    def close(self) -> None:
        """Save and close it."""
        try:
            if self._usable:
                with self._errors_as_config_error():
                    self._save()
        finally:
            self._file.close()

    def _save(self) -> None:
        self._file.save()
        seconds = _seconds(self._last - (self._first or self._last))
        self._kept = f"it has what was published in the first {seconds:.1f} s"

    @contextmanager
    def _errors_as_config_error(self) -> Iterator[None]:
        try:
            yield
        except (OSError, sqlite3.Error) as error:
            self._usable = False
            why = getattr(error, "strerror", None) or error
            raise ConfigError(f"{self._path}: cannot be written ({why}); {self._kept}") from error


def _receiver(types: Typestore, write: Callable[[str, float, object], None]) -> Receiver:
    """A receiver that publishes events as the ROS robots do, without what was refused."""
    make = types.types

    def receive(event: Event) -> None:
        if isinstance(event, Twist):
            linear = make[VECTOR](event.linear, 0.0, 0.0)
            angular = make[VECTOR](0.0, 0.0, event.angular)
            write("/cmd_vel", event.t, make[TWIST](linear, angular))
        elif isinstance(event, SelectedObject):
            write("/selected_object", event.t, make[INT16](event.value))
        elif isinstance(event, Utterance) and event.obeyed:
            write(HEARD_TOPIC, event.t, make[STRING](event.text))

    return receive


def _stamps() -> Callable[[float], int]:
    """Return a function from the time of the run, s, to the time of day, ns."""
    begun = time.time_ns()
    return lambda t: begun + round(t * 1e9)


def _types(path: Path) -> Typestore:
    from rosbags.typesys import Stores, get_typestore

    is_ros1 = path.suffix == ".bag"
    return get_typestore(Stores.ROS1_NOETIC if is_ros1 else Stores.ROS2_HUMBLE)


def _text(message: Any) -> str:
    return str(message.data)


def _seconds(nanoseconds: int) -> float:
    return round(nanoseconds / 1e9, 3)
