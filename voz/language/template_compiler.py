"""Compiles the templates of all files to commands; pure."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice, product

from voz.errors import CommandsError
from voz.language.sentences.command_set import Commands, Meaning, SlotReader
from voz.language.sentences.expression import (
    NO_WORDS,
    Choice,
    Concatenation,
    Expression,
    NumberRange,
    Permutation,
    ResolvedReference,
    Size,
    Word,
    children,
    default_name,
    may_be_empty,
    numbers_in,
    size,
    tagged_wordings,
)
from voz.language.sentences.templates import (
    Advice,
    Definition,
    Template,
    TemplateSource,
    reference_text,
    resolve,
)
from voz.language.sentences.text_lines import error_at, summarize_warnings
from voz.language.template_states import (
    MAX_JOINED_STATES,
    MAX_TEMPLATE_ARCS,
    SharedSentence,
    TooManyArcsError,
    TooManyStatesError,
    join_readers,
    lay_out,
)

MAX_TEMPLATE_WORDS = 30
"""Words of one sentence; a plain list allows 12."""

MAX_SENTENCES = 10**10
"""No recognizer distinguishes more."""

MAX_READINGS = 50
"""Interpretations of one ambiguous sentence that are compared."""


@dataclass(frozen=True)
class LineCost:
    """What a line of a file adds."""

    name: str  # of the rule or list, or the command of the template
    place: str  # `FILE:LINE`
    sentences: int  # number of sentences; for a rule or list, of wordings
    states: int  # of the search; 0 for a rule or list
    used_by: int  # number of templates that contain it


@dataclass(frozen=True)
class CompiledTemplates:
    """Compiled templates."""

    commands: Commands  # the sentences and what they mean
    templates: Sequence[Template]  # without references
    warnings: tuple[str, ...]  # what the user should know, one line each
    places: Mapping[str, str]  # where each word stands first, as `FILE:LINE`
    costs: Sequence[LineCost]  # what each template, rule and list adds


def compile_templates(source: TemplateSource) -> CompiledTemplates:
    """Compile the templates of all files together; raises CommandsError."""
    if not (source.templates or source.left_out):
        raise CommandsError(f"{source.name}: contains no command; {source.advice.sentence}")
    written, warnings = resolve(source)
    if not written:
        raise CommandsError(f"{warnings[0]}; no other sentence is there")
    _check_sizes(written)
    templates = by_commands(written, source.advice)
    readers = [_reader(template) for template in templates]
    try:
        automaton, shared = join_readers(readers)
    except TooManyStatesError:
        raise CommandsError(
            f"{source.name}: has more than {MAX_JOINED_STATES:,} states; "
            "make lists shorter, or begin templates with different words"
        ) from None
    lines = {place: n for n, place in enumerate(dict.fromkeys(one.place for one in templates))}
    meanings = [
        Meaning(
            template.command or default_name(template.expression),
            dict(template.constants),
            one if _has_slots(one) else None,
            lines[template.place],
        )
        for template, one in zip(templates, readers, strict=True)
    ]
    told = [
        line
        for one in shared
        for line in _ambiguous(one, templates, meanings, lenient=source.lenient)
    ]
    summary = f"{source.name}: {len(told)} sentences are there twice, or can be read in two ways"
    warnings = (*warnings, *summarize_warnings(told, summary))
    states = [len(one.arcs) for one in readers]
    commands = Commands(automaton, meanings)
    costs = [*_costs_of_templates(templates, commands, states), *_costs_of_names(source, templates)]
    return CompiledTemplates(commands, templates, warnings, _places(source), costs)


def _check_sizes(templates: Iterable[Template]) -> None:
    known: dict[int, Size] = {}
    total = 0
    for template in templates:
        ways, longest = size(template.expression, known)
        total += ways
        if longest > MAX_TEMPLATE_WORDS:
            raise error_at(
                template.place,
                f"has up to {longest} words; at most {MAX_TEMPLATE_WORDS} are allowed",
            )
        if total > MAX_SENTENCES:
            raise error_at(
                template.place,
                f"this makes {total:,} sentences; make lists shorter "
                f"or leave options out: at most {MAX_SENTENCES:,}",
            )


def _reader(template: Template) -> SlotReader:
    try:
        laid_out = lay_out(template.expression)
    except TooManyArcsError:
        raise error_at(
            template.place,
            f"has more than {MAX_TEMPLATE_ARCS:,} words with its lists and options expanded; "
            "use fewer lists in one template",
        ) from None
    if 0 in laid_out.ends:
        raise error_at(template.place, 'everything is optional; remove "[...]" from one part')
    return laid_out


def _has_slots(one: SlotReader) -> bool:
    return any(marks for arcs in one.arcs for found in arcs.values() for _, marks in found)


def _ambiguous(
    shared: SharedSentence,
    templates: Sequence[Template],
    meanings: Sequence[Meaning],
    *,
    lenient: bool,
) -> Iterator[str]:
    """Refuse or warn of a sentence that two templates give, or one in two ways."""
    first, second = templates[shared.first], templates[shared.second]
    words = shared.sentence.split()
    if first is second:
        slots = meanings[shared.first].reader
        readings = islice(slots.readings(words), MAX_READINGS) if slots else ()
        different = list(dict.fromkeys(map(_in_words, readings)))
        if len(different) > 1:
            yield (
                f'{first.place}: "{shared.sentence}" can be read as {" or as ".join(different[:2])}'
                "; the first is taken"
            )
        return
    one, other = (_means(meanings[number], words) for number in (shared.first, shared.second))
    if one == other:
        yield f'{second.place}: "{shared.sentence}" is there twice (first in {first.place})'
        return
    taken = f'"{shared.sentence}" is a sentence of "{one[0]}" already ({first.place})'
    if not (lenient or first.place == second.place):
        raise error_at(second.place, f"{taken}; take it out of one of them")
    yield f"{second.place}: {taken}, and means that"


def _means(meaning: Meaning, words: Sequence[str]) -> tuple[str, str]:
    slots = (meaning.reader.slots(words) if meaning.reader else None) or {}
    return meaning.command, _in_words({**meaning.constants, **slots})


def _in_words(slots: Mapping[str, object]) -> str:
    return ", ".join(f"{name}={value}" for name, value in sorted(slots.items())) or "no slot"


def _places(source: TemplateSource) -> dict[str, str]:
    places: dict[str, str] = {}
    held: list[Definition | Template] = [*source.definitions.values(), *source.templates]
    for definition in held:
        for word in _words(definition.expression):
            places.setdefault(word, f"{definition.place.file}:{definition.place.line}")
    for word in _words(source.skipped or NO_WORDS):
        places.setdefault(word, source.name)
    return places


def _words(item: Expression) -> Iterator[str]:
    if isinstance(item, Word):
        yield item.text
    elif isinstance(item, NumberRange):
        yield from _words(tagged_wordings(item))
    for inner in children(item):
        yield from _words(inner)


def _costs_of_templates(
    templates: Sequence[Template], commands: Commands, states: Sequence[int]
) -> Iterator[LineCost]:
    sentences = commands.automaton.counts_by_label
    for number, template in enumerate(templates):
        name = template.command or default_name(template.expression)
        place = f"{template.place.file}:{template.place.line}"
        yield LineCost(name, place, sentences.get(number, 0), states[number], 1)


def _costs_of_names(source: TemplateSource, templates: Sequence[Template]) -> Iterator[LineCost]:
    known: dict[int, Size] = {}
    holding: dict[tuple[str, str], int] = {}
    ways: dict[tuple[str, str], int] = {}
    for template in templates:
        for named in set(_names(template.expression, set())):
            key = named.kind, named.name
            holding[key] = holding.get(key, 0) + 1
            ways[key] = size(named, known).ways
    for (kind, name), definition in source.definitions.items():
        place = f"{definition.place.file}:{definition.place.line}"
        if (kind, name) in ways:
            used_by = holding[kind, name]
            yield LineCost(reference_text(kind, name), place, ways[kind, name], 0, used_by)


def _names(item: Expression, seen: set[int]) -> Iterator[ResolvedReference]:
    if isinstance(item, ResolvedReference):
        if id(item) in seen:
            return
        seen.add(id(item))
        yield item
    for inner in children(item):
        yield from _names(inner, seen)


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
