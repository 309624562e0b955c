"""What may be said, as people who read it want it: patterns with slots. Does I/O."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import islice, product
from pathlib import Path

from voz.language.compile_templates import compile_templates
from voz.language.formats.command_list import (
    is_templates,
    parse_commands,
    read_file_or_names,
    read_templates,
)
from voz.language.sentences.expression import (
    Choice,
    Concatenation,
    Expression,
    NumberRange,
    Optional,
    Permutation,
    ResolvedReference,
    Slot,
    Word,
    children,
    default_name,
    plain_number,
)
from voz.language.sentences.templates import Template, slots

MAX_WORDINGS = 5
"""Wordings of one template; a template with slots has one."""

MAX_VALUES = 24
"""Values of one slot that are listed."""


@dataclass(frozen=True)
class Pattern:
    """One way to say a command."""

    command: str  # its name
    # Without what may be left out, but for slots, which are in brackets then; a slot is in braces,
    # by the name of its list.
    text: str
    # The list of each slot, by the slot's own name.
    slots: Mapping[str, str] = field(default_factory=dict)
    # What may be said for each list.
    values: Mapping[str, tuple[str, ...]] = field(default_factory=dict)


def read_patterns(path: Path) -> list[Pattern]:
    """Read the patterns of a list of commands, in its order, in any format.

    Raises:
        CommandsError: the list cannot be used.
    """
    data = read_file_or_names(path)
    if not is_templates(path, data):
        return [Pattern(text, text) for text in parse_commands(data, str(path)).sentences]
    source, _ = read_templates(path)
    return [pattern for one in compile_templates(source).templates for pattern in _patterns(one)]


def _patterns(template: Template) -> Iterator[Pattern]:
    item = template.expression
    command = template.command or default_name(item)
    found = slots(item, {}, [])
    lists = {name: _list_name(slot) for name, slot in found.items()}
    values = {_list_name(slot): tuple(_values(slot.item)) for slot in found.values()}
    for text in islice(_wordings(item), 1 if found else MAX_WORDINGS):
        yield Pattern(command, text, lists, values)


def _list_name(slot: Slot) -> str:
    return slot.item.name if isinstance(slot.item, ResolvedReference) else slot.name


def _wordings(item: Expression) -> Iterator[str]:
    """Yield the sentences of a template, without what may be left out and has no slot."""
    if isinstance(item, Word):
        yield item.text
    elif isinstance(item, Slot):
        yield f"{{{_list_name(item)}}}"
    elif isinstance(item, NumberRange):
        yield _range_text(item)
    elif isinstance(item, Optional):
        yield f"[{next(_wordings(item.item))}]" if slots(item, {}, []) else ""
    elif isinstance(item, (Concatenation, Permutation)):
        ways = (list(islice(_wordings(one), MAX_WORDINGS)) for one in item.items)
        yield from (" ".join(filter(None, words)) for words in product(*ways))
    else:
        for inner in children(item):
            yield from _wordings(inner)


def _values(item: Expression) -> Iterator[str]:
    """Yield what may be said for a slot; of very many values the first."""
    alternatives = list(_alternatives(item))
    for one in alternatives[:MAX_VALUES]:
        yield next(_wordings(one))
    if len(alternatives) > MAX_VALUES:
        yield f"{len(alternatives) - MAX_VALUES} more"


def _alternatives(item: Expression) -> Iterator[Expression]:
    if isinstance(item, Choice):
        for one in item.items:
            yield from _alternatives(one)
    elif isinstance(item, ResolvedReference):
        yield from _alternatives(item.item)
    else:
        yield item


def _range_text(numbers: NumberRange) -> str:
    first, last, step = map(plain_number, (numbers.first, numbers.last, numbers.step))
    if first == last:
        return str(first)
    return f"{first} to {last}" + (f", by {step}" if step != 1 else "")
