"""Processes that a user's code forks: none goes on as voz, or keeps a robot's process alive."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING
from weakref import WeakSet

if TYPE_CHECKING:
    from multiprocessing.connection import Connection  # which loads OpenSSL, 3 MB

_links: WeakSet[Connection] = WeakSet()
"""Between a run and the processes of its robots: each sees by its end that the other is gone."""


@contextmanager
def ends_forks() -> Iterator[None]:
    """Call a user's code in a `with` block; a process that it forks ends when it comes back."""
    process = os.getpid()
    try:
        yield
    finally:
        if os.getpid() != process:
            os._exit(0)  # or two would go on from here, and only one of them hears a stop


def close_in_forks(link: Connection) -> None:
    """Keep a link from processes that are forked later."""
    _links.add(link)


def _close_links() -> None:
    for link in list(_links):
        link.close()


os.register_at_fork(after_in_child=_close_links)
