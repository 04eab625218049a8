"""Address of a server, and the message that announces it."""

from __future__ import annotations

_HERE = ("127.0.0.1", "localhost", "::1")
_ALL = ("0.0.0.0", "")


def url(host: str, port: int) -> str:
    """Address to open in a browser on this machine."""
    host = "127.0.0.1" if host in _ALL else "::1" if host == "::" else host
    return f"http://{f'[{host}]' if ':' in host else host}:{port}"


def announcement(what: str, host: str, port: int, asked: int) -> str:
    """Message with the address of `what`, also for other machines; `asked`: requested port."""
    lines = []
    if asked not in (0, port):
        lines.append(f"port {asked} is in use, taking {port}")
    lines.append(f"{what} at {url(host, port)}")
    if host in _HERE:
        lines.append(
            f"  from another machine: ssh -L {port}:127.0.0.1:{port} THIS_MACHINE, "
            "then the same address there"
        )
    else:
        lines.append(f"  any machine that reaches this one on port {port} sees it")
    return "\n".join(lines)
