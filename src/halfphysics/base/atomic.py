"""Files that appear whole or not at all."""

from __future__ import annotations

import contextlib
import errno
import hashlib
import os
import re
import secrets
import socket
import stat
import time
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any

from halfphysics.base.machine import is_running
from halfphysics.base.validation import file_path
from halfphysics.errors import FileError

#: How files end that are being written, and the age at which nobody writes one any more [s].
_SUFFIX, _OLD = ".part", 86_400.0


@contextlib.contextmanager
def atomic_path(path: str | os.PathLike[str]) -> Iterator[Path]:
    """An empty file for another program to write that replaces `path` when the block ends.

    It lies beside the target (same file system, so that the replacement is one step) and is
    removed when anything goes wrong; what a killed process left there is removed by the next
    that writes `path`. Where `path` is a symbolic link, the target is the file that it leads to.

    Raises:
        FileError: The folder is missing, `path` is a folder, a pipe or a device, or writing fails.
    """
    path = linked(file_path(path))
    if not path.parent.is_dir():
        raise FileError(
            f"{path}: cannot write, the folder {path.parent} does not exist. Create it first"
        )
    if path.is_dir():
        raise FileError(f"{path}: cannot write, this is a folder. Give a file name")
    if path.exists() and not path.is_file():
        raise FileError(f"{path}: cannot write, this is a pipe or a device. Give a file name")
    _remove_left(path)
    try:
        temporary = _made(path)
    except OSError as error:
        raise FileError(f"{path}: cannot write in {path.parent}: {reason(error)}") from None
    try:
        yield temporary
        with contextlib.suppress(FileNotFoundError):  # a file that is there keeps its rights
            temporary.chmod(stat.S_IMODE(path.stat().st_mode))
        os.replace(temporary, path)
    except OSError as error:
        raise FileError(f"{path}: cannot write: {reason(error)}") from None
    finally:
        with contextlib.suppress(OSError):  # the first error is the one to report
            temporary.unlink(missing_ok=True)


def linked(path: Path) -> Path:
    """The file that is written by the name `path`: of a symbolic link the one that it leads to.

    That file may be missing.

    Raises:
        FileError: The link leads to itself.
    """
    if not path.is_symlink():
        return path
    target = Path(os.path.realpath(path))
    if target.is_symlink():
        raise FileError(f"{path}: cannot write, this link leads to itself. Give another name")
    nameless = path.exists() and not target.exists()  # a pipe, by way of /dev/stdout
    return path if nameless else target


def _made(path: Path) -> Path:
    """A new, empty file beside `path`, with the rights that a plain open() gives: those of
    `tempfile` are private, and to ask for the process's umask is to change it for a moment."""
    while True:
        name = f".{path.name}.{_writer()}.{secrets.token_hex(4)}{_SUFFIX}"
        temporary = path.with_name(name)
        with contextlib.suppress(FileExistsError):
            os.close(os.open(temporary, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
            return temporary


def _writer() -> str:
    """Names this process in the names of its files: machine and number.

    Of a container, too: processes of another one, or from before the machine started again, have
    numbers of their own.
    """
    whose = [socket.gethostname()]
    with contextlib.suppress(OSError):  # Linux
        whose.append(Path("/proc/sys/kernel/random/boot_id").read_text())
        whose.append(os.readlink("/proc/self/ns/pid"))
    machine = hashlib.sha256(" ".join(whose).encode()).hexdigest()[:16]
    return f"{machine}-{os.getpid()}"


def _remove_left(path: Path) -> None:
    """Remove what writers of `path` that were killed have left beside it.

    A file is left if its writer was on this machine and runs no more, or if it has not changed for
    a day.
    """
    mine = _writer().rpartition("-")[0]
    form = re.compile(rf"\.{re.escape(path.name)}\.(?:(\w+)-(\d+)\.)?\w+{re.escape(_SUFFIX)}")
    with contextlib.suppress(OSError):
        for entry in os.scandir(path.parent):
            match = form.fullmatch(entry.name)
            if match is None:
                continue
            with contextlib.suppress(OSError):  # another process removed it, or it is not ours
                gone = match[1] == mine and not is_running(int(match[2]))
                if gone or time.time() - entry.stat().st_mtime > _OLD:
                    os.unlink(entry.path)


def reason(error: OSError) -> str:
    """The system's reason why writing failed, with advice if the disk is full."""
    said = error.strerror or str(error)
    full = error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
    return f"{said}. Make room on the disk and try again" if full else said


@contextlib.contextmanager
def atomic_write(path: str | os.PathLike[str]) -> Iterator[IO[Any]]:
    """A binary file to write to that replaces `path` when the block ends without an error.

    Raises:
        FileError: As `atomic_path`.
    """
    with atomic_path(path) as temporary, temporary.open("wb") as handle:
        yield handle
