"""Statics as many convex obstacles, and what of a person they are proven to be clear of.

Every triangle of a mesh is an obstacle, every primitive is one as a whole. `Obstacles.clearance`
answers for many clouds of points at once: is the hull of this cloud farther than `far` from all
obstacles? It proves so by planes (`separation`): every obstacle near the cloud has to be behind
one.
"""

from __future__ import annotations

import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Mesh, Sphere
from support.judges.separation import TINY, nearest_to_origin, planes
from support.judges.triangle_soup import Boxes, triangle_boxes


class Obstacles:
    """Convex obstacles of statics (none of them a plane), in the world.

    Attributes:
        owner: Index of each obstacle's static (O,).
    """

    def __init__(self, statics):
        meshes = [k for k, s in enumerate(statics) if isinstance(s.shape, Mesh)]
        others = [k for k in range(len(statics)) if k not in set(meshes)]
        facets = [_facets(statics[k]) for k in meshes]
        self._round = [_Primitive(statics[k]) for k in others]
        self._facets = sum(map(len, facets))
        cores = [r.core[None] for r in self._round]
        # A triangle, a segment or a point (O, 3, 3).
        self._core = np.concatenate([np.zeros((0, 3, 3)), *facets, *cores])
        self.owner = np.repeat([*meshes, *others], [*map(len, facets), *(1 for _ in others)])
        low, high = triangle_boxes(self._core)
        self._half = np.array([r.half for r in self._round]).reshape(-1, 3, 3)
        self._disc = np.array([r.disc for r in self._round]).reshape(-1, 2, 3)
        self._ball = np.array([r.ball for r in self._round]).reshape(-1, 1)
        reach = np.abs(self._half).sum(axis=1) + self._ball
        reach = reach + np.linalg.norm(self._disc, axis=1)
        low[self._facets :] -= reach
        high[self._facets :] += reach
        self._low, self._high = low, high
        self._boxes = Boxes(low, high) if len(low) else None

    def highest(self, which, n):
        """The points (k, 3) of obstacles `which` (k,) farthest along unit normals n (k, 3)."""
        core = self._core[which]
        heights = np.einsum("kmi,ki->km", core, n)
        out = core[np.arange(len(which)), heights.argmax(axis=1)]
        if self._facets < len(self._core):
            some = np.flatnonzero(which >= self._facets)
            r, n = which[some] - self._facets, n[some]
            sides = np.sign(np.einsum("kij,kj->ki", self._half[r], n))
            out[some] += np.einsum("ki,kij->kj", sides, self._half[r]) + self._ball[r] * n
            across = np.einsum("kij,kj->ki", self._disc[r], n)
            size = np.linalg.norm(across, axis=1, keepdims=True)
            out[some] += np.einsum("ki,kij->kj", across / np.maximum(size, TINY), self._disc[r])
        return out

    def near(self, low, high):
        """Pairs (box, obstacle) that meet, of boxes (K, 3); sorted by box."""
        box, which = self._boxes.overlapping(low, high)
        order = np.argsort(box, kind="stable")
        return box[order], which[order]

    def clearance(self, clouds, middle, cloud, which, far, settle=False):
        """Distances of the hulls of clouds (K, m, 3): `far` where it is proven, else less (K,) [m].

        Args:
            middle: Middles of the clouds (K, 3): where to look first.
            cloud, which: The clouds and obstacles that may be near each other; sorted by cloud.
            far: What is to be proven [m].
            settle: What is not proven is an estimate of the distance; without, any smaller number.
        """
        out = np.full(len(clouds), float(far))
        at = middle[cloud]
        if settle:  # the nearest obstacle's distance is the estimate
            away = nearest_to_origin(self._core[which] - at[:, None])
        else:  # for proofs any order will do: by the obstacles' boxes
            away = at - np.clip(at, self._low[which], self._high[which])
        front = -np.einsum("ki,ki->k", away, away)
        while len(cloud):
            # Of each cloud the foremost obstacle that is left.
            start = np.flatnonzero(np.diff(cloud, prepend=-1))
            some = np.repeat(np.arange(len(start)), np.diff(start, append=len(cloud)))
            chosen = np.lexsort((-front, some))[start]
            who, what = cloud[chosen], which[chosen]
            n, d = planes(
                clouds[who],
                lambda i, n, what=what: self.highest(what[i], n),
                -nearest_to_origin(self._core[what] - middle[who, None]),
                far,
                settle,
            )
            out[who] = np.minimum(out[who], d)
            # All obstacles behind the same plane are done.
            bottom = np.einsum("ki,ki->k", self.highest(what, n), n) + d
            top = np.einsum("ki,ki->k", self.highest(which, n[some]), n[some])
            front = top - bottom[some]
            left = (front > -far) & (d >= far)[some]
            left[chosen] = False
            cloud, which, front = cloud[left], which[left], front[left]
        return out


class _Primitive:
    """A primitive in the world: the sum of points, a box, a ball and a disc.

    Attributes:
        core: Points (3, 3).
        half: Vectors from the middle to the sides of the box (3, 3).
        ball: Radius.
        disc: Two radii (2, 3), normal to each other.
    """

    def __init__(self, static):
        turn, position = rot.to_matrix(static.quaternion), np.asarray(static.position, float)
        shape, self.half, self.ball, self.disc = (
            static.shape,
            np.zeros((3, 3)),
            0.0,
            np.zeros((2, 3)),
        )
        length = 0.0
        if isinstance(shape, Box):
            self.half = turn.T * (0.5 * np.asarray(shape.size, float))[:, None]
        elif isinstance(shape, Sphere):
            self.ball = shape.radius
        elif isinstance(shape, Capsule):
            self.ball, length = shape.radius, shape.length
        elif isinstance(shape, Cylinder):
            self.disc, length = shape.radius * turn.T[:2], shape.length
        else:
            raise TypeError(f"no obstacle of a {type(shape).__name__}")
        end = 0.5 * length * turn[:, 2]
        self.core = position + np.array([end, -end, -end])


def _facets(static):
    """The triangles (F, 3, 3) of a mesh."""
    vertices, faces = static.shape.triangles()
    turn = rot.to_matrix(static.quaternion)
    return (np.asarray(vertices) @ turn.T + np.asarray(static.position, float))[np.asarray(faces)]
