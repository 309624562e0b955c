"""Figures for groups of clips. Pure."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from typing import Literal, get_args

import jiwer
import msgspec

from voz.apps.evaluation.confusions import Confusion, confusions
from voz.apps.evaluation.results import Result, ScoredKind
from voz.apps.evaluation.statistics import AlarmRate, Estimate, alarm_rate, estimate
from voz.apps.recordings.manifest import BETWEEN_COMMANDS

GroupedBy = Literal["all", "condition", "snr", "noise", "speaker"]


class Group(msgspec.Struct, frozen=True):
    """Clips that are scored together."""

    set: str
    kind: ScoredKind
    by: GroupedBy  # what else they have in common; `all` is the whole set
    name: str  # of the condition, noise or speaker; empty for the whole set
    snr: float | None = None  # dB; None without added noise
    noise: str = ""  # empty for all of them, and without added noise


class CommandScores(msgspec.Struct, frozen=True):
    """Scores of recordings of commands, one or several in each."""

    group: Group
    clips: int
    speakers: int
    right: Estimate  # share of clips in which exactly what was said was heard
    right_and_accepted: Estimate  # share of clips
    word_error_rate: Estimate  # wrong, missing and extra words for each word said
    refused: Estimate  # share of clips in which all that was heard was refused
    wrongly_obeyed: Estimate  # share of clips
    cpu_ms: float  # mean processor time for each clip, ms


class NearMissScores(msgspec.Struct, frozen=True):
    """Scores of speech that is no command, a phrase in each clip."""

    group: Group
    clips: int
    speakers: int
    let_through: Estimate  # share of clips


class AlarmScores(msgspec.Struct, frozen=True):
    """Scores of sound that goes on: running speech, noise, or what is between commands."""

    group: Group
    rate: AlarmRate
    commands: dict[str, int] = {}  # what was obeyed and how often, the most frequent first


class Scores(msgspec.Struct, frozen=True):
    """All figures of an evaluation; what the curves show is in `curves`."""

    commands: list[CommandScores]
    near_misses: list[NearMissScores]
    alarms: list[AlarmScores]
    confusions: list[Confusion] = []  # of all sets together


def score(results: Iterable[Result]) -> Scores:
    """Score each set, condition, speaker, noise and ratio; clips with an error are left out."""
    readable = [result for result in results if result.error is None]
    groups = grouped(readable)
    scores = Scores([], [], [], confusions(readable))
    for group, members in groups.items():
        if group.kind in ("command", "long"):
            scores.commands.append(score_commands(group, members))
        elif group.kind == "near-miss":
            scores.near_misses.append(score_near_misses(group, members))
        else:
            obeyed = Counter(text for result in members for text in result.obeyed)
            commands = dict(obeyed.most_common())
            scores.alarms.append(AlarmScores(group, alarms_in(members), commands))
    return scores


def grouped(results: Sequence[Result]) -> dict[Group, list[Result]]:
    """Group results by set and kind, and within them by condition, noise and speaker.

    They are in the order of a table: each set as a whole, then its parts. A condition or a speaker
    that would be all of its set is left out, and so are those of clips in noise.
    """
    groups: dict[Group, list[Result]] = {}
    for result in results:
        for group in _groups_of(result):
            groups.setdefault(group, []).append(result)
    wholes = {(g.set, g.kind): len(members) for g, members in groups.items() if g.by == "all"}
    sets = list(dict.fromkeys(group.set for group in groups))

    def place(group: Group) -> tuple[int, str, int, str, float, str]:
        by = get_args(GroupedBy).index(group.by)
        return sets.index(group.set), group.kind, by, group.noise, -(group.snr or 0), group.name

    return {
        group: groups[group]
        for group in sorted(groups, key=place)
        if group.by in ("all", "snr", "noise") or len(groups[group]) < wholes[group.set, group.kind]
    }


def score_commands(group: Group, results: Sequence[Result]) -> CommandScores:
    """Score commands; there is at least one."""
    words = [len(_words_said(result)) for result in results]
    return CommandScores(
        group=group,
        clips=len(results),
        speakers=_speakers(results),
        right=_share(results, lambda r: r.is_right),
        right_and_accepted=_share(results, lambda r: r.is_right_and_accepted),
        word_error_rate=estimate([word_errors(r) for r in results], words, _who(results)),
        refused=_share(results, lambda r: r.is_refused),
        wrongly_obeyed=_share(results, lambda r: r.is_wrongly_obeyed),
        cpu_ms=round(1000 * sum(r.cpu for r in results) / len(results), 2),
    )


def score_near_misses(group: Group, results: Sequence[Result]) -> NearMissScores:
    """Score speech that is no command; there is at least one clip."""
    let_through = _share(results, lambda r: bool(r.obeyed))
    return NearMissScores(group, len(results), _speakers(results), let_through)


def alarms_in(results: Iterable[Result]) -> AlarmRate:
    """Count what would be obeyed in sound that should move nothing; it is longer than 0 s."""
    counted = [(len(result.obeyed), result.seconds) for result in results]
    return alarm_rate(
        sum(alarms for alarms, _ in counted), sum(seconds for _, seconds in counted) / 3600
    )


def word_errors(result: Result) -> int:
    """Count the words that are wrong, missing or extra in what was heard."""
    heard = " ".join(result.texts)
    counted = jiwer.process_words(" ".join(_words_said(result)), heard)
    return int(counted.substitutions + counted.deletions + counted.insertions)


def _groups_of(result: Result) -> list[Group]:
    if result.snr is not None:
        decibels = f"{result.snr:g} dB"
        named = f"{result.noise}, {decibels}"
        return [
            Group(result.set, result.kind, "snr", decibels, result.snr),
            Group(result.set, result.kind, "noise", named, result.snr, result.noise),
        ]
    return [
        Group(result.set, result.kind, "all", ""),
        Group(result.set, result.kind, "condition", result.condition),
        Group(result.set, result.kind, "speaker", result.speaker),
    ]


def _share(results: Sequence[Result], holds: Callable[[Result], bool]) -> Estimate:
    return estimate([holds(r) for r in results], [1] * len(results), _who(results))


def _who(results: Sequence[Result]) -> list[str]:
    return [result.speaker for result in results]


def _speakers(results: Sequence[Result]) -> int:
    return len(set(_who(results)))


def _words_said(result: Result) -> list[str]:
    return result.text.replace(BETWEEN_COMMANDS, " ").split()
