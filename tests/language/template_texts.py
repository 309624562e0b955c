"""Templates from a text, as in a file."""

from __future__ import annotations

from voz.language.formats.notation import parse_templates
from voz.language.sentences.command_set import Commands
from voz.language.template_compiler import CompiledTemplates, compile_templates


def compile_text(text: str) -> CompiledTemplates:
    return compile_templates(parse_templates(text.encode(), "l.txt"))


def commands_of(text: str) -> Commands:
    return compile_text(text).commands
