from __future__ import annotations

import enum
import inspect
import re
import subprocess
import sys
from typing import Any

import pytest
from recordings import ROOT

import voz
from voz import errors
from voz.recognition.live_utterances import MicrophoneUtterances
from voz.recognition.recognizer import Recognizer
from voz.records import PublicNames


def test_every_error_is_exported_and_of_one_family() -> None:
    family = {name for name, cls in inspect.getmembers(errors, inspect.isclass)}
    assert family <= set(voz.__all__)
    assert all(issubclass(getattr(voz, name), voz.VozError) for name in family)


def test_the_tree_in_the_documentation_is_the_tree() -> None:
    assert errors.__doc__ is not None
    for name in (cls.__name__ for cls in voz.VozError.__subclasses__()):
        assert f"── {name} " in errors.__doc__


def test_every_name_is_there_and_listed() -> None:
    for name in voz.__all__:
        assert getattr(voz, name) is not None
    assert dir(voz) == sorted(voz.__all__) == sorted(set(voz.__all__))
    assert not hasattr(voz, "no_such_name")


def test_a_notice_has_its_old_name_too() -> None:
    with pytest.warns(DeprecationWarning, match=r"voz\.Warning is called voz\.Notice") as warned:
        assert voz.Warning is voz.Notice  # type: ignore[attr-defined]
    assert [each.filename for each in warned] == [__file__]
    assert "Warning" not in dir(voz)


def test_everything_public_is_documented() -> None:
    for name in voz.__all__:
        named = getattr(voz, name)
        if inspect.isclass(named) or inspect.isfunction(named):
            assert inspect.getdoc(named), name


def own_bases(kind: type) -> list[type]:
    return [base for base in kind.__mro__ if base.__module__.partition(".")[0] == "voz"]


def is_documented(kind: type, name: str) -> bool:
    """Whether a name of voz's has a docstring, or a line under `Attributes:` of its class."""
    described = r"^ *Attributes:\n(?:.*\n)*?" + rf" +{name}: "
    if any(re.search(described, base.__doc__ or "", re.M) for base in own_bases(kind)):
        return True
    found = inspect.getattr_static(kind, name, None)
    return isinstance(found, property) or (inspect.isroutine(found) and bool(found.__doc__))


def undocumented(kind: type, names: list[str]) -> list[str]:
    foreign = {n for base in kind.__mro__ if base not in own_bases(kind) for n in dir(base)}
    if issubclass(kind, enum.Enum):
        foreign |= set(kind.__members__)
    return [name for name in names if name not in foreign and not is_documented(kind, name)]


CLASSES = [each for name in voz.__all__ if inspect.isclass(each := getattr(voz, name))]


@pytest.mark.parametrize("kind", [*CLASSES, MicrophoneUtterances])
def test_a_class_has_no_public_name_that_is_not_documented(kind: type) -> None:
    assert undocumented(kind, [name for name in dir(kind) if not name.startswith("_")]) == []


def test_what_is_not_documented_is_found() -> None:
    class Other(voz.Robot):
        strength = 1

    Other.__module__ = "voz.other"
    assert undocumented(Other, ["move", "strength"]) == ["strength"]


def test_objects_show_nothing_internal(recognizer: Recognizer) -> None:
    listener = recognizer.listen(16_000)
    things: list[Any] = [recognizer, listener, voz.Controller([]), voz.Robot(), voz.Config()]
    things += [voz.load_config(ROOT / "examples" / "arm" / "voz.toml")]
    things += [voz.Utterance(0, "stop", 1, True, 0, 0, "text"), voz.VozError("no"), voz.Safety()]
    with voz.SoundClient() as client:
        for thing in (*things, client):
            shown = [name for name in dir(thing) if not name.startswith("__")]
            assert undocumented(type(thing), shown) == [], thing
    assert "decode" in dir(recognizer)
    assert issubclass(voz.Client, PublicNames)
    assert issubclass(MicrophoneUtterances, PublicNames)


def test_to_import_voz_loads_no_numpy() -> None:
    program = "import sys, voz; print('numpy' in sys.modules, 'pocketsphinx' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stdout == "False False\n"
