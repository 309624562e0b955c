"""The versions that voz may be installed with have none of the holes that are known."""

from __future__ import annotations

import sys

import pytest
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
