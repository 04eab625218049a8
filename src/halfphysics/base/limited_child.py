"""A program in a process of its own, with limits of time and memory: what it reads may kill it.

The child is a module of this package that is run as a script: it needs no part of the caller's main
module, so that no guard (`if __name__ == "__main__"`) is needed, and it starts on every system in
the time of its own imports. Memory is limited where the system can (Linux: what the process
allocates; other POSIX systems: its address space, where they take the limit); processor time on
POSIX systems, so that a busy machine refuses nothing; the time that passes everywhere.
"""

from __future__ import annotations

import math
import os
import signal
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

#: Libraries that are loaded into every program: a sanitizer or an allocator among them reserves
#: more than any limit of memory.
_PRELOADED = ("LD_PRELOAD", "DYLD_INSERT_LIBRARIES")


#: A child may take so many times its processor time: others use the machine too.
PATIENCE = 10.0

#: Windows ends a process that crashes with the number of the fault; all of them are from here on.
_WINDOWS_FAULT = 0x8000_0000


@dataclass(frozen=True)
class Answer:
    """What a child wrote to its standard output, or why it did not: `failure` is then a clause."""

    output: bytes
    failure: str = ""


def can_start() -> bool:
    """Whether there is an interpreter to start: programs that embed Python may have none."""
    frozen = getattr(sys, "frozen", False)  # then the executable is somebody's whole program
    return not frozen and bool(sys.executable) and Path(sys.executable).is_file()


def run(script: Path, request: bytes, *, seconds: float, memory: int) -> Answer:
    """Run a script that reads `request` from standard input and writes its answer to the output.

    Args:
        script: A Python file that imports nothing of this package.
        request: Bytes.
        seconds: Time of a processor after which it is ended; `PATIENCE` times as long may pass.
        memory: Bytes that it may allocate.

    The script sets the limits of its process itself: its arguments are the memory and the whole
    seconds.
    """
    # -P: the modules beside the script stand in for no others; it finds what this process finds.
    command = [sys.executable, "-P", str(script), str(memory), str(math.ceil(seconds))]
    found = {"PYTHONPATH": os.pathsep.join(folder for folder in sys.path if folder)}
    one_thread = {name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")}
    own = {name: value for name, value in os.environ.items() if name not in _PRELOADED}
    try:
        done = subprocess.run(
            command,
            input=request,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            timeout=PATIENCE * seconds,
            env={**own, **one_thread, **found},
            check=False,
            creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
        )
    except subprocess.TimeoutExpired:
        return Answer(b"", f"took more than {PATIENCE * seconds:g} s")
    except OSError as error:
        return Answer(b"", f"cannot start a process: {error.strerror}")
    if done.returncode == -getattr(signal, "SIGXCPU", 0) != 0:
        return Answer(b"", f"took more than {math.ceil(seconds)} s of a processor")
    if done.returncode < 0 or done.returncode >= _WINDOWS_FAULT:
        return Answer(b"", "crashed the program that read it")
    if done.returncode:
        return Answer(b"", "ended the program that read it")
    return Answer(done.stdout)
