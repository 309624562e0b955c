"""Tasks for workers and their results. Both are pickled."""

from __future__ import annotations

from typing import TypeAlias

import msgspec

from voz.apps.batch.long_recordings import CutPlan, DecodedPart, RecordingPart
from voz.apps.batch.outcomes import Outcome
from voz.recognition.interpreter import NO_DETAILS, Details
from voz.settings import Recognition


class SimulationOptions(msgspec.Struct, frozen=True):
    """How recordings drive."""

    folder: str  # for the events and pictures
    settings: bytes  # all of them, as JSON
    listening: bool = False  # whether commands are obeyed before a `start speech`
    pictures: bool = False  # whether the ways are drawn


class WorkerSetup(msgspec.Struct, frozen=True):
    """What all workers are told once."""

    folder: str  # the language files
    settings: Recognition
    profile: str | None = None  # the name of a speaker's
    memory: int | None = None  # that a worker may need besides the models, bytes; None is no limit
    fingerprint: str | None = None  # a worker with another one refuses
    base: str = ""  # the folder that paths are relative to, on a cluster
    simulation: SimulationOptions | None = None  # None if recordings drive no robot
    details: Details = NO_DETAILS  # what rows have besides


class DecodeTask(msgspec.Struct, frozen=True):
    """Recordings to be decoded."""

    names: tuple[str, ...]  # paths and addresses
    cut: bool = False  # whether long ones come back as None, to be cut


class CutTask(msgspec.Struct, frozen=True):
    """Find where a long recording can be cut."""

    name: str


class PartTask(msgspec.Struct, frozen=True):
    """Decode a part of a long recording."""

    name: str
    part: RecordingPart


BatchTask: TypeAlias = DecodeTask | CutTask | PartTask

TaskResult: TypeAlias = tuple[Outcome | None, ...] | CutPlan | DecodedPart | None
"""Of files an outcome for each, None for one to be cut; of a cutting the plan, if there is one."""
