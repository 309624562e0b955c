"""Who may send requests: checks of Host, Origin and token.

The token is never part of an address that is sent: it stands behind the # of the link, and the page
exchanges it for a cookie. So no log and no Referer has it.
"""

from __future__ import annotations

import hmac
import secrets
from collections import deque
from collections.abc import Collection
from contextlib import suppress
from ipaddress import ip_address
from urllib.parse import urlsplit

from starlette.datastructures import Headers

MAX_SESSIONS = 200
"""Browsers that are logged in at a time; with more, the first has to show the token again."""

TOKEN_BYTES = 24


def new_token() -> str:
    """Make a token that nobody can guess."""
    return secrets.token_urlsafe(TOKEN_BYTES)


class AccessControl:
    """Decides about requests by their headers."""

    def __init__(self, hosts: Collection[str], token: str | None = None, cookie: str = "voz"):
        """Set who may send requests.

        Args:
            hosts: the names of this server, in lower case; under another name a stranger's page
                would count as this one (DNS rebinding).
            token: what a client must know; None lets every client in.
            cookie: the name of the cookie of clients that have shown the token.
        """
        self.cookie = cookie
        self._hosts = frozenset(hosts)
        self._token = token
        self._sessions: deque[str] = deque(maxlen=MAX_SESSIONS)

    @property
    def needs_token(self) -> bool:
        """Whether a client must show a token."""
        return self._token is not None

    def refusal(self, headers: Headers) -> str | None:
        """Return why a request is refused for its Host or Origin; None if it is not."""
        hosts = headers.getlist("host")
        host = hosts[0].lower() if len(hosts) == 1 else ""
        if not self._is_own(_without_port(host)):
            return "this server has another name: use the address that `voz run` shows"
        own = (f"http://{host}", f"https://{host}")
        if "cross-site" in headers.getlist("sec-fetch-site") or any(
            origin.lower() not in own for origin in headers.getlist("origin")
        ):
            return "another site's page may not drive this robot"
        return None

    def _is_own(self, name: str) -> bool:
        with suppress(ValueError):
            return bool(ip_address(name))  # DNS rebinding needs a name
        return name in self._hosts

    def is_authenticated(self, headers: Headers) -> bool:
        """Whether the client has shown the token, in this request or before."""
        if self._token is None:
            return True
        bearer = headers.get("authorization", "").removeprefix("Bearer ")
        if secrets_equal(bearer, self._token):
            return True
        cookies = (part.strip().partition("=") for part in headers.get("cookie", "").split(";"))
        # The first alone: a stranger could send thousands, each compared with all sessions.
        shown = next((value for name, _, value in cookies if name == self.cookie), "")
        return any(secrets_equal(shown, session) for session in self._sessions)

    def log_in(self, token: str) -> str | None:
        """Begin a session; returns the value of its cookie, None if the token is wrong."""
        if self._token is not None and not secrets_equal(token, self._token):
            return None
        self._sessions.append(session := new_token())
        return session


def _without_port(host: str) -> str:
    try:
        return urlsplit(f"//{host}").hostname or ""
    except ValueError:
        return ""


def secrets_equal(shown: str, known: str) -> bool:
    """Compare two secrets in a time that does not depend on where they differ."""
    return hmac.compare_digest(shown.encode("utf-8", "replace"), known.encode())
