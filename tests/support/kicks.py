"""A leg that swings, and a ball in front of its foot."""

from __future__ import annotations

import numpy as np

from halfphysics.geometry.shapes import Plane, Sphere
from halfphysics.scene.scene import Scene
from support.people import along_x


def swing(body, fps, back=True):
    """One second: the right leg swings forward by 1.2 rad in 0.2 s and back, or stays there."""
    n = round(fps) + 1
    t = np.clip((np.arange(n) / fps - 0.3) / 0.4, 0.0, 1.0)
    forward = np.sin(np.pi * t) if back else 0.5 - 0.5 * np.cos(np.pi * np.clip(2 * t, 0.0, 1.0))
    motion = along_x(0.0, n, start=0.0, fps=fps)
    rotations = motion.rotations.copy()
    rotations[:, 2, 0] = 0.4 - 1.2 * forward
    return motion.with_frames(motion.translation, rotations).grounded(body, 0.002)


def before_the_foot(body, mass, radius=0.3, ahead=0.5, height=None, **material):
    """A ball `ahead` of the toe: on the floor, or weightless with its centre at `height` [m]."""
    toe = body.joints(swing(body, 30.0))[0, 11]
    scene = Scene(gravity=9.81 if height is None else 0.0)
    if height is None:
        scene.add_static("floor", Plane())
    position = (toe[0] + ahead + radius, toe[1], radius if height is None else height)
    scene.add_object("ball", Sphere(radius), mass=mass, position=position, **material)
    return scene
