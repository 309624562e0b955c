"""Advice on how to install a missing optional part of voz."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path


def how_to_install(extra: str) -> str:
    """How to install an extra, for the end of a message.

    No package of a registry is named, since `voz` on PyPI is another project.
    """
    folder = Path(__file__).resolve().parent.parent
    pip = f"{shlex.quote(sys.executable)} -m pip install"
    if (folder / "pyproject.toml").is_file():  # an editable install of a clone
        return f"run `{pip} --editable {shlex.quote(f'{folder}[{extra}]')}`"
    return f"run `{pip} '.[{extra}]'` in a clone of voz"
