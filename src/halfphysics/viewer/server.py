"""A viser server without its own output: address and errors are reported by this package."""

from __future__ import annotations

import contextlib
import errno
import logging
import socket
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from halfphysics.base.validation import is_whole, shown
from halfphysics.errors import FileError, InputError, MissingDependencyError

if TYPE_CHECKING:
    from halfphysics.viewer.site_root import SiteRoot

#: Number of ports tried, from the requested one.
TRIES = 50
#: A stopped server's thread is waited for so long, at most [s].
_ENDS = 10.0


def open_server(
    host: str, port: int, *, label: str | None = None, root: SiteRoot | None = None
) -> Any:
    """Open a viser server on `port`, or on the next free one; 0: any.

    Args:
        host: Address to listen on; 0.0.0.0: all addresses of this machine.
        port: 0 to 65535.
        label: Title of the panel.
        root: The folder that it serves; None: viser's own.

    Raises:
        InputError: An invalid host or port.
        FileError: No port is free.
        MissingDependencyError: viser cannot be imported.
    """
    try:
        import viser
    except ImportError as error:
        raise MissingDependencyError(
            f"showing this needs viser, which cannot be imported ({error}). pip install viser"
        ) from None
    # viser silently tries a thousand ports, and waits for ever if none is free.
    port = free_port(host, port)
    # Browsers open connections that they do not use: no traceback for these.
    logging.getLogger("websockets.server").addFilter(_worth_telling)
    with quiet(), contextlib.nullcontext() if root is None else root.serving():
        return viser.ViserServer(host=host, port=port, label=label, verbose=False)


def _worth_telling(record: logging.LogRecord) -> bool:
    return record.getMessage() != "opening handshake failed"


def close_server(server: Any) -> None:
    """Stop a server without output."""
    with quiet():
        server.stop()
        # viser waits a second for its thread, which prints as it ends: later on a busy machine.
        thread = getattr(getattr(server, "_websock_server", None), "_server_thread", None)
        if thread is not None:
            thread.join(timeout=_ENDS)


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """Suppress viser's output, which it prints through rich's console."""
    import rich

    console = rich.get_console()
    was_quiet, console.quiet = console.quiet, True
    try:
        yield
    finally:
        console.quiet = was_quiet


def free_port(host: str, port: int) -> int:
    """The first free port of `host`, from `port` on; 0 stays 0.

    Raises:
        InputError: An invalid host or port.
        FileError: No port is free, or opening one is not permitted.
    """
    if not is_whole(port, least=0, plain=False) or port > 65535:
        raise InputError(f"port: found {shown(port)}, expected a whole number from 0 to 65535")
    if not isinstance(host, str):
        raise InputError(f"host: found {shown(host)}, expected an address, such as '127.0.0.1'")
    port = int(port)
    last = min(port + TRIES, 65536) if port else 1
    for number in range(port, last):
        try:
            with socket.socket(_family(host), socket.SOCK_STREAM) as probe:
                probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                probe.bind((host, number))
                return number
        except OSError as error:
            if error.errno == errno.EADDRINUSE:
                continue
            if error.errno == errno.EADDRNOTAVAIL:
                raise InputError(
                    f"host: found {host!r}, which is no address of this machine. Use 127.0.0.1, "
                    "or 0.0.0.0 for all of its addresses"
                ) from None
            raise FileError(
                f"cannot open port {number} on {host}: {error.strerror}. Ports from 1024 on need "
                "no rights"
            ) from None
    raise FileError(f"ports {port} to {last - 1} on {host} are all in use. Give another port")


def _family(host: str) -> socket.AddressFamily:
    try:
        return socket.getaddrinfo(host, None, type=socket.SOCK_STREAM)[0][0]
    except (socket.gaierror, UnicodeError):
        raise InputError(
            f"host: found {host!r}, which is no address. Use 127.0.0.1, or 0.0.0.0 for all "
            "addresses of this machine"
        ) from None


def icon(name: str) -> Any:
    """viser's icon of this name for a button, such as "HOME"."""
    import viser

    return getattr(viser.Icon, name)
