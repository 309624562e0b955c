"""The programs that teach the network, which no package holds."""

from __future__ import annotations

import importlib.util
import os
import subprocess
from types import ModuleType

from recordings import ROOT

PYTHON = ROOT / ".venv-training" / "bin" / "python"
"""tools/install.sh makes it; it has PyTorch."""


def in_training(*arguments: object) -> subprocess.CompletedProcess[str]:
    """Call the Python that has PyTorch."""
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    command = [PYTHON, *map(str, arguments)]
    return subprocess.run(command, env=environment, capture_output=True, text=True, timeout=500)


def load_training(name: str) -> ModuleType:
    """A module of the folder `training`."""
    spec = importlib.util.spec_from_file_location(name, ROOT / "training" / f"{name}.py")
    assert spec
    assert spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
