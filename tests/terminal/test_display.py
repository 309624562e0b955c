"""What the terminal shows, as plain text."""

from __future__ import annotations

import io
import re
from types import SimpleNamespace

import pytest
from rich.console import Console

from voz import texts
from voz.events import Notice, Partial, Reply, SelectedObject, Twist, Utterance
from voz.terminal.display import KEYS_HELP, MAX_LINES, TYPING_HELP, Display


def shown(display: Display, colors: bool = False) -> str:
    text = io.StringIO()
    system = "standard" if colors else None
    console = Console(file=text, width=90, force_terminal=colors, color_system=system)
    console.print(display)
    return text.getvalue()


def a_display(
    peak: float = 0.1,
    listening: bool = True,
    speaking: bool = False,
    note: str = "",
    typing: str = "",
    name: str = "",
    wake: str = "start speech",
    language: str = "en",
) -> Display:
    sound = SimpleNamespace(peak=peak, background=-52.3, speaking=speaking, device="USB Audio")
    ear = SimpleNamespace(listening=listening, name=name, awake=not name, wake=wake)
    return Display(sound, ear, lambda: typing, lambda: note, language=language)


def heard(text: str, **others: object) -> Utterance:
    fields = {"confidence": 0.87, "accepted": True, "start": 0, "end": 1, "source": "microphone"}
    fields["obeyed"] = bool(others.get("accepted", True))
    return Utterance(1.0, text, **(fields | others))  # type: ignore[arg-type]


def line_with(text: str, display: Display) -> str:
    (line,) = [line for line in shown(display).splitlines() if text in line]
    return line


def test_a_command_is_shown_with_how_sure_and_how_soon() -> None:
    display = a_display()
    display.receive(heard("go forward", latency=0.214))
    assert "go forward  87%  0.21 s" in line_with("go forward", display)


def test_what_the_robot_says_is_text_and_no_markup_or_escape() -> None:
    display = a_display(note="\x1b[2J")
    display.receive(Reply(1.0, "[red]a[/b] \x1b[2J"))
    assert r"[red]a[/b] \x1b[2J" in line_with("says", display)
    assert "\x1b[2J" not in shown(display)


def test_it_shows_how_loud_the_room_is_and_how_far_the_speaker_stands_out_of_it() -> None:
    display = a_display()
    assert "-52 dB" in line_with("room", display)
    assert "above it" not in shown(display)
    display.receive(heard("go forward", above=24.6))
    assert "-52 dB, the last speech 25 dB above it" in line_with("room", display)
    display.receive(heard("", accepted=False, above=9.0))
    assert "9 dB above it" in line_with("room", display)
    assert "\x1b[33m, the last speech 9 dB" in shown(display, colors=True)


def test_what_is_refused_is_dimmed_and_says_what_it_may_have_been_and_why() -> None:
    display = a_display()
    between = ("turn left", "rotate left")
    refused = heard("turn left", accepted=False, reason="unsure_between", between=between)
    display.receive(refused)
    assert '(perhaps "turn left" 87%, unsure between "turn left" and' in shown(display)
    assert '"rotate left")' in shown(display)
    assert "\x1b[2m(perhaps" in shown(display, colors=True)


def test_what_was_understood_and_not_obeyed_is_dimmed_and_says_why() -> None:
    display = a_display()
    display.receive(heard("go back", obeyed=False, ignored="not_listening"))
    assert 'go back  not obeyed: say "start speech" first' in shown(display)
    assert "\x1b[2mgo back" in shown(display, colors=True)
    display.receive(heard("go back", obeyed=False, ignored="robot_speaking"))
    assert "go back  not obeyed: the robot was speaking" in shown(display)


def test_what_begins_the_listening_is_said_in_the_words_of_the_list() -> None:
    asleep = shown(a_display(listening=False, wake="empieza a escuchar"))
    assert 'say "empieza a escuchar"' in asleep.splitlines()[0]
    assert " not listening " in shown(a_display(listening=False, wake="")).splitlines()[0]
    display = a_display(wake="empieza a escuchar")
    ignored: dict[str, object] = {"obeyed": False, "ignored": "not_listening"}
    display.receive(heard("go back", say_first="empieza a escuchar", **ignored))
    assert 'go back  not obeyed: say "empieza a escuchar" first' in shown(display)
    display.receive(heard("go forward", say_first="", **ignored))
    assert "go forward  not obeyed: it does not listen" in shown(display)


def test_what_was_no_command_says_so() -> None:
    display = a_display()
    display.receive(heard("", accepted=False, reason="too_quiet"))
    assert "(too quiet)" in shown(display)


def test_the_motion_the_arm_the_reply_and_warnings_are_shown() -> None:
    display = a_display()
    for event in (
        Twist(1, 0.1, 0),
        SelectedObject(1, 2),
        Reply(1, "bep bep. I am listening you"),
        Notice(1, "the microphone is gone"),
        Partial(1, "stop", 0.5),
    ):
        display.receive(event)
    text = shown(display)
    for part in ("forward at 0.10 m/s", "object 2", "bep bep. I am", "microphone is gone"):
        assert part in text
    assert "perhaps" not in text
    display.receive(SelectedObject(1, 100))
    display.receive(Twist(1.1, 0, 0))
    assert "folded" in shown(display)
    assert "stands still" in shown(display)


def test_only_what_is_wrong_stands_out() -> None:
    display = a_display()
    display.receive(Notice(1, "the microphone is gone"))
    display.receive(Notice(2, "listening again", good=True))
    lines = shown(display, colors=True).splitlines()
    yellow = [line for line in lines if "\x1b[33m" in line]
    assert [text in "".join(yellow) for text in ("microphone is gone", "again")] == [True, False]
    assert "listening again" in shown(display)


def test_only_the_last_lines_stay_and_the_picture_does_not_grow() -> None:
    display = a_display()
    height = len(shown(display).splitlines())
    for number in range(MAX_LINES + 3):
        display.receive(Notice(number, f"warning {number}."))
    text = shown(display)
    assert "warning 2." not in text
    assert "warning 3." in text
    assert f"warning {MAX_LINES + 2}." in text
    assert len(text.splitlines()) == height


@pytest.mark.parametrize(
    ("peak", "full", "words"),
    [(0.0, 0, "silent"), (0.001, 0, "silent"), (0.0317, 15, "-30 dB"), (1.0, 30, "0 dB")],
)
def test_the_bar_shows_the_level(peak: float, full: int, words: str) -> None:
    line = line_with("microphone", a_display(peak))
    assert line.count("█") == full
    assert line.count("·") == 30 - full
    assert words in line


def test_the_bar_turns_red_before_the_microphone_clips() -> None:
    assert "\x1b[31m█" in shown(a_display(0.9), colors=True)
    assert "\x1b[32m█" in shown(a_display(0.5), colors=True)


def test_it_says_whether_it_listens_to_which_microphone_and_what_stops_the_robot() -> None:
    assert "listening" in shown(a_display()).splitlines()[0]
    assert "speaking" in shown(a_display(speaking=True)).splitlines()[0]
    assert 'asleep: say "hey robot"' in shown(a_display(name="hey robot")).splitlines()[0]
    text = shown(a_display(listening=False, note="everything is recorded"))
    assert 'say "start speech"' in text.splitlines()[0]
    for part in ("USB Audio", "everything is recorded", "space or Esc stops"):
        assert part in text


def test_what_is_typed_is_seen_and_that_its_first_space_does_not_stop() -> None:
    display = a_display(typing="go fo")
    assert "go fo▏" in line_with("type", display)
    assert "Esc or two spaces stop the robot" in shown(display)
    assert "space or Esc stops" not in shown(display)


def test_what_others_say_is_seen_and_not_obeyed_by_the_terminal() -> None:
    display = a_display()
    display.receive(Notice(1.0, "the robot says \x1b[2J\r"))
    display.receive(heard("\x1b]0;mine\x07", accepted=False, reason="not_a_command"))
    text = shown(display)
    assert r"\x1b[2J\r" in text
    assert r"\x1b]0;mine\x07" in text
    assert all(line.isprintable() for line in text.splitlines())


def test_all_of_it_is_in_the_language_of_the_robot() -> None:
    note = "what is said is recorded in said"
    asleep = shown(a_display(0.0, listening=False, wake="escucha", note=note, language="es"))
    assert " di «escucha» " in asleep.splitlines()[0]
    display = a_display(language="es", typing="av")
    for event in (
        Twist(1, 0.1, 0),
        SelectedObject(1, 100),
        Notice(1, "no sound comes from the microphone: the robot stops"),
        heard("avanza", accepted=False, reason="too_quiet", above=9.0),
        heard("para", obeyed=False, ignored="asleep"),
    ):
        display.receive(event)
    text = asleep + shown(display)
    for part in (
        "micrófono", "silencio", "sala", "lo último dicho, 9 dB más alto", "avanza a 0.10 m/s",
        "plegado", "dice", "oído", "teclea", "Esc o dos espacios paran el robot, Intro obedece",
        "espacio o Esc paran el robot, también puedes teclear, Ctrl-C termina", "escucha",
        "(quizás «avanza» 87%, demasiado bajo)", "no llega sonido del micrófono: el robot se para",
        "para  no obedecido: no has dicho el nombre del robot", "lo que se dice se graba en said",
    ):  # fmt: skip
        assert part in text
    english = r"\b(the|is|not|stops?|heard|says|robot drives|room|arm|listening|type)\b"
    assert not re.findall(english, text)


@pytest.mark.parametrize("language", ["es", "fr"])
def test_what_the_keys_do_has_room_in_each_language(language: str) -> None:
    for typing, keys in (("", KEYS_HELP), ("a", TYPING_HELP)):
        last = shown(a_display(language=language, typing=typing)).splitlines()[-1]
        assert f" {texts.text(keys, language)} " in last
