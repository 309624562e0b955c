"""A card of commands as an HTML page to print. Pure."""

from __future__ import annotations

import html
import re
from collections.abc import Sequence

from voz.apps.card.command_card import CardEntry, CommandCard
from voz.apps.web.command_buttons import LISTEN

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
    """Write a page that needs no other file, network or script.

    Args:
        card: the commands.
        name: of the list.
        icon: SVG.

    Returns:
        The page, which a browser prints on A4.
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
    values = "".join(_values(*each) for each in entry.values.items())
    return (
        f'<div class="command">{arrow if arrows else ""}<div>{said}'
        f'<p class="does">{_sentence(entry.does)}</p>{values}</div></div>\n'
    )


def _values(slot: str, values: Sequence[str]) -> str:
    each = "".join(f"<dd>{html.escape(value)}</dd>" for value in values)
    return f"<dl><dt>{html.escape(slot)}</dt>{each}</dl>"


def _sentence(text: str) -> str:
    """A text with its slots set apart."""
    return re.sub(r"\{(\w+)\}", r"<i>\1</i>", html.escape(text))
