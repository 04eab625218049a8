"""Tasks for the tests of the evidence's framework, found by name in other processes too."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path

from evidence.model import Outcome
from halfphysics.errors import InputError

PNG = b"\x89PNG\r\n\x1a\n"


def square(value, log="", nap=0.0):
    """value squared, with a picture; a line in `log` says that the work was done."""
    time.sleep(nap)
    if log:
        with open(log, "a") as handle:
            handle.write(f"{value}\n")
    return Outcome(values={"square": value * value}, pictures={"dot": PNG + str(value).encode()})


def wrong(cause):
    """A user's file that cannot be used."""
    raise InputError(cause)


def bug():
    """An error of our own."""
    return {}["nothing"]


def dies(once=""):
    """Kills its process; with `once` (path of a missing file), only the first time."""
    if once and Path(once).exists():
        return Outcome(values={"alive": True})
    if once:
        Path(once).touch()
    os.kill(os.getpid(), signal.SIGKILL)


def endless():
    """A result of NaN."""
    return Outcome(values={"x": float("nan")})


def meddles(path, how):
    """A square, while its input file is removed or changed."""
    if how == "removes":
        Path(path).unlink()
    elif how == "writes":
        Path(path).write_text("after")
    return square(3)
