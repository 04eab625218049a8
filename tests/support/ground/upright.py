"""Somebody who stands upright with bent knees, and a floor: what tests of standing begin with."""

from __future__ import annotations

import numpy as np
import trimesh

import halfphysics as hp
from support.as_it_is import as_it_is

#: Clearance, the gap of a sole, and what its points miss of the skin between them [m].
STANDS = (0.0009, 0.004)
WEIGHT = as_it_is(weight=True)
BODY = hp.Body.default()
SIDES = ("left", "right")
FEET = np.flatnonzero(
    BODY.weights[
        :, [hp.JOINT_NAMES.index(f"{s}_{j}") for s in ("left", "right") for j in ("ankle", "foot")]
    ].sum(1)
    > 0.5
)


def standing(height=0.0, frames=60, fps=30.0):
    """Somebody who stands upright with bent knees, the soles so high over z = 0 [m]."""
    rotations = np.zeros((frames, 55, 3))
    rotations[:, 0] = [np.pi / 2, 0.0, 0.0]
    for side in ("left", "right"):
        for joint, bend in (("hip", -0.5), ("knee", 1.0), ("ankle", -0.5)):
            rotations[:, hp.JOINT_NAMES.index(f"{side}_{joint}"), 0] = bend
    motion = hp.Motion(np.zeros((frames, 3)), rotations, fps)
    low = BODY.vertices(motion[0])[:, 2].min()
    return motion.with_frames(motion.translation + np.array([0.0, 0.0, height - low]), rotations)


def floor(shape="plane", top=0.0):
    scene = hp.Scene()
    if shape == "plane":
        scene.add_static("floor", hp.Plane(), position=(0.0, 0.0, top))
    else:
        box = hp.Box((4.0, 4.0, 0.2))
        item = box if shape == "hull" else trimesh.creation.box((4.0, 4.0, 0.2))
        scene.add_static("floor", item, position=(0.0, 0.0, top - 0.1))
    return scene


def lowest(motion, vertices=slice(None)):
    return BODY.vertices(motion)[:, vertices, 2].min(axis=1)
