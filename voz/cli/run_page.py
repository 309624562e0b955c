"""`voz run --web`: the operator page of a live run."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from voz.cli.run_options import RunOptions
from voz.cli.text_io import info
from voz.errors import AudioError
from voz.files import data_folder

if TYPE_CHECKING:
    from voz.apps.web.page_address import PageAddress
    from voz.inbox import Inbox
    from voz.language.sentences.command_set import Commands
    from voz.robot.simulation.room_view import RoomView
    from voz.run.clocks import Clock
    from voz.run.live import Page

NO_MICROPHONE_ADVICE = (
    ", or use `--web` to speak into a browser, `--text -` to type commands, "
    "or `--wav FILE` for recordings"
)
"""What to do besides connecting a microphone, where there is none."""

BROWSER_DEVICE = "browser"
"""The name of the microphone of the operator's page, for `--device`."""

NO_DEVICE = "none"
"""For `--device` where only other programs drive, by `--wyoming`."""

WEB_PACKAGES = ("starlette", "uvicorn", "websockets", "segno", "cryptography")


def chosen_microphone(options: RunOptions) -> str | None:
    """Find the microphone; None if it is the operator's browser. Raises AudioError.

    Where a robot that other programs drive has none, it is `NO_DEVICE`.
    """
    from voz.audio.microphone import choose_microphone

    if options.web and options.device == BROWSER_DEVICE:
        return None
    if options.wyoming and options.device == NO_DEVICE:
        return NO_DEVICE
    try:
        return choose_microphone(options.device, NO_MICROPHONE_ADVICE).name
    except AudioError:
        if options.web and options.device is None:
            return None
        if options.wyoming and options.device is None:
            info("there is no microphone: only typed commands and Wyoming clients are obeyed")
            return NO_DEVICE
        raise


def check_installed() -> None:
    """Raise ConfigError if a package that a page needs is missing."""
    from voz.extras import require

    require("web", *WEB_PACKAGES)


@contextmanager
def page_site(options: RunOptions) -> Iterator[PageAddress]:
    """Take the page's address for a `with` block, and show it; raises ConfigError."""
    check_installed()
    from voz.apps.web.page_address import open_page_address, qr_code

    authority = data_folder("certificates") if options.https else None
    with open_page_address(options.web_host, options.web_port, authority) as site:
        info(f"operator page: {site.link}")
        if site.access.needs_token:
            _show_code(qr_code(site.link))
        yield site


def page_of(
    site: PageAddress,
    commands: Callable[[], Commands],
    view: RoomView | None,
    microphone: str | None,
) -> Callable[[Inbox, Clock], Page]:
    """Return what makes the page of a run.

    Args:
        site: where it is.
        commands: returns what may be given there now.
        view: the simulated room, if there is one.
        microphone: the robot's own; None if the browser is one.
    """
    from voz.apps.web.live_page import LivePage
    from voz.apps.web.picture import DeadReckoningPicture, RoomPicture

    picture = RoomPicture(view.settings, view.state) if view else DeadReckoningPicture()
    return lambda inbox, clock: LivePage(
        site, inbox, clock, commands, picture=picture, browser_listens=microphone is None
    )


def _show_code(code: str) -> None:
    """Draw a QR code, unless standard error is a log."""
    if sys.stderr.isatty():
        print(code, file=sys.stderr, flush=True)
