"""The confidence is fitted on labeled recordings, and judged on other speakers."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest
from language.template_texts import commands_of
from msgspec.structs import replace
from recordings import FIXTURES

from voz.apps.evaluation.fit_confidence import (
    Example,
    RecordingExamples,
    acceptance,
    check_talk,
    collect_examples,
    cross_validated,
    describe_set,
    fit,
    fit_models,
    with_alarms,
    with_costs,
)
from voz.apps.recordings.manifest import Clip, read_manifest
from voz.errors import ConfigError
from voz.language.language_files import find_language, read_commands
from voz.language.sentences.command_set import plain_commands
from voz.recognition.confidence import (
    NETWORK_FEATURES,
    POCKETSPHINX_FEATURES,
    VOICES_AROUND,
    Context,
    load_models,
    probability,
    save_models,
)


def test_a_set_is_described_by_its_kinds_and_speakers() -> None:
    clips = read_manifest(FIXTURES / "manifest.tsv")
    kinds = {clip.kind for clip in clips}
    said = describe_set(clips, clips[0].set)
    assert all(f" {kind}" in said for kind in kinds)
    assert said.endswith(f"; {len({clip.speaker for clip in clips})} speakers")


def test_recordings_without_talk_are_refused_before_they_are_recognized() -> None:
    clips = [c for c in read_manifest(FIXTURES / "manifest.tsv") if c.kind != "talk"]
    with pytest.raises(ConfigError, match="of the kind talk, half an hour or so"):
        check_talk(clips)
    check_talk([*clips, replace(clips[0], kind="talk")])


def test_in_a_stream_everything_belongs_to_what_was_said_there(tmp_path: Path) -> None:
    session = FIXTURES / "long" / "session.wav"
    said = Clip("lab", "session.wav", session, "start speech", "me", "command", "all", 0.5, 2.0)
    other = replace(said, text="", kind="near-miss", start=2.5, end=4.0)
    (collected,) = collect_examples([said, other], None, 1)
    for examples in (collected.examples, collected.alone):
        kinds = [(e.clip.kind, e.text, e.right) for e in examples]
        assert kinds[:2] == [("command", "start speech", True), ("near-miss", "go forward", False)]
        assert {kind for kind, _, _ in kinds[2:]} == {"noise"}
    assert collected.talk == 0


MODEL = load_models().with_network
NAMES = ("match", "nothing")


def clip(number: int, kind: str = "command") -> Clip:
    return Clip(
        set="lab",
        file=f"{number}.wav",
        path=Path(f"{number}.wav"),
        text="stop",
        speaker=f"speaker {number % 10}",
        kind=kind,  # type: ignore[arg-type]
        condition="all",
    )


def example(
    clip: Clip,
    features: dict[str, float],
    right: bool,
    speech_probability: float = 1.0,
    context: Context = Context.QUIET,
) -> Example:
    return Example(clip, "go back", features, speech_probability, context, right)


def examples(count: int = 600) -> list[Example]:
    """Right with the probability that a match of so much has: 1 / (1 + exp(-2 match))."""
    chance = np.random.default_rng(0)
    match = chance.normal(0, 1.5, count)
    right = chance.random(count) < 1 / (1 + np.exp(-2 * match))
    return [
        example(clip(i), {"match": float(m), "nothing": float(chance.normal())}, bool(r))
        for i, (m, r) in enumerate(zip(match, right, strict=True))
    ]


def test_it_finds_the_weights_that_the_examples_were_made_with() -> None:
    model = fit(examples(5000), ["made up"], NAMES)
    assert model.fitted_on == ["made up"]
    assert model.weights["match"] == pytest.approx(2, abs=0.2)
    assert model.weights["nothing"] == pytest.approx(0, abs=0.1)


def test_the_share_of_near_misses_among_the_examples_does_not_matter() -> None:
    some = examples(5000)
    fewer = [e for i, e in enumerate(some) if e.right or i % 3 == 0]
    for match in (-2.0, 0.0, 1.0):
        values = {"match": match, "nothing": 0.0}
        one, other = (probability(fit(these, [], NAMES), values) for these in (some, fewer))
        assert one == pytest.approx(other, abs=0.03)


def test_what_is_no_speech_is_not_fitted_on_and_never_likely() -> None:
    some = examples()
    noise = [
        example(clip(i, "noise"), {"match": 9.0, "nothing": 0.0}, False, speech_probability=0.0)
        for i in range(99)
    ]
    assert fit(some + noise, [], NAMES) == fit(some, [], NAMES)
    assert cross_validated(some + noise, NAMES)[-99:] == [0.0] * 99


def talk(odds: Iterable[float], text: str = "go back") -> tuple[list[Example], list[float]]:
    heard = [
        dataclasses.replace(example(replace(clip(i, "talk"), text=""), {}, False), text=text)
        for i, _ in enumerate(odds)
    ]
    return heard, [1 / (1 + math.exp(-one)) for one in odds]


def test_talk_tells_how_many_false_alarms_there_are() -> None:
    """Of an hour's talk, the k likeliest has odds of at least 1 / k."""
    odds = [-math.log(rank) for rank in range(1, 200)]  # one alarm at even odds, two at half
    model = with_alarms(MODEL, *talk(odds), hours=1.0)
    assert model.alarm_exponent == pytest.approx(1, rel=0.35)
    assert model.alarms == pytest.approx(6 / 5, rel=0.5)
    twice = with_alarms(MODEL, *talk(odds), hours=2.0)
    assert twice.alarms == pytest.approx(model.alarms / 2, rel=1e-3)


def test_talk_in_which_the_command_was_said_is_no_false_alarm() -> None:
    odds = [-math.log(rank) for rank in range(1, 200)]
    heard, likely = talk(odds, "stop")
    stopped = replace(heard[0].clip, text="and there it stopped for a moment")
    likeliest = dataclasses.replace(heard[0], clip=stopped)
    without = with_alarms(MODEL, heard[1:], likely[1:], hours=1.0)
    assert with_alarms(MODEL, [likeliest, *heard[1:]], likely, hours=1.0) == without


def test_too_little_talk_is_one_clear_line() -> None:
    with pytest.raises(ConfigError, match="more recordings of the kind talk"):
        with_alarms(MODEL, examples(), [0.9] * 600, hours=1.0)


def test_talk_in_which_commands_are_said_is_one_line_that_names_it() -> None:
    for surest in ([9.0] * 6, [9.1, 9.1, 9.1, 9.1, 9.1, 9.0], [-1.0] * 6):
        heard, likely = talk([*surest, *[-3.0] * 100], "stop")
        with pytest.raises(ConfigError, match=r'"stop" in 0.wav, "stop" in 1.wav.*give the texts'):
            with_alarms(MODEL, heard, likely, hours=1.0)


def test_other_speech_around_it_makes_an_utterance_unlikely() -> None:
    some = examples()
    amid = [dataclasses.replace(e, context=Context.SPEECH) for e in some]
    pairs = zip(cross_validated(some, NAMES), cross_validated(amid, NAMES), strict=True)
    assert all(other < one for one, other in pairs)


def test_acceptance_counts_by_set_kind_condition_and_outcome() -> None:
    some = [
        example(clip(0), {}, True),
        example(clip(1), {}, True),
        example(clip(2, "near-miss"), {}, False),
    ]
    assert acceptance(some, [0.9, 0.1, 0.6], threshold=0.5) == {
        "lab command all right": (0.5, 2),
        "lab near-miss all wrong": (1.0, 1),
    }


def test_what_a_rate_costs_counts_all_commands_also_those_of_which_nothing_was_heard() -> None:
    model = replace(MODEL, alarms=1.0, alarm_exponent=1.0)  # a rate of 0.5 needs two thirds
    commands = [clip(number) for number in range(4)]
    some = [
        example(commands[0], {}, True),
        example(commands[1], {}, True),
        example(commands[2], {}, True),
        example(commands[2], {}, False),
        example(clip(9, "talk"), {}, False),
    ]
    language = plain_commands(["go back"])
    costs = with_costs(model, some, [0.7, 0.6, 0.9, 0.8, 0.9], commands, language).costs
    missed = {cost.alarms: cost.missed for cost in costs}
    assert (missed[0.1], missed[0.5], missed[1.0]) == (1.0, 0.75, 0.5)


def test_any_sentence_of_a_template_that_must_not_be_missed_is_missed_less() -> None:
    """A probability of .5 is enough for `stop`, and for nothing else, at a rate of 0.5."""
    model = replace(MODEL, alarms=1.0, alarm_exponent=1.0)
    said = [replace(clip(number), text=text) for number, text in enumerate(("halt now", "go on"))]
    heard = [Example(one, one.text, {}, 1.0, Context.QUIET, True) for one in said]
    costs = with_costs(model, heard, [0.5, 0.5], said, commands_of("stop: halt now\ngo on")).costs
    assert {cost.alarms: cost.missed for cost in costs}[0.5] == 0.5


def test_examples_of_one_kind_alone_are_refused() -> None:
    with pytest.raises(ConfigError, match="both commands"):
        fit([e for e in examples() if e.right], [], NAMES)


def as_talk(some: Iterable[Example]) -> list[Example]:
    """What was heard wrongly, as if it had been talk."""
    wrong = (e for e in some if not e.right)
    return [dataclasses.replace(e, clip=replace(e.clip, kind="talk")) for e in wrong]


def test_the_fixtures_give_a_model_that_can_be_saved_and_read(tmp_path: Path) -> None:
    clips = read_manifest(FIXTURES / "manifest.tsv")[::6]
    collected = list(collect_examples(clips, None, 2))
    found = [e for c in collected for e in c.examples]
    assert any(e.right for e in found)
    assert any(not e.right for e in found)
    assert all(e.features.keys() >= {*NETWORK_FEATURES} for e in found)
    alone = [e for c in collected for e in c.alone]
    assert any(e.right for e in alone)
    assert any(not e.right for e in alone)
    assert all(set(e.features) == {*POCKETSPHINX_FEATURES, VOICES_AROUND} for e in alone)
    commands = [clip for c in collected for clip in c.commands]
    assert len(commands) == sum(clip.kind == "command" for clip in clips)
    fitted_on = [describe_set(clips, "audio_fixtures")]
    found, alone = ([*some, *as_talk(some)] for some in (found, alone))
    together = RecordingExamples(found, alone, talk=3600.0, commands=commands)
    commands_listed = read_commands(find_language(None))
    models, judging = fit_models([together], fitted_on, commands_listed)
    assert judging.model == models.with_network
    assert "command" in models.with_network.fitted_on[0]
    assert len(models.with_network.costs) == len(models.without_network.costs) == 6
    assert set(models.with_network.weights) == {*NETWORK_FEATURES}
    assert set(models.without_network.weights) == {*POCKETSPHINX_FEATURES, VOICES_AROUND}
    assert models.with_network.weights["score"] > 0
    assert sum(count for _, count in judging.accepted.values()) == len(found)
    save_models(models, tmp_path / "models.json")
    assert load_models(str(tmp_path / "models.json")) == models
    without, judging = fit_models([together], fitted_on, commands_listed, with_network=False)
    assert without == replace(load_models(), without_network=models.without_network)
    assert judging.model.fitted_on == fitted_on
    assert sum(count for _, count in judging.accepted.values()) == len(alone)
