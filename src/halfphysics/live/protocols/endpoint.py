"""Where a protocol listens or sends to: "vmc", "vmc:39539", "vmc:192.168.0.7:39539"."""

from __future__ import annotations

import ipaddress
import socket
from collections.abc import Sequence
from dataclasses import dataclass, replace

from halfphysics.errors import InputError
from halfphysics.live.safety import is_loopback

#: The address that is taken where none is given: nothing from or to other machines.
LOOPBACK = "127.0.0.1"
#: All addresses of this machine for who listens; what is sent there goes to the loopback.
_ALL = ("0.0.0.0", "::")
#: Where names and addresses lead to that are not places of their own.
_LEADS = {"localhost": {LOOPBACK, "::1"}, "0.0.0.0": {LOOPBACK}, "::": {"::1"}}


@dataclass(frozen=True)
class Endpoint:
    """A protocol at an address.

    Attributes:
        protocol: Its name, such as "vmc".
        host: Name or IP address.
        port: UDP or TCP port; 0: any free one.
    """

    protocol: str
    host: str
    port: int

    def __str__(self) -> str:
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"{self.protocol}:{host}:{self.port}"

    @property
    def is_local(self) -> bool:
        """Whether it is this machine's loopback."""
        return is_loopback(self.host)


def endpoint(text: str, default_port: int) -> Endpoint:
    """The endpoint of "PROTOCOL", "PROTOCOL:PORT" or "PROTOCOL:HOST:PORT".

    Raises:
        InputError: It is none of these, or the port is no number from 0 to 65535.
    """
    protocol, _, rest = text.partition(":")
    host, _, port = rest.rpartition(":")
    if rest and not port.isdecimal():
        host, port = rest, str(default_port)
    host = host.removeprefix("[").removesuffix("]") or LOOPBACK
    number = int(port or default_port)
    odd = any(char.isspace() or char in "/@" for char in host)
    if not protocol or number > 65535 or odd or (":" in host and not _is_address(host)):
        raise InputError(
            f"{text!r}: expected PROTOCOL, PROTOCOL:PORT or PROTOCOL:HOST:PORT with a port from 0 "
            f"to 65535, such as {protocol or 'vmc'}:{LOOPBACK}:{default_port}"
        )
    return Endpoint(protocol, host, number)


def check_apart(listen: Sequence[Endpoint], forward: Sequence[Endpoint]) -> None:
    """That everybody has an address of their own, and nobody is sent to where they are heard.

    Args:
        listen: Where poses come in, of one person each.
        forward: Where corrected poses go out to, likewise.

    Raises:
        InputError: One address is given twice, or what goes out would come in again.
    """
    for what, places in (("listen", listen), ("forward", forward)):
        for i, place in enumerate(places):
            if any(_reaches(place, other) for other in places[:i]):
                raise InputError(
                    f"{what}: found {place} for two people, expected a port for each. Give "
                    f"another, such as {_beside(place)}"
                )
    for place in forward:
        for other in listen:
            if _reaches(place, other):
                why = (
                    "where poses come in: people would follow themselves"
                    if place.protocol == other.protocol
                    else f"a port that people's poses come in by, of {other}"
                )
                raise InputError(
                    f"forward: found {place}, {why}. "
                    f"Forward to another port, such as {_beside(place)}"
                )


def _reaches(place: Endpoint, other: Endpoint) -> bool:
    """Whether what is sent to one place is heard at the other; port 0 is any free one."""
    if place.port != other.port or place.port == 0:
        return False
    sent, heard = _addresses(place.host), _plain(other.host)
    if heard in _ALL:  # of IPv4 alone, or of both
        return any(_is_own(one) and (heard == "::" or ":" not in one) for one in sent)
    return not sent.isdisjoint(_addresses(other.host))


def _is_own(host: str) -> bool:
    """Whether an address is one of this machine's: what is sent to it comes from it, too."""
    if is_loopback(host):
        return True
    if not _is_address(host):
        return False
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        with socket.socket(family, socket.SOCK_DGRAM) as trial:
            trial.connect((host, 9))  # of UDP: nothing is sent
            return _plain(trial.getsockname()[0]) == _plain(host)
    except OSError:
        return False


def _addresses(host: str) -> set[str]:
    """Where a host may be, as far as that is known without asking the network: only the name of
    this machine is looked up.
    """
    name = _plain(host)
    return _LEADS.get(name) or _addresses_of_own(name) or {name}


def _addresses_of_own(name: str) -> set[str]:
    """Addresses of this machine by its own name; of another name none."""
    own = socket.gethostname().lower()
    short = own.partition(".")[0]
    if name not in (own, short, f"{short}.local"):
        return set()
    try:
        found = socket.getaddrinfo(name, None, type=socket.SOCK_DGRAM)
    except (OSError, UnicodeError):
        return set()
    return {_plain(str(address[0])) for *_, address in found}


def _plain(host: str) -> str:
    """An address in the one usual way, such as 127.0.0.1 of "127.1"; a name in small letters."""
    try:
        address = ipaddress.ip_address(host)
    except ValueError:
        try:
            return socket.inet_ntoa(socket.inet_aton(host))
        except (OSError, ValueError):  # ValueError: letters that no address has
            return host.lower()
    return str(getattr(address, "ipv4_mapped", None) or address)


def _beside(place: Endpoint) -> Endpoint:
    """The same with the next port."""
    return replace(place, port=place.port + 1 if place.port < 65535 else place.port - 1)


def _is_address(host: str) -> bool:
    try:
        ipaddress.ip_address(host)
    except ValueError:
        return False
    return True
