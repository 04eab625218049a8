"""Cores and memory that this process may use: limits of the machine and of its control groups."""

from __future__ import annotations

import mmap
import os
import sys
from pathlib import Path

import pytest

from halfphysics.base import machine

MIB = 2**20
linux = pytest.mark.skipif(sys.platform != "linux", reason="tells what processes hold and refuses")


@linux
def test_what_the_machine_lets_us_use():
    assert 1 <= machine.cores() <= os.cpu_count()
    total = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    assert 64 * MIB < machine.memory() <= total
    before = machine.resident()
    # New pages, not memory that was freed before.
    with mmap.mmap(-1, 64 * MIB) as held:
        for at in range(0, len(held), mmap.PAGESIZE):
            held[at] = 1
        assert 60 * MIB < machine.resident() - before < 70 * MIB


@linux
def test_limits_of_control_groups(tmp_path, monkeypatch):
    """The tightest limit of all enclosing control groups counts."""
    own = Path("/proc/self/cgroup").read_text().splitlines()
    path = next((line.removeprefix("0::/") for line in own if line.startswith("0::/")), "")
    monkeypatch.setattr(machine, "_GROUPS", tmp_path)
    (tmp_path / path).mkdir(parents=True, exist_ok=True)
    assert machine.cores() == len(os.sched_getaffinity(0))
    (tmp_path / path / "memory.max").write_text("max\n")
    (tmp_path / "memory.max").write_text("123456789\n")
    (tmp_path / path / "cpu.max").write_text("100000 100000\n")
    assert machine.memory() == 123456789
    assert machine.cores() == 1
