"""A sweep on a cluster: Ray's core runs the tasks, no other part of Ray is used.

Tasks and answers are a few numbers; clips, results and shards are read and written in the folder
of the sweep, which all machines share. Ray repeats no task (`max_retries=0`): the death of a
process is reported to the driver with its task, as for processes of this machine, so a variant that
kills its process is found in the same way. Only tasks of a lost machine are handed over again here,
as the task did not cause the loss.
"""

from __future__ import annotations

import contextlib
import io
import logging
import math
import os
import queue
import shutil
import signal
import socket
import sys
import tempfile
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

from halfphysics import __version__
from halfphysics.base import machine
from halfphysics.base.code_hash import code_hash
from halfphysics.base.workers import DIED, FULL, THREADS, Death
from halfphysics.errors import HalfPhysicsError, InputError, MissingDependencyError
from halfphysics.sweep.run.local import GIB, LEAST
from halfphysics.sweep.run.work import Done, Task, do

if TYPE_CHECKING:
    from concurrent.futures import Future

LOST = "its machine was lost, again and again"

_MOVES = 5  # number of times a task is moved after its machine was lost
_REFRESH = 5.0  # time between queries of the size of the cluster [s]
_PATIENCE = 10.0  # time for a cluster to answer [s]
_LONGEST = 20  # longest path of the folder of temporary files [characters]
_FRESH = 1000  # tasks after which a process is replaced, so that leaks stay small
_STORE = 80_000_000  # Ray's object store if started here, near its minimum [bytes]; stays empty


class ClusterError(HalfPhysicsError):
    """Ray cannot run tasks: no cluster at the address, or halfphysics is missing or differs."""


@dataclass(frozen=True)
class _Answer:
    """The answer of a process: the outcome of the task, and its stderr if the task failed."""

    end: Done | Death
    said: str = ""


class RayEngine:
    """Runs tasks on a Ray cluster, or on a local Ray that is started here and ended by `close`.

    If this process is already connected to Ray, that connection is used and stays open. On a
    cluster, `slots` follows its size as machines are added and removed.

    Args:
        folder: The folder of the sweep: the same path on all machines.
        jobs: Largest number of tasks at a time; None: one per core.
        memory: Memory of all tasks together [GiB], divided evenly; a task cannot allocate more than
            its share, which is smaller once the cluster has more cores. There are never more tasks
            at a time than have 0.5 GiB each. None: Ray's memory monitor ends processes if a machine
            runs out of memory.
        address: Address of a cluster ("auto", "HOST:PORT", "ray://HOST:PORT"). None:
            `$RAY_ADDRESS`, which `ray job submit` sets; without it, processes of this machine.
        function: The function that the processes run.

    Raises:
        MissingDependencyError: ray is not installed.
        InputError: Invalid numbers.
        ClusterError: There is no cluster at the address, or it cannot be used.
    """

    def __init__(
        self,
        folder: Path,
        jobs: int | None = None,
        memory: float | None = None,
        *,
        address: str | None = None,
        function: Callable[[str, Task], Done] = do,
    ) -> None:
        if jobs is not None and jobs < 1:
            raise InputError(f"jobs: found {jobs}, expected at least 1")
        if memory is not None and not 0.0 < memory < math.inf:
            raise InputError(f"memory: found {memory:g} GiB, expected a number above 0")
        self._ray = _ray()
        self._memory = None if memory is None else int(GIB * memory)
        rooms = [] if self._memory is None else [max(1, self._memory // LEAST)]
        self._most = min(rooms if jobs is None else [jobs, *rooms], default=None)
        self._queue: deque[tuple[Task, int]] = deque()
        self._under_way: dict[Any, tuple[Task, int]] = {}
        self._ended: queue.SimpleQueue[tuple[Any, Future[_Answer]]] = queue.SimpleQueue()
        self._started = not self._ray.is_initialized()
        self._scratch: Path | None = None
        if self._started:
            address = address or os.environ.get("RAY_ADDRESS") or "local"
            self._scratch = _scratch() if address == "local" else None
            _connect(self._ray, address, jobs, self._scratch)
        self.slots, self._asked = 1, 0.0
        self._refresh()
        self._order = function, str(Path(folder).absolute()), code_hash()
        self._remote = self._function("halfphysics", calls=_FRESH)
        # Ray reuses processes by environment: this one has processes of its own, used for one call.
        self._alone = self._function("halfphysics-alone", calls=1, HALFPHYSICS_ALONE="1")

    def submit(self, task: Task) -> None:
        """Hand over a task."""
        self._queue.append((task, 0))
        self._dispatch()

    def wait(self) -> list[tuple[Task, Done | Death]]:
        """Outcomes of at least one task; the list is empty only if no task is in progress.

        Raises:
            ClusterError: Ray cannot run the tasks.
        """
        found: list[tuple[Task, Done | Death]] = []
        while self._under_way and not (found and self._ended.empty()):
            reference, future = self._ended.get()
            task, moves = self._under_way.pop(reference)
            end = self._end(future)
            if end is None and moves < _MOVES:
                self._queue.append((task, moves + 1))
            else:
                found.append((task, end or Death(LOST)))
            self._dispatch()
        self._refresh()
        self._dispatch()
        return found

    def close(self) -> None:
        """End the tasks in progress, and Ray if this engine started it or connected to it."""
        self._queue.clear()
        if self._started:
            self._ray.shutdown()
            if self._scratch is not None:
                shutil.rmtree(self._scratch, ignore_errors=True)
        else:
            for reference in self._under_way:
                self._ray.cancel(reference, force=True)
        self._under_way.clear()

    def _function(self, name: str, *, calls: int, **environment: str) -> Any:
        """`_answer` as a Ray function, in processes that end after `calls` calls."""
        return self._ray.remote(
            name=name,
            num_cpus=1,
            max_retries=0,
            max_calls=calls,
            runtime_env={"env_vars": {**_environment(), **environment}},
        )(_answer)

    def _dispatch(self) -> None:
        """Hand tasks to Ray, up to the limit of `jobs`; Ray keeps a queue of its own."""
        while self._queue and (self._most is None or len(self._under_way) < self._most):
            task, moves = self._queue.popleft()
            remote = self._alone if task.kind == "variants" else self._remote
            share = None if self._memory is None else self._memory // self.slots
            reference = remote.remote(*self._order, share, task)
            self._under_way[reference] = task, moves
            # `ray.wait` checks all tasks in progress on each call; a callback has a constant cost.
            reference.future().add_done_callback(
                lambda future, reference=reference: self._ended.put((reference, future))
            )

    def _end(self, future: Future[_Answer]) -> Done | Death | None:
        """The outcome of a task; None if its machine was lost."""
        errors = self._ray.exceptions
        error = future.exception()
        if error is None:
            answer = future.result()
            if answer.said:
                print(answer.said, end="", file=sys.stderr)
            return answer.end
        if isinstance(error, errors.NodeDiedError):
            return None
        if isinstance(error, errors.WorkerCrashedError):
            return Death(DIED)
        if isinstance(error, errors.OutOfMemoryError):
            return Death(FULL)
        raise ClusterError(
            f"ray cannot run the sweep's tasks: {_last_line(error)}. halfphysics {__version__} has "
            "to be installed on every machine of the cluster"
        ) from error

    def _refresh(self) -> None:
        """Count the cores of the cluster, at most every `_REFRESH` seconds."""
        now = time.monotonic()
        if self._asked and now - self._asked < _REFRESH:
            return
        self._asked = now
        # A cluster that grows on demand may have no cores yet: waiting tasks make it grow.
        cores = max(1, int(self._ray.cluster_resources().get("CPU", 1)))
        self.slots = cores if self._most is None else min(cores, self._most)


def _answer(
    function: Callable[[str, Task], Done],
    folder: str,
    ours: str,
    memory: int | None,
    task: Task,
) -> _Answer:
    """Run a task in a process of the cluster."""
    place = f"on {socket.gethostname()}"
    if code_hash() != ours:
        stop = (
            f"{place}: halfphysics {__version__} there, or what it computes with (mujoco, numpy, "
            "scipy, trimesh, coacd, zlib), is not what is installed here. Install the same "
            "versions on all machines"
        )
        return _Answer(Done(0.0, stop=stop))
    if memory is not None:
        machine.limit_memory(memory)
    machine.offer_to_the_killer()
    said = io.StringIO()
    try:
        with contextlib.redirect_stderr(said):
            done = function(folder, task)
    except MemoryError:
        return _Answer(Death(FULL))
    if done.stop:
        return _Answer(replace(done, stop=f"{place}: {done.stop}"), said.getvalue())
    return _Answer(done)


def _environment() -> Mapping[str, str]:
    """Environment variables of the processes: one thread each, and paths of licensed models."""
    ours = {name: value for name, value in os.environ.items() if name.startswith("HALFPHYSICS_")}
    return {**{name: os.environ.get(name, "1") for name in THREADS}, **ours}


def _ray() -> Any:
    """The module, without usage statistics and warnings."""
    # Ray would send usage statistics to its developers.
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    # Ray would warn each time about a future change of its GPU settings.
    os.environ.setdefault("RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO", "0")
    try:
        import ray
    except ImportError as error:
        raise MissingDependencyError(
            "--engine ray needs ray: pip install 'halfphysics[ray]' (or pip install ray)"
        ) from error
    return ray


def _scratch() -> Path | None:
    """A folder for sockets and logs, removed with the sweep; None: the default folder of Ray.

    Ray adds about 65 characters for its sockets, and paths of sockets are limited: 107 characters
    on Linux, 103 on macOS.
    """
    folder = Path(tempfile.gettempdir()).absolute()
    if len(str(folder)) > _LONGEST:
        return None
    return Path(tempfile.mkdtemp(prefix="hp-ray-", dir=folder))


def _connect(ray: Any, address: str, jobs: int | None, scratch: Path | None) -> None:
    """Start Ray on this machine, or connect to a cluster."""
    options: dict[str, Any] = {"log_to_driver": False, "logging_level": logging.ERROR}
    if address == "local":
        options |= {
            "num_cpus": jobs or machine.cores(),
            "include_dashboard": False,
            "object_store_memory": _STORE,
        }
    if scratch is not None:
        options["_temp_dir"] = str(scratch)
    try:
        _reach(address)
        with _signals_kept():
            ray.init(address, **options)
    except (OSError, RuntimeError, ValueError) as error:
        if scratch is not None:
            shutil.rmtree(scratch, ignore_errors=True)
        raise ClusterError(
            f"ray: cannot use {address}: {_last_line(error)}. `ray start --head` starts a cluster, "
            "`ray status` says whether there is one"
        ) from error
    # Ray would report every death of a process on stdout, and has no setting against it.
    worker = sys.modules.get("ray._private.worker")
    if hasattr(worker, "_worker_logs_enabled"):
        setattr(worker, "_worker_logs_enabled", False)  # noqa: B010


def _reach(address: str) -> None:
    """Check that a server listens there: Ray would wait for minutes without a clear error.

    Raises:
        OSError: No server listens there.
        ValueError: The port of the address is not a number.
    """
    parts = urlsplit(address if "://" in address else f"//{address}")
    if parts.hostname is not None and parts.port is not None:
        socket.create_connection((parts.hostname, parts.port), _PATIENCE).close()


@contextlib.contextmanager
def _signals_kept() -> Iterator[None]:
    """Restore the caller's handler of SIGTERM, which Ray replaces."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.getsignal(signal.SIGTERM)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before if before is not None else signal.SIG_DFL)


def _last_line(error: BaseException) -> str:
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    return lines[-1] if lines else type(error).__name__
