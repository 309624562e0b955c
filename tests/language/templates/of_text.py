"""Templates from a text, as in a file."""

from __future__ import annotations

from voz.language.templates.commands import Commands
from voz.language.templates.compiling import Compiled, compiled
from voz.language.templates.sentences import parse_templates


def compile_text(text: str) -> Compiled:
    return compiled(parse_templates(text.encode(), "l.txt"))


def commands_of(text: str) -> Commands:
    return compile_text(text).commands
