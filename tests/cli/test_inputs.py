"""Small inputs as people have them, and what must come of each on the command line.

Each row is one input: its files, the calls in their folder, and what each call must print.
"""

from __future__ import annotations

import shlex
import struct
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
import soundfile
from recordings import GO_BACK

from voz.audio import SAMPLE_RATE


class Call(NamedTuple):
    """A call of `voz`."""

    arguments: str  # as they are typed
    shows: tuple[str, ...] = ()  # what is printed among other things
    code: int = 0  # the exit status
    never: tuple[str, ...] = ()  # what is not printed


def built(name: str, *shows: str, never: tuple[str, ...] = ()) -> Call:
    return Call(f"build-lm {name} --out lm", shows, never=never)


def refused(name: str, *shows: str) -> Call:
    return Call(f"build-lm {name} --out lm", shows, code=2)


def meant(said: str, *shows: str) -> Call:
    return Call(f"parse --lm lm --json {shlex.quote(said)}", shows)


def fixture() -> np.ndarray[Any, np.dtype[np.float64]]:
    samples, rate = soundfile.read(GO_BACK)
    assert rate == SAMPLE_RATE
    return samples


def stereo(right: float) -> Callable[[Path], None]:
    """Write a recording whose right channel is the left one times so much."""

    def write(path: Path) -> None:
        soundfile.write(path, np.stack([fixture(), right * fixture()], 1), SAMPLE_RATE)

    return write


def wav(riff_size: int, data_size: int, before: bytes = b"") -> Callable[[Path], None]:
    """Write a WAV whose header has other lengths."""

    def write(path: Path) -> None:
        layout = struct.pack("<IHHIIHH", 16, 1, 1, SAMPLE_RATE, 2 * SAMPLE_RATE, 2, 16)
        head = b"RIFF" + struct.pack("<I", riff_size) + b"WAVEfmt " + layout + before
        pcm = (fixture() * 32767).astype("<i2").tobytes()
        path.write_bytes(head + b"data" + struct.pack("<I", data_size) + pcm)

    return write


def intents(*sentences: str, then: str = "") -> str:
    listed = "".join(f"      - '{one}'\n" for one in sentences)
    return f"language: en\nintents:\n  Do:\n    data:\n    - sentences:\n{listed}{then}"


def jsgf(rules: str) -> str:
    return f"#JSGF V1.0;\ngrammar g;\n{rules}\n"


LIST_CHUNK = struct.pack("<4sI4s4sI", b"LIST", 26, b"INFO", b"ISFT", 14) + b"Rec 1.02.345\0\0"

BACK = ("  yes       go back  ",)

File = str | Callable[[Path], None]

INPUTS: Mapping[str, tuple[dict[str, File], tuple[Call, ...]]] = {
    "several public rules": (
        {"a.gram": jsgf("public <fan> = (start | stop) the fan;\npublic <off> = off;")},
        (built("a.gram", 'a.gram: "fan": one command each'), meant("stop the fan", '"fan"')),
    ),
    "tags within a rule": (
        {
            "a.gram": jsgf(
                "public <do> = <go> | stop;\n"
                "<go> = [run] [to the] (left {L} | right {R}) | (jump [up]) {UP} | home;"
            )
        },
        (
            built("a.gram", never=("one command each",)),
            meant("run to the left", '"go"', '"go":"L"'),
            meant("jump", '"go":"UP"'),
            meant("home", '"go":"home"'),
        ),
    ),
    "a tag for several": (
        {"a.gram": jsgf("public <c> = (up | down) {move} | stop;")},
        (built("a.gram", 'a.gram: "move": one command each'),),
    ),
    "converters of rules and lists": (
        {
            "a.ini": "[Go]\ngo <far>{m!float}\nto $place{to!upper}\nby (nine:(9!int)){m}\n"
            "far = (half:0.5 | two:2)\n",
            "slots/place": "hall\nattic:top\n",
        },
        (
            built("a.ini", never=("never used",)),
            meant("go two", '"m":2.0'),
            meant("to attic", '"to":"TOP"'),
            meant("by nine", '"m":9}'),
        ),
    ),
    "channels that cancel each other": (
        {"a.wav": stereo(-0.7)},
        (
            Call("decode a.wav", (*BACK, "out of phase")),
            Call("decode - < a.wav", (*BACK, "out of phase")),
        ),
    ),
    "a silent channel": (
        {"a.wav": stereo(0)},
        (Call("decode a.wav", BACK, never=("phase",)), Call("decode - < a.wav", BACK)),
    ),
    "lengths that nobody filled in": (
        {"a.wav": wav(0, 0), "b.wav": wav(0xFFFFFFFF, 0xFFFFFFFF), "c.wav": wav(0, 0, LIST_CHUNK)},
        tuple(
            Call(f"decode {name}", BACK)
            for wav in ("a.wav", "b.wav", "c.wav")
            for name in (wav, f"- < {wav}")
        ),
    ),
    "a list of Home Assistant": (
        {"a.yaml": intents("find <area>", then='expansion_rules: {area: "[the] {area}"}\n')},
        (refused("a.yaml", 'there is no list "area"', "Home Assistant fills it", "lists: {area:"),),
    ),
    "a folder": (
        {
            "f/go.ini": "[Go]\ngo to <where>\nwhere = (hall | attic){where}\n",
            "f/halt.yaml": intents("halt"),
            "f/notes.txt": "clean up\n",
            "f/old/a.ini": "[Old]\ncome\n",
        },
        (
            built("f", "f/notes.txt is left out", "f/old is left out"),
            meant("go to attic", '"command":"Go"', '"where":"attic"'),
            meant("halt", '"command":"Do"'),
        ),
    ),
    "more alternatives than commands may be": (
        {"a.gram": jsgf("public <code> = <d> <d> <d>;\n<d> = 0|1|2|3|4|5|6|7|8|9;")},
        (refused("a.gram", "makes more than 500 commands; give all of it a tag, as in: (one"),),
    ),
    "a header without its end": (
        {"a.gram": "#JSGF V1.0;\ngrammar lamp\npublic <c> = on;\n"},
        (refused("a.gram", 'a.gram:2:12: write ";" at the end of this line'),),
    ),
    "acronyms": (
        {"a.txt": "stop\nGPIO on\nIMU reset\nlidar off\nRFID\nNASA\nPWM up\n"},
        (
            built(
                "a.txt",
                '"gpio" is in no dictionary; JH IY P IY AY OW is a guess',
                '"imu" is in no dictionary; AY EH M Y UW or ',
                '"lidar" is in no dictionary; L IH D AA R is a guess',
                '"rfid" is in no dictionary; AA R EH F AY D IY is a guess',
                '"pwm" is in no dictionary; P IY D AH B AH L Y UW EH M is a guess',
                never=("nasa",),
            ),
        ),
    ),
    "a home folder in voz.toml": (
        {"a.txt": "wave\nstop\n", "voz.toml": 'lm = "~/own/lm"\n'},
        (Call("build-lm a.txt --out HOME/own/lm"), Call("parse wave", ('"wave": wave',))),
    ),
    "the same part of YAML twice": (
        {"a.yaml": intents("go <p>", then="expansion_rules:\n  p: please\n  p: please\n")},
        (built("a.yaml", '"p" is there twice (first in line 8)'),),
    ),
    "another part of YAML twice": (
        {"a.yaml": intents("go", then="  Do:\n    data:\n    - sentences: [come]\n")},
        (refused("a.yaml", '"Do" is there twice (first in line 3); write what is in both'),),
    ),
    "advice for Rhino": (
        {"a.yml": "context:\n  expressions:\n    up: ['@would lift $part:p']\n"},
        (refused("a.yml", "macros: {would: "),),
    ),
    "advice for keyword lists": (
        {"a.kwlist": "\n"},
        (refused("a.kwlist", "write one keyphrase per line, as: stop /1e-20/"),),
    ),
    "advice for Rhasspy": (
        {"a.ini": "[A]\ngo $where\n"},
        (refused("a.ini", "one per line, into slots/where"),),
    ),
    "a slot twice": (
        {"a.yaml": intents("{side} then {side}", then="lists: {side: {values: [port, lee]}}\n")},
        (
            built("a.yaml", 'the slot "side" occurs twice in one sentence', "the last one counts"),
            meant("port then lee", '"side":"lee"'),
        ),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", INPUTS)
def test_what_people_have_gives_what_they_expect(
    voz: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    files, calls = INPUTS[name]
    for file, content in files.items():
        (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
        if callable(content):
            content(tmp_path / file)
        else:
            (tmp_path / file).write_text(content)
    for call in calls:
        typed, _, piped = call.arguments.replace("HOME", str(tmp_path / "home")).partition(" < ")
        with (tmp_path / (piped or next(iter(files)))).open() as source:
            monkeypatch.setattr("sys.stdin", source)
            done = voz(*shlex.split(typed))
        printed = done.out + done.err
        assert done.code == call.code, printed
        for text in call.shows:
            assert text in printed
        for text in call.never:
            assert text not in printed
