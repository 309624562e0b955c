"""The addresses for what is played, for what was really said, and for how sure voz is to be."""

from __future__ import annotations

import asyncio
from http import HTTPStatus

from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import BaseRoute, Route

from voz.apps.web.answers import decoded_body, refused
from voz.apps.web.desk import Desk
from voz.apps.web.dial import Dial
from voz.apps.web.marking import Marking
from voz.apps.web.messages import Alarms, Mark, Playing
from voz.apps.web.replies import spoken
from voz.apps.web.sounding import Sounding
from voz.errors import AudioError, ConfigError, SpeechError

NOT_DRIVING = "only the page that drives may do that: take the wheel first"


class TuningApi:
    """Answers what is asked about recordings, replies and false alarms."""

    def __init__(
        self, desk: Desk, marking: Marking, dial: Dial, sounding: Sounding, voice: str
    ) -> None:
        """Prepare to answer.

        Args:
            desk: knows who drives.
            marking: knows the recordings.
            dial: sets how many false alarms there may be.
            sounding: told of what the page plays.
            voice: of the replies.
        """
        self._desk = desk
        self._marking = marking
        self._dial = dial
        self._sounding = sounding
        self._voice = voice

    def routes(self) -> list[BaseRoute]:
        """Its addresses."""
        return [
            Route("/api/recordings/{file}", self.recording),
            Route("/api/reply", self.reply),
            Route("/api/mark", self.mark, methods=["POST"]),
            Route("/api/alarms", self.alarms, methods=["POST"]),
            Route("/api/sounding", self.sounds, methods=["POST"]),
        ]

    async def recording(self, request: Request) -> Response:
        """GET /api/recordings/FILE: the sound of an utterance of this run."""
        path = self._marking.path(request.path_params["file"])
        try:
            sound = await asyncio.to_thread(path.read_bytes) if path else None
        except OSError:
            sound = None
        if sound is None:
            return refused(HTTPStatus.NOT_FOUND, "that recording is not there any more")
        return Response(sound, media_type="audio/flac")

    async def reply(self, request: Request) -> Response:
        """GET /api/reply?text=TEXT: the sound of what the robot said a moment ago."""
        text = request.query_params.get("text", "")
        if not self._desk.has_said(text):  # nobody lets it render anything else
            return refused(HTTPStatus.NOT_FOUND, "the robot has not said that just now")
        try:
            sound = await spoken(text, self._voice)
        except SpeechError as error:
            return refused(HTTPStatus.SERVICE_UNAVAILABLE, str(error))
        return Response(sound, media_type="audio/wav")

    async def mark(self, request: Request) -> Response:
        """POST /api/mark: what was really said in a recording."""
        mark = await decoded_body(request, Mark)
        if mark is None:
            return refused(HTTPStatus.BAD_REQUEST, "send JSON with page, file and said")
        if not self._desk.driven_by(mark.page):
            return refused(HTTPStatus.CONFLICT, NOT_DRIVING)
        try:
            record = await self._marking.mark(mark.file, mark.said)
        except ConfigError as error:
            return refused(HTTPStatus.BAD_REQUEST, str(error))
        except AudioError as error:
            return refused(HTTPStatus.SERVICE_UNAVAILABLE, str(error))
        self._desk.tell(record)
        return JSONResponse(record)

    async def alarms(self, request: Request) -> Response:
        """POST /api/alarms: how many false alarms there may be in an hour, for the run."""
        alarms = await decoded_body(request, Alarms)
        if alarms is None:
            return refused(HTTPStatus.BAD_REQUEST, "send JSON with page and alarms")
        if not self._desk.driven_by(alarms.page):
            return refused(HTTPStatus.CONFLICT, NOT_DRIVING)
        try:
            self._dial.turn(alarms.alarms)
        except ConfigError as error:
            return refused(HTTPStatus.BAD_REQUEST, str(error))
        return JSONResponse({"alarms": self._dial.alarms})

    async def sounds(self, request: Request) -> Response:
        """POST /api/sounding: the page plays something; once this is answered it may begin."""
        sounds = await decoded_body(request, Playing)
        if sounds is None:
            return refused(HTTPStatus.BAD_REQUEST, "send JSON with page and seconds")
        if not self._desk.driven_by(sounds.page):
            return refused(HTTPStatus.CONFLICT, NOT_DRIVING)
        self._sounding.begin(sounds.seconds)
        return JSONResponse({"seconds": sounds.seconds})
