"""Many motions at once: whole clips on the threads of the core, with the bits of `simulate`."""

from __future__ import annotations

import logging
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, overload

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import progress as bars
from halfphysics.base.machine import cores
from halfphysics.base.stopwatch import Stopwatch
from halfphysics.base.validation import is_whole, shown
from halfphysics.errors import HalfPhysicsError, InputError
from halfphysics.motion.joint_groups import stiffness_of_motions, stiffness_over_time
from halfphysics.results.argument_checks import checked_scene, checked_settings
from halfphysics.simulation.argument_checks import checked_people
from halfphysics.simulation.build_world import build_world
from halfphysics.simulation.jobs import Job, jobs_of
from halfphysics.simulation.lost_time import warn_of_lost_time
from halfphysics.simulation.recorded_result import recorded_result
from halfphysics.simulation.recording import Recorder, core_firmness
from halfphysics.simulation.simulate import follow
from halfphysics.simulation.start_warnings import warn_of_start

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion
    from halfphysics.results.result import Result
    from halfphysics.scene.scene import Scene
    from halfphysics.settings import Settings
    from halfphysics.simulation.sequence import Sequence as Story
    from halfphysics.simulation.simulate import Stiffness
    from halfphysics.simulation.world import World

logger = logging.getLogger(__name__)

Array = NDArray[np.float64]

#: Jobs that are set up ahead of the threads, for each thread.
_AHEAD = 2
#: The longest wait for a thread before Python looks at signals, such as Ctrl-C [s].
_WAIT = 0.1
#: From `warnings.warn` to the line that called `simulate_many`.
_CALLER = 5


@overload
def simulate_many(
    jobs: Iterable[Motion | Sequence[Motion] | Story],
    scenes: Scene | Sequence[Scene | None] | None = None,
    *,
    body: Body | Sequence[Body | Sequence[Body] | None] | None = None,
    settings: Settings | Sequence[Settings | None] | None = None,
    stiffness: Stiffness | Sequence[Stiffness | None] | None = None,
    allow_mismatch: bool = False,
    threads: int | None = None,
    errors: Literal["raise"] = "raise",
    progress: bool = False,
) -> list[Result]: ...
@overload
def simulate_many(
    jobs: Iterable[Motion | Sequence[Motion] | Story],
    scenes: Scene | Sequence[Scene | None] | None = None,
    *,
    body: Body | Sequence[Body | Sequence[Body] | None] | None = None,
    settings: Settings | Sequence[Settings | None] | None = None,
    stiffness: Stiffness | Sequence[Stiffness | None] | None = None,
    allow_mismatch: bool = False,
    threads: int | None = None,
    errors: Literal["return"],
    progress: bool = False,
) -> list[Result | Exception]: ...
def simulate_many(
    jobs: Iterable[Motion | Sequence[Motion] | Story],
    scenes: Scene | Sequence[Scene | None] | None = None,
    *,
    body: Body | Sequence[Body | Sequence[Body] | None] | None = None,
    settings: Settings | Sequence[Settings | None] | None = None,
    stiffness: Stiffness | Sequence[Stiffness | None] | None = None,
    allow_mismatch: bool = False,
    threads: int | None = None,
    errors: str = "raise",
    progress: bool = False,
) -> list[Any]:
    """Give many motions a body, each for itself, on all cores: `simulate` for each, in one call.

    The results are those of `simulate`, bit for bit, with any number of threads. While threads
    simulate, this one sets up the next jobs and makes results of those that are done; memory holds
    the worlds of a few jobs per thread, and all results.

    Args:
        jobs: Of each job the motion, a list of one motion per person, or a `Sequence`, whose
            scene, body and settings count where none are given here.
        scenes: The scene of all jobs, or a list with one for each; None: an empty one.
        body: As in `simulate`, for all jobs; or a list with one entry for each job, itself a list
            where a job has several people.
        settings: `Settings` of all jobs, or a list with one for each.
        stiffness: As in `simulate`, for all jobs; or a list or tuple with one entry for each job.
        allow_mismatch: As in `simulate`.
        threads: Number of threads; None: one per core that this process may use.
        errors: "raise": the error of the first job that fails is raised, with its number, and the
            others are dropped. "return": errors stand in the list in place of results.
        progress: Show a progress bar of the jobs (`halfphysics.progress`).

    Returns:
        A `Result` for each job, in their order; with `errors="return"` a `Result` or an exception.

    Warns:
        HalfPhysicsWarning: As `simulate`, with the number of the job in front: "jobs[3]: ...".

    Raises:
        InputError: Impossible arguments; in a job, as `simulate` raises it, with its number.
        MismatchError: As `simulate` raises it, with the number of the job.
    """
    if errors not in ("raise", "return"):
        raise InputError(f"errors: found {shown(errors)}, expected 'raise' or 'return'")
    if threads is not None and not is_whole(threads, least=1, plain=False):
        raise InputError(f"threads: found {shown(threads)}, expected a whole number from 1 on")
    todo = jobs_of(jobs, scenes, body, settings, stiffness)
    if not todo:
        return []
    count = min(cores() if threads is None else int(threads), len(todo))
    clock = Stopwatch(logger)
    with bars.asked(progress), bars.bar(len(todo), "simulating", "job") as bar:
        run = _Run(todo, count, allow_mismatch, bar.update)
        try:
            run.all(stop=errors == "raise")
        finally:
            run.close()
    clock.done("simulated %d jobs in %d threads", len(todo), count, count=len(todo), unit="job")
    if errors == "raise" and run.failed:
        first = min(run.failed)
        raise _numbered(run.failed[first], first)
    return [run.failed.get(i, run.results.get(i)) for i in range(len(todo))]


@dataclass
class _Ready:
    """A job whose world is set up; the arrays are the core's until it is done."""

    world: World
    motions: list[Motion]
    start: tuple[Array, Array]
    firmness: Array
    targets: Array
    stiffness: Array
    recorder: Recorder


class _Run:
    """Jobs on their way through the core's threads."""

    def __init__(
        self, jobs: list[Job], threads: int, allow_mismatch: bool, done: Callable[[int], Any]
    ) -> None:
        from halfphysics import _native

        self._jobs, self._allow, self._done = jobs, allow_mismatch, done
        self._batch = _native.Batch(threads)
        self._limit = (1 + _AHEAD) * threads
        self._open: dict[int, _Ready] = {}
        self.results: dict[int, Result] = {}
        self.failed: dict[int, Exception] = {}

    def all(self, stop: bool) -> None:
        """Run all jobs; `stop`: no new ones once one has failed."""
        waiting = iter(range(len(self._jobs)))
        more = True
        while more or self._open:
            if stop and self.failed:
                return
            if more and len(self._open) < self._limit:
                i = next(waiting, None)
                more = i is not None
                if i is not None:
                    self._try(i, self._begin, i)
                continue
            for i in self._batch.ended(_WAIT):
                self._try(i, self._finish, i, self._open.pop(i))

    def close(self) -> None:
        """End the threads."""
        self._batch.close()

    def _try(self, i: int, work: Callable[..., Any], *arguments: Any) -> None:
        try:
            _with_numbered_warnings(i, work, *arguments)
        except Exception as error:  # whatever it is, it is of this job
            self.failed[i] = error
        if i not in self._open:
            self._done(1)

    def _begin(self, i: int) -> None:
        """Set up a job and hand it to the threads."""
        job = self._jobs[i]
        motions, bodies = checked_people(job.motion, job.body, allow_mismatch=self._allow)
        firmness = stiffness_over_time(job.stiffness, len(motions[0]), len(motions))
        world = build_world(bodies, checked_scene(job.scene), checked_settings(job.settings))
        if world.settings.drive.follow is not None:  # a baseline that another engine runs
            self.results[i] = follow(world, motions, firmness)
            return
        if firmness is None:
            firmness = stiffness_of_motions(world.stiffness, motions)
        usual, dt = np.tile(world.stiffness, (len(motions), 1)), 1.0 / motions[0].fps
        ready = _Ready(
            world=world,
            motions=motions,
            start=world.start([motion[0] for motion in motions]),
            firmness=world.stiffness_to_core(usual),
            targets=world.motion_coordinates(motions)[1:],
            stiffness=core_firmness(world, firmness)[1:],
            recorder=Recorder(world, len(motions[0]), dt),
        )
        self._batch.submit(
            key=i,
            stepper=world.stepper,
            qpos=ready.start[0],
            qvel=ready.start[1],
            lambda_=ready.firmness,
            targets=ready.targets,
            dt=dt,
            substeps=world.settings.substeps_for(dt),
            record=world.settings.record == "substeps",
            stiffness=ready.stiffness,
            out=ready.recorder.rest,
        )
        self._open[i] = ready

    def _finish(self, i: int, ready: _Ready) -> None:
        got: Mapping[str, Any] = self._batch.take(i)
        world, motions = ready.world, ready.motions
        warn_of_start(world, motions, got["start_inside"])
        recorder = ready.recorder
        start = ("start_qpos", "start_clearance", "start_inside", "start_footing")
        recorder.start(*(got[key] for key in start))
        recorder.add(got)
        result = recorded_result(world, motions, recorder.recording())
        warn_of_lost_time(result, stacklevel=1)
        self.results[i] = result


def _with_numbered_warnings(i: int, work: Callable[..., Any], *arguments: Any) -> None:
    """Do some work; its warnings get the number of the job."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        work(*arguments)
    for warning in caught:
        warnings.warn(f"jobs[{i}]: {warning.message}", warning.category, stacklevel=_CALLER)


def _numbered(error: Exception, i: int) -> Exception:
    """The error with the number of the job in front of its words."""
    if isinstance(error, HalfPhysicsError):
        numbered = type(error)(f"jobs[{i}]: {error}")
        numbered.__cause__ = error
        return numbered
    error.add_note(f"in jobs[{i}] of simulate_many")
    return error
