"""What is handed to a worker, and what comes back. Both are pickled on the way."""

from __future__ import annotations

from typing import TypeAlias

import msgspec

from voz.apps.batch.long_recordings import CutPlan, DecodedPart, RecordingPart
from voz.apps.batch.outcomes import Outcome
from voz.settings import Recognition


class SimulationOptions(msgspec.Struct, frozen=True):
    """How recordings drive.

    Attributes:
        folder: where the events and pictures go, beside each other.
        settings: all of them, as JSON: the safety rules, the commands, the room.
        listening: whether commands are obeyed before a `start speech`.
    """

    folder: str
    settings: bytes
    listening: bool = False


class WorkerSetup(msgspec.Struct, frozen=True):
    """What all workers are told once.

    Attributes:
        folder: the language files.
        settings: how speech becomes text.
        profile: the name of a speaker's.
        memory: how much more than to begin with a worker may need, bytes; None is no limit.
        fingerprint: of all that results hang on; a worker elsewhere that has another one refuses.
        base: the folder that paths are from, if workers may be in another one.
        driving: how the recordings drive a robot; None if they do not.
    """

    folder: str
    settings: Recognition
    profile: str | None = None
    memory: int | None = None
    fingerprint: str | None = None
    base: str = ""
    driving: SimulationOptions | None = None


class DecodeTask(msgspec.Struct, frozen=True):
    """Recordings to be decoded.

    Attributes:
        names: paths, or addresses with `://` in them.
        cut: whether long ones come back as they are, to be cut.
    """

    names: tuple[str, ...]
    cut: bool = False


class CutTask(msgspec.Struct, frozen=True):
    """A long recording, for which it is to be found where it can be cut."""

    name: str


class PartTask(msgspec.Struct, frozen=True):
    """A part of a long recording, to be decoded."""

    name: str
    part: RecordingPart


BatchTask: TypeAlias = DecodeTask | CutTask | PartTask

TaskResult: TypeAlias = tuple[Outcome | None, ...] | CutPlan | DecodedPart | None
"""Of files an outcome for each, None for one to be cut; of a cutting the plan, if there is one."""
