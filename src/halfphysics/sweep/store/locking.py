"""One driver in a folder: a lock that goes with the process, also where it is killed."""

from __future__ import annotations

import errno
import os
import socket
from pathlib import Path

from halfphysics.base.json_files import reported
from halfphysics.errors import InputError

try:
    import fcntl
except ImportError:  # Windows: nothing to lock with, no process is refused
    fcntl = None  # type: ignore[assignment]

#: File systems without locks: there the user sees to it that one driver runs.
_NO_LOCKS = (errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP, errno.EINVAL)
# Locks are a process's own: what this one has locked it would be given again.
_held: set[Path] = set()


class Lock:
    """Holds `path` from `take` until `release` or the end of the process.

    A lock of the process (POSIX), not of the open file: workers that a killed driver leaves
    behind do not keep it, and it holds over machines that share a file system.
    """

    def __init__(self, path: Path) -> None:
        #: The file; its date is when it was last taken.
        self.path = path.absolute()
        self._handle: int | None = None

    def take(self) -> None:
        """Lock.

        Raises:
            InputError: Another process holds it.
            FileError: The file cannot be made.
        """
        if self.path in _held:  # not even opened: closing it again would let go of the lock
            raise self._taken("this process")
        with reported(self.path):
            self.path.parent.mkdir(parents=True, exist_ok=True)
            handle = os.open(self.path, os.O_RDWR | os.O_CREAT, 0o666)
        try:
            if not _locked(handle):
                raise self._taken(os.read(handle, 200).decode("utf-8", "replace").strip())
            with reported(self.path):
                os.ftruncate(handle, 0)
                os.write(handle, f"process {os.getpid()} on {socket.gethostname()}\n".encode())
        except BaseException:
            os.close(handle)
            raise
        self._handle = handle
        _held.add(self.path)

    def _taken(self, holder: str) -> InputError:
        return InputError(
            f"{self.path.parent.parent}: another sweep works in this folder "
            f"({holder or 'unknown'}). Wait for it, stop it, or give another folder (--out)"
        )

    def release(self) -> None:
        """Let go; the file stays."""
        if self._handle is not None:
            _held.discard(self.path)
            os.close(self._handle)
            self._handle = None


def _locked(handle: int) -> bool:
    if fcntl is None:
        return True
    try:
        fcntl.lockf(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        return error.errno in _NO_LOCKS
    return True
