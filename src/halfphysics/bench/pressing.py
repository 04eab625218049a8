"""A clip with contact, timed beside the peer: common code of the cases with contact."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from halfphysics import metrics
from halfphysics.bench.clips import SUBSTEPS, body
from halfphysics.bench.mujoco_loop import MujocoLoop
from halfphysics.bench.record import Checks, Options, Record
from halfphysics.bench.sides import driven, followed
from halfphysics.motion.motion import Motion
from halfphysics.results.result import ObjectTrack, Result
from halfphysics.scene.scene import Scene
from halfphysics.simulation.simulate import follow
from halfphysics.simulation.simulator import Simulator

if TYPE_CHECKING:
    from halfphysics.body.body import Body

Array = NDArray[np.float64]
#: A person's motion and the tracks of objects.
Moved = tuple[Motion, Mapping[str, ObjectTrack]]


@dataclass(frozen=True, kw_only=True)
class Play:
    """A motion, its scene, and the scene's meshes for the peer.

    Attributes:
        motion: A motion of the default body.
        scene: Statics and objects.
        hulls: Name of a static mesh -> points of its convex pieces, for the peer.
    """

    motion: Motion
    scene: Scene
    hulls: Mapping[str, Sequence[Array]] = field(default_factory=dict)


def pressed(
    case: str, name: str, play: Play, options: Options
) -> Iterator[tuple[Record, Result, Moved]]:
    """Time both drives at stiffness 1 beside the peer.

    Yields:
        The record, our result, and the peer's motion and object tracks.
    """
    person, motion = body(), play.motion
    peer = MujocoLoop(person, motion.fps, SUBSTEPS, play.scene, play.hulls)
    targets = peer.coordinates(motion.translation, motion.rotations, motion.axes)
    side = peer.player(motion)
    for skin, done in driven(
        case, name, motion, options, ours=followed, peer=side, scene=play.scene
    ):
        result, rigid, theirs = done.ours, cast("Result", done.parts), done.peer
        moved = tracks(peer, motion, play.scene, theirs)
        checks: Checks = {
            "contacts": (contacts(skin, motion), peer.contacts(targets)),
            "skin inside [mm]": (
                inside(person, play.scene, result.motion, result.objects),
                inside(person, play.scene, *moved),
            ),
            "parts inside [mm]": (
                1000.0 * peer.deepest(coordinates(peer, rigid)),
                1000.0 * peer.deepest(theirs),
            ),
            "time lost [ms]": (1000.0 * float(result.lost_time.sum()), None),
            **solving(skin, motion),
        }
        yield replace(done.record, checks=checks), result, moved


def inside(person: Body, scene: Scene, motion: Motion, objects: Mapping[str, Any]) -> float:
    """Largest penetration of the skin into the scene at the ends of frames [mm]."""
    return metrics.penetration(motion, person, scene, objects=objects).depth_max_mm


def tracks(peer: MujocoLoop, motion: Motion, scene: Scene, qpos: Array) -> Moved:
    """The peer's coordinates (T, nq) as a motion and tracks of objects with centred frames."""
    at = peer.model.nq - 7 * len(scene.objects)
    objects = {}
    for name in scene.objects:
        objects[name] = ObjectTrack(
            position=qpos[:, at : at + 3], quaternion=qpos[:, at + 3 : at + 7]
        )
        at += 7
    return peer.motion(qpos, motion), objects


def coordinates(peer: MujocoLoop, result: Result) -> Array:
    """A result as the peer's coordinates (T, nq); objects have centred frames."""
    motion = result.motion
    qpos = peer.coordinates(motion.translation, motion.rotations, motion.axes)
    at = peer.model.nq - 7 * len(result.objects)
    for track in result.objects.values():
        qpos[:, at : at + 3] = track.position
        qpos[:, at + 3 : at + 7] = track.quaternion
        at += 7
    return qpos


def contacts(simulator: Simulator, motion: Motion) -> float:
    """Largest number of simultaneous contact points per frame, mean over the frames."""
    simulator.reset(motion[0])
    counts = [simulator.step(motion[t]).diagnostics["contacts"] for t in range(1, len(motion))]
    return float(np.mean(counts))


def solving(simulator: Simulator, motion: Motion) -> Checks:
    """Time of the contact solver per substep with contacts [us], median and p95.

    Empty if the core records no times.
    """
    core = simulator.world.stepper
    if not hasattr(core, "keep_times"):
        return {}
    core.keep_times(True)
    try:
        follow(simulator.world, [motion])
        times = np.asarray(core.solve_times())
    finally:
        core.keep_times(False)
    times = times[times > 0.0]
    middle, high = 1e6 * np.percentile(times, [50, 95]) if len(times) else (0.0, 0.0)
    return {"solve [us]": (float(middle), None), "p95 [us]": (float(high), None)}
