"""How replies sound, for the page that lets them be heard."""

from __future__ import annotations

import asyncio
import threading

from voz.errors import SpeechError
from voz.files import read_bytes
from voz.speech.speech_cache import cached_speech

PATIENCE = 5.0
"""For a reply to be rendered, s."""


async def spoken(text: str, voice: str) -> bytes:
    """Give a reply as a WAV file.

    Args:
        text: what is said.
        voice: as in the settings.

    Raises:
        SpeechError: it cannot be rendered.
    """
    cancelled = threading.Event()

    def rendered() -> bytes:
        return read_bytes(
            cached_speech(text, voice, cancelled), SpeechError, "let it be said again"
        )

    try:
        return await asyncio.wait_for(asyncio.to_thread(rendered), PATIENCE)
    except asyncio.TimeoutError:
        raise SpeechError("the reply takes too long to be rendered") from None
    finally:
        cancelled.set()
