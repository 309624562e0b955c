"""Figures for groups of clips, what was misheard, and the comparison of two evaluations. Pure."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from typing import Literal, get_args

import jiwer
import msgspec
from msgspec.structs import replace

from voz.apps.evaluation.results import OUT_OF_NOTHING, Result, ScoredKind, Understood
from voz.apps.evaluation.statistics import AlarmRate, Estimate, alarm_rate, estimate, mcnemar
from voz.apps.recordings.manifest import BETWEEN_COMMANDS
from voz.language.sentences.command_set import Commands
from voz.recognition.confidence import Model, alarm_rates_near
from voz.recognition.decision import DecisionRule
from voz.recognition.thresholds import thresholds_of
from voz.settings import Recognition

REFUSED = "refused"
NOT_HEARD = "not heard"


class Confusion(msgspec.Struct, frozen=True):
    """A command that was misheard."""

    said: str
    heard: str  # what would be obeyed instead; empty if nothing would
    outcome: str  # `as COMMAND`, `more than once`, `refused`, or `not heard`
    speakers: dict[str, int]  # clips by speaker, the one with the most first

    @property
    def clips(self) -> int:
        """How many clips of all speakers."""
        return sum(self.speakers.values())


def confusions(results: Iterable[Result]) -> list[Confusion]:
    """Count the misheard commands, the most frequent first; clips of several are left out."""
    counted: dict[tuple[str, str, str], Counter[str]] = {}
    for result in results:
        if result.kind == "command" and not result.is_right_and_accepted:
            for heard, outcome in _outcomes(result):
                found = counted.setdefault((result.text, heard, outcome), Counter())
                found[result.speaker] += 1
    rows = [Confusion(*key, dict(of.most_common())) for key, of in counted.items()]
    return sorted(rows, key=lambda row: (-row.clips, row.said, row.outcome))


def _outcomes(result: Result) -> list[tuple[str, str]]:
    """What became of a misheard command; if it was obeyed too, what was obeyed besides."""
    wrong = [text for text in dict.fromkeys(result.obeyed) if text != result.text]
    if wrong:
        return [(text, f"as {text}") for text in wrong]
    if result.obeyed:
        return [(result.text, "more than once")]
    return [("", REFUSED if result.texts else NOT_HEARD)]


class OperatingPoint(msgspec.Struct, frozen=True):
    """One rate of false alarms that may be asked for, and what it costs."""

    false_alarms_per_hour: float  # the setting
    threshold: float  # that most commands need
    missed: float | None  # share of the commands not right and accepted; None without any
    let_through: float | None  # share of the near-misses obeyed; None without any
    talk: AlarmRate | None  # false alarms in talk; None without any


def operating_points(
    results: Iterable[Result], model: Model, settings: Recognition, commands: Commands
) -> list[OperatingPoint]:
    """Compute what would be obeyed at several rates of false alarms, by the thresholds of a model.

    Results are what voz itself made of clips; those in added noise are left out.
    """
    clean = [r for r in results if r.snr is None and r.error is None]
    found = []
    for alarms in alarm_rates_near(model.default_alarm_rate):
        asked = replace(settings, threshold=None, false_alarms_per_hour=alarms)
        rule = DecisionRule(commands, model, asked)
        judged = [replace(r, heard=tuple(_judged(u, rule) for u in r.heard)) for r in clean]
        found.append(_operating_point(alarms, thresholds_of(model, asked).usual, judged))
    return found


def _judged(heard: Understood, rule: DecisionRule) -> Understood:
    return replace(heard, accepted=rule.accepts(heard.text, heard.confidence))


def _operating_point(alarms: float, threshold: float, results: Sequence[Result]) -> OperatingPoint:
    commands = [not r.is_right_and_accepted for r in results if r.kind == "command"]
    near_misses = [bool(r.obeyed) for r in results if r.kind == "near-miss"]
    talk = [r for r in results if r.kind == "talk"]
    return OperatingPoint(
        alarms,
        round(threshold, 3),
        _mean(commands),
        _mean(near_misses),
        alarms_in(talk) if talk else None,
    )


def _mean(values: Sequence[bool]) -> float | None:
    return round(sum(values) / len(values), 4) if values else None


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


class Difference(msgspec.Struct, frozen=True):
    """A set of commands, heard in two ways."""

    set: str
    snr: float | None  # dB; None without added noise
    clips: int  # heard in both
    this: float  # share right and accepted here
    other: float  # the same in the other evaluation
    only_this: int  # clips right and accepted only here
    only_other: int  # clips right and accepted only there
    p: float  # of McNemar's exact test


class AlarmDifference(msgspec.Struct, frozen=True):
    """Sound that should move nothing, heard in two ways."""

    set: str
    kind: ScoredKind
    snr: float | None  # dB; None without added noise
    this: AlarmRate
    other: AlarmRate


def compare(these: Iterable[Result], others: Iterable[Result]) -> list[Difference]:
    """Compare two evaluations by the commands that both have heard.

    Clips are the same if set, file and noise have the same names, wherever the files are.
    """
    pairs: dict[tuple[str, float | None], list[tuple[bool, bool]]] = {}
    for result, other in _pairs(these, others, ("command",)):
        both = (result.is_right_and_accepted, other.is_right_and_accepted)
        pairs.setdefault((result.set, result.snr), []).append(both)
    return [_difference(name, snr, outcomes) for (name, snr), outcomes in pairs.items()]


def compare_alarms(these: Iterable[Result], others: Iterable[Result]) -> list[AlarmDifference]:
    """Compare two evaluations by the false alarms in the sound that both have heard."""
    pairs: dict[tuple[str, ScoredKind, float | None], list[tuple[Result, Result]]] = {}
    for result, other in _pairs(these, others, ("talk", "noise", OUT_OF_NOTHING)):
        pairs.setdefault((result.set, result.kind, result.snr), []).append((result, other))
    return [
        AlarmDifference(*group, alarms_in(r for r, _ in pair), alarms_in(o for _, o in pair))
        for group, pair in pairs.items()
    ]


def _difference(name: str, snr: float | None, outcomes: list[tuple[bool, bool]]) -> Difference:
    only_this, only_other = outcomes.count((True, False)), outcomes.count((False, True))
    return Difference(
        set=name,
        snr=snr,
        clips=len(outcomes),
        this=round(sum(this for this, _ in outcomes) / len(outcomes), 5),
        other=round(sum(other for _, other in outcomes) / len(outcomes), 5),
        only_this=only_this,
        only_other=only_other,
        p=mcnemar(only_this, only_other),
    )


def _pairs(
    these: Iterable[Result], others: Iterable[Result], kinds: Collection[str]
) -> Iterator[tuple[Result, Result]]:
    there = {_key(result): result for result in others if result.error is None}
    for result in these:
        other = there.get(_key(result))
        if result.kind in kinds and result.error is None and other:
            yield result, other


def _key(result: Result) -> tuple[object, ...]:
    clip = (result.set, result.file, result.kind, result.start)
    return *clip, result.snr, result.noise
