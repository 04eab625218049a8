"""A sweep on a cluster: Ray's core runs the tasks, nothing else of Ray is used.

Tasks and what they answer are a few numbers; clips, results and shards go through the folder of
the sweep, which all machines see. Ray repeats nothing by itself (`max_retries=0`): a process that
dies names its task to the driver, as it does with processes of this machine, so that a variant
that kills its process is found in the same way. Only what a lost machine took along is handed over
again here, for that is no fault of the task's.
"""

from __future__ import annotations

import contextlib
import io
import logging
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
from halfphysics.sweep.run.local import GIB
from halfphysics.sweep.run.work import Done, Task, do

if TYPE_CHECKING:
    from concurrent.futures import Future

LOST = "its machine was lost, again and again"

_MOVES = 5  # so many machines may be lost under one task
_REFRESH = 5.0  # how often the size of the cluster is asked for [s]
_PATIENCE = 10.0  # for a cluster to answer at all [s]
_LONGEST = 20  # letters of the folder of temporary files
_FRESH = 1000  # after so many tasks a process is replaced: no leak grows for days
_STORE = (
    80_000_000  # Ray's object store where we start it, hardly its least [bytes]: it stays empty
)


class ClusterError(HalfPhysicsError):
    """Ray cannot run tasks: no such cluster, no halfphysics there, another version."""


@dataclass(frozen=True)
class _Answer:
    """What comes back from a process: how the task ended, and what was said if it went wrong."""

    end: Done | Death
    said: str = ""


class RayEngine:
    """The cores of a Ray cluster, or of a Ray that is started here and ended by `close`.

    A Ray that this process is connected to already is used as it is and stays. On a cluster,
    `slots` follows its size as machines come and go.

    Args:
        folder: The sweep's: the same path on all machines.
        jobs: At most so many tasks at a time; None: one per core.
        memory: For all of them together [GiB]: each is refused more than its part. None: Ray's own
            watch ends processes where a machine runs out.
        address: Of a cluster ("auto", "HOST:PORT", "ray://HOST:PORT"). None: `$RAY_ADDRESS`,
            which `ray job submit` sets; without one, processes of this machine.
        function: What the processes run.

    Raises:
        MissingDependencyError: ray is not installed.
        InputError: Impossible numbers.
        ClusterError: There is no such cluster, or it cannot be used.
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
        if memory is not None and not memory > 0.0:
            raise InputError(f"memory: found {memory:g} GiB, expected more than 0")
        self._ray = _ray()
        self._most = jobs
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
        share = None if memory is None else int(GIB * memory / self.slots)
        self._order = function, str(Path(folder).absolute()), share, code_hash()
        self._remote = self._function("halfphysics", calls=_FRESH)
        # Processes belong to an environment, and those of this one answer once: it finds none.
        self._alone = self._function("halfphysics-alone", calls=1, HALFPHYSICS_ALONE="1")

    def submit(self, task: Task) -> None:
        """Hand over a task."""
        self._queue.append((task, 0))
        self._dispatch()

    def wait(self) -> list[tuple[Task, Done | Death]]:
        """How tasks ended, at least one; nothing only where none is under way.

        Raises:
            ClusterError: Ray cannot run what it is given.
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
        """End what is under way, and Ray if it was started or connected to here."""
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
        """`_answer` as Ray knows it, in processes that end after so many calls."""
        return self._ray.remote(
            name=name,
            num_cpus=1,
            max_retries=0,
            max_calls=calls,
            runtime_env={"env_vars": {**_environment(), **environment}},
        )(_answer)

    def _dispatch(self) -> None:
        """Give to Ray what it may run; it keeps a queue of its own, of all that it is given."""
        while self._queue and (self._most is None or len(self._under_way) < self._most):
            task, moves = self._queue.popleft()
            remote = self._alone if task.kind == "variants" else self._remote
            reference = remote.remote(*self._order, task)
            self._under_way[reference] = task, moves
            # `ray.wait` looks at all that is under way each time; this costs the same for each.
            reference.future().add_done_callback(
                lambda future, reference=reference: self._ended.put((reference, future))
            )

    def _end(self, future: Future[_Answer]) -> Done | Death | None:
        """How a task ended; None: its machine was lost."""
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
        """Count the cores of the cluster, now and then."""
        now = time.monotonic()
        if self._asked and now - self._asked < _REFRESH:
            return
        self._asked = now
        # A cluster that grows on demand may have no cores yet: what waits makes it grow.
        cores = max(1, int(self._ray.cluster_resources().get("CPU", 1)))
        self.slots = cores if self._most is None else min(cores, self._most)


def _answer(
    function: Callable[[str, Task], Done],
    folder: str,
    memory: int | None,
    ours: str,
    task: Task,
) -> _Answer:
    """What runs in the processes of the cluster."""
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
    """What the processes need to know: one thread each, and where licensed models lie."""
    ours = {name: value for name, value in os.environ.items() if name.startswith("HALFPHYSICS_")}
    return {**{name: os.environ.get(name, "1") for name in THREADS}, **ours}


def _ray() -> Any:
    """The module, told to keep to itself."""
    # It would send what it is used for to its makers.
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    # Of what it will do with graphics cards one day it warns each time.
    os.environ.setdefault("RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO", "0")
    try:
        import ray
    except ImportError as error:
        raise MissingDependencyError(
            "--engine ray needs ray: pip install 'halfphysics[ray]' (or pip install ray)"
        ) from error
    return ray


def _scratch() -> Path | None:
    """A folder for sockets and logs that goes with the sweep; None: where Ray always has them.

    Ray makes sockets some 65 letters further down, and paths of sockets are short: 107 letters on
    Linux, 103 on macOS.
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
    # Of every process that dies it would tell on stdout, where there is no setting against it.
    worker = sys.modules.get("ray._private.worker")
    if hasattr(worker, "_worker_logs_enabled"):
        setattr(worker, "_worker_logs_enabled", False)  # noqa: B010


def _reach(address: str) -> None:
    """Check that a server listens there: Ray itself would wait for minutes, and then say nothing.

    Raises:
        OSError: No server does.
        ValueError: An address whose port is no number.
    """
    parts = urlsplit(address if "://" in address else f"//{address}")
    if parts.hostname is not None and parts.port is not None:
        socket.create_connection((parts.hostname, parts.port), _PATIENCE).close()


@contextlib.contextmanager
def _signals_kept() -> Iterator[None]:
    """Ray answers SIGTERM in its own way; the caller's handler is put back."""
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
