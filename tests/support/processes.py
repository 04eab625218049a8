"""Processes of this machine, from /proc."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

needs_proc = pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="looks into /proc")


def of_group(group):
    """The processes of a process group that have not ended."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[2]) == group and fields[0] != "Z":
            found.append(int(stat.parent.name))
    return found


def group_ends(group, seconds):
    """Wait until no process of a group is left; returns whether that is so."""
    deadline = time.monotonic() + seconds
    while of_group(group) and time.monotonic() < deadline:
        time.sleep(0.02)
    return not of_group(group)
