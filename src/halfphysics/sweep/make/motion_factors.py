"""Factors of motions: speed, frame rate, rotation, translation; all people of a clip together.

Angles are in degrees, lengths in metres; docs/sweeps.md explains each factor.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, cast

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.scene.items import fixed
from halfphysics.scene.trajectories import KinematicObject, start_velocity
from halfphysics.sweep.plan.factors import OFFSETS, FactorName
from halfphysics.sweep.plan.values import Value

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion
    from halfphysics.scene.scene import Scene

Array = NDArray[np.float64]


def said_of_motion(factors: Mapping[str, Value]) -> dict[str, float]:
    """The factors `motion.X` by X (other factors are ignored).

    Raises:
        InputError: A factor is unknown or has an impossible value.
    """
    said = {}
    for factor, value in factors.items():
        name = FactorName.parse(factor)
        if name.group == "motion" and name.bounds is not None:
            name.bounds.check(factor, value)
            said[name.what] = float(cast("float", value))
    return said


def retimed(motions: Sequence[Motion], said: Mapping[str, float]) -> tuple[Motion, ...]:
    """The motions `speed` times as fast at their own frame rate, or at `fps`: sampled once."""
    speed = said.get("speed", 1.0)
    made = []
    for motion in motions:
        fps = said.get("fps", motion.fps)
        quick = motion
        if speed != 1.0:
            quick = motion.changed(lambda its: replace(its, fps=speed * its.fps))
        made.append(quick if quick.fps == fps else quick.resample(fps))
    return tuple(made)


def placed(
    motions: Sequence[Motion], bodies: Sequence[Body], said: Mapping[str, float]
) -> tuple[Motion, ...]:
    """The motions rotated about the vertical at the first person's initial pelvis, then moved."""
    angle = np.radians(said.get("yaw", 0.0))
    offset = np.array([said.get(key, 0.0) for key in OFFSETS])
    if angle == 0.0 and not offset.any():
        return tuple(motions)
    pelvises = [m.axes @ b.rest_joints[0] for m, b in zip(motions, bodies, strict=True)]
    centre = motions[0].translation[0] + pelvises[0]
    turn = np.array([np.cos(0.5 * angle), 0.0, 0.0, np.sin(0.5 * angle)])

    def moved(motion: Motion, pelvis: Array) -> Motion:
        translation, rotations = motion.translation, motion.rotations
        if angle != 0.0:
            way = translation + pelvis - centre
            translation = centre + rot.rotate(turn, way) - pelvis
            rotations = np.array(rotations)
            rotations[:, 0] = rot.log(rot.multiply(turn, rot.exp(rotations[:, 0])))
        return motion.with_frames(translation + offset, rotations)

    return tuple(
        motion.changed(partial(moved, pelvis=pelvis))
        for motion, pelvis in zip(motions, pelvises, strict=True)
    )


def recorded_in_step(scene: Scene, speed: float) -> Scene:
    """A new scene in which trajectories are played `speed` times as fast."""
    changed = {}
    for name, item in scene.objects.items():
        if isinstance(item, KinematicObject):
            fps = speed * item.fps
            velocity, spin = start_velocity(item.positions, item.quaternions, fps)
            changed[name] = replace(
                item, fps=fps, velocity=fixed(velocity), angular_velocity=fixed(spin)
            )
    return scene._with(changed, {})
