"""What Windows is asked: its functions stand in here, as its documentation describes them.

On Windows itself the last test asks the real ones.
"""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from halfphysics.base import machine, windows

NO_SUCH, DENIED, ENDED, RUNNING = 87, 5, 0, 258


class Kernel:
    """kernel32 with processes by number: the state that waiting for one tells, or an error."""

    def __init__(self, processes):
        self.processes, self.error, self.open = processes, 0, []

    def OpenProcess(self, rights, inherit, number):
        assert rights & 0x1000
        assert rights & 0x0010_0000
        assert not inherit
        state = self.processes.get(number, -NO_SUCH)
        if state < 0:
            self.error = -state
            return None
        self.open.append(number)
        return number

    def WaitForSingleObject(self, handle, milliseconds):
        assert milliseconds == 0, "looking at a process may not wait for it"
        return self.processes[handle]

    def CloseHandle(self, handle):
        self.open.remove(handle)

    def GetCurrentProcess(self):
        return -1

    def GlobalMemoryStatusEx(self, pointer):
        status = pointer._obj
        assert status.length == 64, "what the structure is to Windows"
        status.total = 24 << 30
        return 1

    def K32GetProcessMemoryInfo(self, handle, pointer, size):
        assert handle == -1
        assert size == pointer._obj.length == 72, "what the structure is to Windows"
        pointer._obj.resident = 300 << 20
        return 1


@pytest.fixture
def kernel(monkeypatch):
    kernel = Kernel({10: RUNNING, 11: ENDED, 12: -DENIED})
    monkeypatch.setattr(windows, "_kernel", lambda: kernel)
    monkeypatch.setattr(windows, "_last_error", lambda: kernel.error)
    monkeypatch.setattr(machine.sys, "platform", "win32")
    return kernel


@pytest.mark.parametrize(("process", "runs"), [(10, True), (11, False), (12, True), (13, False)])
def test_a_process_runs_until_it_ends_or_is_not_there(kernel, process, runs):
    assert machine.is_running(process) is runs
    assert kernel.open == []


def test_memory(kernel):
    assert machine.memory() == 24 << 30
    assert machine.resident() == 300 << 20


@pytest.mark.skipif(sys.platform != "win32", reason="asks Windows")
def test_what_windows_says():
    assert 2**28 < machine.memory() < 2**44
    held = bytearray(os.urandom(64 << 20))
    assert len(held) < machine.resident() < machine.memory()
    assert machine.is_running(os.getpid())
    done = subprocess.Popen([sys.executable, "-c", ""])
    done.wait()
    assert not machine.is_running(done.pid)
