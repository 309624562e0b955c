"""The HTTP requests for recordings, replies, marks and the false-alarm setting."""

from __future__ import annotations

import asyncio
from contextlib import suppress
from http import HTTPStatus
from pathlib import Path
from threading import Event

import numpy as np
import numpy.typing as npt
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import BaseRoute, Route

from voz.apps.web.false_alarm_setting import FalseAlarmSetting
from voz.apps.web.json_requests import decode_body
from voz.apps.web.page_messages import Alarms, Mark, Playing
from voz.apps.web.page_playback import PagePlayback, PageReply
from voz.apps.web.page_registry import PageRegistry
from voz.apps.web.recording_marks import RecordingMarks
from voz.audio.sound_files import read_blocks
from voz.errors import SpeechError
from voz.files import read_bytes
from voz.speech.synthesis import cached_speech

RENDER_TIMEOUT = 5.0
"""For a reply to be rendered, s."""


class TuningApi:
    """Answers the requests about recordings, replies and false alarms."""

    def __init__(
        self,
        registry: PageRegistry,
        marks: RecordingMarks,
        false_alarms: FalseAlarmSetting,
        playback: PagePlayback,
        voice: str,
    ) -> None:
        """Prepare to answer; `voice` is that of the replies."""
        self._registry = registry
        self._marks = marks
        self._false_alarms = false_alarms
        self._playback = playback
        self._voice = voice

    def routes(self) -> list[BaseRoute]:
        """The addresses that it answers."""
        return [
            Route("/api/recordings/{file}", self.recording),
            Route("/api/reply", self.reply),
            Route("/api/mark", self.mark, methods=["POST"]),
            Route("/api/alarms", self.alarms, methods=["POST"]),
            Route("/api/sounding", self.playback, methods=["POST"]),
        ]

    async def recording(self, request: Request) -> Response:
        """GET /api/recordings/FILE: the sound of an utterance of this run."""
        path = self._marks.path(request.path_params["file"])
        with suppress(OSError):
            if path:
                sound = await asyncio.to_thread(path.read_bytes)
                return Response(sound, media_type="audio/flac")
        raise HTTPException(HTTPStatus.NOT_FOUND, "that recording is not there any more")

    async def reply(self, request: Request) -> Response:
        """GET /api/reply?text=TEXT: the sound of a reply that the robot gave recently."""
        text = request.query_params.get("text", "")
        if not self._registry.has_said(text):  # any other text would be work for strangers
            raise HTTPException(HTTPStatus.NOT_FOUND, "the robot has not said that just now")
        path = await _rendered(text, self._voice)
        sound = await asyncio.to_thread(read_bytes, path, SpeechError, "let it be said again")
        return Response(sound, media_type="audio/wav")

    async def mark(self, request: Request) -> Response:
        """POST /api/mark: marks what was said in a recording."""
        mark = await decode_body(request, Mark, "send JSON with page, file and said")
        self._registry.check_driving(mark.page)
        record = await self._marks.mark(mark.file, mark.said)
        self._registry.broadcast(record)
        return JSONResponse(record)

    async def alarms(self, request: Request) -> Response:
        """POST /api/alarms: sets `false_alarms_per_hour` for the run."""
        alarms = await decode_body(request, Alarms, "send JSON with page and alarms")
        self._registry.check_driving(alarms.page)
        self._false_alarms.set(alarms.alarms)
        return JSONResponse({"alarms": self._false_alarms.alarms})

    async def playback(self, request: Request) -> Response:
        """POST /api/sounding: the page plays something; once this is answered it may begin."""
        playing = await decode_body(request, Playing, "send JSON with page and seconds")
        self._registry.check_driving(playing.page)
        reply = None
        if playing.reply and self._registry.has_said(playing.reply):
            wav = await _rendered(playing.reply, self._voice)
            reply = PageReply(playing.reply, await asyncio.to_thread(_samples, wav))
        self._playback.start(playing.seconds, reply)
        return JSONResponse({"seconds": playing.seconds})


async def _rendered(text: str, voice: str) -> Path:
    """Return a WAV file of a reply; raises SpeechError."""
    cancelled = Event()

    def render() -> Path:
        return cached_speech(text, voice, cancelled)

    try:
        return await asyncio.wait_for(asyncio.to_thread(render), RENDER_TIMEOUT)
    except asyncio.TimeoutError:
        raise SpeechError("the reply takes too long to be rendered") from None
    finally:
        cancelled.set()


def _samples(path: Path) -> npt.NDArray[np.float32]:
    """Return a reply's samples, 16 kHz, -1 to 1; raises AudioError."""
    samples: npt.NDArray[np.float32] = np.concatenate(list(read_blocks(path))) / np.float32(32768)
    return samples
