"""The WebSockets of a page: events, and sound; docs/operator-page-protocol.md has them."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Coroutine
from contextlib import suppress
from typing import Any

from starlette.routing import BaseRoute, WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect

from voz.apps.servers.connections import RateLimit
from voz.apps.web.control_api import decode_json, stop_answer
from voz.apps.web.page_messages import (
    Drive,
    FromMicrophone,
    FromPage,
    Hello,
    Leave,
    Record,
    Rehearse,
    Seen,
    Stop,
    encode_record,
)
from voz.apps.web.page_registry import OpenPage, PageRegistry
from voz.apps.web.page_sound import PageAudioStream

DEVICES = (
    ("iPhone", "iPhone"),
    ("iPad", "iPad"),
    ("CrOS", "Chromebook"),
    ("Windows", "Windows PC"),
    ("Macintosh", "Mac"),
    ("Linux", "Linux PC"),
)
"""Words of a User-Agent, and the device; the first that is found counts."""

PROGRAM = "program"
"""What is no browser."""


def device_name(user_agent: str) -> str:
    """Return a name such as "iPhone" or "Android phone"."""
    if "Mozilla/" not in user_agent:
        return PROGRAM
    if "Android" in user_agent:
        return "Android phone" if "Mobile" in user_agent else "Android tablet"
    return next((name for word, name in DEVICES if word in user_agent), "browser")


MESSAGE_RATE, MESSAGE_BURST = 40.0, 200.0
"""Messages of one page per second, and at once, besides sound: it answers ten states a second."""

LATE_NOTICE_RATE = 2.0
"""How many times per second a page is told that its sound is late."""

PING_INTERVAL = 1.0
"""Between two pings for a page's time, s."""

POLICY_VIOLATION, MESSAGE_TOO_BIG, TRY_AGAIN_LATER = 1008, 1009, 1013
"""Why a WebSocket is closed, as RFC 6455 and IANA name it."""


class WebSocketApi:
    """Serves the WebSockets of pages."""

    def __init__(self, registry: PageRegistry, snapshot: Callable[[], Record]) -> None:
        """Prepare to serve; `snapshot` returns all that a page shows."""
        self._registry = registry
        self._snapshot = snapshot
        self._stops: set[asyncio.Task[None]] = set()

    def routes(self) -> list[BaseRoute]:
        """The addresses that it serves."""
        return [
            WebSocketRoute("/api/events", self.events),
            WebSocketRoute("/api/audio", self.audio),
        ]

    async def events(self, socket: WebSocket) -> None:
        """WS /api/events: sends events and states, takes what a page asks for."""
        await socket.accept()
        if self._registry.is_full:
            await socket.close(TRY_AGAIN_LATER, "too many pages are open")
            return
        device = device_name(socket.headers.get("user-agent", ""))
        with self._registry.registered(device) as page:
            identity = {"page": page.number, "name": page.name, "secret": page.secret}
            page.put(encode_record({**self._snapshot(), "type": "welcome", **identity}))
            sending = asyncio.create_task(_send_records(socket, page))
            try:
                await self._receive_messages(socket, page)
            finally:
                sending.cancel()
                with suppress(asyncio.CancelledError):
                    await sending

    async def audio(self, socket: WebSocket) -> None:
        """WS /api/audio: takes the sound of the driving page."""
        await socket.accept()
        hello = decode_json(await _receive_text(socket), FromMicrophone)
        page = self._registry.page_with_secret(hello.page) if isinstance(hello, Hello) else None
        microphone = self._registry.microphone
        if not microphone or not page or not isinstance(hello, Hello):
            await _close(socket, POLICY_VIOLATION, "nobody listens to this page")
            return
        stream = PageAudioStream(microphone, hello.rate)
        pinging = asyncio.create_task(_ping(socket))
        try:
            await self._receive_audio(socket, page, stream)
        finally:
            pinging.cancel()
            if self._registry.is_driving(page):
                stream.close()

    async def _receive_messages(self, socket: WebSocket, page: OpenPage) -> None:
        """Do what a page asks for, until it goes or sends something invalid."""
        limit = RateLimit(MESSAGE_RATE, MESSAGE_BURST)
        while (text := await _receive_text(socket)) is not None:
            message = decode_json(text, FromPage)
            if message is None or not limit.allows(time.monotonic()):
                await _close(socket, POLICY_VIOLATION, "invalid message, or too many")
                return
            if isinstance(message, Seen):
                self._registry.keep_alive(page)
            elif isinstance(message, Drive):
                driving = self._registry.start_driving(page, message.over)
                answer = {"type": "drive", "driving": driving, **self._registry.status}
                page.put(encode_record(answer))
            elif isinstance(message, Leave):
                self._registry.stop_driving(page)
            elif isinstance(message, Rehearse):
                self._registry.set_rehearsal(page, message.on)
            elif isinstance(message, Stop):
                self._start(self._stop(page, message.number))

    async def _receive_audio(
        self, socket: WebSocket, page: OpenPage, stream: PageAudioStream
    ) -> None:
        """Take the sound of a page while it is driving."""
        notice_limit = RateLimit(LATE_NOTICE_RATE, 1.0)
        while (message := await _receive(socket)) is not None:
            if not self._registry.is_driving(page):
                await _close(socket, POLICY_VIOLATION, "this page does not drive")
                return
            text, data = message.get("text"), message.get("bytes")
            try:
                if data is not None and not self._registry.is_answering(page):
                    stream.skip_block()
                elif data is not None:
                    late = stream.take_block(data)
                    if late is not None and notice_limit.allows(time.monotonic()):
                        await socket.send_text(encode_record({"type": "late", "seconds": late}))
                else:
                    stream.take_message(decode_json(text, FromMicrophone))
            except ValueError:
                await _close(socket, MESSAGE_TOO_BIG, "invalid block of sound, or too many")
                return

    async def _stop(self, page: OpenPage, number: int) -> None:
        answer, _ = await stop_answer(self._registry, page, number)
        page.put(encode_record({"type": "stop", "number": number, **answer}))

    def _start(self, stop: Coroutine[Any, Any, None]) -> None:
        """Run a stop by itself: it must not wait for the one before it."""
        task = asyncio.create_task(stop)
        self._stops.add(task)  # the event loop holds no reference
        task.add_done_callback(self._stops.discard)


async def _send_records(socket: WebSocket, page: OpenPage) -> None:
    with suppress(WebSocketDisconnect, RuntimeError):
        while not page.too_slow:
            for record in await page.take():
                await socket.send_text(record)
        await socket.close(TRY_AGAIN_LATER, "this page is too slow to follow")


async def _ping(socket: WebSocket) -> None:
    """Ask a page for its time again and again: clocks drift, and are set."""
    with suppress(WebSocketDisconnect, RuntimeError):
        while True:
            await socket.send_text(encode_record({"type": "ping", "t": time.monotonic()}))
            await asyncio.sleep(PING_INTERVAL)


async def _receive(socket: WebSocket) -> Any:
    """Return the next message of a page; None once it has gone."""
    try:
        message = await socket.receive()
    except RuntimeError:  # it was closed from here
        return None
    return message if message["type"] == "websocket.receive" else None


async def _receive_text(socket: WebSocket) -> str | None:
    message = await _receive(socket)
    return None if message is None else message.get("text") or ""


async def _close(socket: WebSocket, code: int, why: str) -> None:
    with suppress(RuntimeError, WebSocketDisconnect):
        await socket.close(code, why)
