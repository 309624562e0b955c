"""What the parts ask: properties of any templates, and of plain lists."""

from __future__ import annotations

from itertools import product

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from language.template_texts import commands_of, compile_text
from pocketsphinx import Config, Decoder, get_model_path

from voz import CommandsError, LanguageError
from voz.language.grammar import structured_jsgf, to_fsg
from voz.language.sentences.automaton import prefix_tree
from voz.language.sentences.command_set import Commands, plain_commands
from voz.language.sentences.neighbors import LetterDistances, nearest
from voz.language.similarity import WordDistances

WORD = st.sampled_from(["go", "stop", "back", "left", "up"])


def groups(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    some = st.lists(inner, min_size=1, max_size=3)
    return st.one_of(
        some.map(" ".join),
        some.map(lambda parts: f"({' | '.join(parts)})"),
        some.map(lambda parts: f"({' ; '.join(parts)})"),
        inner.map(lambda part: f"[{part}]"),
    )


EXPRESSION = st.recursive(WORD, groups, max_leaves=8)
TEMPLATE = st.one_of(EXPRESSION, EXPRESSION.map(lambda e: f"{e} {{n: 1..3}} {{way}}"))
FILE = st.lists(TEMPLATE, min_size=1, max_size=3).map(
    lambda lines: "\n".join([*(f"same: {line}" for line in lines), "way = red | deep blue:blue"])
)


def commands_or_none(text: str) -> Commands | None:
    try:
        return commands_of(text)
    except CommandsError:  # everything is optional, or it has two meanings
        return None


@given(FILE)
def test_the_count_is_that_of_the_different_sentences(text: str) -> None:
    commands = commands_or_none(text)
    if commands:
        listed = commands.listed
        assert len(set(listed)) == len(listed) == len(commands)
        assert set(commands.sample(len(commands))) == set(listed)
        assert max(len(sentence.split()) for sentence in listed) == commands.longest
        assert {word for sentence in listed for word in sentence.split()} == set(
            commands.vocabulary
        )


@given(FILE)
def test_every_sentence_parses_to_itself_with_its_slots(text: str) -> None:
    commands = commands_or_none(text)
    for sentence in commands.sample(20) if commands else ():
        parse = commands.parse(sentence)
        assert parse
        assert (parse.text, parse.command) == (sentence, "same")
        words = sentence.split()
        assert parse.slots.get("n") == (
            None
            if "n" not in parse.slots
            else 1
            + ["one", "two", "three"].index(
                next(word for word in words if word in ("one", "two", "three"))
            )
        )
        assert ("blue" in words) == (parse.slots.get("way") == "blue")


@given(FILE)
def test_what_is_no_sentence_has_no_parse(text: str) -> None:
    commands = commands_or_none(text)
    if commands:
        listed = set(commands)
        for words in product(commands.vocabulary[:3], repeat=2):
            sentence = " ".join(words)
            assert (commands.parse(sentence) is not None) == (sentence in listed)
            longer = any(one.startswith(f"{sentence} ") for one in listed)
            assert commands.has_continuation(sentence) == longer
            assert commands.is_typed_prefix(sentence.upper()) == longer


@settings(max_examples=30)
@given(FILE, st.integers(0, 5))
def test_neighbors_are_other_sentences(text: str, number: int) -> None:
    commands = commands_or_none(text)
    if commands:
        sound = WordDistances({word: [["S", "T", "AA", "P"]] for word in commands.vocabulary})
        sentence = commands.sample(1)[0]
        near = commands.neighbors(sentence, number, sound)
        assert len(set(near)) == len(near) <= number
        assert sentence not in near
        assert set(near) <= set(commands)


@pytest.fixture(scope="module")
def decoder() -> Decoder:
    model = {
        "hmm": get_model_path("en-us/en-us"),
        "dict": get_model_path("en-us/cmudict-en-us.dict"),
    }
    return Decoder(Config(**model, lm=None, loglevel="FATAL"))


@settings(max_examples=30)
@given(FILE)
def test_every_sentence_is_in_the_grammar_that_the_decoder_searches(
    decoder: Decoder, text: str
) -> None:
    commands = commands_or_none(text)
    if commands:
        arcs, end = to_fsg(commands.automaton)
        written = structured_jsgf([one.expression for one in compile_text(text).templates])
        for searched in (decoder.create_fsg("any", 0, end, arcs), decoder.parse_jsgf(written)):
            for sentence in commands.sample(20):
                assert searched.accept(sentence)
            for word in commands.vocabulary:
                assert searched.accept(word) == (word in commands)


def test_weights_make_every_sentence_as_likely() -> None:
    automaton = commands_of("a (b|c|d)\na\n[z] x").automaton
    arcs, end = to_fsg(automaton)
    found: dict[int, float] = {}

    def follow(state: int, probability: float, words: int) -> None:
        if state == end:
            found[len(found)] = probability
        for arc in arcs:
            if arc[0] == state:
                follow(arc[1], probability * arc[2], words + 1)

    follow(0, 1.0, 0)
    assert list(found.values()) == pytest.approx([1 / 6] * 6)


def test_a_billion_sentences_are_counted_and_found() -> None:
    digits = "(one|two|three|four|five|six|seven|eight|nine|zero)"
    commands = commands_of("call: " + " ".join([digits] * 9) + "\nstop")
    assert len(commands) == 10**9 + 1
    assert all(commands.parse(text) for text in commands.sample(50))
    assert len(commands.automaton.arcs) < 20
    with pytest.raises(LanguageError, match="too many"):
        list(commands)
    assert {word for text in commands.examples() for word in text.split()} == set(
        commands.vocabulary
    )


def test_typed_text_may_have_digits_capitals_and_a_full_stop() -> None:
    commands = commands_of("turn left {angle: 5..180 by 5} degree[s]\ngo {far: 0.5..2 by 0.5}")
    for typed, slots in {
        "Turn left 90 degrees.": {"angle": 90},
        "turn LEFT ninety degrees!": {"angle": 90},
        "turn left 180°": {"angle": 180},
        "turn-left a hundred and eighty degrees": {"angle": 180},
        "Go 1.5": {"far": 1.5},
        "go .5": {"far": 0.5},
    }.items():
        parse = commands.parse(typed)
        assert parse, typed
        assert parse.slots == slots
    parse = commands.parse("turn left 90 degrees")
    assert parse
    assert parse.text == "turn left ninety degrees"
    for other in ("turn left 91 degrees", "turn left -90 degrees", "", "...", "90", "go é 1"):
        assert commands.parse(other) is None


def test_typed_text_may_lack_accents() -> None:
    commands = plain_commands(["más despacio", "señala la cerveza", "cómo", "como"])
    for typed, text in {
        "mas despacio": "más despacio",
        "MAS DESPACIO.": "más despacio",
        "senala la cerveza": "señala la cerveza",
        "como": "como",
        "cómo": "cómo",
    }.items():
        parse = commands.parse(typed)
        assert parse, typed
        assert parse.text == text
    assert commands.parse("mäs despacio") is None
    commands = commands_of("gira {lado} {angle: 1..9} metros\nlado = rápido:1 | atrás:2")
    parse = commands.parse("gira atras 5 metros")
    assert parse
    assert parse.slots == {"lado": 2, "angle": 5}


def test_unknown_text_gets_the_nearest_sentence() -> None:
    commands = plain_commands(["go forward", "go back", "start speech", "stop speech", "stop"])
    assert commands.closest_sentence("go forwards") == "go forward"
    assert commands.closest_sentence("please go back") == "go back"
    assert commands.closest_sentence("strat speech") == "start speech"
    assert commands.closest_sentence("what is the weather like") is None
    assert commands.closest_sentence("") is None


def test_a_plain_list_keeps_its_order_and_names_its_commands() -> None:
    sentences = ["stop speech", "go back", "stop", "go"]
    commands = plain_commands(sentences)
    assert list(commands) == sentences
    assert list(commands.names) == sentences
    parse = commands.parse("go back")
    assert parse
    assert (parse.command, parse.slots) == ("go back", {})
    assert commands.has_continuation("stop")
    assert not commands.has_continuation("go back")


def test_the_nearest_in_sound_come_first() -> None:
    commands = plain_commands(["bring the red cup", "bring the bed cup", "bring the green cup"])
    sound = WordDistances(
        {
            "bring": [["B", "R", "IH", "NG"]],
            "the": [["DH", "AH"]],
            "cup": [["K", "AH", "P"]],
            "red": [["R", "EH", "D"]],
            "bed": [["B", "EH", "D"]],
            "green": [["G", "R", "IY", "N"]],
        }
    )
    assert commands.neighbors("bring the red cup", 2, sound) == [
        "bring the bed cup",
        "bring the green cup",
    ]


def test_the_sentences_of_a_command_are_found_the_shortest_first() -> None:
    commands = commands_of("halt: [please] stop [now]\ngo")
    assert commands.named(["halt"], 3) == ["stop", "please stop", "stop now"]
    assert commands.named(["go", "stop now", "fly"], 3) == ["go", "stop now"]


@pytest.mark.parametrize(
    ("text", "may_be"),
    [
        ("make coffee", True),
        ("make coffee with milk", True),
        ("make coffee with milk and sugar", False),
        ("make coffee with", False),  # no sentence
        ("turn to twenty", False),  # twenty-five is another number
        ("go back", False),  # it has no slots
        ("go back two meters", False),
    ],
)
def test_a_sentence_may_be_extended_by_what_changes_none_of_its_slots(
    text: str, may_be: bool
) -> None:
    commands = commands_of(
        "make: make {drink} [with {more} [and {most}]]\ndrink = coffee | tea\nmore = milk\n"
        "most = sugar\nturn to {angle: 5..90 by 5}\ngo back [{far: 1..3} meters]"
    )
    assert commands.may_be_extended(text) == may_be


@given(st.sets(st.lists(WORD, min_size=1, max_size=4).map(" ".join), min_size=2))
def test_all_that_differ_in_one_word_are_neighbors(sentences: set[str]) -> None:
    listed = sorted(sentences)
    said, *others = listed
    near = {
        found.sentence
        for found in nearest(prefix_tree(listed), said.split(), LetterDistances(), 100, 1)
    }
    assert near == {other for other in others if one_change(said.split(), other.split())}


def one_change(one: list[str], other: list[str]) -> bool:
    if len(one) == len(other):
        return sum(a != b for a, b in zip(one, other, strict=True)) == 1
    short, long = sorted((one, other), key=len)
    return len(long) == len(short) + 1 and any(
        long[:at] + long[at + 1 :] == short for at in range(len(long))
    )
