"""A web server on this computer."""

from __future__ import annotations

import functools
import http.server
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest

Serve = Callable[..., str]


class Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_: object) -> None:
        pass


@contextmanager
def _serving(handler: Callable[..., http.server.BaseHTTPRequestHandler]) -> Iterator[str]:
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()
        thread.join()


@pytest.fixture
def serve() -> Iterator[Serve]:
    """Starts a server with a handler of requests, or with a folder; gives its address."""
    with ExitStack() as stack:

        def start(what: type[http.server.BaseHTTPRequestHandler] | Path) -> str:
            is_folder = isinstance(what, Path)
            handler = functools.partial(Quiet, directory=str(what)) if is_folder else what
            return stack.enter_context(_serving(handler))

        yield start
