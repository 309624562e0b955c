"""What other false alarm rates would cost, counted again from the confidences."""

from __future__ import annotations

from voz.apps.evaluation.operating_points import operating_points
from voz.apps.evaluation.results import Result, Understood
from voz.apps.evaluation.statistics import alarm_rate
from voz.apps.recordings.manifest import Kind
from voz.config import Recognition
from voz.recognition.confidence import Model, alarm_rates_near

MODEL = Model(fitted_on=[], intercept=0.0, weights={}, alarms=1.0, alarm_exponent=1.0)
COMMANDS = ["go back", "stop"]
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


def test_what_must_not_be_missed_needs_less() -> None:
    results = [result("command", 0.45), result("command", 0.45, "stop")]
    settings = Recognition(missed_cost=2)
    even = operating_points(results, MODEL, settings, COMMANDS)[RATES.index(1.0)]
    assert even.missed == 0.5


def test_clips_in_noise_do_not_count_and_what_is_not_there_is_not_told() -> None:
    (first, *_) = operating_points(
        [result("command", 1.0, snr=10.0)], MODEL, Recognition(), COMMANDS
    )
    assert (first.missed, first.let_through, first.talk) == (None, None, None)
