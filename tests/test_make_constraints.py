"""The versions that are installed: one of each package, for every Python and processor."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from make_constraints import CONSTRAINTS, TARGETS, Target, merged
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from recordings import ROOT

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
EXTRAS = PROJECT["optional-dependencies"]


def environment(target: Target) -> dict[str, str]:
    return {
        "python_version": target.python,
        "python_full_version": f"{target.python}.9",
        "platform_machine": target.machine,
        "sys_platform": "linux",
    }


def applies(requirement: Requirement, target: Target) -> bool:
    return requirement.marker is None or requirement.marker.evaluate(environment(target))


def lines() -> list[Requirement]:
    text = CONSTRAINTS.read_text().splitlines()
    return [Requirement(line) for line in text if not line.startswith("#")]


def needed(names: list[str], target: Target) -> Iterator[Requirement]:
    """What voz needs on a target, with all that extras name in turn."""
    for requirement in map(Requirement, names):
        if applies(requirement, target):
            if requirement.name == PROJECT["name"]:
                for extra in requirement.extras:
                    yield from needed(EXTRAS[extra], target)
            else:
                yield requirement


@pytest.mark.parametrize("target", TARGETS, ids=" ".join)
def test_what_voz_needs_has_one_version_within_its_range(target: Target) -> None:
    versions: dict[str, str] = {}
    for line in lines():
        if applies(line, target):
            (pin,) = line.specifier
            assert pin.operator == "=="
            assert canonicalize_name(line.name) not in versions
            versions[canonicalize_name(line.name)] = pin.version
    for requirement in needed([*PROJECT["dependencies"], *EXTRAS["dev"], *EXTRAS["docs"]], target):
        assert requirement.specifier.contains(versions[canonicalize_name(requirement.name)])


def test_no_line_says_where_a_package_comes_from() -> None:
    assert not [line for line in lines() if line.url]
    assert "://" not in CONSTRAINTS.read_text()


@given(
    st.dictionaries(
        st.sampled_from(TARGETS),
        st.dictionaries(st.sampled_from(["one", "two"]), st.sampled_from(["1.0", "2.0", "3.0"])),
    )
)
def test_each_target_gets_back_its_versions(found: dict[Target, dict[str, str]]) -> None:
    requirements = [Requirement(line) for line in merged(found)]
    for target, versions in found.items():
        for name, version in versions.items():
            (got,) = [r for r in requirements if r.name == name and applies(r, target)]
            assert str(got.specifier) == f"=={version}"


@pytest.mark.slow
def test_the_installation_reads_the_file(tmp_path: Path) -> None:
    """By a line that pip complains of, before it fetches anything."""
    shutil.copytree(ROOT / "tools", tmp_path / "tools")
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    (tmp_path / "constraints.txt").write_text("numpy is wanted\n")
    (tmp_path / "other.txt").write_text("soxr is wanted\n")
    subprocess.run([sys.executable, "-m", "venv", tmp_path / ".venv"], check=True)
    install = ["sh", str(tmp_path / "tools" / "install.sh")]
    for name, complaint in ("", "numpy is wanted"), ("other.txt", "soxr is wanted"):
        environment = os.environ | {"CONSTRAINTS": name}
        done = subprocess.run(install, capture_output=True, text=True, env=environment)
        assert done.returncode
        assert f"Invalid requirement: '{complaint}" in done.stderr
    assert not list((tmp_path / ".venv").glob("installed*"))
