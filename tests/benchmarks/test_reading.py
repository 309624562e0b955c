"""`benchmarks/reading.py`: how long README takes, and how hard the documents are to read."""

from __future__ import annotations

import re
import runpy

import pytest
from benchmark_programs import printed
from recordings import ROOT

PROGRAM = runpy.run_path(str(ROOT / "benchmarks" / "reading.py"))

grade, sentences = PROGRAM["grade"], PROGRAM["sentences"]


def test_readme_takes_four_minutes_and_most_sentences_of_the_documents_are_easy() -> None:
    readme, docs, *rest = printed("reading", "--count", 3, "--worst", 2)
    assert float(re.findall(r"([\d.]+) minutes", readme)[0]) <= 4
    middle, high = map(float, re.findall(r"(?:grade|above) ([\d.]+)", docs))
    assert middle <= 6
    assert high <= 10
    assert len([line for line in rest if re.match(r" *-?\d+\.\d  \S+\.md: ", line)]) == 5


def test_the_grade_of_a_sentence_is_that_of_the_formula() -> None:
    assert grade("the cat sat on the mat") == pytest.approx(0.39 * 6 + 11.8 * 6 / 6 - 15.59)
    assert grade("an automatic renewal") == pytest.approx(0.39 * 3 + 11.8 * 8 / 3 - 15.59)
    assert grade("call `voz build-lm --check` now") == grade("call it now")


def test_sentences_are_those_of_paragraphs_and_lists() -> None:
    page = (
        "# A heading of five words\n\nIt stops at once here. "
        "Then you\nmay [say it](a.md) again.\n\n"
        "| a | table of no less words |\n\n- **Stop.** It stops when you say `stop`. Too short.\n"
        "```\nno sentence of a block\n```\n"
    )
    assert [*sentences(page)] == [
        "It stops at once here",
        "Then you may say it again",
        "It stops when you say `stop`",
    ]
