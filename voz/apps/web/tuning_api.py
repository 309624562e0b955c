"""The HTTP requests for recordings, replies, marks and the false-alarm setting."""

from __future__ import annotations

import asyncio
from http import HTTPStatus

from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import BaseRoute, Route

from voz.apps.web.false_alarm_setting import FalseAlarmSetting
from voz.apps.web.json_requests import decode_body, error_response
from voz.apps.web.page_messages import Alarms, Mark, Playing
from voz.apps.web.page_playback import PagePlayback
from voz.apps.web.page_registry import PageRegistry
from voz.apps.web.recording_marks import RecordingMarks
from voz.apps.web.reply_audio import render_reply
from voz.errors import AudioError, ConfigError, SpeechError

NOT_DRIVING = "only the page that drives may do that: press Drive first"


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
        try:
            sound = await asyncio.to_thread(path.read_bytes) if path else None
        except OSError:
            sound = None
        if sound is None:
            return error_response(HTTPStatus.NOT_FOUND, "that recording is not there any more")
        return Response(sound, media_type="audio/flac")

    async def reply(self, request: Request) -> Response:
        """GET /api/reply?text=TEXT: the sound of a reply that the robot gave recently."""
        text = request.query_params.get("text", "")
        if not self._registry.has_said(text):  # any other text would be work for strangers
            return error_response(HTTPStatus.NOT_FOUND, "the robot has not said that just now")
        try:
            sound = await render_reply(text, self._voice)
        except SpeechError as error:
            return error_response(HTTPStatus.SERVICE_UNAVAILABLE, str(error))
        return Response(sound, media_type="audio/wav")

    async def mark(self, request: Request) -> Response:
        """POST /api/mark: marks what was said in a recording."""
        mark = await decode_body(request, Mark)
        if mark is None:
            return error_response(HTTPStatus.BAD_REQUEST, "send JSON with page, file and said")
        if not self._registry.is_driving_secret(mark.page):
            return error_response(HTTPStatus.CONFLICT, NOT_DRIVING)
        try:
            record = await self._marks.mark(mark.file, mark.said)
        except ConfigError as error:
            return error_response(HTTPStatus.BAD_REQUEST, str(error))
        except AudioError as error:
            return error_response(HTTPStatus.SERVICE_UNAVAILABLE, str(error))
        self._registry.broadcast(record)
        return JSONResponse(record)

    async def alarms(self, request: Request) -> Response:
        """POST /api/alarms: sets `false_alarms_per_hour` for the run."""
        alarms = await decode_body(request, Alarms)
        if alarms is None:
            return error_response(HTTPStatus.BAD_REQUEST, "send JSON with page and alarms")
        if not self._registry.is_driving_secret(alarms.page):
            return error_response(HTTPStatus.CONFLICT, NOT_DRIVING)
        try:
            self._false_alarms.set(alarms.alarms)
        except ConfigError as error:
            return error_response(HTTPStatus.BAD_REQUEST, str(error))
        return JSONResponse({"alarms": self._false_alarms.alarms})

    async def playback(self, request: Request) -> Response:
        """POST /api/sounding: the page plays something; once this is answered it may begin."""
        playing = await decode_body(request, Playing)
        if playing is None:
            return error_response(HTTPStatus.BAD_REQUEST, "send JSON with page and seconds")
        if not self._registry.is_driving_secret(playing.page):
            return error_response(HTTPStatus.CONFLICT, NOT_DRIVING)
        self._playback.start(playing.seconds)
        return JSONResponse({"seconds": playing.seconds})
