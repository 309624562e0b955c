"""`voz view`: shows a session that was kept."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from voz.cli.options import CommonOptions
from voz.cli.run_options import LOCAL, WebPortOption, require_page
from voz.cli.text_io import info


def view(
    session: Annotated[
        Path,
        typer.Argument(metavar="SESSION", help="What `voz run --events` wrote, or a bag."),
    ],
    room: Annotated[
        bool,
        typer.Option("--room", help="Draw the simulator's room: `--robot simulator` drove."),
    ] = False,
    recordings: Annotated[
        Path | None,
        typer.Option(
            "--recordings", metavar="DIR", help="Play what was said, from `voz run --record DIR`."
        ),
    ] = None,
    config: Annotated[
        Path | None,
        typer.Option("--config", metavar="FILE", help="Settings with the room, of that run."),
    ] = None,
    web_port: WebPortOption = 8737,
) -> None:
    """Show a session that was kept in a browser: a timeline with what was said on it.

    A bag has what was obeyed and the velocities; what `voz run --events FILE` wrote has all that
    was heard, said and warned of. Where the robot was is reckoned from its velocities; with
    `--room` it drives through the simulator's room again. Nothing is driven, and the page is for
    this computer alone.

    Example: voz view drive.jsonl
    """
    require_page()
    from voz.apps.web.session_page import (
        read_recordings,
        read_session,
        session_record,
        show_session,
    )
    from voz.apps.web.web_server import open_page_address
    from voz.files import shown_path

    settings = CommonOptions(config=config).settings().simulator if room else None
    sound = read_recordings(recordings) if recordings else {}
    record = session_record(str(shown_path(session)), read_session(session), settings, sound)
    with open_page_address(LOCAL, web_port, None) as site:
        info(f"the session is at {site.link}")
        show_session(site, record, sound)
