"""Tasks of the tests' workers, found by name in other processes."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path

MIB = 2**20


def act(order):
    """One word of an order: the answer names the process."""
    word, _, rest = order.partition(" ")
    if word == "die":
        os.kill(os.getpid(), signal.SIGKILL)
    if word == "once" and not Path(rest).exists():
        Path(rest).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    if word == "nap":
        time.sleep(float(rest))
    if word == "take":
        return len(bytearray(int(rest) * MIB))
    if word == "hold":
        act.held = bytearray(int(rest) * MIB)
    if word == "threads":
        return os.environ["OMP_NUM_THREADS"]
    if word == "log":
        with open(rest, "a") as handle:
            handle.write(f"{os.getpid()}\n")
        time.sleep(0.1)
    return os.getpid()
