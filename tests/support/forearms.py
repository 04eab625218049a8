"""A body small enough for plain numpy, and a motion that bends all its joints."""

from __future__ import annotations

import dataclasses

import numpy as np

import halfphysics as hp
from halfphysics.bench.clips import straight
from halfphysics.labels.bounding_spheres import part_balls


def forearm() -> hp.Body:
    """A forearm with palm and thumb alone: plain numpy tries every triangle."""
    body = hp.Body.default()
    part = part_balls(body).part
    faces = body.faces[np.isin(part, [18, 20, 37, 38, 39])[body.faces].all(axis=1)]
    kept, place = np.unique(faces, return_inverse=True)
    return dataclasses.replace(
        body,
        faces=place.reshape(-1, 3).astype(np.int32),
        weights=body.weights[kept],
        rest_vertices=body.rest_vertices[kept],
        mean_vertices=None,
        mean_joints=None,
    )


def wavy(frames: int = 6) -> hp.Motion:
    """A person with all joints bent."""
    motion = straight(frames / 30.0, 0.3, -0.2)[:frames]
    rng = np.random.default_rng(3)
    swing = 0.5 * rng.normal(size=(1, 55, 3)) * np.linspace(0.0, 1.0, len(motion))[:, None, None]
    swing[:, 0] = 0.0
    return motion.with_frames(motion.translation, motion.rotations + swing)
