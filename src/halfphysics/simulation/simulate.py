"""The main job: a motion, a scene and a body in; the corrected motion and its contacts out."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, TypeAlias, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.base import progress as bars
from halfphysics.base.short_repr import counted
from halfphysics.base.stopwatch import Stopwatch
from halfphysics.motion.joint_groups import stiffness_of_motions, stiffness_over_time
from halfphysics.results.argument_checks import checked_scene, checked_settings
from halfphysics.simulation.argument_checks import checked_people
from halfphysics.simulation.build_world import build_world
from halfphysics.simulation.lost_time import warn_of_lost_time
from halfphysics.simulation.recorded_result import recorded_result
from halfphysics.simulation.recording import record
from halfphysics.simulation.start_warnings import warn_of_start

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion
    from halfphysics.results.result import Result
    from halfphysics.scene.scene import Scene
    from halfphysics.settings import Settings
    from halfphysics.simulation.world import World

logger = logging.getLogger(__name__)

Array = NDArray[np.float64]
#: lambda: one for all joints, by joint group or joint, or over time.
Stiffness: TypeAlias = "float | Mapping[str, float] | ArrayLike"


def simulate(
    motion: Motion | Sequence[Motion],
    scene: Scene | None = None,
    *,
    body: Body | Sequence[Body] | None = None,
    settings: Settings | None = None,
    stiffness: Stiffness | Sequence[Stiffness] | None = None,
    allow_mismatch: bool = False,
    progress: bool = False,
) -> Result:
    """Give a motion a body in a scene (Half-Physics, Algorithm 1, or the drive of `drive_time`).

    Args:
        motion: The motion of one person, or of several (same fps and number of frames).
        scene: Statics and objects; None: an empty one.
        body: The person's body, or one per person; None: `Body.default()` for all.
        settings: See `Settings`.
        stiffness: Stiffness instead of `Settings.stiffness`, for all people or in a list one a
            person: a number or numbers by joint group, or over time (T,) for all joints or
            (T, 55). Row t is that of the way to frame t, as if `Simulator.set_stiffness` were
            called before that step. None: `Settings.stiffness`, times `Motion.stiffness_scale`.
        allow_mismatch: Accept a body of another gender or model than the motion says.
        progress: Show progress bars (`halfphysics.progress`).

    Returns:
        `Result`: the corrected motions, the objects' motions, contacts, clearance. Where
        nothing is in the way the motion is followed exactly.

    Raises:
        InputError: An impossible value, or people with different fps or numbers of frames.
        MismatchError: The body's gender or model is not the motion's.
    """
    motions, bodies = checked_people(motion, body, allow_mismatch=allow_mismatch)
    firmness = stiffness_over_time(stiffness, len(motions[0]), len(motions))
    clock = Stopwatch(logger)
    with bars.asked(progress):
        with bars.bar(1, "building the world", "world"):
            world = build_world(bodies, checked_scene(scene), checked_settings(settings))
        people = counted(len(bodies), "person", "people")
        clock.done("built the world of %s and %s", people, counted(len(world.names), "item"))
        return follow(world, motions, firmness)


def follow(
    world: World,
    motions: Sequence[Motion],
    stiffness: Array | None = None,
    *,
    progress: bool = False,
) -> Result:
    """Run a world over whole motions, one per person: `simulate` without its set-up.

    What `Simulator.step` would do frame by frame, to the last bit; all that is not physics is
    done for all frames at once.

    Args:
        world: People and scene; nothing is held.
        motions: One per person, of one length and frame rate.
        stiffness: Stiffness (T, people, 55) of every frame; None: by the settings and motions.
        progress: As of `simulate`.
    """
    count = len(motions[0]) - 1
    with bars.asked(progress), bars.bar(count, "simulating", "frame") as bar:
        other_engine = world.settings.drive.follow  # a baseline that another engine runs
        if other_engine is not None:
            return cast("Result", other_engine(world, motions, stiffness, bar.update))
        if stiffness is None:
            stiffness = stiffness_of_motions(world.stiffness, motions)
        world.reset([motion[0] for motion in motions])
        warn_of_start(world, motions, world.stepper.inside())
        clock = Stopwatch(logger)
        run = record(world, motions, stiffness, bar.update)
    people = counted(len(motions), "person", "people")
    clock.done("simulated %s of %s", counted(count, "frame"), people, count=count)
    logger.debug("%r", world.settings)
    result = recorded_result(world, motions, run)
    warn_of_lost_time(result, stacklevel=3)
    return result
