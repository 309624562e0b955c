"""Drives a robot from another program, as an operator page does; needs the extra `web`."""

from __future__ import annotations

import json
import ssl
import threading
from collections.abc import Mapping
from contextlib import ExitStack, suppress
from http.client import HTTPException
from os import PathLike, fspath
from queue import Empty, SimpleQueue
from typing import Any
from urllib.error import HTTPError
from urllib.parse import SplitResult, urlsplit
from urllib.request import Request, urlopen

import msgspec

from voz.apps.web.page_messages import PAGE_SOURCE, Command, Drive, FromPage, Leave, Seen
from voz.control.table import STOP
from voz.errors import ConfigError, RobotError
from voz.events import Utterance
from voz.extras import require
from voz.language.sentences.spelling import normalize
from voz.records import PublicNames, check_path, check_type

TIMEOUT = 5.0
"""For the robot to answer, s; in a network that works it takes a tenth of a second."""


class Client(PublicNames):
    """Drives a robot that serves the operator page, `voz run --web`, from another program.

        with voz.Client("http://127.0.0.1:8737") as robot:
            robot.command("go forward")

    The robot watches it as it watches a page: when the program ends, is killed or suspended, or
    loses its connection, and when the `with` block ends, the robot stops within half a second.
    Without `with` the connection lasts as long as the program. Any thread may call it.
    """

    def __init__(
        self,
        address: str,
        token: str | None = None,
        authority: str | PathLike[str] | None = None,
    ) -> None:
        """Connect, without driving yet.

        Args:
            address: of the page; the link that `voz run` prints, with its token, will do.
            token: what the link has behind `#token=`, if it has one.
            authority: the robot's own certificate, `/api/authority.crt`, for `--https`; None trusts
                whom the system trusts.

        Raises:
            RobotError: the robot cannot be reached, or does not let this program in.
            ConfigError: an argument is invalid, or the extra `web` is not installed.
        """
        require("web", "websockets")
        check_type(str, address, "address")
        check_type((str, type(None)), token, "token")
        if authority is not None:
            check_path(authority, "authority")
        link = _parse_link(address)
        self._origin = f"{link.scheme}://{link.netloc}"
        token = token or link.fragment.removeprefix("token=")
        self._headers = {"Authorization": f"Bearer {token}"} if token else {}
        self._tls = _tls_context(authority) if link.scheme == "https" else None
        self._lock = threading.Lock()
        self._stops = 0  # how often this program has asked for a stop
        self._answers: SimpleQueue[dict[str, Any] | None] = SimpleQueue()  # to Drive; None: lost
        self._opened = ExitStack()
        self._request("/api/state")  # whose refusal has words, which a WebSocket's has not
        self._connect()

    def __enter__(self) -> Client:
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Drive no more: the robot stops if this program drove it."""
        with suppress(RobotError):
            self._send(Leave())
        self._opened.close()
        self._watcher.join()

    def command(self, text: str) -> Utterance:
        """Give a command as if it were said; one that stops the robot does, whoever drives it.

        Args:
            text: the command.

        Returns:
            What became of it: whether it is `accepted` and `obeyed`, and if not, why.

        Raises:
            RobotError: another page or program drives, or the robot does not answer.
        """
        check_type(str, text, "text")
        if normalize(text) == STOP:
            t = self.stop()
            return Utterance(t, STOP, 1.0, True, t, t, PAGE_SOURCE, obeyed=True)
        stops = self._stops  # of those after this line one overtakes the command
        try:
            self._start_driving()
        except RobotError:
            with suppress(RobotError):  # the robot obeys what stops it, and refuses all else
                return self._give(text, stops)
            raise
        return self._give(text, stops)

    def _give(self, text: str, stops: int) -> Utterance:
        command = Command(text, self._secret, stops)
        try:
            return msgspec.convert(self._request("/api/command", command), Utterance)
        except msgspec.ValidationError as error:
            raise RobotError(f"{self._origin}: invalid answer: {error}") from error

    def stop(self) -> float:
        """Stop the robot, whoever drives it; returns when zero velocity was sent, s of the run.

        Raises:
            RobotError: it was not confirmed.
        """
        with self._lock:
            self._stops += 1
            headers = {"X-Voz-Page": self._secret, "X-Voz-Stop": str(self._stops)}
        return float(self._request("/api/stop", {}, headers)["t"])

    def _connect(self) -> None:
        """Open the connection by which the robot watches this program."""
        from websockets.exceptions import WebSocketException
        from websockets.sync.client import connect

        address = f"{self._origin.replace('http', 'ws', 1)}/api/events"
        try:
            opened = connect(
                address, ssl=self._tls, additional_headers=self._headers, max_size=None,
                open_timeout=TIMEOUT, close_timeout=1.0, compression=None,
            )  # fmt: skip
            self._socket = self._opened.enter_context(opened)
            welcome = json.loads(self._socket.recv(TIMEOUT))
            self._secret = str(welcome["secret"])
        except (OSError, WebSocketException, ValueError, KeyError) as error:
            raise RobotError(f"{self._origin}: {error or 'no answer'}") from error
        self._watcher = threading.Thread(target=self._watch, name="voz-client", daemon=True)
        self._watcher.start()

    def _watch(self) -> None:
        """Answer each state, so that the robot knows that this program goes on."""
        from websockets.exceptions import ConnectionClosed

        with suppress(ConnectionClosed, RobotError):
            while True:
                record = json.loads(self._socket.recv())
                if record["type"] == "state":
                    self._send(Seen())
                elif record["type"] == "drive":
                    self._answers.put(record)
        self._answers.put(None)

    def _send(self, message: FromPage) -> None:
        from websockets.exceptions import ConnectionClosed

        try:
            self._socket.send(msgspec.json.encode(message).decode())
        except ConnectionClosed:
            raise self._lost() from None

    def _lost(self) -> RobotError:
        return RobotError(
            f"{self._origin}: the connection is lost, and the robot has stopped",
            "make a new voz.Client",
        )

    def _start_driving(self) -> None:
        """Ask again each time: after a break the robot may have forgotten who drove."""
        with self._lock:
            self._send(Drive())
            try:
                answer = self._answers.get(timeout=TIMEOUT)
            except Empty:
                self._socket.close()  # a late answer would be taken for that of the next
                answer = None
        if answer is None:
            raise self._lost()
        if not answer["driving"]:
            raise RobotError(f"{self._origin}: {answer['driver_name']}, drives", "end that first")

    def _request(
        self, path: str, body: object = None, headers: Mapping[str, str] | None = None
    ) -> dict[str, Any]:
        """Send a request, by POST if it has a body; returns the answer."""
        data = None if body is None else msgspec.json.encode(body)
        kind = {"Content-Type": "application/json"}
        request = Request(self._origin + path, data, {**kind, **self._headers, **(headers or {})})
        try:
            with urlopen(request, timeout=TIMEOUT, context=self._tls) as answer:
                return dict(json.load(answer))
        except HTTPError as error:
            raise RobotError(f"{self._origin}: {_reason(error)}") from error
        except (OSError, HTTPException, ValueError) as error:
            reason = getattr(error, "reason", error)
            raise RobotError(f"{self._origin}: {reason}", _remedy(reason)) from error


def _parse_link(address: str) -> SplitResult:
    """Read the address of a page; raises ConfigError if it is none."""
    with suppress(ValueError):
        link = urlsplit(address)
        if link.scheme in ("http", "https") and link.hostname and link.port != 0:
            return link
    example = "give the whole of it, as http://127.0.0.1:8737"
    raise ConfigError(f"{address!r} is no address of an operator page", example)


def _remedy(reason: object) -> str | None:
    if isinstance(reason, ssl.SSLCertVerificationError):
        return "give its /api/authority.crt as `authority`"
    if isinstance(reason, ConnectionRefusedError):
        return "nothing listens there; start the robot with `voz run --web`"
    return None


def _reason(error: HTTPError) -> str:
    """Why the robot refuses a request."""
    with suppress(ValueError, KeyError, TypeError), error:
        return str(json.load(error)["error"])
    return f"{error.code} {error.reason}"


def _tls_context(authority: str | PathLike[str] | None) -> ssl.SSLContext:
    """Trust one authority, or those that the system trusts."""
    try:
        return ssl.create_default_context(cafile=authority and fspath(authority))
    except (OSError, ValueError) as error:  # ssl.SSLError is an OSError
        raise ConfigError(f"authority {authority}: {error}") from error
