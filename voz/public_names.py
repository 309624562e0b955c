"""What `dir()` shows of an object."""

from __future__ import annotations


class PublicNames:
    """Base of classes whose objects show no internal names in `dir()`.

    Those begin with one underscore, and can be used all the same.
    """

    __slots__ = ()

    def __dir__(self) -> list[str]:
        names = super().__dir__()
        return [name for name in names if not name.startswith("_") or name.startswith("__")]
