"""`voz view`: shows a session that was kept."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from voz.cli.run_options import LOCAL, WebPortOption
from voz.cli.run_page import check_installed
from voz.cli.text_io import info


def view(
    session: Annotated[
        Path,
        typer.Argument(metavar="SESSION", help="What `voz run --events` wrote, or a bag."),
    ],
    web_port: WebPortOption = 8737,
) -> None:
    """Show a session that was kept in a browser, at any time of it: a slider moves through it.

    A bag has what was obeyed and the velocities; what `voz run --events FILE` wrote has all that
    was heard, said and warned of. Where the robot was is reckoned from its velocities. Nothing is
    driven, and the page is for this computer alone.

    Example: voz view drive.jsonl
    """
    check_installed()
    from voz.apps.recordings.sessions import read_session
    from voz.apps.web.page_address import open_page_address
    from voz.apps.web.session_page import session_record, show_session
    from voz.files import shown_path

    record = session_record(str(shown_path(session)), read_session(session))
    with open_page_address(LOCAL, web_port, None) as site:
        info(f"the session is at {site.link}")
        show_session(site, record)
