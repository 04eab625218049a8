"""Resources of this machine: cores and memory that may be used, and the memory of a process."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Iterator
from pathlib import Path

from halfphysics.base import windows

#: Where control groups (of containers and job systems) state limits of memory and cores, and which
#: ones this process is in.
_GROUPS, _OWN = Path("/sys/fs/cgroup"), Path("/proc/self/cgroup")


def cores() -> int:
    """How many cores this process may use."""
    count = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    for quota in (
        *_limits("", "cpu.max"),
        *_limits("cpu", "cpu.cfs_quota_us", "cpu.cfs_period_us"),
    ):
        if len(quota) == 2 and quota[1]:
            count = min(count or 1, max(1, round(quota[0] / quota[1])))
    return count or 1


def memory() -> int:
    """The memory that this process may use at most, together with all others [bytes]."""
    if sys.platform == "win32":
        return windows.memory()
    total = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    limits = [*_limits("", "memory.max"), *_limits("memory", "memory.limit_in_bytes")]
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


def _limits(controller: str, *names: str) -> Iterator[list[int]]:
    """The numbers in such files of our control group and all around it; none: no limit.

    In version 1 each controller, such as "memory", has groups of its own; "": those of version 2.
    """
    root, own = _group(controller)
    for folder in (root / own, *(root / own).parents):
        if folder.is_relative_to(root):
            with contextlib.suppress(OSError):
                words = [word for name in names for word in (folder / name).read_text().split()]
                yield [int(word) for word in words] if all(map(str.isdigit, words)) else []


def _group(controller: str) -> tuple[Path, str]:
    """The folder of all groups of a controller, and the path of ours in it.

    In a container the path may be that of the machine outside, which is not there: then the limits
    are those of the folder itself.
    """
    try:
        lines = [line.split(":", 2) for line in _OWN.read_text().splitlines()]
    except OSError:
        lines = []
    for _, names, path in (line for line in lines if len(line) == 3):
        if controller in names.split(","):
            root = next((p for p in (_GROUPS / names, _GROUPS / controller) if p.is_dir()), _GROUPS)
            return root, path.lstrip("/")
    return _GROUPS / controller, ""


def _most_held() -> int:
    import resource

    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return most if sys.platform == "darwin" else 1024 * most
