"""Where a protocol listens or sends to: "vmc", "vmc:39539", "vmc:192.168.0.7:39539"."""

from __future__ import annotations

import ipaddress
from dataclasses import dataclass

from halfphysics.errors import InputError
from halfphysics.live.safety import is_loopback

#: The address that is taken where none is given: nothing from or to other machines.
LOOPBACK = "127.0.0.1"


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


def _is_address(host: str) -> bool:
    try:
        ipaddress.ip_address(host)
    except ValueError:
        return False
    return True
