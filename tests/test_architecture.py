"""How the folders of voz hang together: each name once, and no arrow up."""

from __future__ import annotations

import ast
import os
import re
import shutil
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from graphlib import TopologicalSorter
from pathlib import Path

from recordings import ROOT

LATE = {("events", "notebook"), ("robot", "ros1"), ("robot", "ros2")}
"""What is above is used where a notebook shows an utterance, and for a robot that was named."""

MODULES = {
    path.relative_to(ROOT).with_suffix("").parts: ast.parse(path.read_text("utf-8"))
    for path in (ROOT / "voz").rglob("*.py")
}


def imported(module: ast.Module, package: str = "voz") -> Iterator[str]:
    """The folders and modules of a package that a module imports, anywhere in it."""
    level = package.count(".") + 1
    for part in ast.walk(module):
        if isinstance(part, ast.ImportFrom) and part.module:
            names = [f"{part.module}.{name.name}" for name in part.names]
        else:
            names = [name.name for name in part.names] if isinstance(part, ast.Import) else []
        yield from (name.split(".")[level] for name in names if name.startswith(f"{package}."))


PRIVATE_IN_TEXT = re.compile(r"(?<!\bself)(?<!\bcls)\.(_[a-z]\w*)|^(_[a-z]\w*)$")


def defined(module: ast.AST) -> Iterator[str]:
    """All names that a module gives to functions, classes, variables and attributes."""
    for part in ast.walk(module):
        if isinstance(part, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            yield part.name
        elif isinstance(part, ast.Attribute) and isinstance(part.ctx, ast.Store):
            yield part.attr
        elif isinstance(part, ast.Name) and isinstance(part.ctx, ast.Store):
            yield part.id


def reached(module: ast.AST) -> Iterator[tuple[int, str]]:
    """What a module reaches into others for: the line, and the last part of the name.

    What a class does to itself or to its base is its own.
    """
    for part in ast.walk(module):
        if isinstance(part, ast.Attribute):
            owner = part.value.func if isinstance(part.value, ast.Call) else part.value
            if not (isinstance(owner, ast.Name) and owner.id in ("self", "cls", "super")):
                yield part.lineno, part.attr
        elif isinstance(part, ast.ImportFrom):
            yield from ((part.lineno, each.name) for each in part.names)
        elif isinstance(part, ast.Constant) and isinstance(part.value, str):
            # As for `monkeypatch.setattr`, or in a program that a test starts.
            yield from (
                (part.lineno, name)
                for names in PRIVATE_IN_TEXT.findall(part.value)
                for name in names
            )


def run_voz(folder: Path, *arguments: object) -> str:
    """What a copy of voz in a folder prints; it must end well."""
    command = [sys.executable, "-m", "voz", *map(str, arguments)]
    environment = os.environ | {"PYTHONPATH": str(folder)}
    done = subprocess.run(command, env=environment, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_no_two_classes_have_one_name() -> None:
    parts = (part for module in MODULES.values() for part in ast.walk(module))
    names = Counter(part.name for part in parts if isinstance(part, ast.ClassDef))
    assert names["Utterance"] == 1
    assert not [name for name, number in names.items() if number > 1]


def test_no_test_reaches_for_what_is_private() -> None:
    named = {name for module in MODULES.values() for name in defined(module)}
    private = {name for name in named if name.startswith("_") and name.strip("_")}
    private = {name for name in private if not name.endswith("_")}
    assert len(private) > 500
    found = [
        f"{path.relative_to(ROOT)}:{line}: {name}"
        for path in (ROOT / "tests").rglob("*.py")
        for line, name in reached(ast.parse(path.read_text("utf-8")))
        if name in private
    ]
    assert not found


def test_no_folder_imports_what_is_above_it() -> None:
    below: dict[str, set[str]] = {}
    for (_, folder, *_rest), module in MODULES.items():
        if folder != "__init__":
            below.setdefault(folder, set()).update(set(imported(module)) - {folder})
    assert below["run"] > {"control", "events", "inbox"}
    for above, folder in LATE:
        below[above].remove(folder)
    list(TopologicalSorter(below).static_order())  # raises CycleError where there is an arrow up


def test_the_parts_of_language_import_one_way() -> None:
    below: dict[str, set[str]] = {}
    for path, module in MODULES.items():
        if path[:2] == ("voz", "language") and path[2] != "__init__":
            names = set(imported(module, "voz.language")) - {path[2]}
            below.setdefault(path[2], set()).update(names)
    assert below["sentences"] == below["acoustic_model"] - {"phones"} == set()
    assert below["formats"] == {"sentences"}
    list(TopologicalSorter(below).static_order())


def test_recognition_imports_one_way() -> None:
    below: dict[str, set[str]] = {}
    for path, module in MODULES.items():
        if path[:2] == ("voz", "recognition") and path[2] != "__init__":
            names = set(imported(module, "voz.recognition")) - {path[2]}
            below.setdefault(path[2], set()).update(names)
    assert below["network"] == {"language"}
    assert below["pocketsphinx"] == {"language", "thresholds"}
    assert below["thresholds"] == {"confidence"}
    assert below["language"] == below["confidence"] == set()
    list(TopologicalSorter(below).static_order())


def test_the_core_imports_nothing_that_stands_around_it() -> None:
    around = {"apps", "cli"}
    core = {path: module for path, module in MODULES.items() if around.isdisjoint(path)}
    assert len(core) > 100
    found = {"/".join(path) for path, module in core.items() if around & set(imported(module))}
    assert found == {"voz/__init__", "voz/__main__"}  # which names it, and loads it when asked for


def test_a_robot_obeys_without_what_stands_around_the_core(tmp_path: Path) -> None:
    shutil.copytree(ROOT / "voz", tmp_path / "voz", ignore=shutil.ignore_patterns("apps"))
    commands = ROOT / "audio_fixtures" / "commands"
    printed = run_voz(tmp_path, "run", "--wav", commands / "festival_kal__start_speech.flac")
    assert 'heard    "start speech"' in printed


def test_recordings_are_decoded_without_page_doctor_and_services(tmp_path: Path) -> None:
    others = shutil.ignore_patterns("web", "wyoming", "doctor", "systemd.py")
    shutil.copytree(ROOT / "voz", tmp_path / "voz", ignore=others)
    commands = ROOT / "audio_fixtures" / "commands"
    assert "go back" in run_voz(tmp_path, "decode", commands / "festival_kal__go_back.flac")
