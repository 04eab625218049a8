"""A run of the core over whole motions, and the numbers that it gives of every frame."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.motion.skeleton import N_JOINTS
from halfphysics.results.result import DIAGNOSTICS

if TYPE_CHECKING:
    from halfphysics.motion.motion import Motion
    from halfphysics.simulation.world import World

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

#: The longest time that the core runs before it returns to Python [s]: the progress bar moves and
#: Ctrl-C is noticed that often.
_SLICE = 0.1


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
        contacts, inside: Rows of contacts (n, 12) and of overlaps (n, 4), see `core_rows`.
    """

    dt: float
    qpos: Array
    clearance: Array
    lost_time: Array
    torque: Array
    diagnostics: Array
    substeps: Array
    contacts: Rows
    inside: Rows


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
    count = len(targets)
    qpos, clearance = np.empty((count, world.nq)), np.empty(count)
    qpos[0], clearance[0] = core.qpos(), core.clearance()
    lost_time, numbers = np.zeros(count), np.zeros((count, len(DIAGNOSTICS)))
    torque = np.zeros((count, len(world.people), N_JOINTS, 3))
    balls = np.zeros((0, 0)) if firmness is None else world.stiffness_to_core(firmness)
    substeps = [qpos[:1].copy()]
    contacts, inside = _Collected(12), _Collected(4)
    start = core.inside()
    inside.add(start, np.zeros(len(start), dtype=np.int64))
    at = 1
    while at < count:
        got = core.run(
            targets[at:],
            dt,
            settings.substeps_for(dt),
            settings.record == "substeps",
            _SLICE,
            balls[at:],
        )
        frames = np.arange(at, at + len(got["qpos"]))
        qpos[frames], clearance[frames] = got["qpos"], got["clearance"]
        exerted = frames[got["torque_frames"].astype(np.int64)]
        torque[exerted] = world.torques_from_core(got["torques"])
        lost_time[frames], numbers[frames] = got["lost_time"], got["diagnostics"]
        substeps.append(got["substeps"])
        contacts.add(got["touches"], np.repeat(frames, got["touch_count"].astype(np.int64)))
        inside.add(got["inside"], np.repeat(frames, got["inside_count"].astype(np.int64)))
        at += len(frames)
        done(len(frames))
    torque.setflags(write=False)
    return Recording(
        dt=dt,
        qpos=qpos,
        clearance=clearance,
        lost_time=lost_time,
        torque=torque,
        diagnostics=numbers,
        substeps=np.concatenate(substeps),
        contacts=contacts.rows(),
        inside=inside.rows(),
    )


class _Collected:
    """Rows of so many columns, slice after slice."""

    def __init__(self, columns: int) -> None:
        self._rows = [np.zeros((0, columns))]
        self._frames = [np.zeros(0, dtype=np.int64)]

    def add(self, rows: Array, frames: Ints) -> None:
        self._rows.append(rows)
        self._frames.append(frames)

    def rows(self) -> Rows:
        return Rows(np.concatenate(self._rows), np.concatenate(self._frames))
