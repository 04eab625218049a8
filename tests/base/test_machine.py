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


#: /proc/self/cgroup with version 1, with both versions, and with 2.
OLD = "12:memory:/job/7\n11:cpu,cpuacct:/job/7\n1:name=systemd:/user.slice\n"
BOTH = f"{OLD}0::/user.slice\n"
NEW = "0::/job/7\n"


@linux
@pytest.mark.parametrize("text", [OLD, BOTH])
@pytest.mark.parametrize("cpu", ["cpu", "cpu,cpuacct"])
@pytest.mark.parametrize("at", ["job/7", "job", ""])
def test_limits_of_control_groups_of_version_1(tmp_path, monkeypatch, text, cpu, at):
    """Each controller has groups of its own; in a container only the top of them is there."""
    monkeypatch.setattr(machine, "_GROUPS", tmp_path / "cgroup")
    monkeypatch.setattr(machine, "_OWN", tmp_path / "own")
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: range(16))
    (tmp_path / "own").write_text(text)
    # Above the control groups nothing counts.
    (tmp_path / "memory.limit_in_bytes").write_text("1\n")
    before = machine.memory()
    for name, content in (
        ("memory/memory.limit_in_bytes", "9223372036854771712"),
        (f"{cpu}/cpu.cfs_quota_us", "-1"),
        (f"{cpu}/cpu.cfs_period_us", "100000"),
    ):
        (tmp_path / "cgroup" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "cgroup" / name).write_text(f"{content}\n")
    assert (machine.memory(), machine.cores()) == (before, 16)
    for controller in ("memory", cpu):
        (tmp_path / "cgroup" / controller / at).mkdir(parents=True, exist_ok=True)
    (tmp_path / "cgroup/memory" / at / "memory.limit_in_bytes").write_text("67108864\n")
    (tmp_path / "cgroup" / cpu / at / "cpu.cfs_quota_us").write_text("250000\n")
    (tmp_path / "cgroup" / cpu / at / "cpu.cfs_period_us").write_text("50000\n")
    assert (machine.memory(), machine.cores()) == (67108864, 5)


@linux
@pytest.mark.parametrize("text", ["", "no such\n", "0::/../../outside\n", NEW])
def test_control_groups_of_version_2(tmp_path, monkeypatch, text):
    monkeypatch.setattr(machine, "_GROUPS", tmp_path)
    monkeypatch.setattr(machine, "_OWN", tmp_path / "own")
    (tmp_path / "own").write_text(text)
    (tmp_path / "memory.max").write_text("67108864\n")
    assert machine.memory() == 67108864
    (tmp_path / "memory.max").write_text("max\n")
    assert machine.memory() > 67108864
