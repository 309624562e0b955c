from __future__ import annotations

import inspect
import subprocess
import sys

import pytest

import voz
from voz import errors


def test_every_error_is_exported_and_of_one_family() -> None:
    family = {name for name, cls in inspect.getmembers(errors, inspect.isclass)}
    assert family <= set(voz.__all__)
    assert all(issubclass(getattr(voz, name), voz.VozError) for name in family)


def test_a_notice_has_its_old_name_too() -> None:
    with pytest.warns(DeprecationWarning, match=r"voz\.Warning is called voz\.Notice") as warned:
        assert voz.Warning is voz.Notice  # type: ignore[attr-defined]
    assert [each.filename for each in warned] == [__file__]


def test_to_import_voz_loads_no_numpy() -> None:
    program = "import sys, voz; print('numpy' in sys.modules, 'pocketsphinx' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stdout == "False False\n"
