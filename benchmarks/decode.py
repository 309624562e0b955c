"""CPU, memory and accuracy of voz beside plain pocketsphinx, on the commands of the fixtures.

Run `python benchmarks/decode.py`; each row is measured in processes of its own, and the rows take
turns, so that a busy machine is busy for all of them.
"""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

from machine import machine, peak_megabytes

from voz.apps.recordings.manifest import MANIFEST_NAME, parse_records
from voz.audio.sound_files import read_blocks

ROOT = Path(__file__).parent.parent
FIXTURES = ROOT / "audio_fixtures"
ROUNDS = 3
ONE = FIXTURES / "commands" / "festival_slt__go_forward.flac"

Understand = Callable[[Path], str]


def plain() -> Understand:
    """Pocketsphinx with the same grammar, as its documentation shows it."""
    import soundfile
    from pocketsphinx import Decoder

    files = ROOT / "lm" / "comandos_voz"
    decoder = Decoder(jsgf=f"{files}.gram", dict=f"{files}.dic", lm=None, loglevel="FATAL")

    def understand(path: Path) -> str:
        samples, _ = soundfile.read(path, dtype="int16")
        decoder.start_utt()
        decoder.process_raw(samples.tobytes(), full_utt=True)
        decoder.end_utt()
        hypothesis = decoder.hyp()
        return str(hypothesis.hypstr) if hypothesis else ""

    return understand


def without_confidence() -> Understand:
    """End-pointing and decoding of voz, without asking how sure it is."""
    from voz.audio.denoise import denoise_if_noisy
    from voz.audio.segment import Segment
    from voz.audio.segmenter import Segmenter
    from voz.language.language_files import find_language
    from voz.recognition.language import load_language
    from voz.recognition.pocketsphinx.decoder import Decoder, mean_start

    decoder = Decoder(load_language(find_language(None)), is_wide=False)

    def understand(path: Path) -> str:
        segmenter = Segmenter()
        found = [s for block in read_blocks(path) for s in segmenter.feed(block)]
        found += segmenter.finish()
        spoken = [denoise_if_noisy(sound.samples) for sound in found if isinstance(sound, Segment)]
        return " ".join(decoder.decode(samples, mean_start(samples)) for samples in spoken)

    return understand


def with_confidence() -> Understand:
    """All that `voz decode` does."""
    from voz.api.recognizer import Recognizer
    from voz.audio.sound_files import read_blocks
    from voz.language.language_files import find_language
    from voz.settings import Recognition

    recognizer = Recognizer(find_language(None), Recognition())
    return lambda path: " ".join(u.text for u in recognizer.utterances(read_blocks(path), "clip"))


ENGINES: dict[str, Callable[[], Understand]] = {
    "plain pocketsphinx": plain,
    "voz without the confidence": without_confidence,
    "voz": with_confidence,
}


def commands() -> list[tuple[Path, str]]:
    rows = parse_records((FIXTURES / MANIFEST_NAME).read_text(encoding="utf-8"))
    return [(FIXTURES / r["file"], r["text"]) for r in rows if r["kind"] == "command"]


def measure(engine: str) -> None:
    """Decode all commands once; print milliseconds of CPU each, the share right, megabytes."""
    understand = ENGINES[engine]()
    clips = commands()
    understand(clips[0][0])  # what is done once is not a command's
    start = time.process_time()
    right = [understand(path) == text for path, text in clips]
    milliseconds = 1000 * (time.process_time() - start) / len(clips)
    print(json.dumps([milliseconds, sum(right) / len(right), peak_megabytes()]))


def in_process(*arguments: str) -> str:
    command = [sys.executable, *arguments]
    return subprocess.run(command, check=True, capture_output=True, text=True, cwd=ROOT).stdout


def cpu_of(*arguments: str) -> float:
    """CPU seconds of a whole process, the least of several runs."""
    used = []
    for _ in range(5):
        before = os.times()
        in_process(*arguments)
        after = os.times()
        used.append(
            after.children_user
            + after.children_system
            - before.children_user
            - before.children_system
        )
    return min(used)


def main() -> None:
    results: dict[str, list[list[float]]] = {engine: [] for engine in ENGINES}
    for _ in range(ROUNDS):
        for engine, rounds in results.items():
            rounds.append(json.loads(in_process(__file__, engine)))
    baseline = statistics.median(r[0] for r in results["plain pocketsphinx"])
    print(f"{machine()}\n{len(commands())} commands of the fixtures, median of {ROUNDS} rounds\n")
    print("| | CPU per command | ratio | right | peak memory |\n|---|---|---|---|---|")
    for engine, rounds in results.items():
        milliseconds, right, megabytes = (statistics.median(c) for c in zip(*rounds, strict=True))
        ratio = milliseconds / baseline
        print(
            f"| {engine} | {milliseconds:.1f} ms | {ratio:.2f} | {right:.3f} | {megabytes:.0f} MB |"
        )
    print("\n| a process, from start to end | CPU |\n|---|---|")
    call = "import sys; from voz.cli import main; sys.exit(main())"
    for name, arguments in {
        "`import voz`": ["-c", "import voz"],
        "`voz --help`": ["-c", call, "--help"],
        "`voz decode` of one command": ["-c", call, "decode", str(ONE)],
    }.items():
        print(f"| {name} | {cpu_of(*arguments):.2f} s |", flush=True)


if __name__ == "__main__":
    if len(sys.argv) == 1:
        main()
    else:
        measure(sys.argv[1])
