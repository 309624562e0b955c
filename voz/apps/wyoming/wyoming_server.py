"""A Wyoming server: sound in, the text of the command out; nothing is driven.

https://github.com/OHF-Voice/wyoming has the protocol.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from functools import partial

from wyoming.asr import Transcribe, Transcript
from wyoming.audio import AudioChunk, AudioStart, AudioStop
from wyoming.event import Event
from wyoming.info import AsrModel, AsrProgram, Describe, Info

from voz import __version__
from voz.api.recognizer import ARRAY, Listener
from voz.apps.servers.connections import ConnectionGuard
from voz.apps.wyoming.announcement import announced
from voz.apps.wyoming.connection import ATTRIBUTION, Connection, serving
from voz.audio.sound_files import MAX_CHANNELS, Warn
from voz.audio.wav import PCM_WIDTHS, has_unsigned_bytes, pcm_samples
from voz.errors import AudioError
from voz.events import Partial, Utterance
from voz.language.language_files import read_language_info
from voz.recognition.engine import RecognitionEngine, open_stream

MAX_REQUEST_TIME = 120.0
"""The longest sound of one request, s; a command takes two."""

NO_SPEECH_REASONS = ("no_speech", "too_short", "too_quiet")
"""Reasons of utterances that do not end a request: a noise may come before the command."""


def server_info(commands: Sequence[str], language: str) -> Info:
    """Describe this server to a client; the language is that of the commands."""
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


class RequestHandler(Connection):
    """Answers one client, request by request."""

    max_bytes = 4_000_000
    """Half a minute of sound at 48 kHz."""

    def __init__(
        self,
        guard: ConnectionGuard,
        reader: asyncio.StreamReader,
        writer: asyncio.StreamWriter,
        *,
        recognizer: RecognitionEngine,
        info: Info,
        language: str,
        warn: Warn,
    ) -> None:
        super().__init__(guard, reader, writer)
        self._recognizer = recognizer
        self._info = info
        self._language = language
        self._warn = warn
        self._begin_request()

    def _begin_request(self) -> None:
        self._listener: Listener | None = None
        self._format: tuple[int, int, int] | None = None  # Hz, bytes, and how many channels
        self._unsigned = False  # of samples of 8 bits
        self._seconds = 0.0
        self._answered = False

    async def answer(self, event: Event) -> None:
        """Recognize a request."""
        if Describe.is_type(event.type):
            await self.write_event(self._info.event())
        elif Transcribe.is_type(event.type) or AudioStart.is_type(event.type):
            self._begin_request()
        elif AudioChunk.is_type(event.type):
            if not self._answered:  # what follows the end of the speech may be on its way
                await self._decode_or_tell(AudioChunk.from_event(event))
        elif AudioStop.is_type(event.type):
            if self._listener:
                await self._answer_first(await asyncio.to_thread(self._listener.finish))
            if not self._answered:
                await self._transcribe("")
            self._begin_request()

    async def _decode_or_tell(self, chunk: AudioChunk) -> None:
        """Recognize a chunk; after an error, the rest of the request is ignored.

        A client that still sends would lose the error if the connection was closed.
        """
        try:
            await self._decode(chunk)
        except AudioError as error:
            self._answered, self._listener = True, None
            await self.write_error(error)

    async def _decode(self, chunk: AudioChunk) -> None:
        sound_format = (chunk.rate, chunk.width, chunk.channels)
        if chunk.width not in PCM_WIDTHS or not 1 <= chunk.channels <= MAX_CHANNELS:
            raise AudioError(f"send samples of 8 to 32 bits, of 1 to {MAX_CHANNELS} channels")
        if self._listener is None:
            self._listener = Listener(open_stream(self._recognizer, ARRAY), chunk.rate, self._warn)
            self._format = sound_format
            self._unsigned = has_unsigned_bytes(chunk.audio)
        if self._format != sound_format or len(chunk.audio) % (chunk.width * chunk.channels):
            raise AudioError("send all chunks of a request in one format")
        samples = pcm_samples(chunk.audio, chunk.width, unsigned=self._unsigned)
        sound = samples.reshape(-1, chunk.channels)
        self._seconds += len(sound) / chunk.rate
        if self._seconds > MAX_REQUEST_TIME:
            raise AudioError(f"end a request after {MAX_REQUEST_TIME:.0f} s at the latest")
        await self._answer_first(await asyncio.to_thread(self._listener.feed, sound))

    async def _answer_first(self, heard: list[Utterance | Partial]) -> None:
        """Answer with the first speech: the client need not know where it ends."""
        for one in heard:
            if isinstance(one, Partial) or one.reason in NO_SPEECH_REASONS or self._answered:
                continue
            await self._transcribe(one.text if one.accepted else "")

    async def _transcribe(self, text: str) -> None:
        self._answered, self._listener = True, None
        await self.write_event(Transcript(text, language=self._language).event())


def once(warn: Warn) -> Warn:
    """Pass each message on once: clients send request after request."""
    said: set[str] = set()

    def tell(message: str) -> None:
        if message not in said:
            said.add(message)
            warn(message)

    return tell


def serve(
    uri: str,
    recognizer: RecognitionEngine,
    commands: Sequence[str],
    ready: Callable[[], None],
    *,
    announce: bool,
    warn: Callable[[str], None],
) -> None:
    """Answer requests at an address until a signal ends the program.

    `ready` is called once it answers. The commands are for its description. `warn` is called if it
    cannot be announced in the network, and if channels of sound would cancel each other.

    Raises:
        ConfigError: it cannot listen there.
    """
    language = read_language_info(recognizer.files).code
    info = server_info(commands, language)

    async def work() -> None:
        handler = partial(
            RequestHandler,
            recognizer=recognizer,
            info=info,
            language=language,
            warn=once(warn),
        )
        async with serving(uri, handler):
            ready()
            async with announced(uri, warn) if announce else nullcontext():
                await asyncio.Event().wait()

    asyncio.run(work())
