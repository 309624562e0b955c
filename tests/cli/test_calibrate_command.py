"""`voz calibrate`: from recordings or a microphone to a profile that is used."""

from __future__ import annotations

import json
import os
import signal
import subprocess
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
import soundfile
from calls import VOZ
from recordings import FIXTURES, ROOT, Recording

from voz.apps.recordings.calibration import Said, calibrate
from voz.apps.recordings.enrollment import choose_prompts, read_saved_recordings
from voz.apps.recordings.manifest import MANIFEST_NAME, join_lines
from voz.audio import SAMPLE_RATE, Samples
from voz.audio.segmenter import segments
from voz.language.language_files import LanguageFiles, read_sentences
from voz.recognition.speaker.adaptation import StartVector
from voz.recognition.speaker.profiles import Profile, load_profile, save_profile
from voz.settings import Recognition


@pytest.fixture(autouse=True)
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where the profiles are."""
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    return tmp_path / "data" / "voz" / "profiles"


@pytest.fixture
def without_network(tmp_path: Path) -> Path:
    """Settings by which pocketsphinx decides alone: the network learns no microphone."""
    (tmp_path / "voz.toml").write_text("[recognition]\nuse_network = false\n")
    return tmp_path / "voz.toml"


def telephone(plain: Samples) -> Samples:
    """A bad microphone: 300 to 3400 Hz, tilted by 6 dB for each octave, and quiet."""
    frequency = np.fft.rfftfreq(len(plain), 1 / SAMPLE_RATE)
    band = ((frequency > 300) & (frequency < 3400)) + 0.01
    gain = band * np.maximum(frequency, 50) / 1000
    filtered = np.fft.irfft(np.fft.rfft(plain.astype(float)) * gain, len(plain))
    return (filtered * 0.1 * np.abs(plain).max() / np.abs(filtered).max()).astype(np.int16)


def said_by(recordings: list[Recording], voice: str) -> list[Said]:
    own = [r for r in recordings if r.kind == "command" and r.voice == voice]
    return [Said(r.text, r.samples()) for r in own]


def through_telephone(said: Sequence[Said]) -> list[Said]:
    return [Said(s.text, telephone(s.samples)) for s in said]


def write(folder: Path, said: Sequence[Said], speaker: str = "ana") -> Path:
    folder.mkdir(exist_ok=True)
    rows = [("path", "text", "speaker", "kind")]
    for number, sentence in enumerate(said):
        soundfile.write(folder / f"{number}.wav", sentence.samples, SAMPLE_RATE)
        rows.append((f"{number}.wav", sentence.text, speaker, "command"))
    (folder / MANIFEST_NAME).write_text(join_lines(rows))
    return folder


@pytest.mark.slow
def test_a_bad_microphone_is_calibrated_and_the_profile_is_used(
    voz, home: Path, recordings: list[Recording], tmp_path: Path, without_network: Path
) -> None:
    said = through_telephone(said_by(recordings, "flite_slt"))
    folder = write(tmp_path / "wav", said[:9])
    write(tmp_path / "others", said[9:])
    result = voz("calibrate", "ana", "--wav", folder, "--config", without_network)
    assert result.code == 0, result.err
    assert "kept: the start of the cepstral mean" in result.out
    before, after = (float(line.split()[-2]) for line in result.out.splitlines()[2:4])
    assert after >= before + 0.1

    def accepted(*options: str) -> int:
        files = [tmp_path / "others" / f"{n}.wav" for n in range(len(said) - 9)]
        lines = voz(
            "decode", "--json", "--config", without_network, *options, *files
        ).out.splitlines()
        heard = {h["file"]: h["text"] for h in map(json.loads, lines) if h["accepted"]}
        return sum(heard.get(str(f)) == s.text for f, s in zip(files, said[9:], strict=True))

    assert accepted("--profile", "ana") >= accepted()
    assert voz("calibrate", "--list").out == "ana\n"
    assert voz("calibrate", "ana", "--delete").code == 0
    assert not (home / "ana").exists()


@pytest.mark.slow
def test_what_is_not_better_is_not_kept(
    recordings: list[Recording], tmp_path: Path, language: LanguageFiles
) -> None:
    """Half of the recordings are labeled wrongly: what is fitted to them helps nobody."""
    said = said_by(recordings, "festival_slt")[:5]
    swapped = [Said(other.text, s.samples) for s, other in zip(said, said[::-1], strict=True)]
    found = calibrate(swapped, language, Recognition(), tmp_path)
    assert found.after.sort_key >= found.before.sort_key


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
        (["run", "--adapt", "--profile", "nobody", "--wav", "x.wav"], "voz calibrate nobody"),
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
        b'{"mllr": "none.txt"}',
        b'{"other": 1}',
        b'{"mllr": "\\u0000"}',
    ],
)
def test_a_spoilt_profile_is_one_line(content: bytes, voz, home: Path) -> None:
    (home / "ana").mkdir(parents=True)
    (home / "ana" / "profile.json").write_bytes(content)
    result = voz("decode", "--profile", "ana", "x.wav")
    assert (result.code, result.err.count("\n")) == (2, 1)
    assert "voz calibrate ana" in result.err


def test_a_transform_that_is_none_is_one_line(voz, home: Path, tmp_path: Path) -> None:
    (tmp_path / "mllr").write_text("1\n3\nnonsense")
    save_profile("ana", Profile(mllr=str(tmp_path / "mllr")))
    result = voz("decode", "--profile", "ana", "x.wav")
    assert (result.code, result.err.count("\n")) == (2, 1)
    assert "mllr.txt" in result.err


def test_a_profile_of_another_acoustic_model_is_one_line(voz, home: Path) -> None:
    save_profile("ana", Profile(StartVector((1.5,) * 13, 60.0), model="0" * 64))
    result = voz("decode", "--profile", "ana", str(FIXTURES / "commands/festival_slt__stop.flac"))
    assert (result.code, result.err.count("\n")) == (2, 1)
    assert "made with another acoustic model" in result.err


def test_a_profile_is_kept_as_it_is(home: Path) -> None:
    profile = Profile(StartVector((1.5,) * 13, 60.0), None, 0.5)
    path = save_profile("ana", profile)
    assert load_profile("ana") == profile
    assert json.loads(path.read_text())["log_odds"] == 0.5


@pytest.mark.slow
def test_what_run_learns_is_kept_for_the_next_run(
    voz, home: Path, session: Recording, without_network: Path
) -> None:
    frames = []
    for _ in range(2):
        run = ("run", "--adapt", "--no-sound", "--wav", session.path, "--config", without_network)
        assert voz(*run).code == 0
        (kept,) = (home / "default" / "learnt").iterdir()
        frames.append(json.loads(kept.read_text())["frames"])
    assert 0 < frames[0] < frames[1]


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
