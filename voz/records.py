"""Records that check their fields when they are made."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cache
from numbers import Integral, Real
from os import PathLike, fsdecode
from typing import Annotated, Any, TypedDict, get_type_hints

import msgspec
from msgspec.structs import force_setattr

from voz.errors import ConfigError

Fraction = Annotated[float, msgspec.Meta(ge=0, le=1)]
Finite = Annotated[float, msgspec.Meta(ge=-1e12, le=1e12)]
"""Any number but NaN and infinity, seconds since 1970 included."""
Int16 = Annotated[int, msgspec.Meta(ge=-(2**15), lt=2**15)]
"""What a `std_msgs/Int16` holds."""
Int32 = Annotated[int, msgspec.Meta(ge=-(2**31), lt=2**31)]
"""What a `std_msgs/Int32` holds."""
Int64 = Annotated[int, msgspec.Meta(ge=-(2**63), le=2**63 - 1)]


class CheckedRecord(msgspec.Struct, frozen=True):
    """A record whose fields have the declared types and limits, however it is made.

    msgspec's constructors check nothing.
    """

    def __post_init__(self) -> None:
        """Check all fields, as if they were read from a file.

        Raises:
            ConfigError: a field has another type, or is out of its range.
        """
        kind = type(self)
        given = {name: getattr(self, name) for name in kind.__struct_fields__}
        try:
            checked = msgspec.convert(
                {name: _builtin(value) for name, value in given.items()}, _declared(kind)
            )
        except (UnicodeEncodeError, AttributeError, TypeError) as error:  # msgspec's own
            raise ConfigError(f"a value of {kind.__name__} cannot be used ({error})") from None
        except msgspec.ValidationError as error:
            what, at, place = str(error).partition(" - at `$")
            raise ConfigError(f"{what}{at.replace('$', kind.__name__)}{place}") from None
        for name, value in checked.items():  # an int is a float now, and a list a tuple
            if value is not given[name]:
                force_setattr(self, name, value)


def check_type(kind: type | tuple[type, ...], value: object, name: str) -> None:
    """Raise ConfigError, worded as for a record, if an argument has another type.

    Messages have its name, and name the first of several types.
    """
    if not isinstance(value, kind):
        wanted = kind[0] if isinstance(kind, tuple) else kind
        got = type(value).__name__
        raise ConfigError(f"Expected `{wanted.__name__}`, got `{got}` - at `{name}`")


def check_path(value: object, name: str) -> str:
    """Return the name of a file or folder; raises ConfigError as `check_type`."""
    check_type((str, PathLike), value, name)
    return fsdecode(value)  # type: ignore[arg-type]


def check_iterable(value: object, name: str) -> Iterator[Any]:
    """Begin to iterate over an argument; raises ConfigError as `check_type`."""
    try:
        return iter(value)  # type: ignore[call-overload, no-any-return]
    except TypeError:  # an array without a dimension has the method, too
        got = type(value).__name__
        raise ConfigError(f"Expected `Iterable`, got `{got}` - at `{name}`") from None


def check_callable(value: object, name: str) -> None:
    """Raise ConfigError as `check_type` for what is no function."""
    if not callable(value):
        raise ConfigError(f"Expected a function, got `{type(value).__name__}` - at `{name}`")


def is_number(value: object) -> bool:
    """Whether a value is a number, of Python or numpy."""
    return isinstance(value, Real)


def is_finite(value: object) -> bool:
    """Whether a value is a number, of Python or numpy, that a float can hold."""
    try:
        return isinstance(value, Real) and math.isfinite(value)
    except OverflowError:
        return False


@cache
def _declared(kind: type[CheckedRecord]) -> Any:
    hints = get_type_hints(kind, include_extras=True)
    return TypedDict(kind.__name__, {name: hints[name] for name in kind.__struct_fields__})  # type: ignore[operator]


def _builtin(value: object) -> object:
    """Convert a number of numpy, which msgspec does not know."""
    if type(value) in (float, int, bool, str):
        return value
    if isinstance(value, Integral):
        return int(value)
    return float(value) if isinstance(value, Real) else value


class PublicNames:
    """Base of classes whose objects show no internal names in `dir()`.

    Those begin with one underscore, and can be used all the same.
    """

    __slots__ = ()

    def __dir__(self) -> list[str]:
        names = super().__dir__()
        return [name for name in names if not name.startswith("_") or name.startswith("__")]
