"""What may be said, as patterns with slots, and what each does: a page to print. Does I/O."""

from __future__ import annotations

import html
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import islice, product
from pathlib import Path

from voz.apps.command_buttons import LISTEN, command_group, command_place, find_steps
from voz.control.steps import Amount, Step
from voz.control.table import DEFAULT_STATE, CommandTable, Steps, is_selection
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
from voz.language.template_compiler import compile_templates

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


def describe_steps(steps: Sequence[Step]) -> str:
    """Describe the steps of a command, as in `drives forward at 0.1 m/s, then stands still`.

    Slots stay as they are, in braces. Without a step it is a matter of the robot's own program.
    """
    if not steps:
        return "is up to the robot's program"
    return ", then ".join(map(_step, steps))


def _step(step: Step) -> str:
    parts = [_action(step)] if step.actions else []
    if step.say is not None:
        parts.append(f"says “{step.say}”")
    if step.play is not None:
        parts.append(f"plays {step.play}")
    told = ", and ".join(parts)
    if isinstance(step.confirm, str):
        return f"asks “{step.confirm}”, then {told}"
    return f"asks first, then {told}" if step.confirm else told


def _action(step: Step) -> str:
    (action,) = step.actions
    if action in ("drive", "turn", "rotate"):
        return _motion(step)
    if action in ("publish", "run", "call"):
        return _outside(step)
    fixed = {
        "faster": "goes faster",
        "slower": "goes slower",
        "stop": "stands still",
        "again": "does the last motion again",
        "listen": "wakes up" if step.listen else "stands still and sleeps",
        "answer": "answers yes" if step.answer else "answers no",
        "state": f"goes on to “{step.state}”" if step.state else "goes back to the first commands",
    }
    return fixed[action]


def _motion(step: Step) -> str:
    if step.drive is not None:
        parts = ["drives" + _side(step.drive, " forward", " back")]
        parts += [f"{_shown(step.metres)} m"] if step.metres is not None else []
        parts += [f"at {abs(step.drive):g} m/s"] if isinstance(step.drive, float | int) else []
    elif step.turn is not None:
        parts = ["turns" + _side(step.turn, " left", " right"), "while it drives"]
    else:
        assert step.rotate is not None
        parts = ["turns" + _side(step.rotate, " left", " right"), "on the spot"]
    if step.degrees is not None:
        parts.append(f"by {_shown(step.degrees)}°")
    if step.seconds is not None:
        parts.append(f"for {_shown(step.seconds)} s")
    return " ".join(parts)


def _outside(step: Step) -> str:
    if step.run is not None:
        return f"starts {step.run[0]}"
    if step.call is not None:
        return f"calls {str(step.call[0]).rpartition(':')[2]}"
    if is_selection(step):
        return f"selects object {step.publish}"
    value = str(step.publish).lower() if isinstance(step.publish, bool) else step.publish
    return f"sends {value} to {step.topic}"


def _side(amount: Amount, positive: str, negative: str) -> str:
    """Which way a velocity leads; a slot says it itself."""
    if isinstance(amount, str):
        return ""
    return positive if amount > 0 else negative


def _shown(amount: Amount) -> str:
    return amount if isinstance(amount, str) else f"{amount:g}"


@dataclass(frozen=True)
class CardEntry:
    """A command."""

    texts: tuple[str, ...]  # how it may be said, with slots in braces
    does: str  # what it does, in words
    values: dict[str, tuple[str, ...]]  # what may be said for each slot
    place: str | None = None  # where its button stands on the direction pad; None elsewhere


@dataclass(frozen=True)
class CommandCard:
    """The commands of a list."""

    stops: tuple[str, ...]  # how the robot is stopped
    # The other commands by what they do, what begins and ends the listening first.
    groups: dict[str, list[CardEntry]]


def command_card(patterns: Sequence[Pattern], table: CommandTable) -> CommandCard:
    """Put the patterns of a list, in its order, with what they do into groups."""
    by_name: dict[str, list[Pattern]] = {}
    for pattern in patterns:
        by_name.setdefault(pattern.command, []).append(pattern)
    stops = tuple(p.text for p in patterns if p.command in table.stops)
    groups: dict[str, list[CardEntry]] = {LISTEN: []}
    for name, ways in by_name.items():
        if name not in table.stops:
            steps = find_steps(table, name)
            groups.setdefault(command_group(steps), []).append(_entry(table, name, ways, steps))
    return CommandCard(stops, {name: entries for name, entries in groups.items() if entries})


def card_lines(card: CommandCard) -> Iterator[str]:
    """Yield the lines of a card for a terminal."""
    entries = [entry for group in card.groups.values() for entry in group]
    width = max(map(len, (_said(entry.texts) for entry in entries)), default=0)
    yield f"{' or '.join(card.stops)}: stands still, at any time" if card.stops else "nothing stops"
    for name, group in card.groups.items():
        yield f"{name}:"
        for entry in group:
            yield f"  {_said(entry.texts):{width}}  {entry.does}"
            for slot, values in entry.values.items():
                yield f"  {'':{width}}  {{{slot}}}: {', '.join(values)}"


def _said(texts: Sequence[str]) -> str:
    return " or ".join(texts)


def _entry(table: CommandTable, name: str, patterns: Sequence[Pattern], steps: Steps) -> CardEntry:
    does = describe_steps(steps)
    values: dict[str, tuple[str, ...]] = {}
    for pattern in patterns:
        values |= pattern.values
        for slot, shown in pattern.slots.items():
            does = does.replace(f"{{{slot}}}", f"{{{shown}}}")
    states = [state for state, own in table.sets.items() if name in own]
    if states and DEFAULT_STATE not in states:
        does = f"in “{states[0]}”: {does}"
    texts = tuple(dict.fromkeys(pattern.text for pattern in patterns))
    return CardEntry(texts, does, values, command_place(steps))


ARROWS = {
    "forward": "↑", "back": "↓", "turn-left": "↰", "turn-right": "↱", "rotate-left": "↺",
    "rotate-right": "↻", "faster": "»", "slower": "«",
}  # fmt: skip
"""By the place on the direction pad."""

STOP_NOTE = "Works at any time, asleep or not; so do the space bar and Escape."
NO_STOP_NOTE = "No command of this list stops the robot."
SWITCH_NOTE = (
    "A spoken stop may not be heard: "
    "a robot that can hurt someone needs a switch that cuts its power."
)

STYLE = """
:root { --ink: #10151b; --faint: #4d5865; --line: #ccd3db; --chip: #eef1f5; --stop: #c40d17;
  --robot: #5b3fd6; color-scheme: light; font: 11pt/1.35 system-ui, sans-serif; }
:root.few { font-size: 14pt; }
@page { size: A4; margin: 14mm; }
* { box-sizing: border-box; print-color-adjust: exact; -webkit-print-color-adjust: exact; }
body { max-width: 182mm; margin: 0 auto; color: var(--ink); background: #fff; }
@media screen { body { max-width: 202mm; padding: 10mm; } }
h1, h2, p, dl, dd { margin: 0; padding: 0; }
header { display: flex; align-items: center; gap: 5mm; margin-bottom: 5mm; }
header svg { width: 14mm; flex: none; }
h1 { font-size: 26pt; line-height: 1.1; letter-spacing: -.01em; }
header p { color: var(--faint); font-size: 11pt; overflow-wrap: anywhere; }
.stop { display: flex; align-items: center; gap: 8mm; padding: 5mm 8mm 6mm; margin-bottom: 6mm;
  border-radius: 5mm; background: var(--stop); color: #fff; break-inside: avoid; }
.stop strong { font-size: 60pt; line-height: 1; font-weight: 800; }
.stop .others { font-size: 1.4rem; font-weight: 700; }
.listening .commands { display: grid; grid-template-columns: 1fr 1fr; column-gap: 8mm; }
.groups { columns: 2; column-gap: 8mm; }
section { margin-bottom: 5mm; }
.groups section.short { break-inside: avoid; }
h2 { margin-bottom: 1mm; font-size: .8rem; letter-spacing: .08em; text-transform: uppercase;
  color: var(--robot); break-after: avoid; }
.command { display: flex; gap: 3mm; padding: 1.6mm 0; border-top: .3mm solid var(--line);
  break-inside: avoid; }
.arrow { width: 1.5rem; flex: none; text-align: center; font-size: 1.5rem; line-height: 1;
  color: var(--robot); }
.said { font-size: 1.25rem; font-weight: 700; line-height: 1.2; overflow-wrap: anywhere; }
.said + .said { font-size: 1rem; font-weight: 600; }
.said + .said::before { content: "or "; color: var(--faint); font-weight: 400; }
.does { color: var(--faint); overflow-wrap: anywhere; }
i { font-style: normal; padding: 0 .3em; border-radius: .3em; background: var(--chip);
  color: var(--robot); }
dl { display: flex; flex-wrap: wrap; gap: 1mm; padding-top: 1mm; font-size: .9rem; }
dt { color: var(--robot); font-weight: 600; }
dd { padding: 0 1.6mm; border: .3mm solid var(--line); border-radius: 1.6mm; }
footer { margin-top: 3mm; color: var(--faint); font-size: 9pt; }
"""

FEW_ROWS = 16
"""Commands, and values of slots, with which the type is larger and still fits on a page."""

SHORT_GROUP = 10
"""Commands of a group that is not divided."""


def card_page(card: CommandCard, name: str, icon: str) -> str:
    """Write a page that a browser prints on A4; it needs no other file, network or script.

    It has the name of the list, and the icon as SVG.
    """
    groups = {name: _group(name, entries) for name, entries in card.groups.items()}
    listening = groups.pop(LISTEN, "")
    rows = [row for entries in card.groups.values() for e in entries for row in (e, *e.values)]
    size = ' class="few"' if len(rows) <= FEW_ROWS else ""
    return (
        f'<!DOCTYPE html>\n<html lang="en"{size}>\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width">\n'
        f"<title>What the robot obeys</title>\n<style>{STYLE}</style>\n</head>\n<body>\n"
        f"<header>{icon}<div><h1>What the robot obeys</h1>"
        f"<p>The commands of {html.escape(name)}</p></div></header>\n"
        f'<main>\n{_stop(card.stops)}<div class="listening">{listening}</div>\n'
        f'<div class="groups">\n{"".join(groups.values())}</div>\n</main>\n'
        f"<footer>{SWITCH_NOTE}</footer>\n</body>\n</html>\n"
    )


def _stop(stops: Sequence[str]) -> str:
    if not stops:
        return f'<div class="stop"><p>{NO_STOP_NOTE}</p></div>\n'
    first, *others = map(_sentence, stops)
    more = f'<p class="others">or {", ".join(others)}</p>' if others else ""
    return f'<div class="stop"><strong>{first}</strong><div>{more}<p>{STOP_NOTE}</p></div></div>\n'


def _group(name: str, entries: Sequence[CardEntry]) -> str:
    arrows = any(entry.place in ARROWS for entry in entries)
    commands = "".join(_command(entry, arrows) for entry in entries)
    short = ' class="short"' if len(entries) <= SHORT_GROUP else ""
    title = f"<h2>{html.escape(name)}</h2>"
    return f'<section{short}>{title}\n<div class="commands">{commands}</div></section>\n'


def _command(entry: CardEntry, arrows: bool) -> str:
    arrow = f'<span class="arrow" aria-hidden="true">{ARROWS.get(entry.place or "", "")}</span>'
    said = "".join(f'<p class="said">{_sentence(text)}</p>' for text in entry.texts)
    values = "".join(_values_html(*each) for each in entry.values.items())
    return (
        f'<div class="command">{arrow if arrows else ""}<div>{said}'
        f'<p class="does">{_sentence(entry.does)}</p>{values}</div></div>\n'
    )


def _values_html(slot: str, values: Sequence[str]) -> str:
    each = "".join(f"<dd>{html.escape(value)}</dd>" for value in values)
    return f"<dl><dt>{html.escape(slot)}</dt>{each}</dl>"


def _sentence(text: str) -> str:
    """A text with its slots set apart."""
    return re.sub(r"\{(\w+)\}", r"<i>\1</i>", html.escape(text))
