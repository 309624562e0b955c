"""What `voz eval` shows and writes."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from voz.cli.text_io import info, show, write_text
from voz.files import atomic_write, os_errors_as_config_error, shown_path

if TYPE_CHECKING:
    from voz.apps.evaluation.plots import Plot
    from voz.apps.evaluation.recognize import Task
    from voz.apps.evaluation.report import Evaluation
    from voz.cli.eval_options import EvalOptions


def show_evaluation(evaluation: Evaluation, tasks: Sequence[Task], options: EvalOptions) -> None:
    """Show the main figures, and write all of them to `--html` and `--json`."""
    from voz.apps.evaluation import report
    from voz.events import to_json

    if "-" not in (options.html, options.as_json):
        show(*report.to_text(evaluation).split("\n"))
    names = []
    if options.html:
        names += _write_page(evaluation, tasks, options.html)
    if options.as_json:
        write_text(options.as_json, f"{to_json(evaluation)}\n")
        names += [options.as_json]
    if written := [name for name in names if name != "-"]:
        info(f"written: {', '.join(written)}")


def pictures_folder(page: Path) -> Path:
    """Return the folder for the pictures of a page, beside it."""
    return page.with_name(f"{page.stem}-pictures")


def _write_page(evaluation: Evaluation, tasks: Sequence[Task], name: str) -> list[str]:
    """Write the page and its pictures; return what was written."""
    from voz.apps.evaluation.failure_sounds import sounds_of_failures
    from voz.apps.evaluation.failures import failures
    from voz.apps.evaluation.page import to_html
    from voz.apps.evaluation.plots import pictures

    drawn = pictures(evaluation.curves, evaluation.scores.commands)
    sounds = sounds_of_failures(failures(evaluation.results), tasks)
    write_text(name, to_html(evaluation, {t: p.svg for t, p in drawn.items()}, sounds))
    if not drawn or not Path(name).is_file():  # a pipe, or a device
        return [name]
    folder = pictures_folder(Path(name))
    _write_pictures(folder, drawn)
    return [name, f"{shown_path(folder)}/"]


def _write_pictures(folder: Path, drawn: Mapping[str, Plot]) -> None:
    with os_errors_as_config_error(folder):
        folder.mkdir(exist_ok=True)
        for title, picture in drawn.items():
            stem = re.sub(r"[^a-z]+", "-", title.lower()).strip("-")
            with atomic_write(folder / f"{stem}.svg") as file:
                file.write(picture.svg)
            with atomic_write(folder / f"{stem}.png", "wb") as file:
                file.write(picture.png)
