"""What is where at some moments: enough to draw people and things that no result holds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from halfphysics.motion.motion import Motion
from halfphysics.motion.pose import Pose
from halfphysics.results.result import ObjectTrack
from halfphysics.scene.articulated import start_poses
from halfphysics.scene.scene import Scene

if TYPE_CHECKING:
    from halfphysics.body.body import Body


@dataclass(frozen=True, eq=False)
class Figure:
    """A person of a moment: a body and its motion, which is its own reference."""

    body: Body
    motion: Motion

    @property
    def recorded(self) -> Motion:
        """The same motion: there is nothing to compare with."""
        return self.motion


@dataclass(frozen=True, kw_only=True, eq=False)
class Moment:
    """People, a scene and its objects, with the attributes of a `Result` that pictures need.

    Attributes:
        people: May be empty.
        scene: Statics and objects.
        objects: Name -> track of as many frames as the motions have.
    """

    people: tuple[Figure, ...] = ()
    scene: Scene = field(default_factory=Scene)
    objects: Mapping[str, ObjectTrack] = field(default_factory=dict)

    @property
    def motion(self) -> Motion:
        """The first person's."""
        return self.people[0].motion

    def __len__(self) -> int:
        return len(self.people[0].motion) if self.people else 1


def standing_still(pose: Pose) -> Motion:
    """A motion of two equal frames: a motion has no fewer."""
    twice = np.stack([pose.translation] * 2), np.stack([pose.rotations] * 2)
    return Motion(*twice, fps=1.0, axes=pose.axes)


def tracks(poses: Mapping[str, tuple[np.ndarray, np.ndarray]]) -> dict[str, ObjectTrack]:
    """Tracks of one frame from positions (3,) [m] and quaternions (4,) by name."""
    return {
        name: ObjectTrack(position=position[None], quaternion=quaternion[None])
        for name, (position, quaternion) in poses.items()
    }


def at_start(scene: Scene) -> dict[str, ObjectTrack]:
    """Tracks of a scene's objects and links at their start."""
    poses = {name: (item.position, item.quaternion) for name, item in scene.objects.items()}
    for item in scene.articulated.values():
        poses |= dict(zip(item.link_names, start_poses(item), strict=True))
    return tracks(poses)
