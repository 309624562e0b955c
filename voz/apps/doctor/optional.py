"""Which optional parts of voz are installed. An edge: it asks Python."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from importlib.util import find_spec

from voz.apps.doctor.finding import Finding
from voz.extras import how_to_install

MODULES: Mapping[str, tuple[str, ...]] = {
    "bags": ("rosbags",),
    "report": ("jiwer", "matplotlib"),
    "ros2": ("cyclonedds",),
}
"""What each extra of pyproject.toml brings."""


def extras(needed: frozenset[str] = frozenset()) -> Iterator[Finding]:
    """Tell of each extra whether it is there.

    Args:
        needed: those that the robot does not go without.
    """
    for extra, modules in MODULES.items():
        missing = [module for module in modules if find_spec(module) is None]
        told = f"there is no {' and no '.join(missing)}" if missing else "is installed"
        to_do = how_to_install(extra) if missing else None
        yield Finding(f"extra {extra}", not missing, told, to_do, extra in needed)
