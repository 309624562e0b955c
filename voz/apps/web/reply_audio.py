"""The sound of replies, for a page that plays them."""

from __future__ import annotations

import asyncio
import threading

from voz.errors import SpeechError
from voz.files import read_bytes
from voz.speech.speech_cache import cached_speech

RENDER_TIMEOUT = 5.0
"""For a reply to be rendered, s."""


async def render_reply(text: str, voice: str) -> bytes:
    """Return a reply as a WAV file, in a voice of the settings; raises SpeechError."""
    cancelled = threading.Event()

    def render() -> bytes:
        path = cached_speech(text, voice, cancelled)
        return read_bytes(path, SpeechError, "let it be said again")

    try:
        return await asyncio.wait_for(asyncio.to_thread(render), RENDER_TIMEOUT)
    except asyncio.TimeoutError:
        raise SpeechError("the reply takes too long to be rendered") from None
    finally:
        cancelled.set()
