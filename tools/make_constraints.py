#!/usr/bin/env python3
"""Write constraints.txt, the versions that tools/install.sh installs, for `make constraints`.

The versions that are installed here are those that were tested, and come first. Where one is not
made for another Python or processor, uv takes the newest that is, with a ready-made wheel if there
is any.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections.abc import Iterable, Mapping
from importlib.metadata import distributions
from pathlib import Path
from typing import NamedTuple

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parent.parent
CONSTRAINTS = ROOT / "constraints.txt"

PYTHONS = ("3.10", "3.11", "3.12", "3.13", "3.14")
MACHINES = ("x86_64", "aarch64")

SYSTEM = "manylinux_2_35"
"""The C library of Ubuntu 22.04, the oldest system that the README names."""

BUILT = "pocketsphinx"
"""It has no wheels for all Pythons on ARM; pip builds it there."""

WITHOUT_WHEEL = "docopt"
"""What num2words needs; it is one file, and has no wheel at all."""

HEADER = """\
# The versions that tools/install.sh installs, those that voz was tested with; the ranges are in
# pyproject.toml. Made by `make constraints`; do not edit.
"""


class Target(NamedTuple):
    """A Python on a processor."""

    python: str
    machine: str


TARGETS = [Target(python, machine) for python in PYTHONS for machine in MACHINES]

Versions = Mapping[str, str]
"""Of packages, by their names."""


def installed() -> Versions:
    """What is installed where this program runs."""
    return {canonicalize_name(one.metadata["Name"]): one.version for one in distributions()}


def resolve(uv: Path, target: Target, preferred: Versions) -> Versions:
    """Find a version of each package that voz needs in any of its parts.

    Args:
        uv: the program.
        target: for what.
        preferred: what to take wherever that can be.
    """
    with tempfile.TemporaryDirectory() as folder:
        found = Path(folder, "found.txt")
        for how in (
            ["--only-binary=:all:", f"--no-binary={WITHOUT_WHEEL}"],
            [f"--no-binary={BUILT}"],
        ):
            found.write_text(lines_of(preferred))  # uv keeps to what is in its output
            command = [
                *(uv, "pip", "compile", "--quiet", "--no-header", "--no-annotate"),
                *("--python-version", target.python),
                *("--python-platform", f"{target.machine}-{SYSTEM}"),
                *("--extra", "dev", "--extra", "docs", "--output-file", found),
                *how,
                ROOT / "pyproject.toml",
            ]
            done = subprocess.run([*map(str, command)], capture_output=True, text=True)
            if done.returncode == 0:
                return versions_in(found.read_text())
    raise SystemExit(f"{target.python} on {target.machine}: {done.stderr}")


def versions_in(text: str) -> Versions:
    """Read lines of `name==version`."""
    pinned = [Requirement(line) for line in text.splitlines() if line and line[0] not in "#-"]
    return {canonicalize_name(one.name): str(one.specifier)[2:] for one in pinned}


def lines_of(versions: Versions) -> str:
    """Write lines of `name==version`."""
    return "".join(f"{name}=={version}\n" for name, version in sorted(versions.items()))


def merged(found: Mapping[Target, Versions]) -> list[str]:
    """Put the versions for all targets into lines, with markers where they differ."""
    lines = []
    for name in sorted({name for versions in found.values() for name in versions}):
        by_version: dict[str, list[Target]] = {}
        for target, versions in found.items():
            if name in versions:
                by_version.setdefault(versions[name], []).append(target)
        for version, targets in by_version.items():
            marker = f" ; {marker_for(targets)}" if len(by_version) > 1 else ""
            lines.append(f"{name}=={version}{marker}")
    return lines


def marker_for(targets: Iterable[Target]) -> str:
    """Write in the way of PEP 508 which targets are meant."""
    machines: dict[str, list[str]] = {}
    for target in targets:
        machines.setdefault(target.python, []).append(target.machine)
    return " or ".join(
        f'python_version == "{python}"'
        + (f' and platform_machine == "{on[0]}"' if len(on) < len(MACHINES) else "")
        for python, on in machines.items()
    )


def main() -> None:
    """Find the versions for all targets, and write them."""
    preferred = installed()
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([sys.executable, "-m", "venv", folder], check=True)
        pip = [f"{folder}/bin/python", "-m", "pip", "install", "--quiet", "uv"]
        subprocess.run(pip, check=True)
        uv = Path(folder, "bin", "uv")
        found = {target: resolve(uv, target, preferred) for target in TARGETS}
    CONSTRAINTS.write_text(HEADER + "".join(f"{line}\n" for line in merged(found)))


if __name__ == "__main__":
    main()
