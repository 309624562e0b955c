"""What helps to find out what went wrong, in one file: no sound, and nothing that is secret."""

from __future__ import annotations

import io
import platform
import sys
import zipfile
from collections.abc import Iterable
from importlib.metadata import distributions

import msgspec
from msgspec.structs import replace

from voz import __version__
from voz.apps.web.board import Record, encoded
from voz.config import Config


def bundle(state: Record, events: Iterable[str], settings: Config) -> bytes:
    """Pack a bundle.

    Args:
        state: how things are.
        events: the last of the run, a line of JSON each.
        settings: of the run; what the user's own robots are given is left out.

    Returns:
        A ZIP file.
    """
    hidden = replace(settings, own={name: {} for name in settings.own})
    texts = {
        "state.json": encoded(state),
        "events.jsonl": "\n".join(events),
        "settings.json": msgspec.json.format(msgspec.json.encode(hidden)).decode(),
        "versions.txt": "\n".join(versions()),
    }
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as file:
        for name, text in texts.items():
            file.writestr(name, text)
    return packed.getvalue()


def versions() -> list[str]:
    """List what runs here: voz, Python, the system and the packages."""
    packages = sorted({f"{each.name} {each.version}" for each in distributions()})
    return [f"voz {__version__}", f"Python {sys.version}", platform.platform(), "", *packages]
