"""Templates from a text, as in a file."""

from __future__ import annotations

from voz.language.compile_templates import CompiledTemplates, compile_templates
from voz.language.formats.notation import parse_templates
from voz.language.sentences.command_set import Commands


def compile_text(text: str) -> CompiledTemplates:
    return compile_templates(parse_templates(text.encode(), "l.txt"))


def commands_of(text: str) -> Commands:
    return compile_text(text).commands
