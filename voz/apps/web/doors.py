"""Who may come in: by which name, from which page, and with which token.

The token is no part of any address that is sent: it stands behind the # of the link, and the page
changes it for a cookie. So no log and no Referer has it.
"""

from __future__ import annotations

import hmac
import secrets
from collections import deque
from collections.abc import Collection
from contextlib import suppress
from ipaddress import ip_address
from urllib.parse import urlsplit

MOST_SESSIONS = 200
"""Browsers that are let in at a time; with more, the first of them has to show the token again."""

LETTERS = 24
"""Bytes of a token: nobody guesses 192 bits."""


def new_token() -> str:
    """Make a token that nobody can guess."""
    return secrets.token_urlsafe(LETTERS)


class Doors:
    """Decides about requests by their headers."""

    def __init__(self, hosts: Collection[str], token: str | None = None, cookie: str = "voz"):
        """Prepare to decide.

        Args:
            hosts: the names by which this server is asked for, in lower case; by another name, a
                page of a stranger would be taken for this one (DNS rebinding).
            token: what somebody must know to come in; None lets everybody in who is here.
            cookie: the name of the cookie for those who have shown it.
        """
        self.cookie = cookie
        self._hosts = frozenset(hosts)
        self._token = token
        self._sessions: deque[str] = deque(maxlen=MOST_SESSIONS)

    @property
    def locked(self) -> bool:
        """Whether a token is needed."""
        return self._token is not None

    def refusal(self, headers: Collection[tuple[bytes, bytes]]) -> str | None:
        """Tell why a request is refused by where it comes from; None if it is not."""
        hosts = [value for name, value in headers if name == b"host"]
        host = hosts[0].decode("latin-1").lower() if len(hosts) == 1 else ""
        if not self._is_own(_name(host)):
            return "this server has another name: use the address that `voz run` shows"
        origins = [v.decode("latin-1").lower() for name, v in headers if name == b"origin"]
        if any(origin not in (f"http://{host}", f"https://{host}") for origin in origins):
            return "another site's page may not drive this robot"
        sites = [value for name, value in headers if name == b"sec-fetch-site"]
        if any(site == b"cross-site" for site in sites):
            return "another site's page may not drive this robot"
        return None

    def _is_own(self, name: str) -> bool:
        """Whether a name is of this computer; an address is, as no name can be made to mean it."""
        with suppress(ValueError):
            return bool(ip_address(name))
        return name in self._hosts

    def knows(self, headers: Collection[tuple[bytes, bytes]]) -> bool:
        """Tell whether who asks has shown the token, now or before."""
        if self._token is None:
            return True
        bearer = _first(headers, b"authorization").removeprefix("Bearer ")
        if same_secret(bearer, self._token):
            return True
        cookies = (part.strip().partition("=") for part in _first(headers, b"cookie").split(";"))
        # The first alone: a stranger could send thousands, each compared with all sessions.
        shown = next((value for name, _, value in cookies if name == self.cookie), "")
        return any(same_secret(shown, session) for session in self._sessions)

    def enter(self, token: str) -> str | None:
        """Let somebody in who shows the token; gives the value of the cookie, None if not."""
        if self._token is not None and not same_secret(token, self._token):
            return None
        self._sessions.append(session := new_token())
        return session


def _name(host: str) -> str:
    """The name of a host without its port."""
    try:
        return urlsplit(f"//{host}").hostname or ""
    except ValueError:
        return ""


def same_secret(shown: str, known: str) -> bool:
    """Compare two secrets in a time that does not tell where they differ."""
    return hmac.compare_digest(shown.encode("utf-8", "replace"), known.encode())


def _first(headers: Collection[tuple[bytes, bytes]], wanted: bytes) -> str:
    return next((v.decode("latin-1") for name, v in headers if name == wanted), "")
