"""Results for glTF writers: a scene with many hands, and its points in a y-up world."""

from __future__ import annotations

import dataclasses

import numpy as np

from halfphysics.body.body import Body


def y_up(points):
    """Points of the z-up world, in a y-up one."""
    x, y, z = np.moveaxis(points, -1, 0)
    return np.stack([x, z, -y], axis=-1)


def many_handed(influences, posedirs=0.0):
    """The default body with more joints to a vertex, and pose blend shapes of that size [m]."""
    body, rng = Body.default(), np.random.default_rng(2)
    weights = np.zeros_like(body.weights)
    joints = np.argsort(rng.random(weights.shape), axis=1)[:, :influences]
    np.put_along_axis(weights, joints, rng.uniform(0.1, 1.0, size=joints.shape), axis=1)
    weights /= weights.sum(axis=1, keepdims=True)
    shapes = None
    if posedirs:
        shapes = posedirs * rng.normal(size=(len(weights), 3, 486))
        shapes *= 0.9 ** rng.permutation(486)  # as in real models, few directions carry most
    return dataclasses.replace(body, weights=weights, posedirs=shapes)
