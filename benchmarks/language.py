"""How well people who speak another language are understood: `python benchmarks/language.py DIR`.

DIR has a `manifest.tsv` with the columns `path`, `text`, `speaker`, `kind` (`command` or another)
and `language`. What is a command in a language is its list; everything else should be refused.
"""

from __future__ import annotations

import csv
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated, NamedTuple

import typer
from machine import machine, one_line_errors

from voz.api.recognizer import Recognizer
from voz.apps.evaluation.noise import embed_in_noise, generator_for
from voz.audio import SAMPLE_RATE, Samples
from voz.audio.sound_files import read_samples
from voz.errors import ConfigError
from voz.language.build import build
from voz.language.command_source import read_list
from voz.language.language_files import LanguageFiles
from voz.language.sentences.spelling import first_wording
from voz.language.spoken_language import configured_language
from voz.settings import Recognition, SpokenLanguage

COMMAND = "command"
"""The kind of what should be obeyed."""

ALL = "all"

RATIO = 10.0
"""Of speech to noise, dB."""


class Clip(NamedTuple):
    """What somebody said in a recording."""

    path: Path
    text: str
    speaker: str
    is_command: bool
    language: str


class Heard(NamedTuple):
    """A recording, whether its text was heard, and what was obeyed; empty if nothing was."""

    clip: Clip
    is_right: bool
    obeyed: str


def read_clips(manifest: Path) -> list[Clip]:
    """Read a manifest."""
    with manifest.open(encoding="utf-8", newline="") as lines:
        rows = list(csv.DictReader(lines, delimiter="\t"))
    if missing := {"path", "text", "speaker", "kind", "language"} - set(rows[0] if rows else ()):
        raise ConfigError(f"{manifest}: has no column {min(missing)}; see the help")
    return [
        Clip(
            manifest.parent / row["path"],
            first_wording(row["text"]),
            row["speaker"],
            row["kind"] == COMMAND,
            row["language"],
        )
        for row in rows
    ]


def recognizer_for(
    clips: Sequence[Clip], language: str, folder: Path, network: Path | None
) -> Recognizer:
    """Load a recognizer for the commands of a language."""
    listed = folder / f"{language}.txt"
    commands = dict.fromkeys(clip.text for clip in clips if clip.is_command)
    listed.write_text("".join(f"{text}\n" for text in commands), encoding="utf-8")
    spoken = configured_language(SpokenLanguage(name=language))
    build(listed, folder / language, read_list(listed, spoken))
    settings = Recognition(network=str(network) if network else None)
    return Recognizer(LanguageFiles(folder / language), settings)


def heard_in(recognizer: Recognizer, clip: Clip, noise: Samples | None) -> Heard:
    """Recognize a recording, amid noise if there is any."""
    samples = read_samples(clip.path)
    if noise is not None:
        samples = embed_in_noise(noise, samples, RATIO, generator_for(clip.path.name))
    found = [u for u in recognizer.decode(samples, SAMPLE_RATE) if u.text]
    texts = [u.text for u in found]
    obeyed = " / ".join(u.text for u in found if u.accepted)
    return Heard(clip, clip.is_command and clip.text in texts, obeyed)


def table(language: str, heard: Sequence[Heard]) -> Iterator[str]:
    """A row for each speaker of a language, then one for all."""
    speakers = sorted({each.clip.speaker for each in heard})
    for speaker in (*speakers, ALL):
        own = [each for each in heard if speaker in (ALL, each.clip.speaker)]
        commands = [each for each in own if each.clip.is_command]
        right = sum(each.is_right for each in commands)
        accepted = sum(each.obeyed == each.clip.text for each in commands)
        wrong = sum(each.obeyed not in ("", each.clip.text) for each in commands)
        others = [each for each in own if not each.clip.is_command]
        cells = (
            _share(right, len(commands)),
            _share(accepted, len(commands)),
            f"{wrong}" if commands else "",
            f"{sum(bool(each.obeyed) for each in others)} of {len(others)}" if others else "",
        )
        yield f"| {language} | {speaker} | {len(commands)} | {' | '.join(cells)} |"


def _share(count: int, of: int) -> str:
    return f"{count / of:.3f}" if of else ""


def main(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Holds a manifest.tsv.")],
    network: Annotated[Path | None, typer.Option(help="Other weights than voz's own.")] = None,
    noise: Annotated[
        Path | None, typer.Option(help=f"A recording {RATIO:.0f} dB quieter than the speech.")
    ] = None,
    every: Annotated[bool, typer.Option("--all", help="Show each one that went wrong.")] = False,
) -> None:
    """Print how many commands are right, how many of them are obeyed, and what else is obeyed."""
    with one_line_errors(), tempfile.TemporaryDirectory(prefix="voz-") as work:
        clips = read_clips(folder / "manifest.tsv")
        around = read_samples(noise) if noise else None
        print(f"{machine()}\n")
        print("| language | speaker | commands | right | obeyed | wrong | others obeyed |")
        print("|---|---|---|---|---|---|---|")
        wrong = []
        for language in sorted({clip.language for clip in clips}):
            own = [clip for clip in clips if clip.language == language]
            recognizer = recognizer_for(own, language, Path(work), network)
            heard = [heard_in(recognizer, clip, around) for clip in own]
            print(*table(language, heard), sep="\n", flush=True)
            wrong += [h for h in heard if h.obeyed != (h.clip.text if h.clip.is_command else "")]
    for each in wrong if every else ():
        print(f"{each.clip.path.name} {each.clip.text}: {each.obeyed or 'refused'}")


if __name__ == "__main__":
    typer.run(main)
