"""What the network makes of real commands, and of what is none."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from recordings import Recording, read_manifest

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.echo import Cleaned
from voz.recognition.language import Language
from voz.recognition.network.score import (
    MAX_LEAD_BONUS,
    MAX_SUPPORT,
    MIN_REWARD,
    PENALTY_PER_OTHER_PHONE,
    PROPOSAL_BONUS,
    REWARD_PER_PHONE,
    Match,
    PhoneLikelihoods,
    PhonemeScorer,
    Ranking,
)

COMMANDS = sorted({r.text for r in read_manifest() if r.kind == "command"})


@pytest.fixture(scope="module")
def go_back(scorer: PhonemeScorer, recordings: list[Recording]) -> PhoneLikelihoods:
    return scorer.phone_likelihoods(said(recordings, "go back"))


def said(recordings: list[Recording], text: str) -> Samples:
    return next(r for r in recordings if (r.text, r.voice) == (text, "festival_slt")).samples()


def score(scorer: PhonemeScorer, samples: Samples, text: str) -> float:
    return scorer.rank(scorer.phone_likelihoods(samples), [text]).matches[text].score


@pytest.fixture(scope="module")
def rankings(
    scorer: PhonemeScorer, loaded: Language, recordings: list[Recording]
) -> list[tuple[Recording, Ranking]]:
    """What is said in each command and near-miss of the fixtures, of all commands."""
    clips = [r for r in recordings if r.kind in ("command", "near-miss")]
    sounds = [scorer.phone_likelihoods(clip.samples()) for clip in clips]
    ranked = [scorer.rank(each, loaded.commands.listed) for each in sounds]
    return list(zip(clips, ranked, strict=True))


def gap_in(scorer: PhonemeScorer, samples: Samples, text: str) -> float:
    likelihoods = scorer.phone_likelihoods(samples)
    match = scorer.rank(likelihoods, [text]).matches[text]
    return scorer.longest_gap(likelihoods, text, match)


def test_a_gap_within_a_word_is_seen_and_not_one_between_words(
    scorer: PhonemeScorer, recordings: list[Recording]
) -> None:
    text = "rotate left"
    samples = said(recordings, text)
    (begin, end), _ = scorer.align(scorer.phone_likelihoods(samples), text)
    pause = np.zeros(round(0.5 * SAMPLE_RATE), np.int16)

    def with_pause(at: float) -> Samples:
        return np.insert(samples, round(at * SAMPLE_RATE), pause)

    usual = gap_in(scorer, samples, text)
    assert usual < 0.3
    assert gap_in(scorer, with_pause(end), text) == pytest.approx(usual, abs=0.1)
    assert gap_in(scorer, with_pause((begin + end) / 2), text) >= 0.5


def test_it_knows_which_command_was_said_and_where(
    rankings: list[tuple[Recording, Ranking]],
) -> None:
    right = []
    for clip, ranking in rankings:
        if clip.kind == "command":
            samples, best = clip.samples(), ranking.matches[ranking.text]
            right.append(ranking.text == clip.text)
            loud = np.flatnonzero(np.abs(samples) > np.abs(samples).max() / 30) / SAMPLE_RATE
            assert loud[0] - 0.2 < best.begin < best.end < loud[-1] + 0.2
    assert np.mean(right) > 0.97


def test_what_is_louder_than_the_residue_of_the_playback_is_no_playback(
    scorer: PhonemeScorer, recordings: list[Recording]
) -> None:
    """Whoever says what is being played is heard, if its echo was removed."""
    samples = said(recordings, "stop")
    own = next(r for r in recordings if (r.text, r.voice) == ("stop", "festival_kal")).samples()
    played = np.resize(own, len(samples)).astype(np.float32)
    echo = 3 * np.resize(said(recordings, "go back"), len(samples)).astype(np.float32)

    def score_over(samples: Samples, echo: np.ndarray) -> float:
        sounds = scorer.phones_over_playback(Cleaned(samples, played / 32768, echo))
        return scorer.rank(sounds, ["stop"]).matches["stop"].score

    alone = score(scorer, samples, "stop")
    assert score_over(samples, echo) > alone - 1
    assert score_over(samples, np.zeros_like(echo)) < alone - 5
    assert score_over((0.01 * samples).astype(np.int16), echo) < alone - 5


def test_there_is_more_evidence_for_commands_than_for_what_is_none(
    rankings: list[tuple[Recording, Ranking]],
) -> None:
    scores: dict[str, list[float]] = {"command": [], "near-miss": []}
    for recording, ranking in rankings:
        scores[recording.kind].append(ranking.score)
    assert np.percentile(scores["near-miss"], 80) < np.percentile(scores["command"], 5)


@given(st.data())
def test_other_commands_and_their_order_change_nothing_for_a_command(
    scorer: PhonemeScorer, go_back: PhoneLikelihoods, data: st.DataObject
) -> None:
    some = data.draw(st.lists(st.sampled_from(COMMANDS), min_size=1, unique=True))
    mixed = data.draw(st.permutations(some))
    among, again = scorer.rank(go_back, some), scorer.rank(go_back, mixed)
    assert (again.text, again.next_best, again.score) == (among.text, among.next_best, among.score)
    for command in some:
        alone = scorer.rank(go_back, [command])
        assert among.matches[command] == again.matches[command] == alone.matches[command]


@given(st.data())
def test_one_command_more_is_heard_instead_or_makes_the_best_no_surer(
    scorer: PhonemeScorer, go_back: PhoneLikelihoods, data: st.DataObject
) -> None:
    first, *some = data.draw(st.lists(st.sampled_from(COMMANDS), min_size=2, unique=True))
    fewer, more = scorer.rank(go_back, some), scorer.rank(go_back, [*some, first])
    if more.text == first:
        assert more.matches[first].score > more.matches[fewer.text].score
        assert more.next_best == fewer.text
    else:
        assert more.text == fewer.text
        assert more.score <= fewer.score


@given(
    st.dictionaries(st.text(min_size=1), st.floats(-100, 100), min_size=1),
    st.floats(-50, 50),
)
def test_the_score_is_that_of_the_best_and_how_far_it_is_ahead(
    fits: dict[str, float], more: float
) -> None:
    ranking = Ranking({text: Match(fit, 0.0, 1.0) for text, fit in fits.items()})
    first, second = sorted([*fits.values(), -math.inf])[:-3:-1]
    assert fits[ranking.text] == first
    assert fits.get(ranking.next_best, -math.inf) == second
    assert ranking.text != ranking.next_best
    assert ranking.score == pytest.approx(first + min(MAX_LEAD_BONUS, (first - second) / 2))
    all_better = {text: Match(fit + more, 0.0, 1.0) for text, fit in fits.items()}
    assert Ranking(all_better).score == pytest.approx(ranking.score + more, abs=1e-6)


def test_support_decides_between_what_fits_about_as_well_and_the_more_the_longer_it_is() -> None:
    long = " ".join("abcdefgh")
    for text, most in (("a b c d", 1), (long, 5), (f"{long} i j k l", MAX_SUPPORT)):
        for behind, comes_first in ((most - 0.5, True), (most + 0.5, False)):
            fits = {text: Match(20.0 - behind, 0.0, 1.0), "other": Match(20.0, 0.0, 1.0)}
            ranking = Ranking(fits, [text])
            assert (ranking.text == text) is comes_first
            assert {ranking.text, ranking.next_best} == {*fits}
            if comes_first:  # and nothing is surer by it
                assert ranking.score < 20 - behind
            assert ranking.others(1)[0][1] < ranking.matches[ranking.text].score
    short = {"a b c": Match(9.0, 0.0, 1.0), "other": Match(9.1, 0.0, 1.0)}
    assert Ranking(short, ["a b c"]).text == "other"


def test_what_pocketsphinx_proposes_is_worth_a_little_and_to_that_command_alone(
    scorer: PhonemeScorer, go_back: PhoneLikelihoods
) -> None:
    plain, proposed = scorer.rank(go_back, COMMANDS), scorer.rank(go_back, COMMANDS, "turn left")
    for command in COMMANDS:
        more = proposed.matches[command].score - plain.matches[command].score
        assert more == pytest.approx(PROPOSAL_BONUS if command == "turn left" else 0)
    assert proposed.text == "go back"


def test_a_command_speaks_for_itself_by_the_phone_and_a_short_one_by_some_more(
    scorer: PhonemeScorer, recordings: list[Recording]
) -> None:
    """However well it is said; each command of these is said about as well as it can be."""
    for text in ("stop", "stop speech", "turn left"):
        worth = REWARD_PER_PHONE * scorer.count_phones(text)
        assert 0.7 * worth < score(scorer, said(recordings, text), text) < 1.1 * worth
    short = PhonemeScorer({"a": [["AH"]], "up": [["AH", "P"]], "stop": [["S", "T", "AA", "P"]]})
    sounds = short.phone_likelihoods(said(recordings, "speed up"))
    nothing = PhoneLikelihoods(*(values * 0 for values in sounds))
    for text, match in short.rank(nothing, ["a", "up", "stop"]).matches.items():
        assert match.score == pytest.approx(
            max(REWARD_PER_PHONE * short.count_phones(text), MIN_REWARD)
        )
    assert REWARD_PER_PHONE * short.count_phones("up") < MIN_REWARD


def test_silence_around_a_command_says_nothing_and_speech_speaks_against_it(
    scorer: PhonemeScorer, recordings: list[Recording]
) -> None:
    sound, other = said(recordings, "go back"), said(recordings, "turn left")
    alone = scorer.rank(scorer.phone_likelihoods(sound), ["go back"]).matches["go back"]
    hush = np.random.default_rng(0).normal(0, 8, SAMPLE_RATE).astype(np.int16)
    quiet = scorer.rank(scorer.phone_likelihoods(np.concatenate([hush, sound, hush])), ["go back"])
    assert abs(quiet.matches["go back"].score - alone.score) < PENALTY_PER_OTHER_PHONE
    assert quiet.matches["go back"].begin == pytest.approx(alone.begin + 1, abs=0.05)
    assert quiet.matches["go back"].end == pytest.approx(alone.end + 1, abs=0.05)
    for amid in ([other, sound], [sound, other]):
        assert (
            score(scorer, np.concatenate(amid), "go back")
            < alone.score - 4 * PENALTY_PER_OTHER_PHONE
        )


@pytest.mark.parametrize("samples", [0, 100, SAMPLE_RATE])
def test_of_silence_nothing_is_evidence(samples: int, scorer: PhonemeScorer) -> None:
    ranking = scorer.rank(scorer.phone_likelihoods(np.zeros(samples, np.int16)), COMMANDS)
    assert set(ranking.matches) == {*COMMANDS}
    assert ranking.score < -10


def test_of_the_ways_to_say_a_word_the_best_counts(recordings: list[Recording]) -> None:
    ways = {"a": ["S", "T", "AA", "P"], "b": ["S", "T", "AO", "P"], "c": ["F", "IH", "SH"]}
    scorer = PhonemeScorer(
        {**{word: [way] for word, way in ways.items()}, "any": list(ways.values())}
    )
    matches = scorer.rank(
        scorer.phone_likelihoods(said(recordings, "stop")), ["a", "b", "any"]
    ).matches
    assert matches["any"] == max(matches["a"], matches["b"])


def test_a_sentence_of_many_ways_to_say_it_is_no_burden() -> None:
    ways = [["AH", "S"], ["EY", "S"], ["IY", "S"]]
    scorer = PhonemeScorer(dict.fromkeys("abcdefghijkl", ways))
    sentence = " ".join("abcdefghijkl")
    assert scorer.count_phones(sentence) == 24
    (match,) = scorer.rank(
        scorer.phone_likelihoods(np.zeros(16000, np.int16)), [sentence]
    ).matches.values()
    assert math.isfinite(match.score)
