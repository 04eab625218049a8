"""Resources of this machine: cores and memory that may be used, and the memory of a process."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Iterator
from pathlib import Path

from halfphysics.base import windows

#: Where control groups (of containers and job systems) state limits of memory and cores.
_GROUPS = Path("/sys/fs/cgroup")


def cores() -> int:
    """How many cores this process may use."""
    count = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    for quota in _limits("cpu.max"):
        if len(quota) == 2 and quota[1]:
            count = min(count or 1, max(1, round(quota[0] / quota[1])))
    return count or 1


def memory() -> int:
    """The memory that this process may use at most, together with all others [bytes]."""
    if sys.platform == "win32":
        return windows.memory()
    total = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    limits = [*_limits("memory.max"), *_limits("memory/memory.limit_in_bytes")]
    return min([total, *(limit[0] for limit in limits if limit)])


def resident() -> int:
    """Memory of this process [bytes]; where the system does not tell, its peak memory."""
    if sys.platform == "win32":
        return windows.resident()
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[1])
    except OSError:
        return _most_held()
    return pages * os.sysconf("SC_PAGE_SIZE")


def limit_memory(most: int) -> None:
    """Refuse this process more than so many bytes of its own: a `MemoryError` comes of it.

    Systems other than Linux cannot count the memory that is really used: no limit is set there.
    """
    if sys.platform == "linux":
        import resource

        _, hard = resource.getrlimit(resource.RLIMIT_DATA)
        most = most if hard == resource.RLIM_INFINITY else min(most, hard)
        resource.setrlimit(resource.RLIMIT_DATA, (most, hard))


def is_running(process: int) -> bool:
    """Whether a process of this number runs on this machine; True where that cannot be told."""
    if sys.platform == "win32":
        return windows.is_running(process)
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    return True


def offer_to_the_killer() -> None:
    """Where memory runs out all the same, this process is ended rather than those it serves."""
    with contextlib.suppress(OSError):  # not Linux, or not allowed
        Path("/proc/self/oom_score_adj").write_text("500")


def _limits(name: str) -> Iterator[list[int]]:
    """The numbers in such files of our control group and all around it; none: no limit."""
    try:
        lines = Path("/proc/self/cgroup").read_text().splitlines()
    except OSError:
        return
    own = next((line.removeprefix("0::/") for line in lines if line.startswith("0::/")), "")
    for folder in (_GROUPS / own, *(_GROUPS / own).parents):
        try:
            words = (folder / name).read_text().split()
        except OSError:
            continue
        yield [int(word) for word in words] if all(word.isdigit() for word in words) else []
        if folder == _GROUPS:
            return


def _most_held() -> int:
    import resource

    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return most if sys.platform == "darwin" else 1024 * most
