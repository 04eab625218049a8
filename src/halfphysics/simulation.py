"""The main job: a motion, a scene and a body in; the corrected motion and what it touched out."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.body import check_match
from halfphysics.errors import InputError
from halfphysics.motion import Motion
from halfphysics.result import Contacts, ObjectTrack, PersonResult, Result, Substeps
from halfphysics.simulator import Frame, Simulator, several

if TYPE_CHECKING:
    from halfphysics.body import Body
    from halfphysics.scene import Scene
    from halfphysics.settings import Settings

Array = NDArray[np.float64]


def simulate(
    motion: Motion | Sequence[Motion],
    scene: Scene | None = None,
    *,
    body: Body | Sequence[Body] | None = None,
    settings: Settings | None = None,
    allow_mismatch: bool = False,
    progress: bool = False,
) -> Result:
    """Give a motion a body in a scene (Half-Physics, Algorithm 1, or the drive of `drive_time`).

    Args:
        motion: The motion of one person, or of several (same fps and number of frames).
        scene: Statics and objects; None: an empty one.
        body: The person's body, or one per person; None: `Body.default()` for all.
        settings: See `Settings`.
        allow_mismatch: Accept a body of another gender or model than the motion says.
        progress: Show a progress bar on stderr where it is a terminal.

    Returns:
        `Result`: the corrected motions, the objects' motions, contacts, clearance. Where
        nothing is in the way the motion is followed exactly.

    Raises:
        InputError: An impossible value, or people with different fps or numbers of frames.
        MismatchError: The body's gender or model is not the motion's.
    """
    from halfphysics.body import Body

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

    simulator = Simulator(scene, body=bodies, settings=settings, fps=first.fps)
    # The same coordinates that step() would compute pose by pose, for all frames at once.
    targets = simulator.world.motion_coordinates(motions)
    frames = [simulator.reset([m[0] for m in motions])]
    steps: Iterable[int] = range(1, len(first))
    if progress:
        from tqdm import tqdm

        steps = tqdm(steps, unit="frame", delay=2.0, disable=None, leave=False)
    for t in steps:
        frames.append(simulator._advance(targets[t], simulator.dt))
    return _result(simulator, motions, frames)


def _result(simulator: Simulator, motions: list[Motion], frames: list[Frame]) -> Result:
    world = simulator.world
    people = tuple(
        PersonResult(
            motion=motion.with_frames(
                np.array([f.poses[i].translation for f in frames]),
                np.array([f.poses[i].rotations for f in frames]),
            ),
            reference=motion,
            body=person.body,
            name=person.name,
        )
        for i, (motion, person) in enumerate(zip(motions, world.people, strict=True))
    )
    objects = {
        thing.name: ObjectTrack(
            position=np.array([f.objects[thing.name][0] for f in frames]),
            quaternion=np.array([f.objects[thing.name][1] for f in frames]),
        )
        for thing in world.things
    }
    names = ("person", "part", "subject", "other", "other_part", "position", "normal", "impulse")
    columns = {name: np.concatenate([getattr(f.contacts, name) for f in frames]) for name in names}
    counts = [len(f.contacts.part) for f in frames]
    contacts = Contacts(frame=np.repeat(np.arange(len(frames)), counts), **columns)
    return Result(
        people=people,
        objects=objects,
        scene=world.scene,
        names=world.names,
        contacts=contacts,
        clearance=np.array([f.clearance for f in frames]),
        lost_time=np.array([f.lost_time for f in frames]),
        settings=simulator.settings,
        substeps=_substeps(simulator, motions, frames),
    )


def _substeps(simulator: Simulator, motions: list[Motion], frames: list[Frame]) -> Substeps | None:
    """Every committed pose, with `Settings.record="substeps"`; the first is the start."""
    if simulator.settings.record != "substeps":
        return None
    world = simulator.world
    start, _ = world.start([m[0] for m in motions])
    qpos = np.concatenate([start[None], *(f.substeps for f in frames)])
    fps = motions[0].fps * simulator.settings.substeps_for(simulator.dt)
    tracks = {}
    for thing in world.things:
        position, quaternion = thing.pose(qpos)
        tracks[thing.name] = ObjectTrack(position=position, quaternion=quaternion)
    return Substeps(
        motions=tuple(
            m.with_frames(*person.pose(qpos, m.axes), fps=fps)
            for m, person in zip(motions, world.people, strict=True)
        ),
        objects=tracks,
    )
