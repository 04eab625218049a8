"""What Windows says of memory and processes, asked through its own functions.

Called on Windows only; `halfphysics.base.machine` asks other systems through files and `os`.
"""

from __future__ import annotations

import ctypes
from typing import Any

#: Rights that looking at a process takes: its state and that of its end.
_LOOK = 0x1000 | 0x0010_0000  # PROCESS_QUERY_LIMITED_INFORMATION | SYNCHRONIZE
#: `OpenProcess` says with this error that no process has the number.
_NO_SUCH = 87  # ERROR_INVALID_PARAMETER
#: `WaitForSingleObject` says with this that a process has not ended.
_NOT_YET = 258  # WAIT_TIMEOUT


class _Memory(ctypes.Structure):
    """MEMORYSTATUSEX."""

    _fields_ = (
        ("length", ctypes.c_uint32),
        ("load", ctypes.c_uint32),
        *((name, ctypes.c_uint64) for name in ("total", "free", "a", "b", "c", "d", "e")),
    )


class _Counters(ctypes.Structure):
    """PROCESS_MEMORY_COUNTERS."""

    _fields_ = (
        ("length", ctypes.c_uint32),
        ("faults", ctypes.c_uint32),
        *((name, ctypes.c_size_t) for name in ("most", "resident", "a", "b", "c", "d", "e", "f")),
    )


def memory() -> int:
    """The machine's memory [bytes]."""
    status = _Memory(length=ctypes.sizeof(_Memory))
    _kernel().GlobalMemoryStatusEx(ctypes.byref(status))
    return int(status.total)


def resident() -> int:
    """Memory of this process [bytes]; 0 if Windows does not tell."""
    counters = _Counters(length=ctypes.sizeof(_Counters))
    kernel = _kernel()
    kernel.K32GetProcessMemoryInfo(
        kernel.GetCurrentProcess(), ctypes.byref(counters), counters.length
    )
    return int(counters.resident)


def is_running(process: int) -> bool:
    """Whether a process of this number runs; True if we may not look at it."""
    kernel = _kernel()
    handle = kernel.OpenProcess(_LOOK, False, process)
    if not handle:
        return _last_error() != _NO_SUCH
    try:
        # The number of an ended process stays taken as long as somebody holds it.
        return bool(kernel.WaitForSingleObject(handle, 0) == _NOT_YET)
    finally:
        kernel.CloseHandle(handle)


def _kernel() -> Any:
    """kernel32, told that handles are as wide as pointers."""
    kernel = ctypes.WinDLL("kernel32", use_last_error=True)  # type: ignore[attr-defined]
    handle, number = ctypes.c_void_p, ctypes.c_uint32
    kernel.GetCurrentProcess.restype = handle
    kernel.OpenProcess.restype = handle
    kernel.OpenProcess.argtypes = (number, ctypes.c_int, number)
    kernel.WaitForSingleObject.restype = number
    kernel.WaitForSingleObject.argtypes = (handle, number)
    kernel.CloseHandle.argtypes = (handle,)
    kernel.K32GetProcessMemoryInfo.argtypes = (handle, handle, number)
    kernel.GlobalMemoryStatusEx.argtypes = (handle,)
    return kernel


def _last_error() -> int:
    return int(ctypes.get_last_error())  # type: ignore[attr-defined]
