"""How the folders of voz hang together: each name once, and no arrow up."""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator
from graphlib import TopologicalSorter

from recordings import ROOT

LATE = {("robot", "ros1"), ("robot", "ros2")}
"""`voz/robot/kinds.py` makes what is above it, by a name that the user gave."""

MODULES = {
    path.relative_to(ROOT).with_suffix("").parts: ast.parse(path.read_text("utf-8"))
    for path in (ROOT / "voz").rglob("*.py")
}


def imported(module: ast.Module) -> Iterator[str]:
    """The folders and modules of voz itself that a module imports, anywhere in it."""
    for part in ast.walk(module):
        if isinstance(part, ast.ImportFrom) and part.module:
            names = [f"{part.module}.{name.name}" for name in part.names]
        else:
            names = [name.name for name in part.names] if isinstance(part, ast.Import) else []
        yield from (name.split(".")[1] for name in names if name.startswith("voz."))


def test_no_two_classes_have_one_name() -> None:
    parts = (part for module in MODULES.values() for part in ast.walk(module))
    names = Counter(part.name for part in parts if isinstance(part, ast.ClassDef))
    assert names["Utterance"] == 1
    assert not [name for name, number in names.items() if number > 1]


def test_no_folder_imports_what_is_above_it() -> None:
    below: dict[str, set[str]] = {}
    for (_, folder, *_rest), module in MODULES.items():
        if folder != "__init__":
            below.setdefault(folder, set()).update(set(imported(module)) - {folder})
    assert below["run"] > {"control", "events", "inbox"}
    for above, folder in LATE:
        below[above].remove(folder)
    list(TopologicalSorter(below).static_order())  # raises CycleError where there is an arrow up
