"""One driver per folder: a lock that ends with its process, even if the process is killed."""

from __future__ import annotations

import errno
import importlib
import os
import socket
from pathlib import Path
from typing import Any

from halfphysics.base.json_files import reported
from halfphysics.errors import InputError

try:
    import fcntl
except ImportError:  # Windows has locks of its own
    fcntl = None  # type: ignore[assignment]

#: Errors of file systems without locks: there the user must run only one driver.
_NO_LOCKS = (errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP, errno.EINVAL)
#: Windows locks bytes, which nobody else may then read: this one, far behind the holder's name.
_LOCKED_BYTE = 1 << 30
# POSIX locks belong to a process, which may lock the same file again: remember its locks.
_held: set[Path] = set()


class Lock:
    """Locks `path` from `take` until `release` or the end of the process.

    The lock belongs to the process, not to the open file (on Windows to the file as this process
    has it open): workers that outlive a killed driver do not keep it, and it is valid across
    machines that share a file system.
    """

    def __init__(self, path: Path) -> None:
        #: The lock file; its modification time is the time of the last `take`.
        self.path = path.absolute()
        self._handle: int | None = None

    def take(self) -> None:
        """Lock.

        Raises:
            InputError: Another process holds the lock.
            FileError: The file cannot be created.
        """
        if self.path in _held:  # do not open the file: closing it would release the lock
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
        """Release the lock; the file stays."""
        if self._handle is not None:
            _held.discard(self.path)
            os.close(self._handle)
            self._handle = None


def _locked(handle: int) -> bool:
    if fcntl is None:
        return _locked_by_windows(handle)
    try:
        fcntl.lockf(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        return error.errno in _NO_LOCKS
    return True


def _locked_by_windows(handle: int) -> bool:
    msvcrt: Any = importlib.import_module("msvcrt")
    try:
        os.lseek(handle, _LOCKED_BYTE, os.SEEK_SET)
        msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)
    except OSError as error:
        return error.errno in _NO_LOCKS
    finally:
        os.lseek(handle, 0, os.SEEK_SET)
    return True
