"""Bags: what is written is read by rosbags' own readers, and drives again."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
from driving import COMMANDS, play, type_lines
from full_disk import full_disk
from rosbags.highlevel import AnyReader
from rosbags.rosbag1 import Writer as Writer1
from rosbags.typesys import Stores, get_typestore

from voz.apps.recordings.bags import HEARD_TOPIC, STRING, check_bag, read_sayings, write_bag
from voz.errors import ConfigError
from voz.events import Event, Receiver, SelectedObject, Twist, Utterance
from voz.language.sentences.command_set import plain_commands
from voz.run.sources import bag_items

NAMES = ["drive.mcap", "drive.db3", "drive.bag", "drive"]
LINES = ["start speech", "go forward", "dance", "-", "point beer", "turn left", *"----", "stop"]


def keep(path: Path, lines: Sequence[str] = LINES) -> list[Event]:
    events: list[Event] = []
    with write_bag(path) as receive:
        type_lines(lines, events.append, receive)
    return events


def replay(path: Path, *receivers: Receiver) -> None:
    play(
        lambda _: bag_items(path, read_sayings(path), plain_commands(COMMANDS), {"stop"}),
        *receivers,
    )


def read(path: Path) -> list[tuple[str, str, float, Any]]:
    """Topic, type, time since the begin and message of everything in a bag."""
    with AnyReader([path]) as bag:
        return [
            (c.topic, c.msgtype, (t - bag.start_time) / 1e9, bag.deserialize(data, c.msgtype))
            for c, t, data in bag.messages()
        ]


@pytest.mark.parametrize("name", NAMES)
def test_what_was_published_is_read_back_with_its_types_and_times(
    name: str, tmp_path: Path
) -> None:
    events = keep(tmp_path / name)
    assert [path.name for path in tmp_path.iterdir()] == [name]
    messages = read(tmp_path / name)
    moved = [(t, m.linear, m.angular) for topic, _, t, m in messages if topic == "/cmd_vel"]
    assert [(t, v.x, w.z) for t, v, w in moved] == [
        (event.t, event.linear, event.angular) for event in events if isinstance(event, Twist)
    ]
    assert all((v.y, v.z, w.x, w.y) == (0, 0, 0, 0) for _, v, w in moved)
    selected = [(t, m.data) for topic, _, t, m in messages if topic == "/selected_object"]
    assert selected == [(e.t, e.value) for e in events if isinstance(e, SelectedObject)] != []
    heard = [(t, m.data) for topic, _, t, m in messages if topic == "/recognizer/output"]
    assert heard == [(e.t, e.text) for e in events if isinstance(e, Utterance) and e.accepted]
    assert "dance" not in dict(heard).values()
    assert {topic: kind for topic, kind, _, _ in messages} == {
        "/cmd_vel": "geometry_msgs/msg/Twist",
        "/selected_object": "std_msgs/msg/Int16",
        "/recognizer/output": "std_msgs/msg/String",
    }


@pytest.mark.parametrize("name", NAMES)
def test_a_bag_drives_the_robot_as_it_was_driven(name: str, tmp_path: Path) -> None:
    first = keep(tmp_path / name)
    second: list[Event] = []
    replay(tmp_path / name, second.append)
    kinds = (Twist, SelectedObject)
    moves = [[e for e in events if isinstance(e, kinds)] for events in (first, second)]
    assert moves[0] == moves[1]
    sources = {e.source for e in second if isinstance(e, Utterance)}
    assert sources == {str(tmp_path / name)}


def test_another_recognizer_may_shout_and_say_what_is_no_command(tmp_path: Path) -> None:
    path = tmp_path / "theirs.bag"
    types = get_typestore(Stores.ROS1_NOETIC)
    with Writer1(path) as writer:
        topic = writer.add_connection(f"/robot1{HEARD_TOPIC}", STRING, typestore=types)
        for seconds, text in [(100, "START SPEECH"), (101, " Go  Forward"), (102, "the weather")]:
            message = types.types[STRING](text)
            writer.write(topic, seconds * 10**9, types.serialize_ros1(message, STRING))
    events: list[Event] = []
    replay(path, events.append)
    heard = [(e.t, e.text, e.accepted) for e in events if isinstance(e, Utterance)]
    assert heard == [(0, "start speech", True), (1, "go forward", True), (2, "the weather", False)]
    moving = [event.t for event in events if isinstance(event, Twist) and event.linear]
    assert moving[0] == 1
    assert moving[-1] == 2


@pytest.mark.parametrize("name", NAMES)
def test_a_run_that_is_ended_leaves_a_whole_bag(name: str, tmp_path: Path) -> None:
    def program() -> None:
        path = tmp_path / name
        with write_bag(path) as receive:
            type_lines(["go forward"], receive, listening=True)
            raise SystemExit(143)

    with pytest.raises(SystemExit):
        program()
    assert [path.name for path in tmp_path.iterdir()] == [name]
    moved = [m.linear.x for topic, _, _, m in read(tmp_path / name) if topic == "/cmd_vel"]
    assert moved == [0.1, 0]


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_on_a_full_disk_there_is_one_line_and_what_was_saved_stays(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("voz.apps.recordings.bags.SAVE_INTERVAL", 0.01)
    path = tmp_path / name
    complaint = rf"{name}: cannot be written \([^\n]+\); it has what was published in the first"
    with full_disk(90_000), pytest.raises(ConfigError, match=complaint):
        keep(path, ["start speech", "go forward", *["-"] * 2000])
    moved = [m.linear.x for topic, _, _, m in read(path) if topic == "/cmd_vel"]
    assert moved[0] == 0
    assert moved[-1] == 0.1
    assert len(moved) > 50
    assert [said.text for said in read_sayings(path).sentences] == ["start speech", "go forward"]
    assert [each.name for each in tmp_path.iterdir()] == [name]


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_once_a_bag_cannot_be_written_it_says_so_once(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("voz.apps.recordings.bags.SAVE_INTERVAL", 0.01)
    failures = []

    def program() -> None:
        with full_disk(90_000), write_bag(tmp_path / name) as receive:
            for number in range(3000):
                try:
                    receive(Twist(number / 10, 0.1, 0.0))
                except ConfigError as error:
                    failures.append(error)

    program()
    assert len(failures) == 1


@pytest.mark.parametrize("room", [0, 1000])
@pytest.mark.parametrize("name", NAMES)
def test_on_a_disk_that_is_full_from_the_start_there_is_one_line_and_nothing_left(
    name: str, room: int, tmp_path: Path
) -> None:
    with full_disk(room), pytest.raises(ConfigError, match=rf"{name}: cannot be written \([^\n]+$"):
        keep(tmp_path / name)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", NAMES)
def test_a_bag_is_whole_after_kill_9(name: str, tmp_path: Path) -> None:
    script = f"""
import time
from pathlib import Path
import voz.apps.recordings.bags
from voz.events import Twist
voz.apps.recordings.bags.SAVE_INTERVAL = voz.apps.recordings.bags.SAVE_INTERVAL_SHARE = 0.0
with voz.apps.recordings.bags.write_bag(Path({name!r})) as receive:
    for number in range(30):
        receive(Twist(number / 10, 0.1, 0.0))
    voz.apps.recordings.bags.SAVE_INTERVAL = 1000.0
    for number in range(30, 60):
        receive(Twist(number / 10, 0.1, 0.0))
    print("written", flush=True)
    time.sleep(1000)
"""
    command = [sys.executable, "-c", script]
    with subprocess.Popen(command, stdout=subprocess.PIPE, cwd=tmp_path) as process:
        assert process.stdout
        assert process.stdout.readline() == b"written\n"
        process.kill()
    assert len(read(tmp_path / name)) == 31


def test_a_bag_is_never_overwritten(tmp_path: Path) -> None:
    path = tmp_path / "drive.mcap"
    keep(path)
    before = path.read_bytes()
    with pytest.raises(ConfigError, match=r"drive.mcap: is there already; name a new bag"):
        keep(path)
    assert path.read_bytes() == before


@pytest.mark.parametrize(
    ("name", "complaint"),
    [("a.zip", r"end it with .mcap, .db3, .bag or nothing"), ("no/a.bag", "there is no folder")],
)
def test_what_cannot_be_written_is_told_before(name: str, complaint: str, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=complaint):
        check_bag(tmp_path / name)


@pytest.mark.parametrize("name", ["drive.mcap", "drive.db3", "drive.bag", "drive.wav"])
def test_what_is_no_bag_is_one_line(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    with pytest.raises(ConfigError, match="there is no such bag"):
        read_sayings(path)
    path.write_bytes(b"no bag at all, but long enough to be read as a header of one\n" * 10)
    with pytest.raises(ConfigError, match=f"{name}: cannot be read as a bag [^\n]*$"):
        read_sayings(path)


@pytest.mark.parametrize("damaged", [0, 4 * 10**18])
def test_a_bag_with_a_damaged_time_is_one_line(damaged: int, tmp_path: Path) -> None:
    path = tmp_path / "damaged.bag"
    types = get_typestore(Stores.ROS1_NOETIC)
    with Writer1(path) as writer:
        topic = writer.add_connection(HEARD_TOPIC, STRING, typestore=types)
        for stamp in (1_700_000_000 * 10**9, 1_700_000_001 * 10**9, damaged):
            message = types.types[STRING]("go forward")
            writer.write(topic, stamp, types.serialize_ros1(message, STRING))
    with pytest.raises(
        ConfigError, match=r"damaged.bag: lasts \d+ days by the times in it, [^\n]+"
    ):
        read_sayings(path)


def test_a_bag_cut_short_is_one_line(tmp_path: Path) -> None:
    whole = tmp_path / "drive.mcap"
    keep(whole)
    (tmp_path / "cut.mcap").write_bytes(whole.read_bytes()[:500])
    with pytest.raises(ConfigError, match=r"cut.mcap: cannot be read as a bag"):
        read_sayings(tmp_path / "cut.mcap")


def test_a_bag_without_the_topic_says_what_it_has(tmp_path: Path) -> None:
    path = tmp_path / "other.bag"
    types = get_typestore(Stores.ROS1_NOETIC)
    with Writer1(path) as writer:
        topic = writer.add_connection("/chatter", STRING, typestore=types)
        writer.write(topic, 10**9, types.serialize_ros1(types.types[STRING]("hi"), STRING))
    with pytest.raises(ConfigError, match="no strings on recognizer/output; it has /chatter"):
        read_sayings(path)
