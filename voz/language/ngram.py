"""The trigram language model in ARPA format, by the formulas of lmtool's QuickLM; pure.

http://www.speech.cs.cmu.edu/tools/lmtool.html: half of the probability of every history is kept
for unseen words ("discount mass 0.5"), the other half goes by relative frequency; the back-off
weights follow from that (Katz's ratio method, without cut-offs). Models of others are checked:
damaged ones crash pocketsphinx.
"""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Collection, Iterable, Mapping, Sequence
from math import log10
from typing import TypeAlias

DISCOUNT = 0.5
NGRAM_ORDER = 3

SENTENCE_MARKS = ("<s>", "</s>")

UNKNOWN_WORDS = {"<unk>", "<UNK>"}
"""Any other word, in models of other programs."""

MAX_NGRAM_ORDER = 5
"""The longest n-grams that pocketsphinx supports."""

MAX_LOG_PROBABILITY = 100.0
"""Absolute value, base 10; programs write -99 for what never happens."""

Gram: TypeAlias = tuple[str, ...]


def arpa(sentences: Sequence[str]) -> str:
    """Compute the trigram model of normalized sentences, as the text of an ARPA file."""
    counts = [_count(sentences, n) for n in range(1, NGRAM_ORDER + 1)]
    probabilities = [_probabilities(longer, shorter) for shorter, longer in _with_shorter(counts)]
    lines = [
        f"Trigram model of {len(sentences)} sentences by voz, computed as lmtool's QuickLM does.",
        "",
        "\\data\\",
        *(f"ngram {n}={len(grams)}" for n, grams in enumerate(counts, start=1)),
    ]
    for n, grams in enumerate(probabilities, start=1):
        longer = probabilities[n] if n < NGRAM_ORDER else {}
        lines += ["", f"\\{n}-grams:", *_section(grams, longer, is_last=n == NGRAM_ORDER)]
    return "\n".join([*lines, "", "\\end\\", ""])


def _count(sentences: Iterable[str], n: int) -> Counter[Gram]:
    """Count the runs of n words, with the sentence marks."""
    counts: Counter[Gram] = Counter()
    for sentence in sentences:
        words = (SENTENCE_MARKS[0], *sentence.split(), SENTENCE_MARKS[1])
        counts.update(zip(*(words[start:] for start in range(n)), strict=False))
    return counts


def _with_shorter(
    counts: Sequence[Counter[Gram]],
) -> Iterable[tuple[Mapping[Gram, int], Counter[Gram]]]:
    total: Mapping[Gram, int] = {(): counts[0].total()}
    return zip([total, *counts], counts, strict=False)


def _probabilities(counts: Mapping[Gram, int], histories: Mapping[Gram, int]) -> dict[Gram, float]:
    return {gram: DISCOUNT * count / histories[gram[:-1]] for gram, count in counts.items()}


def _section(
    grams: Mapping[Gram, float], longer: Mapping[Gram, float], is_last: bool
) -> Iterable[str]:
    seen: dict[Gram, float] = defaultdict(float)
    for gram in longer:
        seen[gram[:-1]] += grams[gram[1:]]
    for gram, probability in sorted(grams.items()):
        backoff = "" if is_last else f" {_log(DISCOUNT / (1 - seen[gram]))}"
        yield f"{_log(probability)} {' '.join(gram)}{backoff}"


def _log(probability: float) -> str:
    return f"{round(log10(probability), 4) + 0.0:.4f}"


def check_arpa(text: str, words: Collection[str]) -> None:
    """Check a model with these words as strictly as pocketsphinx needs it; raises ValueError."""
    _, found, body = f"\n{text}".partition("\n\\data\\\n")
    counts, *sections = [part.split("\n") for part in re.split(r"\n{2,}", body.strip())]
    numbers = [_NUMBER_OF_GRAMS.fullmatch(line.strip()) for line in counts]
    orders = [int(match[1]) for match in numbers if match]
    if (
        not found
        or len(orders) < len(counts)
        or orders != [*range(1, MAX_NGRAM_ORDER + 1)][: len(counts)]
    ):
        raise ValueError("it does not say how many n-grams there are")
    if len(sections) != len(orders) + 1 or [line.strip() for line in sections[-1]] != ["\\end\\"]:
        raise ValueError("a part is missing or in the wrong place")
    shorter: Collection[Gram] = [()]
    known = {*words, *SENTENCE_MARKS, *UNKNOWN_WORDS}
    for order, (match, (title, *lines)) in enumerate(zip(numbers, sections, strict=False), start=1):
        if title.strip() != f"\\{order}-grams:" or not match or int(match[2]) != len(lines):
            raise ValueError(f"there are not as many {order}-grams as it says")
        shorter = _grams(lines, order, len(orders), shorter, known)
        if order == 1:
            known = {word for (word,) in shorter}
            if not known.issuperset(SENTENCE_MARKS):
                raise ValueError(f"{SENTENCE_MARKS[0]} or {SENTENCE_MARKS[1]} is missing")


_NUMBER_OF_GRAMS = re.compile(r"ngram ([1-9])=([0-9]{1,9})", re.ASCII)
_LOG = re.compile(r"[-+]?[0-9]{1,3}(\.[0-9]{1,20})?([eE][-+]?[0-9]{1,2})?", re.ASCII)


def _grams(
    lines: Sequence[str], order: int, last: int, shorter: Collection[Gram], known: set[str]
) -> Collection[Gram]:
    grams: dict[Gram, None] = {}
    for line in lines:
        probability, *rest = line.split() or [""]
        gram, backoff = tuple(rest[:order]), rest[order:]
        usable = (
            len(gram) == order
            and len(backoff) <= (order < last)
            and _is_log(probability)
            and float(probability) <= 0
            and all(map(_is_log, backoff))
            and gram not in grams
            and gram[:-1] in shorter
            and known.issuperset(gram)
        )
        if not usable:
            raise ValueError(f'invalid line "{line.strip()[:60]}"')
        grams[gram] = None
    return grams


def _is_log(text: str) -> bool:
    return bool(_LOG.fullmatch(text)) and abs(float(text)) <= MAX_LOG_PROBABILITY
