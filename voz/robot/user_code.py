"""What users write themselves: found beside their voz.toml, by its name."""

from __future__ import annotations

import sys
from importlib import import_module, invalidate_caches
from pathlib import Path
from typing import Any


def import_target(target: str) -> Any:
    """Import MODULE:NAME, also from the user's folder; raises whatever that code raises."""
    here = str(Path.cwd())
    if here not in sys.path:
        sys.path.insert(0, here)  # a module beside voz.toml, as `python` itself would find it
    invalidate_caches()  # it may have been written since
    module, _, name = target.partition(":")
    try:
        return getattr(import_module(module), name)
    except ModuleNotFoundError as error:
        if error.name != module:
            raise
        raise ModuleNotFoundError(
            f"there is no module {module} in the folder you are in; name a file without its .py",
            name=module,
        ) from None
