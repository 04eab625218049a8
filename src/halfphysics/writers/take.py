"""A take: people and props over time, the input of the writers of animated scenes."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.validation import shown
from halfphysics.errors import InputError
from halfphysics.motion.motion import Motion
from halfphysics.scene.articulated import start_poses

if TYPE_CHECKING:
    from collections.abc import Mapping

    from halfphysics.body.body import Body
    from halfphysics.results.dents import Dent
    from halfphysics.results.result import ObjectTrack, Result
    from halfphysics.scene.scene import Scene
    from halfphysics.simulation.sequence import Sequence

    Exportable: TypeAlias = Result | Sequence | Motion

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Actor:
    """A person: `body` moves along `motion`, T frames in the z-up world."""

    name: str
    motion: Motion
    body: Body


@dataclass(frozen=True, kw_only=True, eq=False)
class Prop:
    """A prop: a mesh (V, 3), (F, 3) in its own frame [m] and that frame's pose over time.

    `position` (T, 3) [m] and `quaternion` (T, 4) in the z-up world; one row for a static prop. The
    `dent` of a soft prop that something presses says how its vertices, of that mesh, give.
    """

    name: str
    vertices: Array
    faces: NDArray[np.integer]
    position: Array
    quaternion: Array
    dent: Dent | None = None

    @property
    def moves(self) -> bool:
        """Whether it has a pose per frame."""
        return len(self.position) > 1


@dataclass(frozen=True, kw_only=True, eq=False)
class Take:
    """An animated scene: people and props over `frames` frames, `fps` per second.

    `scene` is the scene of the props (by their names), `joints` the values of the joints of its
    articulated objects as in `Result.joints`, empty if they are unknown.

    Raises:
        InputError: A person or a prop has another number of frames or another rate.
    """

    actors: tuple[Actor, ...]
    props: tuple[Prop, ...]
    fps: float
    frames: int
    scene: Scene
    joints: Mapping[str, Array] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for actor in self.actors:
            motion = actor.motion
            if (len(motion), motion.fps) != (self.frames, self.fps):
                raise InputError(
                    f"export: {actor.name} has {len(motion)} frames at {motion.fps:g} fps, "
                    f"{self.actors[0].name} has {self.frames} at {self.fps:g}; expected the same. "
                    "Use motion.resample(fps) and motion[:frames]"
                )
        for prop in self.props:
            if prop.moves and len(prop.position) != self.frames:
                raise InputError(
                    f"export: {prop.name} has {len(prop.position)} frames, expected "
                    f"{self.frames}, as many as the motion has"
                )


def take_of(what: Exportable, body: Body | None = None, *, fps: float | None = None) -> Take:
    """The take of a result (simulated), a sequence or a motion (reference).

    Args:
        what: A `Result`, `Sequence` or `Motion`.
        body: The body, if `what` has none; None: the default body.
        fps: Frame rate of the take; None: that of the motion.

    Raises:
        InputError: Another type.
    """
    from halfphysics.body.body import Body
    from halfphysics.results.result import Result
    from halfphysics.scene.scene import Scene
    from halfphysics.simulation.sequence import Sequence

    if isinstance(what, Result):
        actors = tuple(
            Actor(name=p.name, motion=p.motion, body=body or p.body) for p in what.people
        )
        scene, joints = what.scene, what.joints
        props = _props(scene, what.objects, _middle(actors), what.dents)
    elif isinstance(what, Sequence | Motion):
        motions = what.motions if isinstance(what, Sequence) else (what,)
        bodies = what.bodies if isinstance(what, Sequence) else (None,)
        names = ["person"] if len(motions) == 1 else [f"person{i}" for i in range(len(motions))]
        actors = tuple(
            Actor(name=name, motion=motion, body=body or own or Body.default())
            for name, motion, own in zip(names, motions, bodies, strict=True)
        )
        sequence = what if isinstance(what, Sequence) else Sequence(what, Scene())
        scene, joints = sequence.scene, {}
        tracks = {**_own_ways(scene, motions[0]), **sequence.recorded}
        props = _props(scene, tracks, _middle(actors), {})
    else:
        raise InputError(f"export: expected a Result, a Sequence or a Motion, found {shown(what)}")
    first = actors[0].motion
    take = Take(
        actors=actors, props=props, fps=first.fps, frames=len(first), scene=scene, joints=joints
    )
    return take if fps is None else resampled(take, fps)


def _own_ways(scene: Scene, motion: Motion) -> dict[str, ObjectTrack]:
    """Where things are that move along trajectories, at the frames of a motion."""
    from halfphysics.results.object_track import ObjectTrack
    from halfphysics.scene.trajectories import KinematicObject

    times = np.arange(len(motion)) / motion.fps
    moving = {n: item for n, item in scene.objects.items() if isinstance(item, KinematicObject)}
    ways = {name: item.at(times) for name, item in moving.items()}
    return {name: ObjectTrack(position=x, quaternion=q) for name, (x, q) in ways.items()}


def _middle(actors: tuple[Actor, ...]) -> Array:
    """Centre (3,) of the box around the people's pelvises at all frames [m]."""
    ways = np.concatenate([a.body.joint_frames(a.motion)[0][:, 0] for a in actors])
    result: Array = 0.5 * (ways.min(axis=0) + ways.max(axis=0))
    return result


def _props(
    scene: Scene, tracks: Mapping[str, ObjectTrack], middle: Array, dents: Mapping[str, Dent]
) -> tuple[Prop, ...]:
    """The props; `middle` is the point around which planes, which are infinite, are drawn."""
    from halfphysics.geometry.shapes import Plane

    props = []
    for name, static in scene.statics.items():
        if name in dents:
            props.append(_soft(dents[name], static.position, static.quaternion))
            continue
        vertices, faces = static.mesh()
        if isinstance(static.shape, Plane):
            local = rot.rotate(rot.conjugate(static.quaternion), middle - static.position)
            normal = np.asarray(static.shape.normal)
            vertices = vertices + local - normal * (normal @ local)
        props.append(_prop(name, (vertices, faces), static.position, static.quaternion))
    for name, item in scene.objects.items():
        mesh = item.mesh() if item.visual is None else item.visual.triangles()
        track = tracks.get(name)
        place = (item.position, item.quaternion)
        if name in dents:
            props.append(_soft(dents[name], *(place if track is None else _rows(track))))
            continue
        props.append(_prop(name, mesh, *(place if track is None else _rows(track))))
    for jointed in scene.articulated.values():
        starts = start_poses(jointed)
        for link, name, place in zip(jointed.links, jointed.link_names, starts, strict=True):
            vertices, faces = link.mesh()
            if len(faces):
                track = tracks.get(name)
                place = place if track is None else _rows(track)
                props.append(_prop(name, (vertices, faces), *place))
    return tuple(props)


def _rows(track: ObjectTrack) -> tuple[Array, Array]:
    return track.position, track.quaternion


def _soft(dent: Dent, position: Array, quaternion: Array) -> Prop:
    mesh = (dent.layer.surface, dent.faces)
    return replace(_prop(dent.name, mesh, position, quaternion), dent=dent)


def _prop(
    name: str, mesh: tuple[Array, NDArray[np.integer]], position: Array, quaternion: Array
) -> Prop:
    return Prop(
        name=name,
        vertices=np.asarray(mesh[0], dtype=np.float64),
        faces=np.asarray(mesh[1]),
        position=np.asarray(position, dtype=np.float64).reshape(-1, 3),
        quaternion=np.asarray(quaternion, dtype=np.float64).reshape(-1, 4),
    )


def resampled(take: Take, fps: float) -> Take:
    """The take at another frame rate: positions linear, rotations by SLERP."""
    from halfphysics.motion.resampling import neighbours

    actors = tuple(
        Actor(name=a.name, motion=a.motion.resample(fps), body=a.body) for a in take.actors
    )
    frames = len(actors[0].motion)
    low, high, weight = neighbours(np.arange(frames, dtype=np.float64) * (take.fps / fps))
    high = np.minimum(high, take.frames - 1)
    w = weight[:, None]
    props = []
    for p in take.props:
        if p.moves:
            p = replace(
                p,
                position=(1.0 - w) * p.position[low] + w * p.position[high],
                quaternion=rot.slerp(p.quaternion[low], p.quaternion[high], weight),
            )
        props.append(p if p.dent is None else replace(p, dent=p.dent.sampled(low, high, weight)))
    joints = {}
    for name, values in take.joints.items():
        a, b = values[low], values[high]
        if values.ndim == 1:
            joints[name] = (1.0 - weight) * a + weight * b
            continue
        # The position of a free joint, the rotation of free and ball joints.
        place = (1.0 - w) * a[:, :-4] + w * b[:, :-4]
        joints[name] = np.hstack([place, rot.slerp(a[:, -4:], b[:, -4:], weight)])
    return replace(
        take, actors=actors, props=tuple(props), fps=float(fps), frames=frames, joints=joints
    )
