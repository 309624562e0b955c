"""Figures, what was misheard and by whose voice, and what other false alarm rates would cost."""

from __future__ import annotations

from typing import Any

import pytest
from language.template_texts import commands_of

from voz.apps.evaluation.results import Result, Understood
from voz.apps.evaluation.scores import (
    AlarmDifference,
    Difference,
    Group,
    compare,
    compare_alarms,
    confusions,
    operating_points,
    score,
    word_errors,
)
from voz.apps.evaluation.statistics import alarm_rate
from voz.apps.evaluation.tables import main_tables, table_text
from voz.apps.recordings.manifest import Kind
from voz.config import Recognition
from voz.language.sentences.command_set import plain_commands
from voz.recognition.confidence import Model, alarm_rates_near


def test_commands_are_counted_by_set_condition_speaker_and_noise(result: Any) -> None:
    scores = score(
        [
            result("stop", "stop", speaker="ann", condition="us", cpu=0.01),
            result("stop", "stop?", speaker="ann", condition="us", cpu=0.03),
            result("go back", "go forward", speaker="bob", condition="gb", cpu=0.02),
            result("go back", speaker="bob", condition="us", cpu=0.02),
            result("stop", "stop", snr=5.0, noise="tap"),
            result("stop", snr=20.0, noise="tap"),
        ]
    )
    found = {(s.group.by, s.group.name): s for s in scores.commands}
    assert list(found) == [
        ("all", ""),
        ("condition", "gb"),
        ("condition", "us"),
        ("snr", "20 dB"),
        ("snr", "5 dB"),
        ("noise", "tap, 20 dB"),
        ("noise", "tap, 5 dB"),
        ("speaker", "ann"),
        ("speaker", "bob"),
    ]
    whole = found["all", ""]
    assert (whole.clips, whole.speakers, whole.cpu_ms) == (4, 2, 20)
    assert whole.right.value == 0.5
    assert whole.right_and_accepted.value == 0.25
    assert whole.refused.value == 0.25
    assert whole.wrongly_obeyed.value == 0.25
    assert whole.word_error_rate.value == 0.5  # forward for back, go, back; of 6
    assert found["condition", "us"].right.value == pytest.approx(2 / 3, abs=1e-5)
    assert found["snr", "5 dB"].right.value == 1
    assert found["speaker", "bob"].right.value == 0


def test_a_condition_that_is_everything_is_not_said_twice(result: Any) -> None:
    scores = score([result("stop", "stop"), result("stop it", kind="near-miss")])
    assert [s.group for s in scores.commands] == [Group("mine", "command", "all", "")]
    assert [s.group for s in scores.near_misses] == [Group("mine", "near-miss", "all", "")]


def test_word_errors_of_a_long_recording(result: Any) -> None:
    said = "stop | go back"
    assert word_errors(result(said, "stop", "go back", kind="long")) == 0
    assert word_errors(result(said, "stop", "stop", "turn back", kind="long")) == 2
    assert word_errors(result(said, kind="long")) == 3


def test_near_misses_that_are_let_through(result: Any) -> None:
    heard = [["stop"], ["stop?"], [], ["go back?", "stop"]]
    (scores,) = score([result("stop it", *h, kind="near-miss") for h in heard]).near_misses
    assert (scores.clips, scores.let_through.value) == (4, 0.5)


def test_false_alarms_for_each_hour_of_talk_and_of_noise(result: Any) -> None:
    hour = {"seconds": 1800.0, "file": "x"}
    scores = score(
        [
            result("what they say", "stop", "go back", "stop?", kind="talk", **hour),
            result("what they say", kind="talk", speaker="bob", **hour),
            result("", "stop", kind="noise", **hour),
        ]
    )
    found = {s.group.kind: s for s in scores.alarms if s.group.by == "all"}
    assert found["talk"].rate == alarm_rate(2, hours=1)
    assert found["noise"].rate == alarm_rate(1, hours=0.5)


def test_talk_is_split_by_condition_with_the_hours_of_each(result: Any) -> None:
    sentence = {"kind": "talk", "condition": "single sentences", "seconds": 3.0}
    goes_on = {"kind": "talk", "condition": "goes on", "seconds": 1800.0}
    results = [result("a", "stop", **sentence)] * 600 + [result("b", **goes_on)]
    found = {s.group.name: s.rate for s in score(results).alarms if s.group.by != "speaker"}
    assert found == {
        "": alarm_rate(600, hours=1),
        "single sentences": alarm_rate(600, hours=0.5),
        "goes on": alarm_rate(0, hours=0.5),
    }


def test_each_noise_is_counted_at_each_ratio(result: Any) -> None:
    scores = score(
        [
            result("stop", "stop", snr=5.0, noise="tap"),
            result("stop", snr=5.0, noise="motor"),
            result("stop", "stop", snr=20.0, noise="motor"),
            result("", "go back", snr=5.0, noise="tap", kind="out-of-nothing", seconds=3600.0),
        ]
    )
    assert [(s.group.name, s.right.value) for s in scores.commands] == [
        ("20 dB", 1),
        ("5 dB", 0.5),
        ("motor, 20 dB", 1),
        ("motor, 5 dB", 0),
        ("tap, 5 dB", 1),
    ]
    assert [s.rate for s in scores.alarms] == [alarm_rate(1, hours=1)] * 2


def test_what_could_not_be_read_does_not_count(result: Any) -> None:
    (scores,) = score([result("stop", "stop"), result("stop", error="no file")]).commands
    assert (scores.clips, scores.right.value) == (1, 1)


def test_each_command_is_counted_by_what_became_of_it(result: Any) -> None:
    clips = [
        result("go back", "go forward", speaker="anne"),
        result("go back", "go forward", speaker="bob"),
        result("go back", "go forward", speaker="anne"),
        result("go back", "go back", speaker="anne"),
        result("go back", "go back?", speaker="anne"),
        result("go back", "fold arm?", speaker="bob"),
        result("go back", speaker="bob"),
        result("stop", "stop", "go back", speaker="bob"),
        result("stop", "stop", "stop", speaker="bob"),
        result("go up", "stop", kind="near-miss"),
        result("stop | go back", "stop", kind="long"),
    ]
    assert [(c.said, c.outcome, c.speakers) for c in confusions(clips)] == [
        ("go back", "as go forward", {"anne": 2, "bob": 1}),
        ("go back", "refused", {"anne": 1, "bob": 1}),
        ("go back", "not heard", {"bob": 1}),
        ("stop", "as go back", {"bob": 1}),
        ("stop", "more than once", {"bob": 1}),
    ]


def test_the_table_has_a_column_for_each_speaker(result: Any) -> None:
    clips = [result("go back", "stop", speaker="anne") for _ in range(2)]
    clips += [result("stop", speaker="bob"), result("stop", "stop", speaker="carol")]
    _, table = main_tables(score(clips), [])
    assert table_text(table).splitlines() == [
        "misheard         clips  anne  bob",
        "go back as stop      2     2     ",
        "stop not heard       1          1",
    ]


def test_the_table_stays_small(result: Any) -> None:
    clips = [result(f"go {n}", speaker=f"s{n % 9}") for n in range(14)]
    clips += [result("stop", "go 1", speaker="s0")]
    _, table = main_tables(score(clips), [])
    assert table.header == ("misheard", "clips", "s0", "s1", "s2", "s3", "s4", "s5", "others")
    assert len(table.rows) == 11
    name, *counts = table.rows[-1]
    assert name == "5 more"
    assert sum(int(row[1]) for row in table.rows) == len(clips)
    assert int(counts[0]) == sum(int(count or 0) for count in counts[1:])


def test_where_nothing_is_misheard_there_is_no_table(result: Any) -> None:
    (table,) = main_tables(score([result("stop", "stop")]), [])
    assert table.header[0] == "commands"


MODEL = Model(fitted_on=[], intercept=0.0, weights={}, alarms=1.0, alarm_exponent=1.0)
COMMANDS = plain_commands(["go back", "stop"])
RATES = alarm_rates_near(MODEL.default_alarm_rate)


def result(
    kind: Kind, confidence: float, text: str = "go back", snr: float | None = None
) -> Result:
    heard = (Understood(text, confidence, accepted=False),)
    return Result("lab", "a.wav", text, "me", kind, "all", snr, heard, seconds=360.0)


def test_a_lower_rate_misses_more_and_lets_less_through() -> None:
    results = [
        *(result("command", c / 20) for c in range(21)),
        *(result("near-miss", c / 20) for c in range(21)),
        *(result("talk", c / 20) for c in range(21)),
    ]
    found = operating_points(results, MODEL, Recognition(), COMMANDS)
    assert [p.false_alarms_per_hour for p in found] == list(RATES)
    missed = [p.missed for p in found]
    through = [p.let_through for p in found]
    assert missed == sorted(missed, reverse=True)
    assert through == sorted(through)
    even = found[RATES.index(1.0)]
    assert (even.threshold, even.missed, even.let_through) == (0.5, 0.4762, 0.5238)
    assert even.talk == alarm_rate(11, hours=2.1)


def test_any_sentence_of_a_template_that_must_not_be_missed_needs_less() -> None:
    results = [result("command", 0.45), result("command", 0.45, "halt now")]
    commands = commands_of("go back\nstop: halt now")
    even = operating_points(results, MODEL, Recognition(missed_cost=2), commands)[RATES.index(1.0)]
    assert (even.threshold, even.missed) == (0.5, 0.5)


def test_a_list_of_too_many_sentences_to_list_has_its_operating_points() -> None:
    commands = commands_of("go: go {n: 1..99} {m: 1..99}")
    assert not commands.can_be_listed
    results = [result("command", 0.6, "go one two"), result("command", 0.9, "go far")]
    even = operating_points(results, MODEL, Recognition(), commands)[RATES.index(1.0)]
    assert (even.threshold, even.missed) == (0.5, 0.5)  # what is no sentence is never accepted


def test_clips_in_noise_do_not_count_and_what_is_not_there_is_not_told() -> None:
    (first, *_) = operating_points(
        [result("command", 1.0, snr=10.0)], MODEL, Recognition(), COMMANDS
    )
    assert (first.missed, first.let_through, first.talk) == (None, None, None)


def test_clips_are_paired_by_name_and_noise(result: Any) -> None:
    here = [
        result("stop", "stop", file="a"),
        result("stop", "stop", file="b"),
        result("stop", "stop?", file="c"),
        result("stop", "stop", file="d", snr=5.0),
        result("stop", "stop", file="only here"),
        result("stop it", "stop", file="e", kind="near-miss"),
    ]
    there = [
        result("stop", "stop", file="c"),
        result("stop", "stop", file="a"),
        result("stop", file="b"),
        result("stop", file="d", snr=5.0),
        result("stop it", file="e", kind="near-miss"),
        result("stop", file="only here", error="no file"),
    ]
    assert compare(here, there) == [
        Difference("mine", None, 3, 0.66667, 0.66667, 1, 1, 1.0),
        Difference("mine", 5.0, 1, 1.0, 0.0, 1, 0, 1.0),
    ]


def test_stretches_of_a_stream_are_paired_by_where_they_begin(result: Any) -> None:
    stream = {"file": "stream", "set": "mine"}
    here = [result("stop", "stop", start=1.0, **stream), result("stop", start=5.0, **stream)]
    there = [result("stop", start=5.0, **stream), result("stop", "stop", start=1.0, **stream)]
    assert compare(here, there) == [Difference("mine", None, 2, 0.5, 0.5, 0, 0, 1.0)]


def test_only_the_same_noise_is_compared(result: Any) -> None:
    tap, motor = (result("stop", "stop", snr=5.0, noise=name) for name in ("tap", "motor"))
    assert compare([tap], [motor]) == []
    assert len(compare([tap], [tap])) == 1


def test_alarms_are_counted_in_what_both_have_heard(result: Any) -> None:
    talk = {"kind": "talk", "seconds": 1800.0}
    here = [result("a", "stop", **talk), result("b", **talk), result("only here", **talk)]
    there = [result("a", **talk), result("b", **talk), result("only there", "stop", **talk)]
    assert compare_alarms(here, there) == [
        AlarmDifference("mine", "talk", None, alarm_rate(1, hours=1), alarm_rate(0, hours=1))
    ]


def test_other_sets_have_nothing_in_common(result: Any) -> None:
    assert compare([result("stop", "stop")], [result("stop", "stop", set="other")]) == []
