"""Writes the matrix of promises into docs/promises.md and docs/safety.md; `make promises` calls it.

The cells are what `tests/promises` runs; the times are measured now, in stepped time.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable
from pathlib import Path

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT / "tests"))


def replaced(text: str, name: str, lines: Iterable[str]) -> str:
    """Put lines in a document between the marks of a name."""
    begin, end = f"<!-- {name} -->", f"<!-- end of {name} -->"
    found = re.compile(f"{re.escape(begin)}.*?{re.escape(end)}", re.DOTALL)
    new = "\n".join([begin, *lines, end])
    changed, times = found.subn(lambda _: new, text)
    if times != 1:
        raise SystemExit(f"the marks of {name} are not there once")
    return changed


def main() -> None:
    """Write the tables."""
    from promises import tables

    promises, safety = ROOT / "docs" / "promises.md", ROOT / "docs" / "safety.md"
    text = promises.read_text(encoding="utf-8")
    text = replaced(text, "doors", tables.doors_table())
    text = replaced(text, "exits", tables.exits_table())
    text = replaced(text, "times", tables.times())
    promises.write_text(text, encoding="utf-8")
    text = safety.read_text(encoding="utf-8")
    safety.write_text(replaced(text, "promises", tables.promises_in_words()), encoding="utf-8")


if __name__ == "__main__":
    main()
