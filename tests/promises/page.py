"""An operator's browser, or a program, before the page of a run: by messages, without a network."""

from __future__ import annotations

import asyncio
import json
import math
import selectors
import struct
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

from promises.fake_time import BEGIN, Timeline
from promises.sound import WORKED, Room
from starlette.types import ASGIApp, Message

from voz.apps.web.access_control import AccessControl
from voz.apps.web.page_sound import BrowserMicrophone
from voz.audio import SAMPLE_RATE, Samples

HEADER = struct.Struct("<IId")
"""Before a block of sound: its number, 0, and when it was heard, ms."""

PAGE_BLOCK_SECONDS = 0.02

CLIENT = ("127.0.0.1", 50_000)


class NoSockets(selectors.SelectSelector):
    """Of an event loop without sockets: nothing is ever to be read, and no system call asks.

    Attributes:
        rest: called with how long the loop has nothing to do, s; None if there is no timer.
    """

    def __init__(self) -> None:
        super().__init__()
        self.rest: Callable[[float | None], None] | None = None

    def select(self, timeout: float | None = None) -> list[tuple[selectors.SelectorKey, int]]:
        """Return nothing at once."""
        if timeout != 0 and self.rest:
            self.rest(timeout)
        return []


class SteppedLoop(asyncio.SelectorEventLoop):
    """An event loop that goes on as a stepped time does, and waits for nothing."""

    def __init__(self) -> None:
        self.due = 0.0  # the time from which there is something to do, s
        self._nothing = NoSockets()
        super().__init__(self._nothing)

    def call_soon(self, *what: Any, **how: Any) -> asyncio.Handle:
        """Do something at the next step."""
        self.due = 0.0
        return super().call_soon(*what, **how)

    def call_at(self, when: float, *what: Any, **how: Any) -> asyncio.TimerHandle:
        """Do something at the step of a time, s."""
        self.due = min(self.due, when)
        return super().call_at(when, *what, **how)

    def call_soon_threadsafe(self, *what: Any, **how: Any) -> asyncio.Handle:
        """Do something that another thread asks for at the next step."""
        handle = super().call_soon_threadsafe(*what, **how)
        self.due = 0.0
        return handle

    def step(self) -> None:
        """Do all that is to be done by now."""
        if self.is_closed() or self.due > self.time():
            return
        self._nothing.rest = self._rest
        try:
            self.run_forever()
        finally:
            self._nothing.rest = None

    def _rest(self, seconds: float | None) -> None:
        self.due = math.inf if seconds is None else self.time() + seconds
        self.stop()


class Server:
    """Serves the application of a page, on the thread of the test, as the time goes on."""

    authority = None
    access = AccessControl(())

    def __init__(self) -> None:
        self._loop = SteppedLoop()
        self._tasks: list[asyncio.Task[Any]] = []
        self._app: ASGIApp | None = None

    @contextmanager
    def serving(
        self, app: ASGIApp, start_tasks: Callable[[], list[asyncio.Task[None]]], _: object
    ) -> Iterator[None]:
        """Serve an application for a `with` block, in place of a `PageAddress`."""
        self._app = app
        self._loop.call_soon(lambda: self._tasks.extend(start_tasks()))
        self.step()
        try:
            yield
        finally:
            self.close()

    def renew_certificate(self) -> None:
        """Do nothing: there is none."""

    def step(self) -> None:
        """Let what waits on the event loop go on."""
        self._loop.step()

    def start(self, work: Any) -> asyncio.Task[Any]:
        """Begin some work on the event loop."""
        task = self._loop.create_task(work)
        self._tasks.append(task)
        self.step()
        return task

    def close(self) -> None:
        """End all work."""
        for task in self._tasks:
            task.cancel()
        with suppress(BaseException):
            self._loop.run_until_complete(asyncio.gather(*self._tasks, return_exceptions=True))
        self._loop.close()

    def post(self, path: str, body: object, **headers: str) -> asyncio.Task[Any]:
        """Send a request on a new connection."""
        return self.start(self._post(path, json.dumps(body).encode(), headers))

    async def _post(self, path: str, body: bytes, headers: dict[str, str]) -> tuple[int, Any]:
        assert self._app
        sent: list[Message] = []

        async def receive() -> Message:
            return {"type": "http.request", "body": body}

        async def send(message: Message) -> None:
            sent.append(message)

        named = {"content-type": "application/json", **headers}
        scope = {
            "type": "http", "method": "POST", "path": path, "query_string": b"",
            "client": CLIENT, "http_version": "1.1", "scheme": "http",
            "headers": [(k.replace("_", "-").encode(), v.encode()) for k, v in named.items()],
        }  # fmt: skip
        await self._app(scope, receive, send)
        answer = b"".join(message.get("body", b"") for message in sent)
        return int(sent[0]["status"]), json.loads(answer)

    def connect(self, path: str, take: Callable[[dict[str, Any]], None]) -> WebSocketClient:
        """Open a WebSocket; each text that comes is handed to `take`."""
        assert self._app
        client = WebSocketClient(take)
        scope = {
            "type": "websocket", "path": path, "query_string": b"", "headers": [],
            "client": CLIENT, "subprotocols": [], "scheme": "ws",
        }  # fmt: skip
        self.start(self._app(scope, client.receive, client.send))
        return client


class WebSocketClient:
    """The browser's end of a WebSocket."""

    def __init__(self, take: Callable[[dict[str, Any]], None]) -> None:
        self._take = take
        self._sent: asyncio.Queue[Message] = asyncio.Queue()
        self._sent.put_nowait({"type": "websocket.connect"})
        self.paused = False  # nothing of it arrives any more, as of a phone without a network
        self.closed = False  # by the application

    def put(self, data: dict[str, Any] | bytes) -> None:
        """Send a message."""
        content: Message = (
            {"bytes": data} if isinstance(data, bytes) else {"text": json.dumps(data)}
        )
        if not self.paused:
            self._sent.put_nowait({"type": "websocket.receive", **content})

    def close(self) -> None:
        """Close it."""
        self._sent.put_nowait({"type": "websocket.disconnect", "code": 1001})

    async def receive(self) -> Message:
        """Give the application what was sent."""
        return await self._sent.get()

    async def send(self, message: Message) -> None:
        """Take what the application sends."""
        self.closed |= message["type"] == "websocket.close"
        if message["type"] == "websocket.send" and not self.paused:
            self._take(json.loads(message["text"]))


class Browser:
    """A page in a browser: it drives, answers each state, and gives commands.

    Attributes:
        secret: authorizes it.
        silent: whether it does not answer any more, though its sound goes on.
        states: the last state that it was sent.
    """

    def __init__(self, server: Server, timeline: Timeline) -> None:
        self.secret = ""
        self.silent = False
        self.stops = 0
        self.room = Room()
        self.answers: list[Any] = []
        self._server = server
        self._timeline = timeline
        self._next = timeline.now
        self._block = 0
        self._hearing = False
        self._sound: WebSocketClient | None = None
        self._events = server.connect("/api/events", self._take)

    def drive(self) -> None:
        """Press Drive."""
        self._events.put({"type": "drive"})

    def tap(self, text: str) -> None:
        """Tap a command."""
        body = {"text": text, "page": self.secret, "stops": self.stops}
        self.answers.append(self._server.post("/api/command", body))

    def stop(self, by_socket: bool) -> None:
        """Tap STOP, whose way is either."""
        self.stops += 1
        if by_socket:
            self._events.put({"type": "stop", "number": self.stops})
        else:
            headers = {"X_Voz_Page": self.secret, "X_Voz_Stop": str(self.stops)}
            self._server.post("/api/stop", {}, **{k.lower(): v for k, v in headers.items()})

    def rehearse(self, on: bool) -> None:
        """Begin or end a rehearsal."""
        self._events.put({"type": "rehearse", "on": on})

    def lose_network(self) -> None:
        """Lose the network: nothing arrives any more, and no connection is closed."""
        for socket in filter(None, (self._events, self._sound)):
            socket.paused = True

    def find_network(self) -> None:
        """Have the network again, press Drive, and go on to talk if it was hands-free."""
        for socket in filter(None, (self._events, self._sound)):
            socket.paused = False
        self.drive()
        if self._hearing:
            self._hearing, self._sound = False, None
            after = self._timeline.now - BEGIN + 0.3
            self._timeline.at(after, lambda: self.begin_to_talk(held=False))

    def close(self) -> None:
        """Close the page."""
        self._hearing = False
        for socket in filter(None, (self._events, self._sound)):
            socket.close()

    def begin_to_talk(self, held: bool) -> None:
        """Open its microphone: for a button that is held, or hands-free."""
        if self._sound is None or self._sound.closed:
            self._sound = self._server.connect("/api/audio", self._pong)
            self._sound.put({"type": "hello", "page": self.secret, "rate": float(SAMPLE_RATE)})
            self._server.step()
        self._sound.put({"type": "begin", "held": held})
        self._server.step()
        self._hearing = True
        self._next = self._timeline.now

    def end_to_talk(self) -> None:
        """Release the button."""
        assert self._sound
        self._hearing = False
        self._sound.put({"type": "end"})

    def step(self) -> None:
        """Send the block of sound that is due."""
        if not self._hearing or not self._sound or self._timeline.now < self._next:
            return
        self._next += PAGE_BLOCK_SECONDS
        if self._sound.closed:
            return
        sound = self.room.take(round(PAGE_BLOCK_SECONDS * SAMPLE_RATE))
        header = HEADER.pack(self._block, 0, self._timeline.now * 1000)
        self._block += 1
        self._sound.put(header + sound.astype("<i2").tobytes())

    def _take(self, record: dict[str, Any]) -> None:
        if record["type"] == "welcome":
            self.secret = record["secret"]
        elif record["type"] == "state" and not self.silent:
            self._events.put({"type": "seen"})

    def _pong(self, record: dict[str, Any]) -> None:
        if record["type"] == "ping" and self._sound:
            at = self._timeline.now * 1000
            self._sound.put({"type": "pong", "t": record["t"], "at": at})


class FollowedMicrophone(BrowserMicrophone):
    """A browser's microphone, of which it is known whether all that it has was heard."""

    def __init__(self, warn: Callable[[str], None]) -> None:
        super().__init__(warn)
        self.over = False  # whether nobody waits for what comes next
        self._changed = threading.Condition()
        self._given = 0  # blocks and ends of streams
        self._heard = 0
        self._taken = False

    def __next__(self) -> Samples:
        with self._changed:
            self._heard += self._taken  # whoever asks for the next one has heard that before
            self._changed.notify()
        self._taken = True
        while not len(block := super().__next__()) and not self.over:
            pass
        return block

    def _put(self, item: Any) -> None:
        super()._put(item)
        self._given += 1

    def wait(self) -> None:
        """Wait until all was heard."""
        with self._changed:
            all_heard = self._changed.wait_for(lambda: self._heard >= self._given, WORKED)
        assert all_heard, "the thread that hears has died"
