"""The skin of a pose, and points sampled on its triangles, in numpy, without the core."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array
from scipy.spatial.transform import Rotation

from halfphysics.motion.skeleton import PARENTS

#: Points sampled on the skin's triangles.
SAMPLES = 20_000


class Skinner:
    """Linear blend skinning in numpy: vertices of poses, and of samples on triangles."""

    def __init__(self, body, samples=SAMPLES, seed=0):
        self.body = body
        self.faces = np.asarray(body.faces, dtype=np.int64)
        self.part = np.argmax(body.weights, axis=1)
        self._weights, self._linear = csr_array(body.weights), self.linear()
        corners = np.asarray(body.rest_vertices)[self.faces]
        area = np.linalg.norm(
            np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
        )
        rng = np.random.default_rng(seed)
        face = rng.choice(len(area), size=samples, p=area / area.sum())
        u = np.sqrt(rng.random((samples, 1)))
        v = rng.random((samples, 1))
        self.bary = np.concatenate([1.0 - u, u * (1.0 - v), u * v], axis=1)
        self.sampled = self.faces[face]
        self.points_part = np.concatenate([self.part, self.part[self.sampled[:, 0]]])

    def linear(self, vertex=slice(None)):
        """Vertices by the joints' turns and shifts (n, 55 * 4); None with pose blend shapes.

        Without them a vertex is the sum of w (R x + s) over its joints: linear in R and s.
        """
        if self.body.posedirs is not None:
            return None
        rest, weights = np.asarray(self.body.rest_vertices)[vertex], self.body.weights[vertex]
        rest = np.append(rest, np.ones((len(rest), 1)), axis=1)
        point, joint = np.nonzero(weights)
        values = weights[point, joint][:, None] * rest[point]
        columns = 4 * joint[:, None] + np.arange(4)
        entries = values.ravel(), (np.repeat(point, 4), columns.ravel())
        return csr_array(entries, shape=(len(rest), 4 * weights.shape[1]))

    def points_of(self, linear, translation, rotations, axes):
        """The points (n, T, 3) of a matrix that `linear` made, at poses."""
        turn, shift = self._moved(translation, self._turns(rotations), axes)
        frames = np.concatenate([turn, shift[..., None]], axis=3)  # (T, 55, 3, 4)
        frames = np.ascontiguousarray(frames.transpose(1, 3, 0, 2)).reshape(linear.shape[1], -1)
        return (linear @ frames).reshape(linear.shape[0], len(translation), 3)

    def _turns(self, rotations):
        turns = Rotation.from_rotvec(np.array(rotations, float).reshape(-1, 3)).as_matrix()
        return turns.reshape(len(rotations), -1, 3, 3)

    def _moved(self, translation, turns, axes):
        """Turns R (T, 55, 3, 3) and shifts s (T, 55, 3) of the joints: R x + s moves x with one."""
        joints = np.asarray(self.body.rest_joints)
        world, origin = turns.copy(), np.empty((len(turns), len(joints), 3))
        origin[:, 0] = translation + axes @ joints[0]
        for j in range(1, len(joints)):
            p = int(PARENTS[j])
            world[:, j] = world[:, p] @ turns[:, j]
            origin[:, j] = origin[:, p] + world[:, p] @ (joints[j] - joints[p])
        return world, origin - np.einsum("tjab,jb->tja", world, joints)

    def vertices(self, translation, rotations, axes):
        """Skin (T, V, 3) of SMPL-X poses (T, 3), (T, 55, 3), axes (3, 3)."""
        if self._linear is not None:
            out = self.points_of(self._linear, translation, rotations, axes)
            return np.ascontiguousarray(out.swapaxes(0, 1))
        body, count, turns = self.body, len(translation), self._turns(rotations)
        bent = (turns[:, 1:] - np.eye(3)).reshape(count, -1)
        bent = np.einsum("vik,tk->tvi", body.posedirs, bent, optimize=True)
        rest = np.asarray(body.rest_vertices) + bent
        world, shift = self._moved(translation, turns, axes)
        out = np.empty(rest.shape)
        for t in range(count):
            blended = self._weights @ np.concatenate([world[t].reshape(-1, 9), shift[t]], axis=1)
            turn = blended[:, :9].reshape(-1, 3, 3)
            out[t] = np.einsum("vab,vb->va", turn, rest[t]) + blended[:, 9:]
        return out

    def points(self, vertices):
        """Vertices (V, 3) and the samples between them, together."""
        samples = np.einsum("nk,nki->ni", self.bary, vertices[self.sampled])
        return np.concatenate([vertices, samples])
