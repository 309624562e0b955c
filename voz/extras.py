"""The parts of voz that not everybody installs: what to do where one is missing."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path


def how_to_install(extra: str) -> str:
    """Tell how the Python that runs gets an optional part of voz, for the end of a message.

    Args:
        extra: its name in pyproject.toml.

    Returns:
        What to do. No package of a registry is named: who calls himself `voz` there is another.
    """
    folder = Path(__file__).resolve().parent.parent
    pip = f"{shlex.quote(sys.executable)} -m pip install"
    if (folder / "pyproject.toml").is_file():  # what is installed is a link to this clone
        return f"run `{pip} --editable {shlex.quote(f'{folder}[{extra}]')}`"
    return f"run `{pip} '.[{extra}]'` in a clone of voz"
