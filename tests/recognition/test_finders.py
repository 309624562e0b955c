"""What is found in real commands: by pocketsphinx and the network, and by pocketsphinx alone."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from recordings import Recording
from synthesis import phrase, with_floor

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.segment import NO_SAMPLES, Segment
from voz.audio.segmenter import segments
from voz.audio.sound_files import to_samples
from voz.language.build import build
from voz.language.language_files import LanguageFiles
from voz.recognition.confidence import POCKETSPHINX_FEATURES, SCORE, VOICES_AROUND, load_models
from voz.recognition.decision import Hypothesis
from voz.recognition.finders import MAX_COMPARED, NetworkFinder, PocketsphinxFinder
from voz.recognition.language import Language, Shortlist, load_language, with_more_words
from voz.recognition.network.score import PROPOSAL_BONUS, PhonemeScorer, scorer_for
from voz.recognition.pocketsphinx.decoder import Decoder
from voz.settings import Recognition


def finder(
    language: Language, settings: Recognition | None = None, network: PhonemeScorer | None = None
) -> NetworkFinder:
    scorer = network or scorer_for(language)
    return NetworkFinder(language, settings or Recognition(), load_models().with_network, scorer)


@pytest.fixture(scope="module")
def network_finder(loaded: Language, scorer: PhonemeScorer) -> NetworkFinder:
    return finder(loaded, network=scorer)


@pytest.fixture(scope="module")
def cut(recordings: list[Recording]) -> dict[str, Segment]:
    """The segment of each command."""
    own = [r for r in recordings if r.kind == "command" and r.voice == "festival_slt"]
    return {r.text: segment for r in own for segment in segments([r.samples()])}


def understood(network_finder: NetworkFinder, segment: Segment) -> Hypothesis:
    return network_finder.understand(segment)


def proposes(monkeypatch: pytest.MonkeyPatch, text: str) -> None:
    """Let pocketsphinx hear this, whatever is said."""
    monkeypatch.setattr(Decoder, "decode", lambda *_: text)


def compared(language: Language, center: str, *never_missed: str) -> list[str]:
    """The commands that are compared around one."""
    return Shortlist(language, never_missed, MAX_COMPARED).similar_to(center)


def built(sentences: list[str], folder: Path) -> Language:
    (folder / "list.txt").write_text("\n".join(sentences))
    build(folder / "list.txt", folder)
    return load_language(LanguageFiles(folder))


def test_the_network_decides_whatever_pocketsphinx_proposes(
    network_finder: NetworkFinder, cut: dict[str, Segment], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nearly: `stop speech` may be a nat behind `start speech`."""
    proposed = {text: understood(network_finder, segment) for text, segment in cut.items()}
    proposes(monkeypatch, "fold arm")
    others = {text: understood(network_finder, segment) for text, segment in cut.items()}
    right = [text for text, heard in others.items() if heard.text == text]
    assert len(right) >= len(cut) - 1
    for text in {*right} - {"fold arm"}:
        less = proposed[text].features[SCORE] - others[text].features[SCORE]
        # Its own nat, and at most as much of being ahead.
        assert PROPOSAL_BONUS - 1e-6 <= less <= 2 * PROPOSAL_BONUS + 1e-6


def spoken(text: str) -> Segment:
    sound = with_floor(phrase("festival_slt", text), np.random.default_rng(0))
    (segment,) = segments([to_samples(sound, SAMPLE_RATE)])
    return segment


def test_a_rival_that_refuses_a_well_known_command_does_not_refuse_another(
    network_finder: NetworkFinder,
    cut: dict[str, Segment],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    others = finder(built(["close window", "go back"], tmp_path))
    monkeypatch.setattr(PhonemeScorer, "rival_lead", lambda *_: 3.5)
    heard = others.understand(spoken("close window"))
    assert (heard.text, heard.probability > 0.9) == ("close window", True)
    for each in (network_finder, others):
        heard = each.understand(cut["go back"])
        assert (heard.text, heard.probability < 0.1) == ("go back", True)


def test_a_command_with_a_gap_within_a_word_was_not_said_but_a_stop_counts(
    network_finder: NetworkFinder, cut: dict[str, Segment], monkeypatch: pytest.MonkeyPatch
) -> None:
    usual = {text: network_finder.understand(cut[text]).probability for text in ("go back", "stop")}
    monkeypatch.setattr(PhonemeScorer, "longest_gap", lambda *_: 0.6)
    heard = {text: network_finder.understand(cut[text]).probability for text in usual}
    assert heard["stop"] == usual["stop"] > 0.9
    assert heard["go back"] < 0.05 < 0.9 < usual["go back"]


def test_of_two_long_orders_that_fit_alike_the_one_that_pocketsphinx_hears_is_right(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever its wording; and nothing is surer to be an order by it."""
    orders = "order: bring (me|us) {number: 13..16} {color} cups (from|of) the kitchen please"
    language = built([orders, "color = red | blue", "stop"], tmp_path)
    both = finder(language)
    said, other = (f"bring me {n} red cups from the kitchen please" for n in ("fifteen", "sixteen"))
    segment = spoken(said)

    def heard_with(proposed: str) -> Hypothesis:
        proposes(monkeypatch, proposed)
        return understood(both, segment)

    alone = heard_with("")
    right, wrong = heard_with(said.replace("me", "us")), heard_with(other)
    assert alone.text == right.text == wrong.text == said
    assert alone.rival
    assert right.rival
    assert wrong.rival
    assert wrong.rival.share < alone.rival.share < right.rival.share
    for heard in (right, wrong):
        assert heard.features[SCORE] == pytest.approx(alone.features[SCORE], abs=PROPOSAL_BONUS)
    proposes(monkeypatch, other)
    assert understood(both, spoken("stop")).text == "stop"
    foreign = finder(replace(language, ipa={"red": ("r",)}), network=scorer_for(language))
    unmoved = understood(foreign, segment)  # in another language pocketsphinx hears worse
    assert unmoved.rival
    assert unmoved.rival.share > wrong.rival.share


def test_pocketsphinx_hears_what_is_said_behind_the_name_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its grammar does not have the name, and would make the beginning of an order of it."""
    language = built(["bring me {number: 1..90} {color} cups", "color = red | blue"], tmp_path)
    proposed: list[tuple[str, int]] = []
    decode = Decoder.decode

    def decoded(decoder: Decoder, samples: Samples, start: str) -> str:
        proposed.append((decode(decoder, samples, start), len(samples)))
        return proposed[-1][0]

    monkeypatch.setattr(Decoder, "decode", decoded)
    said = "bring me fifteen red cups"
    settings = Recognition(name="hey robot")
    named = finder(with_more_words(language, settings), settings)
    segment = spoken(f"hey robot {said}")
    heard = understood(named, segment)
    assert heard.named
    assert heard.text == said
    ((found, samples),) = proposed
    assert found == said
    assert len(spoken(said).samples) * 0.9 < samples < len(segment.samples) - 0.3 * SAMPLE_RATE


def test_where_pocketsphinx_finds_nothing_the_network_still_does(
    network_finder: NetworkFinder, cut: dict[str, Segment], monkeypatch: pytest.MonkeyPatch
) -> None:
    proposes(monkeypatch, "")
    heard = understood(network_finder, cut["turn left"])
    assert (heard.text, heard.next_best) == ("turn left", "turn right")


def test_what_the_end_pointer_cut_off_is_heard_in_the_sound_around_it(
    network_finder: NetworkFinder, cut: dict[str, Segment]
) -> None:
    """Half of `left` and the t of `turn` are around it, as where noise hides them."""
    whole = cut["turn left"]
    first, last = int(0.15 * SAMPLE_RATE), int(0.2 * SAMPLE_RATE)
    inner = whole._replace(
        samples=whole.samples[first:-last],
        start=whole.start + first / SAMPLE_RATE,
        end=whole.end - last / SAMPLE_RATE,
        before=whole.samples[:first],
        after=whole.samples[-last:],
    )
    bare = inner._replace(before=NO_SAMPLES, after=NO_SAMPLES)
    score = understood(network_finder, inner).features[SCORE]
    assert understood(network_finder, inner).text == "turn left"
    assert score > understood(network_finder, bare).features[SCORE] + 1
    # The same sound is the same evidence; only pocketsphinx heard less of it.
    unchanged = whole._replace(before=NO_SAMPLES, after=NO_SAMPLES)
    assert score == pytest.approx(
        understood(network_finder, unchanged).features[SCORE], abs=1.5 * PROPOSAL_BONUS
    )


def test_it_ends_where_its_last_word_does_and_not_where_the_sound_does(
    network_finder: NetworkFinder, cut: dict[str, Segment]
) -> None:
    for segment in cut.values():
        heard = understood(network_finder, segment)
        loud = np.flatnonzero(np.abs(segment.samples) > np.abs(segment.samples).max() / 30)
        said_until = segment.start + loud[-1] / SAMPLE_RATE
        assert said_until - 0.3 < heard.spoken_until < said_until + 0.2


def test_no_word_ends_later_than_what_was_heard(
    network_finder: NetworkFinder, cut: dict[str, Segment]
) -> None:
    """Though the network goes on beyond that, with its last moment and what fills short sound."""
    whole = cut["go back"]
    for length in range(6000, len(whole.samples), 90):
        end = whole.start + length / SAMPLE_RATE
        heard = understood(network_finder, Segment(whole.start, end, end, whole.samples[:length]))
        assert heard.spoken_until <= end


def test_what_is_one_phone_away_from_a_command_is_less_likely_than_the_command(
    network_finder: NetworkFinder, cut: dict[str, Segment], tmp_path: Path
) -> None:
    neighbor = finder(built(["go bag", "stop"], tmp_path))
    heard = understood(neighbor, cut["go back"])
    assert heard.text == "go bag"
    assert heard.features[SCORE] > 8
    assert heard.probability < 0.5 < understood(network_finder, cut["go back"]).probability


def test_what_must_not_be_missed_is_not_doubted_for_what_is_one_phone_away(
    cut: dict[str, Segment], tmp_path: Path
) -> None:
    careful = finder(built(["go bag"], tmp_path), Recognition(never_missed=("go bag",)))
    heard = understood(careful, cut["go back"])
    assert heard.text == "go bag"
    assert heard.probability > 0.8


def test_what_must_not_be_missed_is_not_doubted_for_another_value_of_it(
    cut: dict[str, Segment], tmp_path: Path
) -> None:
    """Whichever of many values it has."""
    template = "turn {side}"
    sides = [*"abcdefghijklmnop", "left", "right"]
    language = built([template, "go back", f"side = {' | '.join(sides)}"], tmp_path)
    usual = finder(language, Recognition(never_missed=()))
    careful = finder(language, Recognition(never_missed=(template,)))
    for text in ("turn left", "turn right"):
        assert text not in Shortlist(language, (template,), MAX_COMPARED).never_missed
        assert understood(usual, cut[text]).rival
        heard = understood(careful, cut[text])
        assert (heard.text, heard.rival) == (text, None)


def test_a_room_that_only_hums_is_no_speech(network_finder: NetworkFinder) -> None:
    time = np.arange(SAMPLE_RATE) / SAMPLE_RATE
    hum = (4000 * np.sin(2 * np.pi * 110 * time)).astype(np.int16)
    heard = understood(network_finder, Segment(0, 1, 1, hum))
    assert (heard.speech_probability, heard.probability) == (0, 0)
    assert heard.why_refused() == ("no_speech", None)


def test_a_part_of_a_command_is_told_from_what_is_none(
    network_finder: NetworkFinder, recordings: list[Recording]
) -> None:
    def why(text: str) -> str:
        clip = next(r for r in recordings if (r.kind, r.text) == ("near-miss", text))
        (segment,) = segments([clip.samples()])
        return understood(network_finder, segment).why_refused()[0]

    assert [why(text) for text in ("turn", "rotate", "right")] == ["part_of_a_command"] * 3
    assert why("good morning everyone") == "not_a_command"


def test_of_a_long_list_what_sounds_like_what_was_found_is_compared(
    cut: dict[str, Segment], tmp_path: Path
) -> None:
    colors = ["red", "green", "blue", "black", "white", "brown", "pink", "gray", "gold", "tan"]
    words = [*colors, "yellow", "purple", "orange"]
    language = built(
        [*(f"{a} {b}" for a in words for b in words), "go back", "go forward", "stop"], tmp_path
    )
    assert len(language.commands) > MAX_COMPARED
    careful = finder(language, Recognition(never_missed=("stop",)))
    candidates = compared(language, "go back", "stop")
    assert 3 < len(candidates) == len(set(candidates)) <= MAX_COMPARED
    assert candidates[:2] == ["go back", "stop"]
    assert "gold black" in candidates
    assert understood(careful, cut["go back"]).text == "go back"
    assert compared(language, "", "stop") == ["stop"]


COLORS = ["red", "green", "blue", "black", "white", "pink", "gold", "tan"]


def test_a_long_list_is_searched_by_the_network_whatever_pocketsphinx_proposes(
    said: Segment, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    network_finder = finder(
        built([f"{a} {b} {c}" for a in COLORS for b in COLORS for c in COLORS], tmp_path)
    )
    monkeypatch.setattr("voz.recognition.finders.MAX_REFINEMENTS", 0)
    for proposed in ("tan tan tan", ""):
        proposes(monkeypatch, proposed)
        assert understood(network_finder, said).text == "green white black"


@pytest.fixture(scope="module")
def said() -> Segment:
    """Three colors."""
    return spoken("green white black")


def test_in_a_longer_list_what_the_network_hears_is_searched_around_in_turn(
    said: Segment, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All three words of what pocketsphinx proposes are wrong, and no neighbor is right yet."""
    monkeypatch.setattr("voz.recognition.finders.MAX_SEARCHED_WORDS", 0)
    language = built([f"{a} {b} {c}" for a in COLORS for b in COLORS for c in COLORS], tmp_path)
    network_finder = finder(language)
    proposes(monkeypatch, "tan tan tan")
    neighbors = compared(language, "tan tan tan", *Recognition().never_missed)
    assert "green white black" not in neighbors
    assert understood(network_finder, said).text == "green white black"
    monkeypatch.setattr("voz.recognition.finders.MAX_REFINEMENTS", 0)
    assert understood(network_finder, said).text in neighbors


def test_of_a_longer_list_in_which_nothing_was_found_nothing_is_asked(
    cut: dict[str, Segment], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("voz.recognition.finders.MAX_SEARCHED_WORDS", 0)
    words = [*"abcdefghijklmn"]
    language = built([f"{a} {b}" for a in words for b in words], tmp_path)
    network_finder = finder(language, Recognition(never_missed=()))
    proposes(monkeypatch, "")
    heard = understood(network_finder, cut["stop"])
    assert (heard.text, heard.features, heard.probability) == ("", {}, 0)
    assert heard.why_refused() == ("not_a_command", None)


def test_a_sound_too_short_for_any_command_is_none(cut: dict[str, Segment], tmp_path: Path) -> None:
    """Each of its 80 phones takes 20 ms at least."""
    network_finder = finder(built(["bring the " + " ".join(["strawberries"] * 8)], tmp_path))
    heard = understood(
        network_finder, Segment(0, 0.5, 0.5, cut["stop"].samples[: SAMPLE_RATE // 2])
    )
    assert (heard.text, heard.features, heard.probability) == ("", {}, 0)
    assert heard.why_refused() == ("too_short", None)


def alone(language: Language, settings: Recognition | None = None) -> PocketsphinxFinder:
    return PocketsphinxFinder(language, settings or Recognition(), load_models().without_network)


@pytest.fixture(scope="module")
def ear_alone(loaded: Language) -> PocketsphinxFinder:
    return alone(loaded)


@pytest.fixture(scope="module")
def clips(recordings: list[Recording]) -> dict[str, Segment]:
    """The segment of each command, and of each near-miss."""
    own = [r for r in recordings if r.kind in ("command", "near-miss")]
    own = [r for r in own if r.voice == "festival_slt"]
    return {r.text: segment for r in own for segment in segments([r.samples()])}


def test_commands_are_found_and_there_is_a_next_best(
    ear_alone: PocketsphinxFinder, loaded: Language, clips: dict[str, Segment]
) -> None:
    for text in loaded.commands:
        heard = ear_alone.understand(clips[text])
        assert (heard.text, heard.speech_probability) == (text, 1)
        assert {*heard.features} == {*POCKETSPHINX_FEATURES, VOICES_AROUND}
        assert heard.next_best in {*loaded.commands} - {text}
        assert heard.rival is None
        assert clips[text].start < heard.spoken_until <= clips[text].end


def test_the_reason_of_a_refusal_is_found_in_the_sound(
    ear_alone: PocketsphinxFinder, clips: dict[str, Segment]
) -> None:
    def why(segment: Segment) -> str:
        return ear_alone.understand(segment).why_refused()[0]

    assert why(clips["point"]) == "part_of_a_command"
    assert why(clips["the weather is nice today"]) == "not_a_command"
    stop = clips["stop"]
    assert why(stop._replace(samples=stop.samples // 300)) == "too_quiet"


def test_a_sound_too_short_for_any_command_is_said_to_be_so(
    clips: dict[str, Segment], tmp_path: Path
) -> None:
    (tmp_path / "list.txt").write_text("bring the " + " ".join(["strawberries"] * 8))
    build(tmp_path / "list.txt", tmp_path)
    patient = alone(load_language(LanguageFiles(tmp_path)))
    sound = clips["stop"].samples[: SAMPLE_RATE // 2]
    heard = patient.understand(Segment(0, 0.5, 0.5, sound))
    assert (heard.text, heard.features, heard.probability) == ("", {}, 0)
    assert heard.why_refused() == ("too_short", None)


def test_words_of_the_trigram_model_that_are_no_command_are_compared_with_none(
    loaded: Language, clips: dict[str, Segment]
) -> None:
    trigrams = alone(loaded, Recognition(search="lm"))
    heard = trigrams.understand(clips["go back"])
    assert (heard.text, bool(heard.features)) == ("go back", True)
    others = [trigrams.understand(s) for t, s in clips.items() if t not in loaded.commands]
    words = [each for each in others if each.text and each.text not in loaded.commands]
    assert words
    assert all((each.features, each.probability) == ({}, 0) for each in words)
    assert {each.why_refused() for each in words} == {("not_a_command", None)}


def test_a_tap_is_no_speech(ear_alone: PocketsphinxFinder) -> None:
    time = np.arange(SAMPLE_RATE) / SAMPLE_RATE
    taps = 8000 * np.exp(-time % 0.2 * 60) * np.sin(2 * np.pi * 900 * time)
    heard = ear_alone.understand(Segment(0, 1, 1, taps.astype(np.int16)))
    assert heard.probability == 0
    assert heard.why_refused() in (("no_speech", None), ("too_short", None))
