"""Puts what was read on the floor: the option `floor` of readers."""

from __future__ import annotations

from collections.abc import Container
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from halfphysics.formats.datasets.ground import lowest_skin
from halfphysics.motion.motion import Motion
from halfphysics.results.result import ObjectTrack

if TYPE_CHECKING:
    from halfphysics.scene.scene import Scene
    from halfphysics.simulation.sequence import Sequence


def motion_on_floor(motion: Motion, floor: float | Literal["lowest"]) -> Motion:
    """The motion with what is at height `floor` [m] at z = 0; "lowest": the default body's skin."""
    from halfphysics.body.body import Body

    if floor == "lowest":
        return motion.grounded(Body.default())
    return _moved(motion, -floor)


def on_floor(
    sequence: Sequence, floor: float | Literal["lowest"], keep: Container[str] = ()
) -> Sequence:
    """The sequence with what is at height `floor` [m] at z = 0: people, things and scene.

    Args:
        sequence: What was read.
        floor: "lowest": that of the lowest skin of all people, of their bodies (default: the
            default body).
        keep: Names of statics that stay where they are.
    """
    up = -(lowest_skin(sequence) if floor == "lowest" else floor)
    motions = tuple(_moved(motion, up) for motion in sequence.motions)
    shift = np.array([0.0, 0.0, up])
    tracks = {
        name: ObjectTrack(position=track.position + shift, quaternion=track.quaternion)
        for name, track in sequence.recorded.items()
    }
    return replace(
        sequence,
        motion=motions[0] if isinstance(sequence.motion, Motion) else motions,
        scene=_raised(sequence.scene, up, keep),
        recorded=tracks,
    )


def _moved(motion: Motion, up: float) -> Motion:
    shift = np.array([0.0, 0.0, up])
    return motion.changed(lambda m: m.with_frames(m.translation + shift, m.rotations))


def _raised(scene: Scene, up: float, keep: Container[str]) -> Scene:
    """A copy of a scene, all of it moved along z."""
    shift, items = np.array([0.0, 0.0, up]), {}
    for name, item in scene._items().items():
        if name not in keep:
            moved: dict[str, Any] = {"position": item.position + shift}
            if hasattr(item, "positions"):
                moved["positions"] = item.positions + shift
            items[name] = replace(item, **moved)
    return scene._with(items, {})
