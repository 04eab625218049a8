"""The convex pieces of people that a simulator keeps clear, posed here without the core.

With `contact="parts"` these are the 55 hulls of the rigid parts, posed by their bodies' frames;
with "skin" the hulls of skinned vertices (`body.skin_corners`), skinned by `skin_judge.Skinner`.
The core supplies only the coordinates and, for the parts, the frames of bodies.
"""

from __future__ import annotations

from functools import cached_property, lru_cache

import coal
import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.motion.skeleton import JOINT_NAMES, N_JOINTS, PARENTS
from support.judges.coal_shapes import coal_hull
from support.judges.skin_judge import Skinner

CONTACTS = ("skin", "parts")
#: The skin is in the world's axes here: the root's rotation contains them.
WORLD = np.eye(3)
#: Bodies whose hulls are kept.
BODIES = 8
#: Points of clouds made together: bounds the memory.
MOST = 100_000


def pieces_of(simulator, contact=None):
    """The pieces of every person.

    Args:
        simulator: A `halfphysics.simulation.simulator.Simulator`.
        contact: "skin", "parts", "both"; None: the simulator's own setting.
    """
    contact = contact or simulator.world.settings.contact
    kinds = CONTACTS if contact == "both" else (contact,)
    made = {"skin": Skin, "parts": Parts}
    return [made[k](simulator.world, p) for p in simulator.world.people for k in kinds]


@lru_cache(maxsize=BODIES)
def _solids(body):
    return [coal_hull(p.vertices) for p in body.variant.parts if len(p.vertices) >= 4]


class Parts:
    """The rigid parts of one person.

    Attributes:
        name: The person's name.
        names: Names of the pieces, "person/left_foot".
        first: Index of each piece's first corner, and the number of corners (P + 1,).
    """

    def __init__(self, world, person):
        parts = [p for p in person.body.variant.parts if len(p.vertices) >= 4]
        self.name = person.name
        self.names = [f"{person.name}/{p.name}" for p in parts]
        self._stepper = world.stepper
        self._bodies = [world.model.body(name).id for name in self.names]
        self._points = [np.asarray(p.vertices, float) for p in parts]
        self._size = np.array([np.linalg.norm(p, axis=1).max() for p in self._points])
        self._solids = _solids(person.body)
        self.first = np.cumsum([0, *(len(p) for p in self._points)])

    def at(self, poses):
        """The pieces at poses (T, nq)."""
        x, q = zip(*(self._stepper.body_frames(p) for p in poses), strict=True)
        x, q = np.array(x)[:, self._bodies], np.array(q)[:, self._bodies]
        return Posed(self, poses, _PartState(self, x, rot.to_matrix(rot.normalize(q))))


class _PartState:
    def __init__(self, pieces, x, turn):
        self.pieces, self.x, self.turn = pieces, x, turn

    def corners(self):
        points = self.pieces._points
        local = np.concatenate(points)
        owner = np.repeat(np.arange(len(points)), [len(p) for p in points])
        moved = [
            np.einsum("nij,nj->ni", turn[owner], local) + x[owner]
            for x, turn in zip(self.x, self.turn, strict=True)
        ]
        return np.stack(moved, axis=1)

    def solid(self, i, t, corners):
        return self.pieces._solids[i], coal.Transform3s(self.turn[t, i], self.x[t, i])

    def length(self, i, t):
        """An upper bound of the way of piece i's corners from pose t to the next [m]."""
        angle = np.linalg.norm(self._turned(i, t))
        return np.linalg.norm(self.x[t + 1, i] - self.x[t, i]) + self.pieces._size[i] * angle

    def between(self, i, t, share):
        """Corners (n, 3) at a share of the way: origin straight, rotation by the shortest arc."""
        turn = self.turn[t, i] @ rot.rotvec_to_matrix(share * self._turned(i, t))
        x = self.x[t, i] + share * (self.x[t + 1, i] - self.x[t, i])
        return self.pieces._points[i] @ turn.T + x

    def _turned(self, i, t):
        return rot.matrix_to_rotvec(self.turn[t, i].T @ self.turn[t + 1, i])


@lru_cache(maxsize=BODIES)
def _skinning(body):
    """Of a body its `Skinner`, and what that makes of its hulls' corners (`Skinner.linear`)."""
    skinner = Skinner(body, samples=0)
    return skinner, skinner.linear(body.skin_corners.vertex)


class Skin:
    """The hulls of one person's skin; attributes as of `Parts`, names "person/left_foot/3"."""

    def __init__(self, world, person):
        hulls, self.body = person.body.skin_corners, person.body
        self.name, self.person = person.name, person
        self.names = [f"{person.name}/{JOINT_NAMES[k]}/{h}" for h, k in enumerate(hulls.part)]
        self.first, self.vertex = hulls.first, hulls.vertex
        self.skinner, self._blend = _skinning(person.body)

    def at(self, poses):
        """The pieces at poses (T, nq)."""
        return Posed(self, poses, _SkinState(self, poses))

    def skinned(self, translation, rotations):
        """Corners (n, T, 3) of all hulls."""
        if self._blend is None:
            skin = self.skinner.vertices(translation, rotations, WORLD)
            return np.ascontiguousarray(np.swapaxes(skin[:, self.vertex], 0, 1))
        return self.skinner.points_of(self._blend, translation, rotations, WORLD)

    @cached_property
    def arms(self):
        """Bounds of the speed of hull h's corners per rad/s of a joint [m] (P, 55)."""
        joints, rest = np.asarray(self.body.rest_joints), np.asarray(self.body.rest_vertices)
        length = np.linalg.norm(joints - joints[[max(p, 0) for p in PARENTS]], axis=1)
        bent = np.zeros((len(rest), N_JOINTS))  # per joint, at the vertex
        if self.body.posedirs is not None:
            by_joint = np.asarray(self.body.posedirs).reshape(len(rest), 3, -1, 9)
            # |d(R - I)/dt| is sqrt(2) of the angular speed, |R - I| 2 sqrt(2) at most.
            bent[:, 1:] = np.sqrt(2.0 * (by_joint**2).sum(axis=(1, 3)))
        out = np.zeros((len(self.names), N_JOINTS))
        for h in range(len(self.names)):
            vertex = self.vertex[self.first[h] : self.first[h + 1]]
            out[h] = bent[vertex].max(axis=0)
            far = np.zeros(N_JOINTS)
            for k in np.flatnonzero((np.asarray(self.body.weights)[vertex] > 0.0).any(axis=0)):
                with_it = vertex[np.asarray(self.body.weights)[vertex, k] > 0.0]
                reach = np.linalg.norm(rest[with_it] - joints[k], axis=1)
                reach = (reach + 2.0 * bent[with_it].sum(axis=1)).max()
                a = int(k)
                while a >= 0:  # an axis is no farther off than the bones are long
                    far[a] = max(far[a], reach)
                    reach, a = reach + length[a], int(PARENTS[a])
            out[h] += far
        return out


class _SkinState:
    def __init__(self, pieces, poses):
        self.pieces, self.poses = pieces, np.asarray(poses)
        self.translation, self.rotations = pieces.person.pose(self.poses, WORLD)
        self._ways = {}

    def corners(self):
        return self.pieces.skinned(self.translation, self.rotations)

    def solid(self, i, t, corners):
        return coal_hull(corners), coal.Transform3s()

    def length(self, i, t):
        moved = np.linalg.norm(self.translation[t + 1] - self.translation[t])
        return moved + self.pieces.arms[i] @ np.linalg.norm(self._turned(t), axis=1)

    def between(self, i, t, share):
        """Corners at a share of the way: root straight, every joint by its shortest arc."""
        if (t, share) not in self._ways:
            q = rot.multiply(rot.exp(self.rotations[t]), rot.exp(share * self._turned(t)))
            x = self.translation[t] + share * (self.translation[t + 1] - self.translation[t])
            self._ways[t, share] = self.pieces.skinned(x[None], rot.log(q)[None])[:, 0]
        return self._ways[t, share][self.pieces.first[i] : self.pieces.first[i + 1]]

    def _turned(self, t):
        a, b = rot.exp(self.rotations[t]), rot.exp(self.rotations[t + 1])
        return rot.log(rot.multiply(rot.conjugate(a), b))


class Posed:
    """Pieces at poses 0 to T - 1, and on their ways from each to the next.

    Attributes:
        corners: Corners of all pieces (n, T, 3) [m].
        low, high: Corners of boxes around the pieces (T, P, 3).
    """

    def __init__(self, pieces, poses, state):
        self.pieces, self._state = pieces, state
        self.corners = state.corners()
        each = np.split(self.corners, pieces.first[1:-1])
        self.low = np.stack([c.min(axis=0) for c in each], axis=1)
        self.high = np.stack([c.max(axis=0) for c in each], axis=1)

    def boxes(self, piece, begin, end):
        """Corners of boxes (K, 3) around pieces (K,) at all poses from `begin` to `end` (K,)."""
        pose = begin[:, None] + np.arange(1 + (end - begin).max(initial=0))
        pose = np.minimum(pose, end[:, None])
        return self.low[pose, piece[:, None]].min(axis=1), self.high[pose, piece[:, None]].max(
            axis=1
        )

    def clouds(self, piece, begin, end):
        """Corners of pieces (K,) at all poses from `begin` to `end` (K,).

        Yields indices (k,) into the K, of pieces of like sizes, and their points (k, m, 3): some
        repeat, so that all are as many.
        """
        first, size = self.pieces.first[:-1], np.diff(self.pieces.first)
        pose = np.arange(1 + (end - begin).max(initial=0))
        kinds = np.ceil(np.log2(size[piece])).astype(int)
        for kind in np.unique(kinds):
            same = np.flatnonzero(kinds == kind)
            corner = np.arange(size[piece[same]].max())
            for some in np.array_split(same, 1 + len(same) * len(corner) * len(pose) // MOST):
                i = piece[some][:, None]
                rows = first[i] + np.minimum(corner, size[i] - 1)
                at = np.minimum(begin[some][:, None] + pose, end[some][:, None])
                yield some, self.corners[rows[:, None], at[:, :, None]].reshape(len(some), -1, 3)

    def points(self, i, t):
        """Corners (n, 3) of piece i at pose t."""
        return self.corners[self.pieces.first[i] : self.pieces.first[i + 1], t]

    def solid(self, i, t):
        """coal's geometry and place of it."""
        return self._state.solid(i, t, self.points(i, t))

    def length(self, i, t):
        """An upper bound of the way of piece i's corners from pose t to the next [m]."""
        return self._state.length(i, t)

    def between(self, i, t, share):
        """Corners (n, 3) of piece i at a share of its way from pose t to the next."""
        return self._state.between(i, t, share)
