"""The main job: a motion, a scene and a body in; the corrected motion and its contacts out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.baselines.modes import ENGINE_MODES, no_stiffness
from halfphysics.motion.joint_groups import stiffness_over_time
from halfphysics.simulation.lost_time import warn_of_lost_time
from halfphysics.simulation.people import checked_people
from halfphysics.simulation.recorded_result import recorded_result
from halfphysics.simulation.recording import record
from halfphysics.simulation.simulator import Simulator
from halfphysics.simulation.start_warnings import warn_of_start

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion
    from halfphysics.results.result import Result
    from halfphysics.scene.scene import Scene
    from halfphysics.settings import Settings

Array = NDArray[np.float64]
#: lambda: one for all joints, by joint group or joint, or over time.
Firmness: TypeAlias = "float | Mapping[str, float] | ArrayLike"


def simulate(
    motion: Motion | Sequence[Motion],
    scene: Scene | None = None,
    *,
    body: Body | Sequence[Body] | None = None,
    settings: Settings | None = None,
    stiffness: Firmness | Sequence[Firmness] | None = None,
    allow_mismatch: bool = False,
    progress: bool = False,
) -> Result:
    """Give a motion a body in a scene (Half-Physics, Algorithm 1, or the drive of `drive_time`).

    Args:
        motion: The motion of one person, or of several (same fps and number of frames).
        scene: Statics and objects; None: an empty one.
        body: The person's body, or one per person; None: `Body.default()` for all.
        settings: See `Settings`.
        stiffness: Firmness instead of `Settings.stiffness`, for everybody or in a list one a
            person: a number or numbers by joint group, or over time (T,) for all joints or
            (T, 55). Row t is that of the way to frame t, as if `Simulator.set_stiffness` were
            called before that step.
        allow_mismatch: Accept a body of another gender or model than the motion says.
        progress: Show a progress bar on stderr where it is a terminal.

    Returns:
        `Result`: the corrected motions, the objects' motions, contacts, clearance. Where
        nothing is in the way the motion is followed exactly.

    Raises:
        InputError: An impossible value, or people with different fps or numbers of frames.
        MismatchError: The body's gender or model is not the motion's.
    """
    motions, bodies = checked_people(motion, body, allow_mismatch=allow_mismatch)
    firmness = stiffness_over_time(stiffness, len(motions[0]), len(motions))
    simulator = Simulator(scene, body=bodies, settings=settings, fps=motions[0].fps)
    return follow(simulator, motions, firmness, progress=progress)


def follow(
    simulator: Simulator,
    motions: Sequence[Motion],
    stiffness: Array | None = None,
    *,
    progress: bool = False,
) -> Result:
    """Run a simulator over whole motions, one per person: `simulate` without its set-up.

    What `Simulator.step` would do frame by frame, to the last bit; all that is not physics is
    done for all frames at once. The motions have one length and the simulator's frame rate.
    `stiffness`: firmness (T, people, 55) of every frame.
    """
    world, dt = simulator.world, simulator.dt
    if world.settings.mode in ENGINE_MODES:
        from halfphysics.baselines.engine.following import follow_in_engine

        if stiffness is not None:
            raise no_stiffness(world.settings.mode)
        with _progress(len(motions[0]) - 1, progress) as bar:
            return follow_in_engine(world, motions, dt, bar.update)
    simulator.reset([m[0] for m in motions])
    world = simulator.world  # what was held is held no more
    warn_of_start(world, motions)
    with _progress(len(motions[0]) - 1, progress) as bar:
        run = record(world, world.motion_coordinates(motions), dt, stiffness, bar.update)
    result = recorded_result(world, motions, run)
    warn_of_lost_time(result, stacklevel=3)
    return result


def _progress(frames: int, show: bool) -> Any:
    """A progress bar on stderr where that is a terminal, after two seconds, if it is to show."""
    from tqdm import tqdm

    hidden = None if show else True
    return tqdm(total=frames, unit="frame", delay=2.0, disable=hidden, leave=False)
