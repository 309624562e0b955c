"""`voz serve` and `voz view`: servers that drive nothing."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from voz.cli.options import (
    CommonOptions,
    ProfileOption,
    RecognizerOptions,
    ZeroconfOption,
    with_options,
)
from voz.cli.run_options import LOCAL, WebPortOption, require_page
from voz.cli.text_io import info, warn
from voz.process.setup import LIVE_MEMORY


@dataclass
class ServeOptions(RecognizerOptions):
    """The options of `voz serve`."""

    wyoming: Annotated[
        str, typer.Option(metavar="URI", help="Where it is asked, by the Wyoming protocol.")
    ] = "tcp://127.0.0.1:10300"
    zeroconf: ZeroconfOption = True
    profile: ProfileOption = None

    @property
    def least_memory(self) -> int:
        """The address space that the server needs, kB."""
        return LIVE_MEMORY


@with_options
def serve(options: ServeOptions) -> None:
    """Be the speech-to-text of Home Assistant and of satellites, by the Wyoming protocol.

    The text of a command that was accepted is the answer, and an empty one else. Nothing is driven:
    for that is `voz run --wyoming`. The protocol has no password: name another address than this
    computer's own only in a network that you trust.

    Example: voz serve --wyoming tcp://0.0.0.0:10300
    """
    from voz.extras import require

    require("wyoming", "wyoming", "zeroconf")
    from voz.apps.wyoming.wyoming_server import serve as serve_wyoming
    from voz.recognition.engine import RecognitionEngine
    from voz.recognition.profiles import load_profile

    settings = options.settings()
    language = options.language(settings)
    known = load_profile(options.profile, warn) if options.profile else None
    recognizer = RecognitionEngine(language, settings.recognition, known)
    ready = partial(info, f"serving at {options.wyoming}")
    examples = recognizer.commands.examples()
    announce = options.zeroconf
    serve_wyoming(options.wyoming, recognizer, examples, ready, announce=announce, warn=warn)


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
