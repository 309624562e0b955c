"""`voz calibrate`: from recordings or a microphone to a profile that is used."""

from __future__ import annotations

import json
import os
import signal
import subprocess
from collections.abc import Sequence
from pathlib import Path

import pytest
import soundfile
from calls import VOZ
from recordings import FIXTURES, ROOT, Recording

from voz.apps.recordings.calibration import Said, choose_prompts, read_saved_recordings
from voz.apps.recordings.manifest import MANIFEST_NAME, join_lines
from voz.audio import SAMPLE_RATE, Samples
from voz.audio.segmenter import segments
from voz.language.language_files import LanguageFiles, read_sentences
from voz.recognition.profiles import Profile, load_profile, save_profile


@pytest.fixture(autouse=True)
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where the profiles are."""
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    return tmp_path / "data" / "voz" / "profiles"


def said_by(recordings: list[Recording], voice: str) -> list[Said]:
    own = [r for r in recordings if r.kind == "command" and r.voice == voice]
    return [Said(r.text, r.samples()) for r in own]


def write(folder: Path, said: Sequence[Said], speaker: str = "ana") -> Path:
    folder.mkdir(exist_ok=True)
    rows = [("path", "text", "speaker", "kind")]
    for number, sentence in enumerate(said):
        soundfile.write(folder / f"{number}.wav", sentence.samples, SAMPLE_RATE)
        rows.append((f"{number}.wav", sentence.text, speaker, "command"))
    (folder / MANIFEST_NAME).write_text(join_lines(rows))
    return folder


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["calibrate", "a/b"], "cannot be the name"),
        (["calibrate", "ana", "--wav", "nowhere"], "manifest.tsv: cannot be read"),
        (["calibrate", "ana", "--wav", "audio_fixtures"], "speakers"),
        (["calibrate", "ana", "--lm", "nowhere"], "voz build-lm"),
        (["calibrate", "nobody", "--delete"], 'no profile "nobody"'),
        (["decode", "--profile", "nobody", "x.wav"], 'no profile "nobody"'),
        (["run", "--profile", "../x", "--wav", "x.wav"], "cannot be the name"),
        (["run", "--profile", "nobody", "--wav", "x.wav"], "voz calibrate nobody"),
    ],
)
def test_a_wrong_call_is_one_line(arguments: list[str], said: str, voz) -> None:
    result = voz(*arguments)
    assert result.code == 2
    assert said in result.err
    assert result.err.count("\n") == 1


@pytest.mark.slow
def test_recordings_that_are_heard_wrongly_are_named(
    voz, recordings: list[Recording], tmp_path: Path
) -> None:
    first, second, *others = said_by(recordings, "festival_slt")[:6]
    mislabeled = [Said(first.text, second.samples), second, *others]
    folder = write(tmp_path / "wav", mislabeled)
    result = voz("calibrate", "ana", "--wav", folder)
    assert result.code == 0
    before, after = result.out.splitlines()[2:4]
    assert after.split()[-3:] >= before.split()[-3:]
    (line,) = result.err.splitlines()
    assert line == f"warning: {folder}/0.wav: should be {first.text}; heard: {second.text}"


def test_too_few_commands_and_broken_recordings_are_one_line(
    voz, recordings: list[Recording], tmp_path: Path
) -> None:
    said = said_by(recordings, "festival_slt")
    few = voz("calibrate", "ana", "--wav", write(tmp_path / "few", said[:4]))
    assert (few.code, few.err.count("\n")) == (2, 1)
    assert "4 different commands" in few.err
    folder = write(tmp_path / "broken", said[:5])
    (folder / "3.wav").write_text("no sound")
    broken = voz("calibrate", "ana", "--wav", folder)
    assert (broken.code, broken.err.count("\n")) == (2, 1)
    assert "3.wav" in broken.err


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"{}}",
        b'{"log_odds": 1e9}',
        b'{"other": 1}',
    ],
)
def test_a_spoilt_profile_is_one_line(content: bytes, voz, home: Path) -> None:
    (home / "ana").mkdir(parents=True)
    (home / "ana" / "profile.json").write_bytes(content)
    result = voz("decode", "--profile", "ana", "x.wav")
    assert (result.code, result.err.count("\n")) == (2, 1)
    assert "voz calibrate ana" in result.err


def test_a_profile_of_another_acoustic_model_is_one_line(voz, home: Path) -> None:
    save_profile("ana", Profile(0.5, "0" * 64))
    result = voz("decode", "--profile", "ana", str(FIXTURES / "commands/festival_slt__stop.flac"))
    assert (result.code, result.err.count("\n")) == (2, 1)
    assert "made with another acoustic model" in result.err


@pytest.mark.slow
def test_the_profile_of_recordings_is_used_listed_and_deleted(
    voz, home: Path, recordings: list[Recording], tmp_path: Path
) -> None:
    folder = write(tmp_path / "wav", said_by(recordings, "festival_slt")[:5])
    result = voz("calibrate", "ana", "--wav", folder)
    assert (result.code, result.err) == (0, "")
    count, _, before, after, kept, *_ = result.out.splitlines()
    assert (count, kept) == ("5 sentences:", "kept: as sure as for others")
    assert before.split()[1:] == after.split()[3:] == ["1.00", "1.00", "0.00"]
    plain = voz("decode", "--json", folder / "0.wav")
    assert voz("decode", "--json", "--profile", "ana", folder / "0.wav").out == plain.out
    assert voz("calibrate", "--list").out == "ana\n"
    assert voz("calibrate", "ana", "--delete").code == 0
    assert not (home / "ana").exists()


@pytest.mark.slow
def test_what_an_older_voz_learned_is_one_line_and_the_run_goes_on(voz, home: Path) -> None:
    path = save_profile("ana", Profile())
    path.write_text('{"start": {"frames": 60.0}, "mllr": "mllr.txt"}')
    recording = FIXTURES / "commands/festival_slt__stop.flac"
    result = voz("decode", "--profile", "ana", recording)
    assert (result.code, result.err.count("\n")) == (0, 1)
    assert "is no longer used" in result.err
    result = voz("run", "--adapt", "--no-sound", "--wav", recording)
    assert (result.code, result.err) == (
        0,
        "warning: --adapt is no longer used: the network need not learn a voice\n",
    )


def test_a_profile_is_kept_as_it_is(home: Path) -> None:
    profile = Profile(0.5)
    path = save_profile("ana", profile)
    assert load_profile("ana") == profile
    assert json.loads(path.read_text())["log_odds"] == 0.5


@pytest.mark.realtime
@pytest.mark.slow
def test_recording_tells_what_is_heard_and_can_be_stopped_and_goes_on(
    pulse: dict[str, str], home: Path, recordings: list[Recording], tmp_path: Path
) -> None:
    said = {s.text: s.samples for s in said_by(recordings, "festival_slt")}
    environment = pulse | {"XDG_DATA_HOME": os.environ["XDG_DATA_HOME"]}
    asked = choose_prompts(read_sentences(LanguageFiles(ROOT / "lm")), "ana")
    assert record(environment, said, tmp_path, times=2) == asked[:2]
    assert [s.text for s in read_saved_recordings(home / "ana" / "recordings", said)] == asked[:2]
    assert record(environment, said, tmp_path, times=1) == asked[2:3]
    kept = read_saved_recordings(home / "ana" / "recordings", said)
    assert [s.text for s in kept] == asked[:3]
    for sentence in kept:
        (segment,) = segments([sentence.samples])
        length = len(said[sentence.text])
        assert len(segment.samples) == pytest.approx(length, abs=0.6 * SAMPLE_RATE)


def record(
    environment: dict[str, str], said: dict[str, Samples], folder: Path, times: int
) -> list[str]:
    """Speak what is asked for, so often, then press Ctrl-C; returns what was asked for.

    What is asked for first is said wrongly, and right when it is asked for again.
    """

    def speak(text: str) -> None:
        soundfile.write(folder / "prompt.wav", said[text], SAMPLE_RATE)
        command = ["paplay", "--device=mic", str(folder / "prompt.wav")]
        subprocess.run(command, env=environment, check=True)

    asked: list[str] = []
    heard: list[str] = []
    options = {"env": environment, "cwd": ROOT, "stdout": subprocess.PIPE, "text": True}
    process = subprocess.Popen([*VOZ, "calibrate", "ana"], **options)
    try:
        for line in process.stdout:
            _, is_prompt, text = line.strip().partition(" say: ")
            if is_prompt and len(asked) == times:
                break
            if is_prompt:
                asked.append(text)
                other = next(other for other in said if other != text)
                speak(other if len(asked) == 1 else text)
            elif asked:
                heard.append(line.strip())
                if heard[-1].endswith(f"; say again: {asked[-1]}"):
                    speak(asked[-1])
        process.send_signal(signal.SIGINT)
        rest, _ = process.communicate(timeout=60)
    finally:
        process.kill()
        process.wait()
    assert process.returncode == 128 + signal.SIGINT
    assert "what is recorded is kept" in rest
    assert heard[0].endswith(f"; say again: {asked[0]}")
    assert sum(line.startswith("heard: ") for line in heard) >= times + 1
    return asked
