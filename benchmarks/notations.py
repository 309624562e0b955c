"""How many sentences of Home Assistant's own lists voz can take, and why it refuses the others.

    pip download --no-deps home-assistant-intents && unzip home_assistant_intents-*.whl
    python benchmarks/notations.py home_assistant_intents/data/{en,es,fr}.json

Each block of sentences is compiled alone, with the rules and lists of its language, and with a few
names, areas and floors, which Home Assistant has of its user. What voz gives of blocks that need a
context, or of words that nobody listed, is counted as left out.
"""

from __future__ import annotations

import json
import re
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from voz.errors import CommandsError
from voz.language.compile_templates import compile_templates
from voz.language.formats.yaml_formats import Yaml, parse_hassil

OF_THE_USER = {
    "name": {"values": ["lamp", "door"]},
    "area": {"values": ["kitchen", "hall"]},
    "floor": {"values": ["first", "second"]},
}

MAX_REASONS = 12
"""Reasons that are shown of each language."""


def main() -> None:
    """Print a table, and the reasons."""
    print("| language | sentences | built | left out | refused |\n|---|---|---|---|---|")
    reasons: Counter[str] = Counter()
    for path in map(Path, sys.argv[1:]):
        counts: Counter[str] = Counter()
        for number, (what, why) in blocks(json.loads(path.read_text(encoding="utf-8"))):
            counts[what] += number
            reasons[why] += number
        shown = " | ".join(f"{counts[what]:,}" for what in ("built", "left out", "refused"))
        print(f"| {path.stem} | {counts.total():,} | {shown} |")
    del reasons[""]
    for why, number in reasons.most_common(MAX_REASONS):
        print(f"{number:5}  {why}")


def blocks(data: dict[str, Any]) -> Iterator[tuple[int, tuple[str, str]]]:
    """Yield the number of sentences of each block, and what becomes of it, with the reason."""
    common: dict[str, Any] = {"expansion_rules": data.get("expansion_rules", {})}
    common["lists"] = OF_THE_USER | data.get("lists", {})
    for intent, content in data["intents"].items():
        for block in content["data"]:
            list_of_block = {**common, "intents": {intent: {"data": [block]}}}
            text = json.dumps(list_of_block, ensure_ascii=False)
            yield len(block["sentences"]), outcome(text)


def outcome(text: str) -> tuple[str, str]:
    """Return what becomes of a block, and why."""
    try:
        built = compile_templates(parse_hassil(Yaml(text.encode(), "a")))
    except CommandsError as error:
        kind = "left out" if "left out" in str(error) else "refused"
        return kind, plain(str(error))
    left_out = [line for line in built.warnings if "left out" in line]
    return ("left out", plain(left_out[0])) if left_out else ("built", "")


def plain(message: str) -> str:
    """Return a message without its place, and without what it quotes."""
    message = message.removesuffix("; no other sentence is there").partition(": ")[2]
    return re.sub(r' ?\("[^"]*", a:[^)]*\)|\d+ (?=sentences are)', "", message)


if __name__ == "__main__":
    main()
