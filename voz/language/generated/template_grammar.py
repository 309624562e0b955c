"""The JSGF grammar of templates, with their rules, groups and options; pure.

pocketsphinx copies a rule wherever it is named: memory grows with the templates, not with their
sentences. Weights make all sentences equally likely.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from itertools import permutations

from voz.language.generated.jsgf_grammar import GRAMMAR_NAME, tree_alternatives
from voz.language.sentences.expression import (
    Choice,
    Concatenation,
    Expression,
    NumberRange,
    Optional,
    Permutation,
    ResolvedReference,
    Slot,
    Tag,
    Word,
)
from voz.language.sentences.expression_size import Size, size
from voz.language.sentences.number_range import numbers_in
from voz.language.sentences.number_words import wordings


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
            said = dict.fromkeys(text for number in numbers_in(item) for text in wordings(number))
            self._names[item] = self._rule("number", " | ".join(tree_alternatives(said)))
        return f"<{self._names[item]}>"

    def _rule(self, name: str, body: str) -> str:
        number = 1
        while (unique := name if number == 1 else f"{name}_{number}") in {*self.rules, "command"}:
            number += 1
        self.rules[unique] = body
        return unique
