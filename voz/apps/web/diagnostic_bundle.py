"""A ZIP file for finding out what went wrong: no sound, and nothing secret."""

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
from voz.apps.web.event_history import Record, encode_record
from voz.config import Config


def diagnostic_bundle(state: Record, events: Iterable[str], settings: Config) -> bytes:
    """Return the ZIP file, without the settings of the user's own robots."""
    hidden = replace(settings, own={name: {} for name in settings.own})
    texts = {
        "state.json": encode_record(state),
        "events.jsonl": "\n".join(events),
        "settings.json": msgspec.json.format(msgspec.json.encode(hidden)).decode(),
        "versions.txt": "\n".join(_versions()),
    }
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as file:
        for name, text in texts.items():
            file.writestr(name, text)
    return packed.getvalue()


def _versions() -> list[str]:
    packages = sorted({f"{each.name} {each.version}" for each in distributions()})
    return [f"voz {__version__}", f"Python {sys.version}", platform.platform(), "", *packages]
