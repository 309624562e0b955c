"""A Wyoming server: sound in, the command that was said out; nothing is driven.

https://github.com/OHF-Voice/wyoming has the protocol.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial

import numpy as np
import numpy.typing as npt
from wyoming.asr import Transcribe, Transcript
from wyoming.audio import AudioChunk, AudioStart, AudioStop
from wyoming.error import Error
from wyoming.event import Event
from wyoming.info import AsrModel, AsrProgram, Attribution, Describe, Info
from wyoming.server import AsyncEventHandler, AsyncServer

from voz import __version__
from voz.errors import AudioError, ConfigError, VozError
from voz.events import Utterance
from voz.language.generated.language_files import read_language_info
from voz.recognition.listener import Listener
from voz.recognition.recognizer import Recognizer

LONGEST = 120.0
"""Of one request, s; a command takes two."""

MOST_CHANNELS = 8

WIDTH = 2
"""Bytes of a sample."""

LARGEST = 4_000_000
"""Bytes of what one message may announce: half a minute of sound at 48 kHz."""

NO_SPEECH = ("no_speech", "too_short", "too_quiet")
"""Why a sound ends no request: a noise may come before the command."""

ATTRIBUTION = Attribution("voz", "https://github.com/cmusphinx/pocketsphinx")


def info(commands: Sequence[str], language: str) -> Info:
    """Tell what this server does.

    Args:
        commands: the sentences that it knows.
        language: they are in, as Home Assistant calls it.
    """
    model = AsrModel(
        name="commands",
        attribution=ATTRIBUTION,
        installed=True,
        description=f"{len(commands)} commands: {', '.join(commands[:20])}",
        version=__version__,
        languages=[language],
    )
    program = AsrProgram(
        name="voz",
        attribution=ATTRIBUTION,
        installed=True,
        description="Offline voice commands for robots",
        version=__version__,
        models=[model],
        requires_external_vad=False,
        prefers_auto_gain_enabled=False,
        prefers_noise_reduction_enabled=False,
    )
    return Info(asr=[program])


class SharedRecognizer:
    """One recognizer for all who ask: one of them is heard at a time."""

    def __init__(self, recognizer: Recognizer) -> None:
        self._recognizer = recognizer
        self._free = asyncio.Lock()

    def listen(self, rate: float) -> Listener:
        """Begin to listen to a stream."""
        return self._recognizer.listen(rate)

    async def feed(self, listener: Listener, sound: npt.ArrayLike) -> list[Utterance]:
        """Hear the next sound of a stream, on another thread."""
        async with self._free:
            heard = await asyncio.to_thread(listener.feed, sound)
        return [event for event in heard if isinstance(event, Utterance)]

    async def finish(self, listener: Listener) -> list[Utterance]:
        """End a stream."""
        async with self._free:
            heard = await asyncio.to_thread(listener.finish)
        return [event for event in heard if isinstance(event, Utterance)]


class Bounded(asyncio.StreamReader):
    """A stream that nobody can fill the memory by: it waits for no message that is too large."""

    def __init__(self, stream: asyncio.StreamReader) -> None:
        self._stream = stream

    async def readline(self) -> bytes:
        """Read a line, of 64 KiB at most."""
        return await self._stream.readline()

    async def readexactly(self, n: int) -> bytes:
        """Read so many bytes; raises ValueError if they are too many."""
        if n > LARGEST:
            raise ValueError(f"{n} bytes are too many")
        return await self._stream.readexactly(n)


class Handler(AsyncEventHandler):
    """Answers one client, request by request."""

    def __init__(
        self,
        ears: SharedRecognizer,
        about: Info,
        language: str,
        reader: asyncio.StreamReader,
        writer: asyncio.StreamWriter,
    ) -> None:
        super().__init__(Bounded(reader), writer)
        self._ears = ears
        self._about = about
        self._language = language
        self._begin()

    def _begin(self) -> None:
        self._listener: Listener | None = None
        self._format: tuple[int, int] | None = None  # Hz, and how many channels
        self._seconds = 0.0
        self._answered = False

    async def run(self) -> None:
        """Answer until the client goes, or sends what is no Wyoming."""
        with suppress(ValueError, KeyError, TypeError, AttributeError, OSError, EOFError):
            await super().run()
        self.writer.close()

    async def handle_event(self, event: Event) -> bool:
        """Answer an event; tells whether there may be more."""
        try:
            await self._answer(event)
        except VozError as error:
            await self.write_event(Error(str(error), code="sound").event())
            return False
        return True

    async def _answer(self, event: Event) -> None:
        if Describe.is_type(event.type):
            await self.write_event(self._about.event())
        elif Transcribe.is_type(event.type) or AudioStart.is_type(event.type):
            self._begin()
        elif AudioChunk.is_type(event.type):
            if not self._answered:  # what follows the end of the speech may be on its way
                await self._hear(AudioChunk.from_event(event))
        elif AudioStop.is_type(event.type):
            if self._listener:
                await self._end_at(await self._ears.finish(self._listener))
            if not self._answered:
                await self._transcribe("")
            self._begin()

    async def _hear(self, chunk: AudioChunk) -> None:
        wanted = (chunk.rate, chunk.channels)
        if chunk.width != WIDTH or not 1 <= chunk.channels <= MOST_CHANNELS:
            raise AudioError("send samples of 16 bits, of 1 to 8 channels")
        if self._listener is None:
            self._listener, self._format = self._ears.listen(chunk.rate), wanted
        if self._format != wanted or len(chunk.audio) % (WIDTH * chunk.channels):
            raise AudioError("send all chunks of a request in one format")
        sound = np.frombuffer(chunk.audio, "<i2").reshape(-1, chunk.channels)
        self._seconds += len(sound) / chunk.rate
        if self._seconds > LONGEST:
            raise AudioError(f"end a request after {LONGEST:.0f} s at the latest")
        await self._end_at(await self._ears.feed(self._listener, sound))

    async def _end_at(self, heard: list[Utterance]) -> None:
        """Answer by the first that was said: the client need not know where it ends."""
        for utterance in heard:
            if not self._answered and utterance.reason not in NO_SPEECH:
                await self._transcribe(utterance.text if utterance.accepted else "")

    async def _transcribe(self, text: str) -> None:
        self._answered, self._listener = True, None
        await self.write_event(Transcript(text, language=self._language).event())


def serve(
    uri: str, recognizer: Recognizer, commands: Sequence[str], ready: Callable[[], None]
) -> None:
    """Answer requests until a signal ends the program.

    Args:
        uri: where, as `tcp://127.0.0.1:10300`.
        recognizer: what understands.
        commands: the sentences that it knows.
        ready: called once it can be asked.

    Raises:
        ConfigError: nobody can be served there.
    """
    language = read_language_info(recognizer.files).code
    about = info(commands, language)

    async def work() -> None:
        server = AsyncServer.from_uri(uri)
        await server.start(partial(Handler, SharedRecognizer(recognizer), about, language))
        ready()
        await asyncio.Event().wait()

    try:
        if not uri.startswith(("tcp://", "unix://")):
            raise ValueError("that is no address")
        asyncio.run(work())
    except (ValueError, OSError) as error:
        raise ConfigError(
            f"--wyoming {uri}: nobody can be served there ({error}); name tcp://HOST:PORT or "
            "unix://FILE"
        ) from None
