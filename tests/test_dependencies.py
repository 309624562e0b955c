"""The versions that voz may be installed with have none of the holes that are known."""

from __future__ import annotations

import re
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st
from make_constraints import TARGETS, Target, merged
from packaging.requirements import Requirement
from packaging.version import Version
from recordings import ROOT

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

MENDED_IN = {
    "cryptography": "44.0.1",  # CVE-2024-12797, its OpenSSL
    "dask": "2026.1",  # CVE-2026-23528, of distributed, which has the same version
    "h11": "0.16",  # CVE-2025-43859
    "pyarrow": "14.0.1",  # CVE-2023-47248
    "starlette": "0.49.1",  # CVE-2025-62727
    "torch": "2.6",  # CVE-2025-32434
}

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]

EXTRAS = PROJECT["optional-dependencies"].values()

REQUIRED = {
    one.name: one
    for line in [*PROJECT["dependencies"], *(line for lines in EXTRAS for line in lines)]
    if (one := Requirement(line)).name != PROJECT["name"]
}

CONSTRAINTS = [
    Requirement(line)
    for line in (ROOT / "constraints.txt").read_text().splitlines()
    if line and not line.startswith("#")
]


@pytest.mark.parametrize("name", MENDED_IN)
def test_a_floor_is_above_the_holes(name: str) -> None:
    floors = [Version(one.version) for one in REQUIRED[name].specifier if one.operator == ">="]
    assert max(floors) >= Version(MENDED_IN[name])


def test_the_constraints_fit_the_ranges() -> None:
    for one in CONSTRAINTS:
        (pinned,) = one.specifier
        if one.name in REQUIRED:
            assert pinned.version in REQUIRED[one.name].specifier, one
        if one.name in MENDED_IN:
            assert Version(pinned.version) >= Version(MENDED_IN[one.name])


@given(
    st.dictionaries(
        st.sampled_from(TARGETS),
        st.dictionaries(st.sampled_from(["one", "two"]), st.sampled_from(["1.0", "2.0", "3.0"])),
    )
)
def test_each_target_of_the_constraints_gets_back_its_versions(
    found: dict[Target, dict[str, str]],
) -> None:
    lines = [Requirement(line) for line in merged(found)]
    for target, versions in found.items():
        place = {"python_version": target.python, "platform_machine": target.machine}
        got = {
            one.name: str(one.specifier)
            for one in lines
            if not one.marker or one.marker.evaluate(place)
        }
        assert {name: got[name] for name in versions} == {
            name: f"=={version}" for name, version in versions.items()
        }


def test_the_dockerfile_installs_what_the_installation_installs() -> None:
    script, docker = ((ROOT / name).read_text() for name in ("tools/install.sh", "Dockerfile"))
    (packages,) = re.findall(r'^packages="(.*)"$', script, re.MULTILINE)
    assert set(packages.split()) <= set(docker.split())
