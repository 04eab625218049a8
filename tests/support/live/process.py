"""`halfphysics serve` in a process of its own."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import halfphysics

_SOURCE = str(Path(halfphysics.__file__).parents[1])
_URL = re.compile(rb"at (ws://\S+)")


class ServerProcess:
    """A server, ended with the block.

    Attributes:
        url: Its address.
    """

    def __init__(self, *options: str) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-m", "halfphysics", "serve", "--port", "0", *options],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            env={**os.environ, "PYTHONPATH": _SOURCE, "OMP_NUM_THREADS": "1"},
            # What a shell starts in its background ignores Ctrl-C, and so do its children.
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
        )
        said = b""
        for line in self.process.stdout:
            said += line
            if found := _URL.search(line):
                self.url = found[1].decode()
                return
        raise RuntimeError(f"the server did not start: {said.decode()}")

    @property
    def memory(self) -> float:
        """Its memory [MB]."""
        pages = int(Path(f"/proc/{self.process.pid}/statm").read_text().split()[1])
        return pages * os.sysconf("SC_PAGE_SIZE") / 1e6

    @property
    def open_files(self) -> int:
        """How many files and sockets it has open."""
        return len(list(Path(f"/proc/{self.process.pid}/fd").iterdir()))

    def kill(self) -> None:
        """End it at once, as `kill -9`."""
        self.process.kill()
        self.process.communicate()

    def __enter__(self) -> ServerProcess:
        return self

    def __exit__(self, *_: object) -> None:
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        try:
            self.said = self.process.communicate(timeout=20)[0].decode()
        except subprocess.TimeoutExpired:
            self.kill()
            raise


def busy(seconds: float) -> subprocess.Popen:
    """A process that keeps a core busy."""
    script = f"import time\nends = time.time() + {seconds}\nwhile time.time() < ends: pass"
    return subprocess.Popen([sys.executable, "-c", script])
