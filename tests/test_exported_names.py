from __future__ import annotations

import inspect

import voz
from voz import errors


def test_every_error_is_exported_and_of_one_family() -> None:
    family = {name for name, cls in inspect.getmembers(errors, inspect.isclass)}
    assert family | {"__version__"} == set(voz.__all__)
    assert all(issubclass(getattr(voz, name), voz.VozError) for name in family)


def test_the_tree_in_the_documentation_is_the_tree() -> None:
    assert errors.__doc__ is not None
    for name in (cls.__name__ for cls in voz.VozError.__subclasses__()):
        assert f"── {name} " in errors.__doc__
