"""How many public lists of other programs voz can take, and why it refuses the others.

    pip download --no-deps home-assistant-intents && unzip home_assistant_intents-*.whl
    python benchmarks/notations.py home_assistant_intents/data/{en,es,fr}.json lists/jsgf

Of Home Assistant each block of sentences is compiled alone, with the rules and lists of its
language, and with a few names, areas and floors, which Home Assistant has of its user. What voz
gives of blocks that need a context, or of words that nobody listed, is counted as left out.
Of a folder each file in it is compiled, whatever its language.
"""

from __future__ import annotations

import json
import re
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from voz.errors import CommandsError
from voz.language.formats.command_list import is_templates, parse_commands, read_templates
from voz.language.formats.yaml_formats import Yaml, parse_hassil
from voz.language.template_compiler import compile_templates

OF_THE_USER = {
    "name": {"values": ["lamp", "door"]},
    "area": {"values": ["kitchen", "hall"]},
    "floor": {"values": ["first", "second"]},
}

MAX_REASONS = 40
"""Reasons that are shown."""


def main() -> None:
    """Print a table, and the reasons."""
    print("| of | tried | built | left out | refused |\n|---|---|---|---|---|")
    reasons: Counter[str] = Counter()
    for path in map(Path, sys.argv[1:]):
        counts: Counter[str] = Counter()
        for number, (what, why) in files(path) if path.is_dir() else blocks(path):
            counts[what] += number
            reasons[why] += number
        shown = " | ".join(f"{counts[what]:,}" for what in ("built", "left out", "refused"))
        print(f"| {path.stem} | {counts.total():,} | {shown} |")
    del reasons[""]
    for why, number in reasons.most_common(MAX_REASONS):
        print(f"{number:5}  {why}")


def files(folder: Path) -> Iterator[tuple[int, tuple[str, str]]]:
    """Yield what becomes of each file of a folder, with the reason."""
    for path in sorted(path for path in folder.iterdir() if path.is_file()):
        yield 1, outcome(partial(compiled, path), f"{path.name}: ")


def compiled(path: Path) -> Sequence[str]:
    """Compile a list; returns the warnings."""
    data = path.read_bytes()
    if not is_templates(path, data):
        return parse_commands(data, path.name).warnings
    return compile_templates(read_templates(path)[0]).warnings


def blocks(path: Path) -> Iterator[tuple[int, tuple[str, str]]]:
    """Yield the number of sentences of each block, and what becomes of it, with the reason."""
    data = json.loads(path.read_text(encoding="utf-8"))
    common: dict[str, Any] = {"expansion_rules": data.get("expansion_rules", {})}
    common["lists"] = OF_THE_USER | data.get("lists", {})
    for intent, content in data["intents"].items():
        for block in content["data"]:
            list_of_block = {**common, "intents": {intent: {"data": [block]}}}
            text = json.dumps(list_of_block, ensure_ascii=False)
            yield len(block["sentences"]), outcome(partial(compiled_hassil, text.encode()))


def compiled_hassil(data: bytes) -> Sequence[str]:
    """Compile intents of hassil; returns the warnings."""
    return compile_templates(parse_hassil(Yaml(data, "a"))).warnings


def outcome(build: Callable[[], Sequence[str]], name: str = "") -> tuple[str, str]:
    """Return what becomes of a list, and why, after a name; `build` returns its warnings."""
    try:
        warnings = build()
    except CommandsError as error:
        kind = "left out" if "left out" in str(error) else "refused"
        return kind, name + plain(str(error))
    left_out = [line for line in warnings if "left out" in line]
    return ("left out", name + plain(left_out[0])) if left_out else ("built", "")


def plain(message: str) -> str:
    """Return a message without its place, and without what it quotes."""
    message = message.removesuffix("; no other sentence is there").partition(": ")[2]
    return re.sub(r' ?\("[^"]*", a:[^)]*\)|\d+ (?=sentences are)', "", message)


if __name__ == "__main__":
    main()
