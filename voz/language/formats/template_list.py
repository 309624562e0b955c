"""A file in voz's own notation: a template, a rule, a list or an import a line; pure."""

from __future__ import annotations

import re

from voz.language.formats.notation import NAME_PATTERN, Notation, list_body
from voz.language.formats.parser import Passage
from voz.language.formats.text_lines import numbered_lines
from voz.language.sentences.location import error_at
from voz.language.sentences.spelling import compose_accents
from voz.language.sentences.template_source import Template, TemplateSource

_MARKS = re.compile(rb"[()\[\]{}<>|;:=]")
_IMPORT = re.compile(r"\s*import\s+(\S*[./\\]\S*)\s*", re.IGNORECASE)
_TEMPLATE_RULE = re.compile(rf"\s*<({NAME_PATTERN})>\s*=", re.ASCII)
_LIST = re.compile(rf"\s*({NAME_PATTERN})\s*=", re.ASCII)
_COMMAND = re.compile(r"\s*([^\W\d][\w'-]*(?:[ \t]+[\w'-]+)*)\s*:")


def has_templates(data: bytes) -> bool:
    """Whether a command list has more than plain sentences; comments do not count."""
    lines = (line.partition(b"#")[0] for line in data.replace(b"\r", b"\n").split(b"\n"))
    return any(_MARKS.search(line) or _is_import(line) for line in lines)


def _is_import(line: bytes) -> bool:
    return bool(_IMPORT.fullmatch(line.decode("utf-8", "replace").strip("\ufeff")))


def parse_templates(data: bytes, name: str) -> TemplateSource:
    """Parse a file in voz's notation, UTF-8; `name` is for messages. Raises CommandsError."""
    source = TemplateSource(name)
    for number, whole in numbered_lines(data, name):
        text = whole.partition("#")[0].rstrip()
        if text.strip():
            _add(source, Passage(name, number, 0, text))
    return source


def _add(source: TemplateSource, line: Passage) -> None:
    place = line.place(len(line.text) - len(line.text.lstrip()))
    if match := _IMPORT.fullmatch(line.text):
        source.imports.append((match[1], line.place(match.start(1))))
    elif match := _TEMPLATE_RULE.match(line.text):
        body = Notation(_behind(line, match)).parse()
        source.define("rule", match[1], body, place)
    elif match := _LIST.match(line.text):
        source.define("list", match[1], list_body(_behind(line, match)), place)
    elif match := _COMMAND.match(line.text):
        expression = Notation(_behind(line, match)).parse()
        source.templates.append(
            Template(compose_accents(" ".join(match[1].split())), expression, place)
        )
    elif "=" in line.text:
        at = line.text.index("=")
        raise error_at(
            line.place(at),
            '"=" is allowed only after the name of a list or rule, as in: color = red | green',
        )
    else:
        source.templates.append(Template(None, Notation(line).parse(), place))


def _behind(line: Passage, match: re.Match[str]) -> Passage:
    if not line.text[match.end() :].strip():
        raise error_at(line.place(match.end() - 1), "nothing follows; write what is said")
    return line.part(match.end())
