"""Which optional parts of voz are installed. An edge: it asks Python."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from importlib.util import find_spec

from voz.apps.doctor.finding import Finding
from voz.extras import how_to_install

EXTRA_MODULES: Mapping[str, tuple[str, ...]] = {
    "bags": ("rosbags",),
    "report": ("jiwer", "matplotlib"),
    "ros2": ("cyclonedds",),
}
"""What each extra of pyproject.toml brings."""


def check_extras(required: frozenset[str] = frozenset()) -> Iterator[Finding]:
    """Check which extras are installed, the `required` ones among them."""
    for extra, modules in EXTRA_MODULES.items():
        missing = [module for module in modules if find_spec(module) is None]
        status = f"there is no {' and no '.join(missing)}" if missing else "is installed"
        remedy = how_to_install(extra) if missing else None
        yield Finding(f"extra {extra}", not missing, status, remedy, extra in required)
