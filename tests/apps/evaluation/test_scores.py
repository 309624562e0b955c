from __future__ import annotations

from typing import Any

import pytest

from voz.apps.evaluation.scores import Group, score, word_errors
from voz.apps.evaluation.statistics import alarm_rate


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
