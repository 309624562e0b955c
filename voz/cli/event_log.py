"""Writes the events of a run as lines of JSON."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from voz.events import Event, Receiver, to_json
from voz.files import os_errors_as_config_error


@contextmanager
def event_log(name: str) -> Iterator[Receiver]:
    """Open a file for events in a `with` block; `-` is standard output.

    Yields what writes an event at once: a signal ends the run between two of them.

    Raises:
        ConfigError: it cannot be opened or written.
        BrokenPipeError: nobody reads standard output any more.
    """

    def receive(event: Event) -> None:
        with os_errors_as_config_error(name):
            stream.write(f"{to_json(event)}\n".encode())

    with os_errors_as_config_error(name):
        # Unbuffered: nothing is left to be written at the end, where it could fail or block.
        file = sys.stdout.fileno() if name == "-" else name
        stream = open(file, "wb", buffering=0, closefd=name != "-")  # noqa: SIM115
    with stream:
        yield receive
