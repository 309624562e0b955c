from __future__ import annotations

import shlex
import sys
from pathlib import Path

import pytest
from recordings import Recording

from voz.apps.evaluation import engines
from voz.apps.evaluation.engines import ENGINES, EngineChoice, load_engine, program_engine
from voz.apps.evaluation.results import Understood
from voz.errors import AudioError, ConfigError
from voz.language.language_files import LanguageFiles
from voz.settings import Recognition

COMMANDS = frozenset({"go back"})


def script(tmp_path: Path, code: str) -> str:
    path = tmp_path / "a program.py"
    path.write_text(code)
    return shlex.join([sys.executable, str(path)])


@pytest.fixture
def clip(recordings: list[Recording]) -> Recording:
    return next(r for r in recordings if r.path.stem == "festival_slt__go_back")


@pytest.mark.parametrize("name", sorted(ENGINES))
def test_each_engine_hears_a_command(name: str, clip: Recording, language: LanguageFiles) -> None:
    engine = load_engine(EngineChoice(name, language, Recognition()))
    (heard,) = engine(clip.samples())
    assert (heard.text, heard.accepted) == ("go back", True)
    assert 0 <= heard.start < heard.end <= len(clip.samples()) / 16000
    assert heard.confidence == 1 or name in ("voz", "without-network")


def test_what_it_is_compared_with_refuses_other_speech(
    recordings: list[Recording], language: LanguageFiles
) -> None:
    engine = load_engine(EngineChoice("pocketsphinx-phone-loop", language, Recognition()))
    other = next(r for r in recordings if r.text == "the weather is nice today")
    assert [(heard.confidence, heard.accepted) for heard in engine(other.samples())] == [(0, False)]


def test_what_it_is_compared_with_hears_all_commands_of_a_long_recording(
    session: Recording, language: LanguageFiles
) -> None:
    engine = load_engine(EngineChoice("pocketsphinx-phone-loop", language, Recognition()))
    heard = engine(session.samples())
    assert [one.text for one in heard] == session.commands
    times = [time for one in heard for time in (one.start, one.end)]
    assert times == sorted(times)
    assert 0 <= times[0] < times[-1] <= len(session.samples()) / 16000


def test_a_program_gets_a_wav_and_writes_the_transcript(tmp_path: Path, clip: Recording) -> None:
    code = (
        "import sys, wave\n"
        "w = wave.open(sys.argv[2])\n"
        "assert w.getparams()[:4] == (1, 2, 16000, int(sys.argv[1])), w.getparams()\n"
        "print(' Go, back!')\n"
    )
    samples = clip.samples()
    engine = program_engine(f"{script(tmp_path, code)} {len(samples)}", COMMANDS)
    whole = (0.0, len(samples) / 16000)
    assert engine(samples) == [Understood("go back", 1, True, *whole)]


@pytest.mark.parametrize(
    ("transcript", "heard"),
    [
        ("Don't\tSTOP... - now?", [("don't stop now", False)]),
        ("", []),
        (" .\n", []),
    ],
)
def test_what_a_program_hears(
    transcript: str, heard: list[tuple[str, bool]], tmp_path: Path, clip: Recording
) -> None:
    engine = program_engine(script(tmp_path, f"print({transcript!r})"), COMMANDS)
    assert [(u.text, u.accepted) for u in engine(clip.samples())] == heard


@pytest.mark.parametrize(
    ("code", "said"),
    [
        ("raise SystemExit('no model')", r"failed with exit code 1 \(no model\)"),
        ("raise SystemExit(3)", "failed with exit code 3$"),
        ("import time; time.sleep(9)", "not done after 0.3 s"),
    ],
)
def test_a_program_that_fails_is_an_error_of_this_clip(
    code: str, said: str, tmp_path: Path, clip: Recording, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(engines, "PROGRAM_TIMEOUT", 0.3 if "sleep" in code else 60)
    with pytest.raises(AudioError, match=said):
        program_engine(script(tmp_path, code), COMMANDS)(clip.samples())


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("magic", 'no engine "magic"'),
        ("command:", "names no program"),
        ("command:'", "close all quotes"),
        ("command:no-such-program -x", "no-such-program: there is no such program"),
    ],
)
def test_an_engine_that_cannot_be(name: str, said: str, language: LanguageFiles) -> None:
    with pytest.raises(ConfigError, match=said):
        load_engine(EngineChoice(name, language, Recognition()))
