"""The main job: a motion, a scene and a body in; the corrected motion and what it touched out."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.baselines.modes import ENGINE_MODES, FORCED, no_stiffness
from halfphysics.body.body import check_match
from halfphysics.errors import HalfPhysicsWarning, InputError
from halfphysics.motion.joint_groups import stiffness_over_time
from halfphysics.motion.motion import Motion
from halfphysics.motion.skeleton import N_JOINTS
from halfphysics.results.contacts import Contacts
from halfphysics.results.inside import Depths, inside_of
from halfphysics.results.result import (
    DIAGNOSTICS,
    ObjectTrack,
    PersonResult,
    Result,
    Substeps,
    at_substeps,
)
from halfphysics.simulation.blocked import warn_of_lost_time
from halfphysics.simulation.contact_rows import touches
from halfphysics.simulation.floating_start import floating
from halfphysics.simulation.simulator import Simulator, several

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.scene.scene import Scene
    from halfphysics.settings import Settings
    from halfphysics.simulation.world import Person, World

Array = NDArray[np.float64]
#: lambda: one for all joints, by joint group or joint, or over time.
Firmness: TypeAlias = "float | Mapping[str, float] | ArrayLike"

#: How long the core runs before it comes back for air [s].
_SLICE = 0.1

#: A start deeper inside than this is worth a word [m].
START_INSIDE = 1e-3
_NAMED = 5  # this many of them are named


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
    from halfphysics.body.body import Body

    motions = several(motion)
    for one in motions:
        if not isinstance(one, Motion):
            raise InputError(f"motion: found {one!r}, expected a halfphysics.Motion")
    if not motions:
        raise InputError("motion: found an empty list, expected at least one Motion")
    first = motions[0]
    for i, other in enumerate(motions):
        if len(other) != len(first) or other.fps != first.fps:
            raise InputError(
                f"motion: person {i} has {len(other)} frames at {other.fps:g} fps, person 0 has "
                f"{len(first)} at {first.fps:g}; expected the same. "
                "Use motion.resample(fps) and slices motion[a:b]"
            )
    if body is None:
        body = Body.default()
    bodies = several(body)
    if not isinstance(body, list | tuple):
        bodies *= len(motions)
    if len(bodies) != len(motions):
        raise InputError(f"body: found {len(bodies)} bodies for {len(motions)} motions")
    for one, its in zip(motions, bodies, strict=True):
        check_match(one, its, allow_mismatch=allow_mismatch)

    firmness = stiffness_over_time(stiffness, len(first), len(motions))
    simulator = Simulator(scene, body=bodies, settings=settings, fps=first.fps)
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
    world, stepper = simulator.world, simulator.world.stepper
    count = len(motions[0])
    if simulator.settings.mode in ENGINE_MODES:
        from halfphysics.baselines.engine.following import follow_in_engine

        if stiffness is not None:
            raise no_stiffness(simulator.settings.mode)
        with _progress(count - 1, progress) as bar:
            return follow_in_engine(world, motions, simulator.dt, bar.update)
    targets = world.motion_coordinates(motions)
    simulator.reset([m[0] for m in motions])
    qpos, clearance = np.empty((count, world.nq)), np.empty(count)
    qpos[0], clearance[0] = stepper.qpos(), stepper.clearance()
    inside = [stepper.inside()]
    inside_frames = [np.zeros(len(inside[0]), dtype=np.int64)]
    if len(inside[0]):
        _warn_of_start(world, inside_of(world, inside[0], inside_frames[0]))
    else:
        _warn_of_floating(world, motions)
    lost_time = np.zeros(count)
    torque = np.zeros((count, len(motions), N_JOINTS, 3))
    firmness = np.zeros((0, 0)) if stiffness is None else world.firmness(stiffness)
    substeps = [qpos[:1].copy()]
    rows, row_frames = [], []
    numbers = np.zeros((count, len(DIAGNOSTICS)))
    settings = simulator.settings
    with _progress(count - 1, progress) as bar:
        done = 1
        while done < count:
            # A slice of time at a time: the bar moves, and Ctrl-C is heard.
            got = stepper.run(
                targets[done:],
                simulator.dt,
                settings.substeps_for(simulator.dt),
                settings.record == "substeps",
                _SLICE,
                firmness[done:],
            )
            frames = np.arange(done, done + len(got["qpos"]))
            qpos[frames], clearance[frames] = got["qpos"], got["clearance"]
            torque[frames[got["torque_frames"].astype(np.int64)]] = world.torques(got["torques"])
            lost_time[frames], numbers[frames] = got["lost_time"], got["diagnostics"]
            substeps.append(got["substeps"])
            rows.append(got["touches"])
            row_frames.append(np.repeat(frames, got["touch_count"].astype(np.int64)))
            inside.append(got["inside"])
            inside_frames.append(np.repeat(frames, got["inside_count"].astype(np.int64)))
            done += len(frames)
            bar.update(len(frames))
    torque.setflags(write=False)
    result = Result(
        people=tuple(
            PersonResult(
                motion=_followed(motion, person, qpos, settings),
                reference=motion,
                body=person.body,
                name=person.name,
                torque=torque[:, i],
            )
            for i, (motion, person) in enumerate(zip(motions, world.people, strict=True))
        ),
        objects=_tracks(world, qpos),
        joints={joint.name: joint.values(qpos) for joint in world.joints},
        scene=world.scene,
        names=world.names,
        contacts=_contacts(world, rows, row_frames),
        clearance=clearance,
        lost_time=lost_time,
        settings=simulator.settings,
        substeps=_substeps(simulator, motions, np.concatenate(substeps)),
        diagnostics=dict(zip(DIAGNOSTICS, numbers.T, strict=True)),
        inside=inside_of(world, np.concatenate(inside), np.concatenate(inside_frames)),
    )
    warn_of_lost_time(result, stacklevel=3)
    return result


def _followed(motion: Motion, person: Person, qpos: Array, settings: Settings) -> Motion:
    """What became of a motion: coordinates (T, nq) of all frames, or what set the pose itself."""
    if settings.mode in FORCED:
        return motion.with_frames(motion.translation, motion.rotations)
    return motion.with_frames(*person.pose(qpos, motion.axes))


def _warn_of_start(world: World, inside: Depths) -> None:
    """One warning that names what starts inside what, at the line that called `simulate`."""
    worth = inside[(inside.depth > START_INSIDE) | inside.no_way_out]
    if not len(worth):
        return
    words = worth.described(world.names, len(world.people))
    more = f" and {len(words) - _NAMED} more" if len(words) > _NAMED else ""
    warnings.warn(
        f"the start is not clear: {', '.join(words[:_NAMED])}{more}. What starts inside is pushed "
        "out; that it meets nothing is guaranteed for clear starts. Move the motion or the scene, "
        "or see motion.grounded(body) for feet in a floor",
        HalfPhysicsWarning,
        stacklevel=4,
    )


def _warn_of_floating(world: World, motions: Sequence[Motion]) -> None:
    """One warning for each clip from a file whose first frame is in mid-air in this scene."""
    for person, motion in zip(world.people, motions, strict=True):
        found = None if motion.origin is None else floating(person.body, motion[0], world.scene)
        if found is not None:
            warnings.warn(
                f"{person.name} starts {100.0 * found[0]:.0f} cm above {found[1]}, on nothing. "
                "Where the clip's floor is not the scene's: motion.grounded(body, z=...), or "
                "--grounded",
                HalfPhysicsWarning,
                stacklevel=4,
            )


def _progress(frames: int, show: bool) -> Any:
    """A progress bar on stderr where that is a terminal, after two seconds, if it is to show."""
    from tqdm import tqdm

    hidden = None if show else True
    return tqdm(total=frames, unit="frame", delay=2.0, disable=hidden, leave=False)


def _contacts(world: World, rows: list[Array], row_frames: list[NDArray[np.int64]]) -> Contacts:
    """The core's rows of all frames in terms of people and names."""
    if not sum(map(len, rows)):
        return Contacts.none()
    columns, row = touches(world, np.concatenate(rows))
    return Contacts(frame=np.concatenate(row_frames)[row], **vars(columns))


def _tracks(world: World, qpos: Array) -> dict[str, ObjectTrack]:
    """The objects' poses in model coordinates (T, nq)."""
    tracks = {}
    for thing in world.tracked:
        position, quaternion = thing.pose(qpos)
        tracks[thing.name] = ObjectTrack(position=position, quaternion=quaternion)
    return tracks


def _substeps(simulator: Simulator, motions: Sequence[Motion], qpos: Array) -> Substeps | None:
    """Every committed pose (S + 1, nq), with `Settings.record="substeps"`; first the start."""
    if simulator.settings.record != "substeps":
        return None
    world = simulator.world
    fps = motions[0].fps * simulator.settings.substeps_for(simulator.dt)
    return Substeps(
        motions=tuple(
            at_substeps(m, *person.pose(qpos, m.axes), fps)
            for m, person in zip(motions, world.people, strict=True)
        ),
        objects=_tracks(world, qpos),
    )
