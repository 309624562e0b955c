"""Lets each recording drive the simulated robot; keeps its events, and a picture of its way.

No program is started, nothing is published and nothing said.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from functools import cache, partial
from pathlib import Path

import msgspec
from msgspec.structs import replace

from voz.apps.batch.locations import EVENTS_ENDING, LocalRecording, file_name_for
from voz.apps.batch.outcomes import ErrorRow, Outcome, Row, make_outcome, utterance_row
from voz.apps.batch.worker import SimulationOptions
from voz.config import Config
from voz.errors import ConfigError
from voz.events import Event, Notice, Utterance, to_json
from voz.files import atomic_write, os_errors_as_config_error, shown_path
from voz.recognition.engine import RecognitionEngine
from voz.recognition.interpreter import NO_DETAILS, Details
from voz.robot.simulation.pictures import check_picture, save_picture
from voz.robot.simulation.simulator import SimulatedRobot
from voz.run.clocks import Item, RecordedClock
from voz.run.controller import controller_by
from voz.run.parts import hear_answers
from voz.run.session import Session
from voz.run.sources import recorded_items
from voz.run.spec import RunSpec

PICTURE_ENDING = ".png"


def simulation_options(
    folder: Path, settings: Config, listening: bool, pictures: bool
) -> SimulationOptions:
    """Prepare the folder for the events and pictures.

    Raises:
        ConfigError: the folder cannot be made, or a drawing library is missing.
    """
    with os_errors_as_config_error(folder):
        folder.mkdir(parents=True, exist_ok=True)
    if pictures:
        check_picture(folder / f"way{PICTURE_ENDING}")
    encoded = msgspec.json.encode(settings)
    return SimulationOptions(str(folder.resolve()), encoded, listening, pictures)


def simulate_recording(
    recognizer: RecognitionEngine,
    found: LocalRecording,
    how: SimulationOptions,
    details: Details = NO_DETAILS,
) -> Outcome:
    """Let one recording drive the simulated robot, and keep its events, and a picture if asked.

    Raises:
        ConfigError: they cannot be written.
    """
    begun, settings = time.process_time(), _settings(how.settings)
    events: list[Event] = []
    unreadable: list[str] = []
    times: list[float] = []
    items = _noted(recorded_items([found.path], recognizer, unreadable, details), times)
    spec = RunSpec(
        controller=controller_by(settings, how.listening),
        settings=settings,
        clock=lambda _: RecordedClock(items),
        in_real_time=False,
        parts=[partial(hear_answers, recognizer=recognizer)],
    )
    session = Session(spec)
    robot = SimulatedRobot(settings.simulator, session.report)
    session.receivers += [robot.receive, lambda event: events.append(_named(event, found.name))]
    session.controller.odometry = robot.place
    session.run()
    robot.come_to_rest()
    _keep(robot, events, Path(how.folder, file_name_for(found.name)), how.pictures)
    rows: list[Row] = [utterance_row(e, found.name) for e in events if isinstance(e, Utterance)]
    rows += [ErrorRow(found.name, error) for error in unreadable]
    outcome = make_outcome(found.name, tuple(rows), times[0], time.process_time() - begun)
    return replace(outcome, warnings=tuple(_warnings(events, found.path, unreadable)))


def _keep(robot: SimulatedRobot, events: list[Event], path: Path, pictures: bool) -> None:
    written = path.with_name(path.name + EVENTS_ENDING)
    with os_errors_as_config_error(written), atomic_write(written) as file:
        file.writelines(f"{to_json(event)}\n" for event in events)
    if pictures:
        save_picture(robot.trip(), path.with_name(path.name + PICTURE_ENDING))


def _warnings(events: list[Event], path: Path, errors: list[str]) -> Iterator[str]:
    """What was said of the recording itself."""
    texts = (event.text for event in events if isinstance(event, Notice))
    return (
        text for text in texts if text.startswith(f"{shown_path(path)}: ") and text not in errors
    )


def _named(event: Event, name: str) -> Event:
    return replace(event, source=name) if isinstance(event, Utterance) else event


def _noted(items: Iterator[Item], times: list[float]) -> Iterator[Item]:
    """Note all times: first the end of the recording, then that of its last command."""
    for item in items:
        if isinstance(item, float):
            times.append(item)
        yield item


@cache
def _settings(settings: bytes) -> Config:
    try:
        return msgspec.json.decode(settings, type=Config)
    except msgspec.MsgspecError as error:
        raise ConfigError(
            f"a worker has another voz ({error}); install the same on all machines"
        ) from error
