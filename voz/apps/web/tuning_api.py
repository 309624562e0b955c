"""The HTTP requests for recordings and what was said in them, replies, and false alarms."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
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

from voz.apps.recordings.recorder import Recorder
from voz.apps.web.control_api import decode_body
from voz.apps.web.page_messages import Alarms, Mark, Playing, Record
from voz.apps.web.page_registry import PageRegistry
from voz.apps.web.page_sound import PagePlayback, PageReply
from voz.audio.sound_files import read_samples
from voz.errors import AudioError, ConfigError, SpeechError
from voz.files import read_bytes
from voz.language.sentences.command_set import Commands
from voz.language.sentences.spelling import normalize
from voz.recognition.confidence import MissRate, miss_rate_at
from voz.recognition.engine import RecognitionEngine, confidence_model
from voz.settings import Recognition
from voz.speech.synthesis import cached_speech

MAX_MARKABLE = 100
"""Recordings that can be played and marked: more than pages show."""

MARK_TIMEOUT = 2.0
"""For the disk to take a mark, s."""


class RecordingMarks:
    """The utterances of this run that have a recording; marks correct what was said in it."""

    def __init__(self, recorder: Recorder | None, commands: Callable[[], Commands]) -> None:
        """Begin with no recording; `recorder` is None if nothing is recorded."""
        self._recorder = recorder
        self._commands = commands
        self._known: dict[str, Record] = {}

    @property
    def note(self) -> str | None:
        """The recorder's status line; empty if it has failed, None if nothing is recorded."""
        return self._recorder.note if self._recorder else None

    @property
    def known(self) -> list[Record]:
        """The last recordings."""
        return list(self._known.values())

    def take_new(self) -> list[Record]:
        """Return the recordings made since the last call."""
        kept = self._recorder.kept if self._recorder else ()
        new = []
        while kept:
            start, file = kept.popleft()
            new.append({"type": "recording", "start": start, "file": file})
            self._known[file] = new[-1]
        while len(self._known) > MAX_MARKABLE:
            del self._known[next(iter(self._known))]
        return new

    def path(self, file: str) -> Path | None:
        """Where a recording is; None if it is none of this run."""
        return self._recorder.folder / file if self._recorder and file in self._known else None

    async def mark(self, file: str, said: str | None) -> Record:
        """Write into the manifest what was really said in a recording, None for no command.

        Returns:
            The recording's record with the mark, for all pages.

        Raises:
            ConfigError: there is no such command.
            AudioError: there is no such recording, or it cannot be marked.
        """
        if self._recorder is None or file not in self._known:
            raise AudioError("that recording is not there any more")
        parse = self._commands().parse(normalize(said)) if said is not None else None
        if said is not None and parse is None:
            raise ConfigError(f'"{said}" is no command: choose one of the list')
        text = parse.text if parse else ""
        done = self._recorder.correct(file, text, "command" if parse else "near-miss")
        try:
            await asyncio.wait_for(asyncio.wrap_future(done), MARK_TIMEOUT)
        except asyncio.TimeoutError:
            raise AudioError("the disk does not answer: the mark may be lost") from None
        except (OSError, UnicodeDecodeError) as error:
            raise AudioError(f"{self._recorder.folder}: cannot be written ({error})") from None
        self._known[file] = {**self._known[file], "said": text}
        return self._known[file]


class FalseAlarmSetting:
    """Sets `false_alarms_per_hour` of a recognizer for the run. Event-loop thread only."""

    def __init__(
        self, recognizer: RecognitionEngine, settings: Recognition, report: Callable[[str], None]
    ) -> None:
        """Begin with the value of the settings; `report` reports each change."""
        self._recognizer = recognizer
        self._settings = settings
        self._report = report
        self._first = (
            settings.false_alarms_per_hour or confidence_model(recognizer).default_alarm_rate
        )
        self.alarms = self._first

    @property
    def problem(self) -> str | None:
        """Why it cannot be set; None if it can."""
        if self._settings.threshold is not None:
            return "a threshold is set in its place: leave it out of voz.toml and the command line"
        if not self._costs:
            return (
                f"{self._settings.confidence} does not say how many commands are missed: make it "
                "again with `voz fit-confidence`"
            )
        return None

    def choices(self) -> Record:
        """The values that it may have, each with the share of commands that is missed."""
        costs = {cost.alarms: cost.missed for cost in self._costs}
        known = miss_rate_at(self._costs, self._first)
        stops = {**costs, **({} if known is None else {self._first: round(known, 4)})}
        return {"stops": sorted(stops.items()), "problem": self.problem}

    def set(self, alarms: float) -> None:
        """Allow so many false alarms per hour, from the next utterance on.

        Raises:
            ConfigError: it cannot be set, or not to this value.
        """
        if self.problem:
            raise ConfigError(self.problem)
        if miss_rate_at(self._costs, alarms) is None:
            lowest, highest = self._costs[0].alarms, self._costs[-1].alarms
            raise ConfigError(f"choose false alarms per hour from {lowest:g} to {highest:g}")
        if alarms != self.alarms:
            self._recognizer.set_false_alarm_rate(alarms)
            self.alarms = alarms
            self._report(f"false_alarms_per_hour is {alarms:g} from now on, for this run")

    @property
    def _costs(self) -> tuple[MissRate, ...]:
        return confidence_model(self._recognizer).costs


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
    samples: npt.NDArray[np.float32] = read_samples(path) / np.float32(32768)
    return samples
