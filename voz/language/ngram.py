"""The trigram language model in ARPA format, by the formulas of lmtool's QuickLM. Does no I/O.

http://www.speech.cs.cmu.edu/tools/lmtool.html: half of the probability of every history is kept
for what was not seen ("discount mass 0.5"), the other half goes by relative frequency; the
back-off weights follow from that (Katz's ratio method, without cut-offs).
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from math import log10
from typing import TypeAlias

DISCOUNT = 0.5
ORDER = 3

Gram: TypeAlias = tuple[str, ...]


def arpa(sentences: Sequence[str]) -> str:
    """Compute the trigram model of some sentences.

    Args:
        sentences: normalised sentences, one word or more in each.

    Returns:
        The model as the text of an ARPA file.
    """
    counts = [_count(sentences, n) for n in range(1, ORDER + 1)]
    probabilities = [_probabilities(longer, shorter) for shorter, longer in _with_shorter(counts)]
    lines = [
        f"Trigram model of {len(sentences)} sentences by voz, computed as lmtool's QuickLM does.",
        "",
        "\\data\\",
        *(f"ngram {n}={len(grams)}" for n, grams in enumerate(counts, start=1)),
    ]
    for n, grams in enumerate(probabilities, start=1):
        longer = probabilities[n] if n < ORDER else {}
        lines += ["", f"\\{n}-grams:", *_section(grams, longer, is_last=n == ORDER)]
    return "\n".join([*lines, "", "\\end\\", ""])


def _count(sentences: Iterable[str], n: int) -> Counter[Gram]:
    """Count the runs of n words, with the marks of the sentences' ends."""
    counts: Counter[Gram] = Counter()
    for sentence in sentences:
        words = ("<s>", *sentence.split(), "</s>")
        counts.update(zip(*(words[start:] for start in range(n)), strict=False))
    return counts


def _with_shorter(
    counts: Sequence[Counter[Gram]],
) -> Iterable[tuple[Mapping[Gram, int], Counter[Gram]]]:
    """Pair the counts of each length with those of the histories."""
    total: Mapping[Gram, int] = {(): counts[0].total()}
    return zip([total, *counts], counts, strict=False)


def _probabilities(counts: Mapping[Gram, int], histories: Mapping[Gram, int]) -> dict[Gram, float]:
    """Compute P(last word | the words before it) from the counts."""
    return {gram: DISCOUNT * count / histories[gram[:-1]] for gram, count in counts.items()}


def _section(
    grams: Mapping[Gram, float], longer: Mapping[Gram, float], is_last: bool
) -> Iterable[str]:
    """Write the lines of one length of n-grams, sorted; the longest have no back-off weight."""
    seen: dict[Gram, float] = defaultdict(float)
    for gram in longer:
        seen[gram[:-1]] += grams[gram[1:]]
    for gram, probability in sorted(grams.items()):
        backoff = "" if is_last else f" {_log(DISCOUNT / (1 - seen[gram]))}"
        yield f"{_log(probability)} {' '.join(gram)}{backoff}"


def _log(probability: float) -> str:
    """Write a logarithm to the base 10 with four decimals, never as -0.0000."""
    return f"{round(log10(probability), 4) + 0.0:.4f}"
