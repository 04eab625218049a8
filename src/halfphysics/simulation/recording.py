"""A run of the core over whole motions, and the numbers that it gives of every frame."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.reader_warnings import warn
from halfphysics.motion.skeleton import N_JOINTS
from halfphysics.results.result import DIAGNOSTICS
from halfphysics.simulation.soft_rows import COLUMNS

if TYPE_CHECKING:
    from halfphysics.motion.motion import Motion
    from halfphysics.simulation.world import World

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

#: The longest time that the core runs before it returns to Python [s]: the progress bar moves and
#: Ctrl-C is noticed that often.
_SLICE = 0.1

#: Most rows of samples under pressure that are kept [rows of 52 bytes]: two minutes of a person who
#: lies, at 30 fps. Longer ones keep those of every second frame, or fourth, and say so.
MOST_PRESSED = 6_000_000


@dataclass(frozen=True)
class Rows:
    """Rows of the core (n, .), and the frame that each belongs to (n,)."""

    rows: Array
    frame: Ints


@dataclass(frozen=True)
class Recording:
    """The core's numbers of T frames, the start first.

    Attributes:
        dt: Length of a frame [s].
        qpos: Coordinates (T, nq).
        clearance, lost_time: (T,) [m], [s].
        torque: What the drives exerted (T, people, 55, 3) [N m]; read-only.
        diagnostics: Numbers (T, .) in the order of `DIAGNOSTICS`.
        substeps: Coordinates (S + 1, nq) after every substep, where settings ask for them.
        lag: How far the people's references are behind (T, people) [s].
        corrected: Whether the people's targets were corrected by weight (T, people).
        contacts, inside: Rows of contacts (n, 12) and of overlaps (n, 4), see `core_rows`.
        breaches: Rows of overlaps that should not be (n, 4).
        soft: Rows of samples under pressure (n, 13), see `soft_rows`.
    """

    dt: float
    qpos: Array
    clearance: Array
    lost_time: Array
    torque: Array
    diagnostics: Array
    substeps: Array
    lag: Array
    corrected: NDArray[np.bool_]
    contacts: Rows
    inside: Rows
    breaches: Rows
    soft: Rows


def record(
    world: World,
    motions: Sequence[Motion],
    firmness: Array | None,
    done: Callable[[int], Any],
) -> Recording:
    """Run a world that was reset to the first frame of its motions over all of them.

    What the core's `frame` would do frame by frame, to the last bit.

    Args:
        world: People and scene.
        motions: One per person, of one length and frame rate.
        firmness: Of all joints in every frame (T, people, 55); None: as it is.
        done: Told how many frames were run.
    """
    core, settings, dt = world.stepper, world.settings, 1.0 / motions[0].fps
    targets = world.motion_coordinates(motions)
    balls = core_firmness(world, firmness)
    recorder = Recorder(world, len(targets), dt)
    recorder.start(core.qpos(), core.clearance(), core.inside(), core.footing())
    while (at := recorder.frames) < len(targets):
        got = core.run(
            targets[at:],
            dt,
            settings.substeps_for(dt),
            settings.record == "substeps",
            _SLICE,
            balls[at:],
            recorder.rest,
        )
        done(recorder.add(got))
    return recorder.recording()


def core_firmness(world: World, firmness: Array | None) -> Array:
    """Stiffness (T, people, 55) in the core's order (T, balls); (0, 0) of None."""
    return np.zeros((0, 0)) if firmness is None else world.stiffness_to_core(firmness)


class Recorder:
    """Collects what the core gives of a run, slice after slice.

    Args:
        world: What is run.
        count: Number of frames, the start included.
        dt: Length of a frame [s].
    """

    def __init__(self, world: World, count: int, dt: float) -> None:
        self._world, self._dt = world, dt
        self.frames = 0
        self._qpos, self._clearance = np.empty((count, world.nq)), np.empty(count)
        self._lost_time, self._numbers = np.zeros(count), np.zeros((count, len(DIAGNOSTICS)))
        self._torque = np.zeros((count, len(world.people), N_JOINTS, 3))
        self._substeps: list[Array] = []
        self._footing = np.zeros((count, len(world.people), 2))
        self._contacts, self._inside = _Collected(12), _Collected(4)
        self._breaches, self._soft = _Collected(4), _Collected(COLUMNS, np.float32, MOST_PRESSED)

    def start(self, qpos: Array, clearance: float, inside: Array, footing: Array) -> None:
        """The first frame: coordinates (nq,), clearance [m], rows of overlaps (n, 4), and of every
        person how far its reference is behind [s] and whether its target was corrected (people, 2).
        """
        self._qpos[0], self._clearance[0] = qpos, clearance
        self._substeps.append(self._qpos[:1].copy())
        self._footing[0] = footing
        self._inside.add(inside, np.zeros(len(inside), dtype=np.int64))
        self.frames = 1

    @property
    def rest(self) -> Array:
        """Where the core puts the coordinates of the frames to come (., nq)."""
        return self._qpos[max(self.frames, 1) :]

    def add(self, got: Mapping[str, Any]) -> int:
        """Add what the core's `run` gave of the next frames; returns their number."""
        count = int(got["frames"])
        at = slice(self.frames, self.frames + count)
        frames = np.arange(at.start, at.stop)
        self._clearance[at] = got["clearance"]
        if len(got["torque_frames"]):
            exerted = frames[got["torque_frames"].astype(np.int64)]
            self._torque[exerted] = self._world.torques_from_core(got["torques"])
        self._lost_time[at], self._numbers[at] = got["lost_time"], got["diagnostics"]
        self._substeps.append(got["substeps"])
        self._footing[at] = got["footing"]
        self._contacts.add(got["touches"], np.repeat(frames, got["touch_count"].astype(np.int64)))
        self._inside.add(got["inside"], np.repeat(frames, got["inside_count"].astype(np.int64)))
        self._breaches.add(got["breaches"], np.repeat(frames, got["breach_count"].astype(np.int64)))
        self._soft.add(got["soft"], np.repeat(frames, got["soft_count"].astype(np.int64)))
        self.frames += count
        return count

    def recording(self) -> Recording:
        """All frames that were added.

        Warns:
            HalfPhysicsWarning: There were too many pressures to keep those of every frame.
        """
        _say_kept(self._soft.every)
        self._torque.setflags(write=False)
        return Recording(
            dt=self._dt,
            qpos=self._qpos,
            clearance=self._clearance,
            lost_time=self._lost_time,
            torque=self._torque,
            diagnostics=self._numbers,
            substeps=np.concatenate(self._substeps),
            lag=self._footing[..., 0],
            corrected=self._footing[..., 1] != 0.0,
            contacts=self._contacts.rows(),
            inside=self._inside.rows(),
            breaches=self._breaches.rows(),
            soft=self._soft.rows(),
        )


def kept_of(counts: Ints) -> int:
    """Which frames' samples under pressure are kept: every one, every second, every fourth, ...

    Args:
        counts: Number of samples of every frame (T,).

    Warns:
        HalfPhysicsWarning: There are too many to keep those of every frame.
    """
    every = 1
    while counts[::every].sum() > MOST_PRESSED and every < len(counts):
        every *= 2
    _say_kept(every)
    return every


def _say_kept(every: int) -> None:
    if every > 1:
        warn(
            f"pressures are kept of one frame in {every}: more than {MOST_PRESSED:,} samples were "
            "pressed. Simulate shorter pieces to keep them all."
        )


class _Collected:
    """Rows of so many columns, slice after slice.

    Where there are more than `most`, those of every second frame are kept, then of every fourth.
    """

    def __init__(self, columns: int, kind: Any = np.float64, most: int | None = None) -> None:
        self._rows = [np.zeros((0, columns), dtype=kind)]
        self._frames = [np.zeros(0, dtype=np.int64)]
        self._kind, self._most = kind, most
        self.every = 1

    def add(self, rows: Array, frames: Ints) -> None:
        self._keep(rows.astype(self._kind, copy=False), frames)
        while self._most is not None and sum(map(len, self._frames)) > self._most:
            self.every *= 2
            old, self._rows = self._rows, self._rows[:1]
            at, self._frames = self._frames, self._frames[:1]
            for its, when in zip(old[1:], at[1:], strict=True):
                self._keep(its, when)

    def _keep(self, rows: Array, frames: Ints) -> None:
        some = slice(None) if self.every == 1 else frames % self.every == 0
        self._rows.append(rows[some])
        self._frames.append(frames[some])

    def rows(self) -> Rows:
        return Rows(np.concatenate(self._rows), np.concatenate(self._frames))
