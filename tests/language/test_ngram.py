from __future__ import annotations

import math

from hypothesis import given
from hypothesis import strategies as st

from voz.language.ngram import arpa

WORDS = st.sampled_from(["go", "back", "stop", "don't", "left"])
SENTENCES = st.lists(st.lists(WORDS, min_size=1, max_size=5).map(" ".join), min_size=1, unique=True)


def test_five_one_word_sentences_give_the_published_figures():
    text = arpa(["one", "two", "three", "four", "five"])
    assert text.partition("\\data\\\n")[2] == EXPECTED


EXPECTED = """\
ngram 1=7
ngram 2=10
ngram 3=5

\\1-grams:
-0.7782 </s> -0.3010
-0.7782 <s> -0.2218
-1.4771 five -0.2218
-1.4771 four -0.2218
-1.4771 one -0.2218
-1.4771 three -0.2218
-1.4771 two -0.2218

\\2-grams:
-1.0000 <s> five 0.0000
-1.0000 <s> four 0.0000
-1.0000 <s> one 0.0000
-1.0000 <s> three 0.0000
-1.0000 <s> two 0.0000
-0.3010 five </s> -0.3010
-0.3010 four </s> -0.3010
-0.3010 one </s> -0.3010
-0.3010 three </s> -0.3010
-0.3010 two </s> -0.3010

\\3-grams:
-0.3010 <s> five </s>
-0.3010 <s> four </s>
-0.3010 <s> one </s>
-0.3010 <s> three </s>
-0.3010 <s> two </s>

\\end\\
"""


@given(SENTENCES)
def test_the_seen_words_share_half_of_the_probability(sentences: list[str]):
    lines = arpa(sentences).partition("\\1-grams:\n")[2].partition("\n\n")[0].splitlines()
    assert math.isclose(sum(10 ** float(line.split()[0]) for line in lines), 0.5, rel_tol=1e-3)


@given(SENTENCES)
def test_the_header_counts_the_entries_and_no_zero_is_negative(sentences: list[str]):
    text = arpa(sentences)
    for n in (1, 2, 3):
        section = text.partition(f"\\{n}-grams:\n")[2].partition("\n\n")[0].splitlines()
        assert f"ngram {n}={len(section)}\n" in text
    assert "-0.0000" not in text
