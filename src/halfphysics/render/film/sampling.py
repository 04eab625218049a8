"""A result at the times of a film: poses between its frames are interpolated."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.motion.motion import Motion
from halfphysics.motion.resampling import neighbours
from halfphysics.motion.skeleton import N_JOINTS
from halfphysics.results.result import ObjectTrack

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.results.dents import Dent
    from halfphysics.results.result import Result
    from halfphysics.scene.scene import Scene

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class DrawnPerson:
    """A person as drawn: the body, the simulated motion and the recorded one."""

    body: Body
    motion: Motion
    recorded: Motion


@dataclass(frozen=True, kw_only=True)
class Sampled:
    """A result as drawn, at other times than its frames."""

    people: tuple[DrawnPerson, ...]
    objects: Mapping[str, ObjectTrack]
    scene: Scene
    dents: Mapping[str, Dent]

    @property
    def motion(self) -> Motion:
        """The first person's motion."""
        return self.people[0].motion


def sampled(result: Result, frames: Array) -> Sampled:
    """The result at fractional frames (N,); whole ones are copied bit for bit.

    Frames after the last one are the last one: the shorter of two results waits at its end.
    """
    low, high, weight = neighbours(np.clip(frames, 0.0, len(result.motion) - 1.0))

    def track(given: Any) -> ObjectTrack:
        q = np.asarray(given.quaternion)
        return ObjectTrack(
            position=_line(np.asarray(given.position), low, high, weight),
            quaternion=_turn(q, low, high, weight),
        )

    # What is drawn need not be a result: it may have none.
    dents: Mapping[str, Dent] = getattr(result, "dents", {})
    return Sampled(
        people=tuple(
            DrawnPerson(
                body=person.body,
                motion=_motion(person.motion, low, high, weight),
                recorded=_motion(person.recorded, low, high, weight),
            )
            for person in result.people
        ),
        objects={name: track(given) for name, given in result.objects.items()},
        scene=result.scene,
        dents={name: dent.sampled(low, high, weight) for name, dent in dents.items()},
    )


def _motion(motion: Motion, low: Any, high: Any, weight: Array) -> Motion:
    """The poses of a film: any number of them, one too, and however far one is from the next."""
    rotations = motion.rotations[low]
    between = weight > 0.0
    before, after = (rot.exp(motion.rotations[k[between]]) for k in (low, high))
    rotations[between] = rot.log(rot.slerp(before, after, weight[between, None]))
    translation = _line(motion.translation, low, high, weight)
    # Pictures are no motion to simulate: neither their number nor their speed is checked.
    poses = Motion(np.zeros((2, 3)), np.zeros((2, N_JOINTS, 3)), motion.fps, axes=motion.axes)
    for name, values in (("translation", translation), ("rotations", rotations)):
        values.setflags(write=False)
        object.__setattr__(poses, name, values)
    return poses


def _line(values: Array, low: Any, high: Any, weight: Array) -> Array:
    w = weight[:, None]
    result: Array = np.where(w > 0.0, (1.0 - w) * values[low] + w * values[high], values[low])
    return result


def _turn(quaternions: Array, low: Any, high: Any, weight: Array) -> Array:
    turned = rot.slerp(quaternions[low], quaternions[high], weight)
    return np.where(weight[:, None] > 0.0, turned, quaternions[low])
