"""The commands of a template without a name: one for each way to say something else; pure.

Without a name a template means what was said, without what may be left out: `[please] (open|close)
door` is two commands. What tells apart within one command stands in a slot.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import islice, product

from voz.language.sentences.expression import (
    Choice,
    Concatenation,
    Expression,
    NumberRange,
    Permutation,
    ResolvedReference,
    may_be_empty,
    numbers_in,
)
from voz.language.sentences.templates import Advice, Template
from voz.language.sentences.text_lines import error_at

MAX_COMMANDS_OF_TEMPLATE = 500
"""More alternatives are a slot, or have a name that the user forgot."""


def by_commands(templates: Iterable[Template], advice: Advice) -> list[Template]:
    """Split each template without a name into those of its commands; raises CommandsError."""
    return [one for template in templates for one in _commands(template, advice)]


def _commands(template: Template, advice: Advice) -> list[Template]:
    if template.command is not None:
        return [template]
    each = list(islice(_meanings(template.expression), MAX_COMMANDS_OF_TEMPLATE + 1))
    if len(each) > MAX_COMMANDS_OF_TEMPLATE:
        raise error_at(
            template.place,
            f"makes more than {MAX_COMMANDS_OF_TEMPLATE} commands; {advice.name}",
        )
    return [replace(template, expression=one) for one in each]


def _meanings(item: Expression) -> Iterator[Expression]:
    """Yield expressions with one meaning each, which together have the same sentences."""
    if isinstance(item, Choice) and not (item.synonyms or may_be_empty(item)):
        for one in item.items:
            yield from _meanings(one)
    elif isinstance(item, Concatenation | Permutation):
        for parts in product(*(_some_meanings(one) for one in item.items)):
            yield replace(item, items=parts)
    elif isinstance(item, NumberRange):
        for number in numbers_in(item):
            yield replace(item, first=number, last=number)
    elif isinstance(item, ResolvedReference) and item.kind == "rule":
        whole = list(_some_meanings(item.item))
        if len(whole) == 1:
            yield item
        else:
            yield from whole
    else:
        yield item


def _some_meanings(item: Expression) -> list[Expression]:
    return list(islice(_meanings(item), MAX_COMMANDS_OF_TEMPLATE + 1))
