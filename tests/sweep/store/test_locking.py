"""A folder's lock: of one process, until that ends; with the locks of POSIX and of Windows."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
import types
from pathlib import Path

import pytest

from halfphysics.errors import InputError
from halfphysics.sweep.store import locking
from halfphysics.sweep.store.locking import Lock


def as_on_windows() -> None:
    """Have `locking` take the locks of Windows, which those of POSIX stand in for.

    `msvcrt.locking` locks bytes from the current position on and refuses with EACCES. Here a lock
    of another process leaves the file readable: on Windows only if the byte is none of the text.
    """
    if sys.platform == "win32":
        return
    import fcntl

    def stand_in(handle: int, mode: int, count: int) -> None:
        assert mode == 2
        assert os.lseek(handle, 0, os.SEEK_CUR) > 1_000_000, "a reader of the name is not refused"
        try:
            fcntl.lockf(handle, fcntl.LOCK_EX | fcntl.LOCK_NB, count, 0, os.SEEK_CUR)
        except OSError:
            raise PermissionError(errno.EACCES, "Permission denied") from None

    sys.modules["msvcrt"] = types.SimpleNamespace(locking=stand_in, LK_NBLCK=2)
    locking.fcntl = None


@pytest.fixture(params=["this system's", "as on Windows"])
def kind(request, monkeypatch):
    monkeypatch.setattr(locking, "fcntl", locking.fcntl)
    monkeypatch.setitem(sys.modules, "msvcrt", sys.modules.get("msvcrt"))
    if request.param == "as on Windows":
        as_on_windows()
    return request.param


HOLDER = """\
import importlib.util, sys
spec = importlib.util.spec_from_file_location("cases", sys.argv[2])
cases = importlib.util.module_from_spec(spec)
spec.loader.exec_module(cases)
if sys.argv[3] == "as on Windows":
    cases.as_on_windows()
from pathlib import Path
cases.Lock(Path(sys.argv[1])).take()
print("taken", flush=True)
sys.stdin.read()
"""


def test_the_lock_of_another_process_holds_until_it_ends(tmp_path, kind):
    path = tmp_path / "sweep" / "state" / "lock"
    command = [sys.executable, "-c", HOLDER, str(path), str(Path(__file__)), kind]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as holder:
        assert holder.stdout.readline().strip() == b"taken"
        with pytest.raises(InputError, match=rf"another sweep works.*process {holder.pid} on "):
            Lock(path).take()
        holder.kill()
        holder.wait()
    lock = Lock(path)
    lock.take()
    assert path.read_text(encoding="utf-8").startswith(f"process {os.getpid()} on ")
    with pytest.raises(InputError, match="this process"):
        Lock(path).take()
    lock.release()
    again = Lock(path)
    again.take()
    again.release()
