"""`voz serve`: recognizes speech for other programs, and drives nothing."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Annotated

import typer

from voz.cli.options import ProfileOption, RecognizerOptions, ZeroconfOption, with_options
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
    serve_wyoming(options.wyoming, recognizer, examples, ready, options.zeroconf, warn)
