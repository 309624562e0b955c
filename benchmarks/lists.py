"""What longer lists of commands cost: time, memory, and commands that are understood.

Run `python benchmarks/lists.py MANIFEST`. The commands of the manifest are heard with all of them
in the list, and with more and more other sentences beside them; its near-misses, too.
"""

from __future__ import annotations

import subprocess
import sys
import time
from itertools import islice, product
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

import typer
from machine import machine, one_line_errors, peak_megabytes

SIZES = (14, 100, 1_000, 10_000)

OTHERS = (
    "bring carry clean close drop fetch find hide lift lock move open paint pull push",
    "a every my no one that the this your",
    "black blue broken brown clean cold empty gray green heavy old pink red small white yellow",
    "apple bag ball book bottle bowl box chair cup door key knife lamp pen plate spoon table toy",
)
"""Words of the sentences beside the commands, one of each line."""

HEADER = (
    "sentences",
    "build",
    "load",
    "CPU per command",
    "right",
    "and accepted",
    "near-misses obeyed",
    "peak memory",
)


def listed(commands: list[str], size: int) -> list[str]:
    """The commands, and so many other sentences that there are `size` in all."""
    others = (" ".join(words) for words in product(*(line.split() for line in OTHERS)))
    every = 43200 // size  # far apart, so that they begin and end differently
    return [*commands, *islice(islice(others, 0, None, max(1, every)), size - len(commands))]


def measure(manifest: Path, size: int, most: int) -> tuple[str, ...]:
    """Hear the commands with a list of so many sentences; runs in a process of its own."""
    from voz.api.recognizer import Recognizer
    from voz.apps.recordings.manifest import read_manifest
    from voz.audio.sound_files import read_blocks
    from voz.language.build import build
    from voz.language.language_files import LanguageFiles
    from voz.settings import Recognition

    everything = read_manifest(manifest)
    clips = [clip for clip in everything if clip.kind == "command"]
    clips = clips[:: max(1, len(clips) // most)]
    others = [clip for clip in everything if clip.kind == "near-miss"]
    others = others[:: max(1, len(others) // most)]
    with TemporaryDirectory() as folder:
        path = Path(folder) / "commands.txt"
        path.write_text("\n".join(listed(sorted({c.text for c in clips}), size)), encoding="utf-8")
        begun = time.process_time()
        build(path, Path(folder) / "lm")
        built = time.process_time()
        recognizer = Recognizer(LanguageFiles(Path(folder) / "lm"), Recognition())
        loaded = time.process_time()
        heard = [list(recognizer.utterances(read_blocks(clip.path), "")) for clip in clips]
        used = time.process_time() - loaded
        missed = [list(recognizer.utterances(read_blocks(clip.path), "")) for clip in others]
    obeyed_others = sum(any(u.accepted for u in utterances) for utterances in missed)
    right = [[u.text for u in us] == [c.text] for us, c in zip(heard, clips, strict=True)]
    obeyed = [r and us[0].accepted for r, us in zip(right, heard, strict=True)]
    return (
        f"{size:,}",
        f"{built - begun:.2f} s",
        f"{loaded - built:.2f} s",
        f"{1000 * used / len(clips):.0f} ms",
        f"{sum(right) / len(clips):.3f}",
        f"{sum(obeyed) / len(clips):.3f}",
        f"{obeyed_others} of {len(others)}",
        f"{peak_megabytes():.0f} MB",
    )


def main(
    manifest: Annotated[Path, typer.Argument(help="Its commands are heard.")],
    most: Annotated[int, typer.Option(min=1, help="Recordings that are heard, about.")] = 100,
    size: Annotated[int | None, typer.Option(hidden=True)] = None,
) -> None:
    """Print what lists of 14 to 10,000 sentences cost.

    Example: python benchmarks/lists.py audio_fixtures/manifest.tsv
    """
    if size is not None:
        print(f"| {' | '.join(measure(manifest, size, most))} |")
        return
    print(f"{machine()}\n\n| {' | '.join(HEADER)} |\n|{' --- |' * len(HEADER)}", flush=True)
    for number in SIZES:
        again = [sys.executable, __file__, str(manifest), "--most", str(most)]
        subprocess.run([*again, "--size", str(number)], check=True)


if __name__ == "__main__":
    with one_line_errors():
        typer.run(main)
