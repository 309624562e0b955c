from __future__ import annotations

import math
import re

from hypothesis import given
from hypothesis import strategies as st

from voz.language.grammar import jsgf

WORDS = st.sampled_from(["go", "back", "stop", "don't", "public", "null"])
SENTENCES = st.lists(st.lists(WORDS, min_size=1, max_size=6).map(" ".join), min_size=1, unique=True)


def expand(text: str) -> dict[str, float]:
    """Give each sentence of a grammar with its probability, as pocketsphinx reads weights."""
    rule = text.partition("public <command> =")[2].rpartition(";")[0]
    tokens = re.findall(r"/\d+/|[()\[\]|]|[a-z']+", rule)
    sentences = _alternatives(tokens)
    assert not tokens
    assert len(set(sentences)) == len(sentences)
    return sentences


def _alternatives(tokens: list[str], optional: bool = False) -> dict[str, float]:
    weighted = [(1.0, {"": 1.0})] if optional else []
    while True:
        weight = float(tokens.pop(0).strip("/")) if tokens[0].startswith("/") else 1.0
        weighted.append((weight, _sequence(tokens)))
        if not tokens or tokens[0] != "|":
            break
        tokens.pop(0)
    total = sum(weight for weight, _ in weighted)
    found: dict[str, float] = {}
    for weight, sentences in weighted:
        for sentence, probability in sentences.items():
            assert sentence not in found
            found[sentence] = weight / total * probability
    return found


def _sequence(tokens: list[str]) -> dict[str, float]:
    found = {"": 1.0}
    while tokens and tokens[0] not in ("|", ")", "]"):
        token = tokens.pop(0)
        part = {token: 1.0}
        if token in ("(", "["):
            part = _alternatives(tokens, optional=token == "[")
            assert tokens.pop(0) == {"(": ")", "[": "]"}[token]
        found = {f"{a} {b}".strip(): p * q for a, p in found.items() for b, q in part.items()}
    return found


def test_common_beginnings_are_shared_and_endings_are_optional():
    text = jsgf(["stop speech", "go forward", "go back", "stop"])
    assert text == (
        "#JSGF V1.0;\n\ngrammar comandos_voz;\n\npublic <command> =\n"
        "      /2/ stop [ speech ]\n    | /2/ go ( forward | back )\n    ;\n"
    )


def test_one_sentence_needs_no_group():
    assert "public <command> =\n      stop\n    ;" in jsgf(["stop"])


@given(SENTENCES)
def test_the_grammar_holds_exactly_the_sentences_each_as_likely(sentences: list[str]):
    expanded = expand(jsgf(sentences))
    assert set(expanded) == set(sentences)
    for probability in expanded.values():
        assert math.isclose(probability, 1 / len(sentences))
