"""The programs that teach the network, which no package holds."""

from __future__ import annotations

import importlib.util
from types import ModuleType

from recordings import ROOT


def load_training(name: str) -> ModuleType:
    """A module of the folder `training`."""
    spec = importlib.util.spec_from_file_location(name, ROOT / "training" / f"{name}.py")
    assert spec
    assert spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
