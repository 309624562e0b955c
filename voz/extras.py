"""The optional parts of voz: whether they are installed, and how to install them."""

from __future__ import annotations

import shlex
import sys
from importlib.util import find_spec
from pathlib import Path

from voz.errors import ConfigError


def require(extra: str, *modules: str) -> None:
    """Raise ConfigError if one of these modules of an extra is not installed."""
    for module in modules:
        if find_spec(module) is None:
            raise ConfigError(f"{module} is not installed; {how_to_install(extra)}")


def how_to_install(extra: str) -> str:
    """How to install an extra, for the end of a message.

    No package of a registry is named, since `voz` on PyPI is another project.
    """
    folder = Path(__file__).resolve().parent.parent
    pip = f"{shlex.quote(sys.executable)} -m pip install"
    if (folder / "pyproject.toml").is_file():  # an editable install of a clone
        return f"run `{pip} --editable {shlex.quote(f'{folder}[{extra}]')}`"
    return f"run `{pip} '.[{extra}]'` in a clone of voz"
