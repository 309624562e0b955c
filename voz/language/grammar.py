"""Grammars for pocketsphinx; pure.

JSGF (https://www.w3.org/TR/jsgf/) is what `voz build-lm` writes: of a list as a tree, since
pocketsphinx loads whole sentences slowly and `go ( forward | back )` is many times smaller; of
templates with their rules, groups and options. Templates are recognized by a finite state grammar
(FSG), which is loaded without copies: JSGF of 50,000 sentences takes 470 MB. Weights make all
sentences equally likely.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from itertools import permutations
from typing import TypeAlias

from voz.language.sentences.automaton import NO_LABEL, Automaton
from voz.language.sentences.expression import (
    Choice,
    Concatenation,
    Expression,
    NumberRange,
    Optional,
    Permutation,
    ResolvedReference,
    Size,
    Slot,
    Tag,
    Word,
    numbers_in,
    size,
)
from voz.language.sentences.spelling import wordings

GRAMMAR_NAME = "comandos_voz"


class _Node(dict[str, "_Node"]):
    """The words that can follow a beginning; `ends` says that it is a sentence."""

    ends = False


def jsgf(sentences: Iterable[str]) -> str:
    """Write a JSGF file whose public rule `<command>` accepts exactly these sentences."""
    rule = "\n    | ".join(tree_alternatives(sentences))
    return f"#JSGF V1.0;\n\ngrammar {GRAMMAR_NAME};\n\npublic <command> =\n      {rule}\n    ;\n"


def tree_alternatives(sentences: Iterable[str]) -> list[str]:
    """Write the alternatives of some sentences, with common beginnings shared."""
    return _alternatives(_tree(sentences))[0]


def _tree(sentences: Iterable[str]) -> _Node:
    root = _Node()
    for sentence in sentences:
        node = root
        for word in sentence.split():
            node = node.setdefault(word, _Node())
        node.ends = True
    return root


def _alternatives(node: _Node) -> tuple[list[str], int]:
    """Write what can follow a prefix, and count the sentences."""
    written = [(word, *_rest(child)) for word, child in node.items()]
    alone = len(written) == 1 and not node.ends
    texts = [
        (f"/{count}/ " if count > 1 and not alone else "") + word + rest
        for word, rest, count in written
    ]
    return texts, node.ends + sum(count for _, _, count in written)


def _rest(node: _Node) -> tuple[str, int]:
    texts, count = _alternatives(node)
    joined = " | ".join(texts)
    if not texts:
        return "", count
    if node.ends:
        return f" [ {joined} ]", count
    return (f" ( {joined} )" if len(texts) > 1 else f" {joined}"), count


def structured_jsgf(expressions: Iterable[Expression]) -> str:
    """Write a JSGF file with one public rule, `<command>`, for expressions without references."""
    writer = _Writer()
    alternatives = writer.alternatives(list(expressions), "\n    | ")
    rules = "".join(f"\n<{name}> = {body};\n" for name, body in writer.rules.items())
    public = f"public <command> =\n      {alternatives}\n    ;\n"
    return f"#JSGF V1.0;\n\ngrammar {GRAMMAR_NAME};\n\n{public}{rules}"


class _Writer:
    def __init__(self) -> None:
        self.rules: dict[str, str] = {}
        self._names: dict[int | NumberRange, str] = {}
        self._kept: list[Expression] = []  # else another could get the id of one
        self._sizes: dict[int, Size] = {}

    def alternatives(self, items: Sequence[Expression], between: str = " | ") -> str:
        """Write alternatives, with weights where some have more sentences than others."""
        ways = [size(item, self._sizes).ways for item in items]
        weighted = max(ways) > 1 and len(items) > 1
        return between.join(
            (f"/{count}/ " if weighted else "") + self.write(item)
            for count, item in zip(ways, items, strict=True)
        )

    def write(self, item: Expression) -> str:
        if isinstance(item, Word):
            return item.text
        if isinstance(item, Concatenation):
            return " ".join(map(self.write, item.items)) or "<NULL>"
        if isinstance(item, Choice):
            return f"( {self.alternatives(item.items)} )"
        if isinstance(item, Optional):
            ways = size(item.item, self._sizes).ways
            return f"[ {f'/{ways}/ ' if ways > 1 else ''}{self.write(item.item)} ]"
        if isinstance(item, Permutation):
            orders = (" ".join(map(self.write, order)) for order in permutations(item.items))
            return f"( {' | '.join(orders)} )"
        if isinstance(item, NumberRange):
            return self._numbers(item)
        if isinstance(item, ResolvedReference):
            return self._named(item)
        assert isinstance(item, (Tag, Slot))
        return self.write(item.item)

    def _named(self, item: ResolvedReference) -> str:
        if id(item) not in self._names:
            self._kept.append(item)
            body = self.write(item.item)
            self._names[id(item)] = self._rule(re.sub(r"\W", "_", item.name), body)
        return f"<{self._names[id(item)]}>"

    def _numbers(self, item: NumberRange) -> str:
        if item not in self._names:
            said = dict.fromkeys(
                text for n in numbers_in(item) for text in wordings(n, item.language)
            )
            self._names[item] = self._rule("number", " | ".join(tree_alternatives(said)))
        return f"<{self._names[item]}>"

    def _rule(self, name: str, body: str) -> str:
        number = 1
        while (unique := name if number == 1 else f"{name}_{number}") in {*self.rules, "command"}:
            number += 1
        self.rules[unique] = body
        return unique


FsgArc: TypeAlias = tuple[int, int, float, str] | tuple[int, int, float]
"""From state, to state, probability, and a word unless a sentence ends."""


def to_fsg(automaton: Automaton) -> tuple[list[FsgArc], int]:
    """Write an automaton as arcs from state 0 on, and name the final state."""
    arcs: list[FsgArc] = []
    end = len(automaton.arcs)
    for state, following in enumerate(automaton.arcs):
        count = automaton.counts[state]
        for word, to in following.items():
            arcs.append((state, to, automaton.counts[to] / count, word))
        if automaton.labels[state] != NO_LABEL:
            arcs.append((state, end, 1 / count))
    return arcs, end
