"""Who may connect, and how much of it.

Any web page that a user opens can send requests to servers on the user's machine. It cannot hide
where it comes from: browsers add `Origin`. A page can also let its own domain point to 127.0.0.1
(DNS rebinding); then `Host` is that domain. So both are checked before anything else.
"""

from __future__ import annotations

import hmac
import ipaddress
import secrets
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from urllib.parse import parse_qs, urlsplit

from halfphysics.base.validation import shown
from halfphysics.errors import InputError

#: Most connections at a time.
MOST_CLIENTS = 256
#: What one client may send for long: messages and bytes per second.
MESSAGES_PER_SECOND, BYTES_PER_SECOND = 1000.0, 4e6
#: What waits to be sent to a client at most [bytes], here and in the system; if there is more, it
#: is left out of frames, so that what it reads is never old.
MOST_WAITING = 64 * 1024


def is_loopback(host: str) -> bool:
    """Whether an address is reached from this machine only."""
    if host.lower() == "localhost":
        return True
    try:
        return ipaddress.ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return False


def token_for(host: str, token: str | None) -> str | None:
    """The token that clients must give: as asked for; a new one beyond this machine; or None.

    Raises:
        InputError: A token that is too short, or of letters that addresses cannot have; or what
            is no text.
    """
    if not isinstance(host, str):
        raise InputError(f"host: found {shown(host)}, expected an address, such as '127.0.0.1'")
    if not isinstance(token, str | None):
        raise InputError(f"token: found {type(token).__name__}, expected text")
    if token is None:
        return None if is_loopback(host) else secrets.token_urlsafe(16)
    fine = token.isascii() and all(letter.isalnum() or letter in "-_.~" for letter in token)
    if len(token) < 8 or not fine:
        raise InputError(
            f"token: found {len(token)} characters, expected at least 8 of a-z, A-Z, 0-9 and -_.~"
        )
    return token


@dataclass(frozen=True)
class Refusal:
    """Why a request is refused, as an HTTP status and a sentence."""

    status: int
    reason: str


@dataclass(frozen=True)
class Gate:
    """Decides which requests may pass.

    Args:
        host: The address that is listened on.
        token: What clients must give, as `?token=` or as `Authorization: Bearer`; None: nothing.
        origins: Origins of pages of other servers that may connect, such as
            "http://localhost:5173"; "null" for pages of files; "*" for all.
    """

    host: str
    token: str | None = None
    origins: tuple[str, ...] = ()

    def refusal(self, path: str, headers: Mapping[str, str]) -> Refusal | None:
        """The reason against a request, by its path with query and its headers; None: it may pass.

        Headers are looked up as "Host", "Origin" and "Authorization".
        """
        host = _only(headers, "Host")
        if host is None:
            return Refusal(400, "expected one Host header")
        if is_loopback(self.host) and not is_loopback(_name(host)):
            return Refusal(
                403, f"found Host {host[:80]!r}, expected 127.0.0.1 or localhost: this server is "
                "for this machine only"
            )  # fmt: skip
        origin = _only(headers, "Origin") if "Origin" in headers else ""
        if origin is None or (origin and not self._welcome(origin, host)):
            return Refusal(
                403, f"found a page of {(origin or 'two origins')[:80]!r}, expected one of this "
                "server. Start it with --origin to let other pages connect"
            )  # fmt: skip
        if self.token is not None and not self._knows(path, headers):
            return Refusal(401, "expected the token that the server printed: ws://...?token=...")
        return None

    def _welcome(self, origin: str, host: str) -> bool:
        if "*" in self.origins or origin in self.origins:
            return True
        try:
            parts = urlsplit(origin)
        except ValueError:  # such as http://[
            return False
        return parts.scheme in ("http", "https") and parts.netloc.lower() == host.lower()

    def _knows(self, path: str, headers: Mapping[str, str]) -> bool:
        given = parse_qs(path.partition("#")[0].partition("?")[2]).get("token", [])
        scheme, _, bearer = (_only(headers, "Authorization") or "").partition(" ")
        if scheme.lower() == "bearer":
            given.append(bearer.strip())
        wanted = (self.token or "").encode()
        # Bytes that are no ASCII come as lone surrogates, which UTF-8 does not have.
        sent = [one.encode(errors="surrogateescape") for one in given]
        return any(hmac.compare_digest(one, wanted) for one in sent)


class Budget:
    """How much a client may send: a bucket that fills at a rate and holds one second of it.

    Args:
        now: A clock [s].
    """

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        self._now = now
        self._then = now()
        self._messages, self._bytes = MESSAGES_PER_SECOND, BYTES_PER_SECOND

    def spend(self, size: int) -> float:
        """A message of `size` bytes came; returns how long to wait before the next is read [s]."""
        now = self._now()
        passed, self._then = now - self._then, now
        self._messages = min(self._messages + passed * MESSAGES_PER_SECOND, MESSAGES_PER_SECOND) - 1
        self._bytes = min(self._bytes + passed * BYTES_PER_SECOND, BYTES_PER_SECOND) - size
        return max(-self._messages / MESSAGES_PER_SECOND, -self._bytes / BYTES_PER_SECOND, 0.0)


def _name(host: str) -> str:
    """The host of a Host header, without its port; "" if it is none."""
    try:
        return urlsplit(f"//{host}").hostname or ""
    except ValueError:
        return ""


def _only(headers: Mapping[str, str], name: str) -> str | None:
    """The value of a header that is there once; None: it is missing or there twice."""
    try:
        return headers[name]
    except LookupError:
        return None
