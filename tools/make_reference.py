#!/usr/bin/env python3
"""Write the reference in docs/reference/ from the program itself; `make docs` calls this first."""

from __future__ import annotations

import inspect
import re
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, get_args

import msgspec
from msgspec import inspect as types

import voz
import voz.events
from voz.config import Config
from voz.events import (
    Attention,
    CallFunction,
    Event,
    Notice,
    Partial,
    Play,
    ProgramEnded,
    Publish,
    Reply,
    SelectedObject,
    StartProgram,
    Twist,
    Utterance,
    to_json,
)

ROOT = Path(__file__).parent.parent
REFERENCE = ROOT / "docs" / "reference"

SAMPLES: tuple[Event, ...] = (
    Utterance(
        5.62, "go forward", 0.998, True, 4.71, 5.58, "microphone", latency=0.18, obeyed=True,
        above=31.4, score=24.9, next_best="go back",
    ),
    Utterance(
        9.1, "stop", 0.21, False, 8.2, 8.9, "microphone", reason="not_a_command", latency=0.62,
        obeyed=False, above=18.0, score=-4.2, next_best="start speech",
    ),
    Partial(5.55, "stop", 0.53),
    Twist(5.7, 0.1, 0.0),
    SelectedObject(7.2, 1),
    Attention(7.4, awake=True, answers=("yes", "no")),
    Publish(7.3, "gripper", True),
    Reply(1.8, "bep bep. I am listening you"),
    Play(1.8, "backing-up"),
    StartProgram(8.0, ("fswebcam", "picture.jpg"), 10.0),
    CallFunction(8.1, "my_arm:wave", (3.0, "left")),
    ProgramEnded(9.2, "fswebcam", "exit code 1"),
    Notice(9.4, "the microphone is gone: the robot stops"),
)  # fmt: skip
"""One event of each type, and an utterance that is refused."""

API = {
    "To understand": ("load", "Recognizer", "Listener", "SpokenWord", "Alternative"),
    "Many recordings": ("decode_many", "Decoded", "read_results"),
    "To drive": ("Controller", "Robot", "Client"),
    "To be heard": ("SoundClient", "BuiltinSound"),
    "Settings": ("Config", "Recognition", "Safety", "load_config"),
}
"""What is not an event or an error, by what it is for."""


def main() -> None:
    """Write all pages."""
    REFERENCE.mkdir(parents=True, exist_ok=True)
    for name, text in pages().items():
        (REFERENCE / name).write_text(text, encoding="utf-8")


def pages() -> dict[str, str]:
    """Make the pages, by the names of their files."""
    return {
        "command-line.md": command_line(),
        "settings.md": settings(),
        "events.md": events(),
        "api.md": api(),
    }


def command_line() -> str:
    """Let typer describe all subcommands."""
    asked = [sys.executable, "-m", "typer", "voz.cli.subcommands", "utils", "docs", "--name", "voz"]
    done = subprocess.run(
        [*asked, "--title", "Command line"], cwd=ROOT, capture_output=True, text=True, check=True
    )
    return done.stdout


def settings() -> str:
    """Describe each table of `voz.toml`: its settings, what they may be and are, what they do."""
    tables = [field for field in msgspec.structs.fields(Config) if _is_table(field.type)]
    parts = [
        "# All settings\n\nWhat each may be; [Settings](../settings.md) shows a whole `voz.toml`.",
        "## Outside of any table\n\n" + _settings_of(Config, {field.name for field in tables}),
    ]
    for field in tables:
        about = inspect.getdoc(field.type) or ""
        parts.append(f"## [{field.name}]\n\n{_opening(about)}\n\n{_settings_of(field.type)}")
    return "\n\n".join(parts) + "\n"


def events() -> str:
    """Describe each event: its fields, and how it looks as JSON."""
    parts = ["# Events\n\n" + (inspect.getdoc(voz.events) or "")]
    parts.append(
        "`voz run --events FILE` writes them, and robots and programs get them as they are."
    )
    for kind in get_args(Event):
        tag = kind.__struct_config__.tag
        about = inspect.getdoc(kind) or ""
        shown = "\n".join(to_json(event) for event in SAMPLES if isinstance(event, kind))
        parts.append(
            f"## {tag}\n\n`voz.{kind.__name__}`. {_opening(about)}\n\n{_fields_of(kind)}\n\n"
            f"```json\n{shown}\n```"
        )
    return "\n\n".join(parts) + "\n"


def api() -> str:
    """List what `voz` offers, for mkdocstrings, and show the examples."""
    named = [kind.__name__ for kind in get_args(Event)]
    errors = [name for name in voz.__all__ if _is_error(name)]
    groups = {**API, "Events": (*named, "PossibleCommand"), "Errors": tuple(errors)}
    parts = ["# API\n\n" + (inspect.getdoc(voz) or "")]
    for title, names in groups.items():
        parts.append("\n\n".join([f"## {title}", *(f"::: voz.{name}" for name in names)]))
    parts.append("## Examples")
    for path in sorted((ROOT / "examples").glob("*.py")):
        parts.append(f"### {path.name}\n\n```python\n{path.read_text(encoding='utf-8')}```")
    return "\n\n".join(parts) + "\n"


def _settings_of(table: type[msgspec.Struct], left_out: set[str] | None = None) -> str:
    meaning = _attributes(inspect.getdoc(table) or "")
    rows = [
        (
            f"`{field.name}`",
            _in_words(types.type_info(field.type)),
            _default(field),
            meaning[field.name],
        )
        for field in msgspec.structs.fields(table)
        if field.name not in (left_out or ())
    ]
    return _table(("setting", "may be", "default", ""), rows)


def _fields_of(kind: type[msgspec.Struct]) -> str:
    meaning = _attributes(inspect.getdoc(kind) or "")
    rows = [
        (f"`{field.name}`", _in_words(types.type_info(field.type)), meaning[field.name])
        for field in msgspec.structs.fields(kind)
    ]
    return _table(("field", "is", ""), rows)


def _table(header: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> str:
    lines = [header, ("---",) * len(header), *rows]
    return "\n".join(
        f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in line)} |" for line in lines
    )


def _default(field: msgspec.structs.FieldInfo) -> str:
    if field.default is None:
        return "not set"
    if field.default is msgspec.NODEFAULT:
        return "empty"
    return f"`{msgspec.json.encode(field.default).decode()}`"


def _in_words(kind: types.Type) -> str:
    """Say what a value may be, as TOML and JSON have it."""
    if isinstance(kind, types.UnionType):
        return " or ".join(_in_words(t) for t in kind.types if not isinstance(t, types.NoneType))
    if isinstance(kind, types.IntType | types.FloatType):
        return _number(kind)
    if isinstance(kind, types.LiteralType):
        return ", ".join(f"`{value}`" for value in kind.values)
    if isinstance(kind, types.TupleType):
        return f"[{', '.join(map(_in_words, kind.item_types))}]"
    if isinstance(kind, types.VarTupleType):
        return f"list of {_in_words(kind.item_type)}"
    if isinstance(kind, types.StructType):
        return f"[{kind.cls.__name__}](api.md#voz.{kind.cls.__name__})"
    return {types.BoolType: "true or false", types.StrType: "text"}.get(type(kind), "table")


def _number(kind: types.IntType | types.FloatType) -> str:
    name = "whole number" if isinstance(kind, types.IntType) else "number"
    bounds = (("from", kind.ge), ("above", kind.gt), ("to", kind.le))
    return " ".join(
        [name, *(f"{word} {_plain(bound)}" for word, bound in bounds if bound is not None)]
    )


def _plain(bound: float) -> str:
    return f"{bound:,.3f}".rstrip("0").rstrip(".")


def _attributes(about: str) -> Mapping[str, str]:
    """Read what a docstring says of each attribute."""
    _, _, listed = about.partition("Attributes:\n")
    entries = re.findall(r"^    (\w+): (.+(?:\n {8}.+)*)", listed, re.MULTILINE)
    return {name: " ".join(text.split()) for name, text in entries}


def _opening(about: str) -> str:
    return " ".join(about.partition("Attributes:")[0].split())


def _is_table(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, msgspec.Struct)


def _is_error(name: str) -> bool:
    found = getattr(voz, name)
    return isinstance(found, type) and issubclass(found, Exception)


if __name__ == "__main__":
    main()
