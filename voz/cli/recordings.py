"""`voz decode`: what is said in recordings."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from voz.cli.exit_codes import SOME_UNREADABLE
from voz.cli.options import ProfileOption, Recognising, with_options
from voz.cli.terminal import put, show, with_bar

if TYPE_CHECKING:
    from voz.recognition.batch import Decoded, Unreadable


@with_options
def decode(
    options: Recognising,
    files: Annotated[list[Path], typer.Argument(metavar="FILE...", help="Recordings.")],
    as_json: Annotated[
        bool, typer.Option("--json", help="One line of JSON for each utterance.")
    ] = False,
    profile: ProfileOption = None,
) -> None:
    """Tell what is said in recordings of any format and rate.

    Exits with 3 when some recordings could not be read; the others are done.

    Example: voz decode audio_fixtures/long/session.wav
    """
    from voz.process.quiet_libraries import quiet_libraries
    from voz.recognition.batch import Unreadable, decode_recordings
    from voz.recognition.recognizer import Recognizer
    from voz.recognition.speaker.profiles import load_profile

    settings = options.settings()
    known = load_profile(profile) if profile else None
    recognizer = Recognizer(options.language(settings), settings.recognition, known)
    write = _show_json if as_json else partial(_show_row, ears=options.verbose)
    if not as_json:
        show(f"   start      end  sure  accepted  {'text':32}  file")
    unreadable = 0
    with quiet_libraries():
        for result in decode_recordings(recognizer, _with_progress(files)):
            write(result)
            unreadable += isinstance(result, Unreadable)
    if unreadable:
        raise typer.Exit(SOME_UNREADABLE)


def _with_progress(files: list[Path]) -> Iterable[Path]:
    """Show a bar while the results go elsewhere; in between them it would be in the way."""
    return files if sys.stdout.isatty() else with_bar(files, "Decoding")


def _show_json(result: Decoded | Unreadable) -> None:
    from voz.events import to_json

    put(to_json(result))


def _show_row(result: Decoded | Unreadable, ears: bool) -> None:
    from voz.events import explain, in_ears
    from voz.recognition.batch import Unreadable

    if isinstance(result, Unreadable):
        show(f"{'':>26} error {result.error}")
        return
    accepted = "yes" if result.accepted else "no"
    explained = result.reason and explain(result.reason, result.between, result.refused_by)
    why = f"({explained})" if explained else ""
    text = " ".join(part for part in (result.text, why) if part)
    show(
        f"{result.start:8.2f} {result.end:8.2f}  {result.confidence:.2f}  {accepted:8}  "
        f"{text:32}  {result.file}"
    )
    if ears and result.ears:
        show(f"{'':35}{in_ears(result.ears)}")
