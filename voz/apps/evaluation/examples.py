"""Labeled utterances, from which the confidence is fitted."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, partial

from msgspec.structs import replace

from voz.apps.evaluation.recognize import Task, in_processes, tasks_for
from voz.apps.evaluation.stretches import assign_to_stretches
from voz.apps.recordings.manifest import Clip
from voz.audio import SAMPLE_RATE
from voz.audio.sound_files import read_blocks
from voz.errors import AudioError, ConfigError
from voz.language.language_files import find_language
from voz.recognition.confidence import Context
from voz.recognition.engine import RecognitionEngine, candidates_in
from voz.settings import Recognition

TOO_LITTLE_TALK = (
    "the manifests need more recordings of the kind talk, half an hour or so, to tell how often it "
    "sounds like a command"
)


@dataclass(frozen=True)
class RecordingExamples:
    """What is in a recording; nothing if it cannot be read."""

    examples: list[Example]  # with the network
    alone: list[Example]  # by pocketsphinx alone
    talk: float  # s
    commands: list[Clip]  # those that are said in it


@dataclass(frozen=True)
class Example:
    """What is known of one utterance."""

    clip: Clip
    text: str  # the command that was heard
    values: dict[str, float]  # its features
    trust: float  # in its being speech, 0 to 1
    context: Context
    right: bool  # whether it is what was said


def collect_examples(
    clips: Sequence[Clip], lm: str | None, processes: int | None
) -> Iterator[RecordingExamples]:
    """Recognize recordings and stretches of streams; yields the examples of each, in order.

    `lm` is the folder of the language files; `processes` None is one on each core.
    """
    tasks = tasks_for(clips, [], [], room=False)
    return in_processes(partial(_examples, lm=lm), tasks, processes)


def describe_set(clips: Iterable[Clip], name: str) -> str:
    """Count the recordings of each kind and the speakers of a set, in one line."""
    chosen = [clip for clip in clips if clip.set == name]
    kinds = Counter(clip.kind for clip in chosen)
    counts = ", ".join(f"{number} {kind}" for kind, number in sorted(kinds.items()))
    return f"{name}: {counts}; {len({clip.speaker for clip in chosen})} speakers"


def check_talk(clips: Iterable[Clip]) -> None:
    """Raise ConfigError if no recording is talk, before minutes of work."""
    if not any(clip.kind == "talk" for clip in clips):
        raise ConfigError(TOO_LITTLE_TALK)


@cache
def _recognizer(lm: str | None, network: bool) -> RecognitionEngine:
    return RecognitionEngine(find_language(lm), Recognition(use_network=network))


def _examples(task: Task, lm: str | None) -> RecordingExamples:
    """Recognize a recording; what is heard around the stretches of a stream counts as noise."""
    first = task.clips[0]
    try:
        blocks = list(read_blocks(first.path))
    except AudioError:
        return RecordingExamples([], [], 0.0, [])
    seconds = sum(map(len, blocks)) / SAMPLE_RATE
    stretches = [(clip.start or 0.0, clip.end or seconds) for clip in task.clips]
    surroundings = replace(first, kind="noise", speaker=first.file, condition="all")

    def heard(network: bool) -> list[Example]:
        found = list(candidates_in(_recognizer(lm, network), blocks))
        parts, rest = assign_to_stretches(found, stretches)
        return [
            Example(
                clip, o.text, o.features, o.speech_probability, o.context, _is_said(clip, o.text)
            )
            for clip, part in zip((*task.clips, surroundings), (*parts, rest), strict=True)
            for o in part
        ]

    talk = sum(b - a for c, (a, b) in zip(task.clips, stretches, strict=True) if c.kind == "talk")
    commands = [clip for clip in task.clips if clip.kind == "command"]
    return RecordingExamples(heard(network=True), heard(network=False), talk, commands)


def _is_said(clip: Clip, text: str) -> bool:
    return clip.kind == "command" and clip.text == text
