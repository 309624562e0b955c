"""A session that was kept is shown at any time of it."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
from browser_page import barriers, opened
from calls import VOZ, in_process
from driving import type_lines
from live_robot import signals_as_a_terminal_has_them
from msgspec.structs import replace
from playwright.sync_api import BrowserContext, Page, expect
from programs import PATIENCE
from recordings import FIXTURES

from voz.apps.recordings.bags import write_bag
from voz.apps.recordings.manifest import MANIFEST_NAME
from voz.apps.recordings.recorder import Excerpt, RecordingFolder
from voz.apps.web.session_page import read_recordings, read_session, session_record
from voz.audio.sound_files import read_samples
from voz.errors import ConfigError
from voz.events import Event, Notice, SelectedObject, Twist, Utterance, to_json
from voz.files import append_line
from voz.robot.simulation.simulator import SimulatedRobot
from voz.settings import Simulator

LINES = [
    *"-" * 80,
    "start speech",
    "go forward",
    *"-----",
    "make coffee",
    "point beer",
    *"-----",
    "stop",
    "-",
]


def test_there_is_a_state_wherever_something_changed_and_none_elsewhere() -> None:
    events: list[Event] = [
        Twist(0.0, 0.0, 0.0),
        Twist(0.1, 0.0, 0.0),
        Utterance(0.15, "go forward", 0.9, True, 0.0, 0.1, "microphone", obeyed=True),
        Twist(0.2, 0.1, 0.0),
        Twist(0.3, 0.1, 0.0),
        SelectedObject(0.35, 1),
        Twist(0.4, 0.0, 0.0),
        Twist(0.5, 0.0, 0.0),
        Notice(0.6, "the robot stops"),
    ]
    session = session_record("drive.jsonl", events)
    assert session["states"] == [
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, None],
        [0.2, 0.0, 0.0, 0.0, 0.1, 0.0, None],
        [0.3, 0.01, 0.0, 0.0, 0.1, 0.0, None],
        [0.4, 0.02, 0.0, 0.0, 0.0, 0.0, 1],
    ]
    assert [event["type"] for event in session["events"]] == ["utterance", "warning"]
    assert (session["begin"], session["end"]) == (0.0, 0.6)


def test_in_a_room_the_robot_drives_its_way_again() -> None:
    settings = Simulator(start=(0.5, 0.5, 0.0))
    robot = SimulatedRobot(settings)
    events: list[Event] = [Twist(t / 10, 0.5, 0.0) for t in range(60)]
    events += [SelectedObject(6.0, 1), Twist(6.1, 0.0, 0.0)]
    for event in events:
        robot.receive(event)
    session = session_record("drive.jsonl", events, settings)
    pose = robot.state_at(6.1).pose
    *_, (t, x, y, heading, linear, angular, selected, arm, collided) = session["states"]
    assert (t, linear, angular, selected, collided) == (6.1, 0.0, 0.0, 1, True)
    assert (x, y, heading) == pytest.approx((pose.x, pose.y, pose.heading), abs=0.001)
    assert len(arm) > 1
    assert session["room"]["room"] == settings.room


def test_what_was_recorded_is_found_by_its_utterance(tmp_path: Path) -> None:
    said = Utterance(2.5, "go forward", 0.9, True, 1.0, 2.0, "microphone", latency=0.2)
    folder = RecordingFolder(tmp_path, 1e9)
    file = folder.add(Excerpt(said, np.ones(16_000, np.int16)))
    append_line(tmp_path / MANIFEST_NAME, "mine.wav\tstop\tme\tcommand\t")
    kept = read_recordings(tmp_path)
    assert kept == {(1.0, 2.0, "go forward"): tmp_path / file}
    events = [replace(said, obeyed=True), replace(said, text="go back")]
    first, second = session_record("drive.jsonl", events, None, kept)["events"]
    assert first["sound"] == {"file": file, "begin": 0.7}
    assert "sound" not in second


def test_a_folder_without_recordings_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="name the folder of `voz run --record`"):
        read_recordings(tmp_path)
    (tmp_path / MANIFEST_NAME).write_text("file\ttext\n")
    with pytest.raises(ConfigError, match="has no recordings"):
        read_recordings(tmp_path)


def recorded(session: Path, folder: Path) -> Path:
    """A folder with the sound of "go forward", which the session then has as spoken."""
    events = read_session(session)
    (said,) = [e for e in events if isinstance(e, Utterance) and "go" in e.text]
    spoken = replace(said, source="microphone")
    lines = [to_json(spoken if event is said else event) for event in events]
    session.write_text("\n".join(lines) + "\n")
    clip = FIXTURES / "commands" / "festival_slt__go_forward.flac"
    samples = read_samples(clip)
    RecordingFolder(folder, 1e9).add(Excerpt(said, samples))
    return folder


@pytest.fixture(params=["drive.jsonl", "drive.mcap"])
def link(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[str]:
    """A session of some seconds, shown by `voz view`; the first with its room and sound."""
    path = tmp_path / request.param
    kept = ("--events", path) if path.suffix == ".jsonl" else ("--bag", path)
    text = tmp_path / "lines.txt"
    text.write_text("\n".join(LINES) + "\n")
    assert in_process("run", "--no-sound", "--text", text, *kept).code == 0
    more = []
    if path.suffix == ".jsonl":
        more = ["--room", "--recordings", str(recorded(path, tmp_path / "said"))]
    process = subprocess.Popen(
        [*VOZ, "view", str(path), "--web-port", "0", *more],
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=signals_as_a_terminal_has_them,
    )
    assert process.stderr
    found = re.search(r"the session is at (\S+)", process.stderr.readline())
    assert found
    yield found[1]
    process.terminate()
    assert process.wait(PATIENCE) == 143
    assert process.stderr.read() == ""
    process.stderr.close()


def move(page: Page, seconds: float) -> None:
    page.locator("#time").evaluate(
        "(slider, at) => { slider.value = at; slider.dispatchEvent(new Event('input')); }", seconds
    )


@pytest.mark.slow
def test_a_slider_moves_through_it_and_it_plays(link: str, context: BrowserContext) -> None:
    context.add_init_script(
        "const made = window.Audio;"
        "window.Audio = function () { return (window.audio = new made()); };"
    )
    page = opened(context, link)
    slider, log = page.get_by_label("time", exact=True), page.locator("#log .entry .what")
    expect(page.locator("#clock")).to_contain_text("0.0 s of 9.")
    expect(page.locator("#timeline .fold")).to_have_text("7 s")
    marked = page.locator("#timeline .mark span:visible")
    expect(marked.filter(has_text="go forward")).to_have_count(1)
    page.get_by_role("button", name="what was said next").click()
    expect(page.locator("#clock")).to_contain_text("8.0 s of 9.")
    bag = "mcap" in page.locator("#name").inner_text()
    slider.focus()
    page.keyboard.press("End")
    expect(log.first).to_have_text("stop")
    expect(page.locator("#arm")).to_have_text("points at the beer")
    end = page.locator("#place").inner_text()
    said = ["stop", "point beer", "go forward", "start speech"]
    shown = [text for text in log.all_inner_texts() if text in said]
    assert shown == said
    refused = page.locator("#log .refused", has_text="make coffee")
    expect(refused).to_have_count(0 if bag else 1)
    move(page, 2.5)  # a second for what is folded, and one before the first command
    expect(page.locator("#linear")).to_have_text("0.10")
    expect(page.locator("#arm")).not_to_have_text("points at the beer")
    expect(page.locator("#log .entry", has_text="point beer")).to_have_count(0)
    if not bag:
        expect(page.locator("#room .walls")).to_be_visible()
        with page.expect_response("**/api/recordings/*") as asked:
            page.get_by_role("button", name="Listen").click()
        assert asked.value.status in (200, 206)
        page.wait_for_function("() => window.audio.currentTime > 0.1")
        move(page, 1.0)
        page.evaluate("() => { window.played = window.audio.src; window.audio.src = ''; }")
    page.get_by_label("speed").select_option("2")
    page.get_by_role("button", name="Play").focus()
    page.keyboard.press("Space")
    expect(page.get_by_role("button", name="Pause")).to_be_visible()
    expect(page.get_by_role("button", name="Play")).to_be_visible()  # it is over
    expect(page.locator("#place")).to_have_text(end)
    if not bag:  # it came to what was said
        assert page.evaluate("() => window.audio.src === window.played")
        assert page.evaluate("() => window.audio.playbackRate") == 2
    page.get_by_label("fold what is idle").uncheck()
    expect(page.locator("#timeline .fold")).to_have_count(0)
    page.get_by_label("fold what is idle").check()
    expect(log.first).to_have_text("stop")
    slider.focus()
    page.keyboard.press("Home")
    expect(page.locator("#log .entry", has_text="go forward")).to_have_count(0)
    expect(page.locator("#linear")).to_have_text("0.00")
    for scheme in ("light", "dark"):
        page.emulate_media(color_scheme=scheme)  # type: ignore[arg-type]
        for width, height in ((1366, 768), (390, 844)):
            page.set_viewport_size({"width": width, "height": height})
            assert barriers(page) == []
    assert page.complaints == []  # type: ignore[attr-defined]
    assert httpx.get(f"{link}api/session", headers={"Host": "robot.example"}).status_code == 403
    assert httpx.post(f"{link}api/command", json={"text": "go forward"}).status_code in (404, 405)


TYPED_LINES = [
    "start speech",
    "go forward",
    "dance",
    "-",
    "point beer",
    "turn left",
    *"----",
    "stop",
]


@pytest.fixture
def events() -> list[Event]:
    events: list[Event] = []
    type_lines(TYPED_LINES, events.append)
    return events


def test_what_was_written_as_json_is_read_back_whole(tmp_path: Path, events: list[Event]) -> None:
    path = tmp_path / "drive.jsonl"
    path.write_text("".join(f"{to_json(event)}\n" for event in events) + '{"type":"cmd_v')
    assert read_session(path) == events  # but for what a power failure cut short


@pytest.mark.parametrize("name", ["drive.mcap", "drive.db3", "drive.bag", "drive"])
def test_of_a_bag_there_is_what_was_published(
    name: str, tmp_path: Path, events: list[Event]
) -> None:
    with write_bag(tmp_path / name) as receive:
        for event in events:
            receive(event)
    read = read_session(tmp_path / name)
    for kind in (Twist, SelectedObject):
        assert [e for e in read if isinstance(e, kind)] == [e for e in events if type(e) is kind]
    heard = [(e.t, e.text) for e in events if isinstance(e, Utterance) and e.obeyed]
    assert [(e.t, e.text) for e in read if isinstance(e, Utterance)] == heard


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "has no events; name what"),
        ("{}\n", "drive.jsonl:1: is not an event of voz"),
        ('{"type":"dance","t":1}\n', "drive.jsonl:1: is not an event of voz"),
        ("[" * 100_000 + "\n", "drive.jsonl:1: is not an event of voz"),
    ],
)
def test_what_is_no_session_is_one_line(text: str, complaint: str, tmp_path: Path) -> None:
    path = tmp_path / "drive.jsonl"
    path.write_text(text)
    with pytest.raises(ConfigError, match=complaint) as caught:
        read_session(path)
    assert "\n" not in str(caught.value)


def test_what_is_not_there_is_one_line(voz: Any, tmp_path: Path) -> None:
    assert "cannot be read" in voz("view", tmp_path / "none.jsonl").complaint
    assert "there is no such bag" in voz("view", tmp_path / "none.mcap").complaint
