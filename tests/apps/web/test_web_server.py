"""A server that fails: the run goes on, is told, and no page stands still."""

from __future__ import annotations

import asyncio
from threading import Event

import httpx
import pytest
from programs import wait_until
from starlette.applications import Starlette

from voz.apps.web.web_server import open_page_socket, running_server
from voz.errors import ConfigError


def test_what_fails_is_told_and_ends_the_server() -> None:
    warnings: list[str] = []
    asked = Event()

    async def fail() -> None:
        while not asked.is_set():
            await asyncio.sleep(0.01)
        raise ZeroDivisionError

    with (
        open_page_socket("127.0.0.1", 0) as at,
        running_server(
            Starlette(), at, None, lambda: [asyncio.create_task(fail())], warnings.append
        ),
    ):
        address = f"http://127.0.0.1:{at.getsockname()[1]}/"
        assert httpx.get(address).status_code == 404
        asked.set()
        wait_until(lambda: warnings)
    assert "ZeroDivisionError" in warnings[0]


def test_it_ends_with_its_block_and_frees_its_address() -> None:
    with open_page_socket("127.0.0.1", 0) as at:
        port = at.getsockname()[1]
        with pytest.raises(ConfigError, match="choose another"):
            open_page_socket("127.0.0.1", port)
        with running_server(Starlette(), at, None, list, lambda _: None):
            pass
    open_page_socket("127.0.0.1", port).close()


def test_a_host_that_is_not_this_computer_is_one_line() -> None:
    with pytest.raises(ConfigError, match="the operator page cannot be at 203"):
        open_page_socket("203.0.113.1", 8737)
