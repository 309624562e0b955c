"""The node `recognizer` hears a microphone, and does what the old package's node did."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

import pytest
from live_robot import speak
from recordings import GO_BACK, ROOT, Recording
from ros1.ros import Ros, eventually

from voz.config import Config
from voz.inbox import Inbox
from voz.ros1 import recognizer_node

FORWARD = GO_BACK.with_name("festival_slt__go_forward.flac")


def heard_well(ros: Ros, *arguments: str) -> tuple:
    node = ros.node("recognizer", *arguments)
    client = ros.client("/recognizer/output", "/recognizer/refused", "/recognizer/trouble")
    eventually(lambda: {"data": ""} in client.of("/recognizer/trouble") or node.process.poll())
    assert node.process.poll() is None, node.text
    return node, client


def words(client) -> list[str]:
    return [data["data"] for data in client.of("/recognizer/output")]


@pytest.mark.realtime
@pytest.mark.slow
def test_it_publishes_what_is_understood_and_what_is_refused(
    ros_with_sound: Ros, recordings: list[Recording]
) -> None:
    ros = ros_with_sound
    _, client = heard_well(ros)
    speak(ros.environment, FORWARD)
    eventually(lambda: words(client) == ["go forward"])
    other = next(r for r in recordings if r.kind == "near-miss")
    speak(ros.environment, other.path)
    eventually(lambda: client.of("/recognizer/refused"))
    assert not json.loads(client.of("/recognizer/refused")[0]["data"])["accepted"]
    assert words(client) == ["go forward"]
    types = {m["type"] for m in client.messages}
    assert types == {"std_msgs/String"}


@pytest.mark.slow
def test_what_is_understood_is_logged_as_heard_where_nobody_subscribes(
    ros_with_sound: Ros,
) -> None:
    ros = ros_with_sound
    node = ros.node("recognizer")
    client = ros.client("/recognizer/trouble")
    eventually(lambda: {"data": ""} in client.of("/recognizer/trouble"))
    speak(ros.environment, FORWARD)
    node.wait_for("go forward")
    (line,) = (line for line in node.lines if "go forward" in line)
    assert 'heard "go forward"' in line


@pytest.mark.slow
def test_start_and_stop_are_services_and_start_reads_the_parameters_again(
    ros_with_sound: Ros, tmp_path: Path
) -> None:
    ros = ros_with_sound
    node, client = heard_well(ros)
    assert ros.call("rosservice", "type", "/recognizer/stop").stdout.strip() == "std_srvs/Empty"
    assert ros.call("rosservice", "call", "/recognizer/stop").returncode == 0
    stopped = {"data": "the recognizer was stopped by its service"}
    eventually(lambda: client.of("/recognizer/trouble")[-1] == stopped)
    speak(ros.environment, FORWARD)
    own = tmp_path / "own.txt"
    own.write_text("open gripper\ngo back\n")
    ros.call("rosparam", "set", "/recognizer/commands", str(own))
    assert ros.call("rosservice", "call", "/recognizer/start").returncode == 0
    speak(ros.environment, GO_BACK)
    eventually(lambda: words(client) == ["go back"])
    (again,) = [line for line in node.lines if "listening again" in line]
    assert "[INFO]" in again
    speak(ros.environment, FORWARD)  # is not in this list
    eventually(lambda: client.of("/recognizer/refused"))
    ros.call("rosparam", "set", "/recognizer/commands", "/none.txt")
    failed = ros.call("rosservice", "call", "/recognizer/start")
    assert failed.returncode
    assert "/none.txt: cannot be read" in failed.stderr
    assert "Traceback" not in node.text


@pytest.mark.slow
def test_models_of_the_online_lmtool_and_a_pulseaudio_source_are_taken(
    ros_with_sound: Ros, tmp_path: Path
) -> None:
    ros = ros_with_sound
    for ending in ("lm", "dic", "sent"):
        text = (ROOT / "lm" / f"comandos_voz.{ending}").read_text()
        # lmtool writes upper case.
        upper = text.upper().replace("<S>", "<s>").replace("</S>", "</s>")
        (tmp_path / f"1234.{ending}").write_text(upper)
    _, client = heard_well(
        ros, f"_lm:={tmp_path}/1234.lm", f"_dict:={tmp_path}/1234.dic", "_search:=lm",
        "_mic_name:=mic.monitor",
    )  # fmt: skip
    speak(ros.environment, FORWARD)
    eventually(lambda: words(client) == ["go forward"])


@pytest.mark.slow
def test_a_microphone_that_is_not_there_is_one_line(ros: Ros) -> None:
    done = ros.call(str(ROOT / "ros" / "scripts" / "recognizer"), "_device:=none of these")
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert line.startswith("recognizer: there is")


@pytest.mark.slow
def test_a_name_needs_the_control_in_the_same_node(ros: Ros, tmp_path: Path) -> None:
    settings = tmp_path / "voz.toml"
    settings.write_text('[recognition]\nname = "hey robot"\n')
    done = ros.call(str(ROOT / "ros" / "scripts" / "recognizer"), f"_config:={settings}")
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert "need recognizer and control in one node; start the node `voz`" in line


def test_of_two_that_start_it_at_once_only_the_last_one_hears(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    heard: list[int] = []

    @contextmanager
    def hearing() -> Iterator[None]:
        heard.append(1)
        yield
        time.sleep(0.1)  # as a microphone takes to be closed
        heard.pop()

    monkeypatch.setattr(recognizer_node, "make_hearing", lambda *_: hearing())
    monkeypatch.setattr(recognizer_node, "load_recognizer", lambda settings: (settings, None))
    monkeypatch.setattr(recognizer_node, "read_settings", Config)
    hearer = recognizer_node.SwitchedHearing(Inbox({"stop"}), time.monotonic)
    hearer.start()
    with ThreadPoolExecutor(8) as services:
        for starting in [services.submit(hearer.start) for _ in range(8)]:
            starting.result()
    assert len(heard) == 1
    hearer.stop()
    assert not heard
