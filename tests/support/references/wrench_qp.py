"""halfphysics.support.wrench_qp in plain numpy: all frames at once, the same Newton steps.

For every frame, with the wrench w that is needed (force and moment about the pelvis), places at
r_i from the pelvis with readiness b_i and the friction cone K_i = {|f_t| <= mu f_n}::

    minimise  1/2 |S (sum_i J_i f_i - w)|^2 + 1/2 PENALTY^2 sum_i |f_i|^2 / b_i^2,   f_i in K_i

    J_i f = (f, r_i x f),    S: forces as they are, moments times MOMENTS

It always has one solution, which changes continuously with w, r and b, so it is as smooth in time
as they are. Its dual has six unknowns, the scaled wrench y that is missing: with
g_i = b_i^2 / PENALTY^2 J_i^T S y each force is the projection of g_i on K_i, and y the minimum of

    1/2 |y|^2 - y . S w + 1/2 sum_i PENALTY^2 / b_i^2 |proj_i(g_i)|^2

which is strongly convex with a continuous gradient: Newton steps of six unknowns, each shortened
until it descends, at most `STEPS` of them. All frames are solved at once.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from halfphysics.support.wrench_qp import MOMENTS, PENALTIES, SEARCHES, SHEAR, STEPS, TOLERANCE

Array = NDArray[np.float64]
#: As in native/tuning.h.
FLAT, COARSE = 0.5, 0.01
Ints = NDArray[np.int64]


def spread(
    wrench: Array, frame: Ints, arm: Array, normal: Array, friction: Array, ready: Array
) -> Array:
    """Forces at the places that together come closest to a wrench in every frame.

    Args:
        wrench: Force [N] and moment [N m] that is needed, shape (T, 6).
        frame: Frame of every place (n,), ascending.
        arm: Of every place from the point of the moments (n, 3) [m].
        normal: Unit vectors, along which the places push (n, 3).
        friction: Coefficients (n,).
        ready: Readiness (n,), over 0, at most 1.

    Returns:
        Forces (n, 3) [N], each in its cone.
    """
    force = np.zeros((len(frame), 3))
    scale = np.array([1.0, 1.0, 1.0, MOMENTS, MOMENTS, MOMENTS])
    used, start = np.unique(frame, return_index=True)
    if not len(used):
        return force
    goal = wrench[used] * scale
    size = np.linalg.norm(goal, axis=1)
    y = goal.copy()
    for penalty in PENALTIES:
        ease = (ready / penalty) ** 2
        places = _Places(np.append(start, len(frame)), arm, normal, friction, ease)
        tolerance = (TOLERANCE if penalty == PENALTIES[-1] else COARSE) * size
        # The minimum along y: the dual is a quadratic on every ray from 0.
        along = np.einsum("ki,ki->k", y, y) + places.squares(y)
        y *= (np.einsum("ki,ki->k", y, goal) / np.where(along > 0.0, along, 1.0))[:, None]
        _descend(places, y, goal, tolerance)
    force, _ = places.forces(y)
    return force


def _descend(places: _Places, y: Array, goal: Array, tolerance: Array) -> None:
    """Newton steps of all frames, in place, until the gradient is under the tolerance (k,)."""
    todo = np.flatnonzero(np.linalg.norm(goal, axis=1) > 0.0)
    for _ in range(STEPS):
        if not len(todo):
            return
        some = places.of(todo)
        slope, bend = some.dual(y[todo], goal[todo])
        going = np.linalg.norm(slope, axis=1) > tolerance[todo]
        todo = todo[going]
        if not len(todo):
            return
        way = np.linalg.solve(bend[going], -slope[going][..., None])[..., 0]
        start = np.einsum("ki,ki->k", slope[going], way)
        y[todo] += _length(places.of(todo), y[todo], goal[todo], way, start)[:, None] * way


def _length(places: _Places, y: Array, goal: Array, way: Array, start: Array) -> Array:
    """Parts of Newton steps (k,) at which the slope along them is half of that at their start."""

    def slope(length: Array) -> Array:
        return np.einsum("ki,ki->k", places.dual(y + length[:, None] * way, goal)[0], way)

    flat = -FLAT * start
    low, high, at_low = np.zeros(len(y)), np.ones(len(y)), start.copy()
    at_high = slope(high)
    found, done, side = np.ones(len(y)), at_high <= flat, np.zeros(len(y))
    for _ in range(SEARCHES):
        if done.all():
            break
        length = low + (high - low) * at_low / (at_low - at_high)
        now = slope(length)
        hit = ~done & (np.abs(now) <= flat)
        found[hit] = length[hit]
        done |= hit
        up, down = ~done & (now > 0.0), ~done & (now <= 0.0)
        high[up], at_high[up] = length[up], now[up]
        at_low[up & (side == 1)] *= 0.5
        low[down], at_low[down] = length[down], now[down]
        at_high[down & (side == -1)] *= 0.5
        side[up], side[down] = 1, -1
    return np.where(done, found, low)


class _Places:
    """The places of some frames: rows first[k] to first[k + 1] belong to the k-th of them."""

    def __init__(
        self, first: Ints, arm: Array, normal: Array, friction: Array, ease: Array
    ) -> None:
        self.first, self.arm, self.normal = first, arm, normal
        self.friction, self.ease = friction, ease
        self.frame = np.repeat(np.arange(len(first) - 1), np.diff(first))

    def of(self, frames: Ints) -> _Places:
        """Those of some frames (k,), ascending."""
        if len(frames) == len(self.first) - 1:
            return self
        counts = np.diff(self.first)[frames]
        first = np.concatenate([[0], np.cumsum(counts)])
        rows = np.repeat(self.first[frames] - first[:-1], counts) + np.arange(first[-1])
        return _Places(
            first, self.arm[rows], self.normal[rows], self.friction[rows], self.ease[rows]
        )

    def forces(self, y: Array) -> tuple[Array, Array]:
        """Forces (n, 3) at missing scaled wrenches y (k, 6), and g (n, 3) that they project.

        In g, as in the weight of forces, what is tangential is scaled by 1 / `SHEAR`.
        """
        push = y[self.frame]
        g = push[:, :3] + MOMENTS * np.cross(push[:, 3:], self.arm)
        g *= self.ease[:, None]
        along = np.einsum("ni,ni->n", g, self.normal)
        across = (g - along[:, None] * self.normal) / SHEAR
        size = np.linalg.norm(across, axis=1)
        mu = SHEAR * self.friction
        slips = size > mu * along
        normal = np.where(slips, np.maximum(along + mu * size, 0.0) / (1.0 + mu * mu), along)
        safe = np.where(size > 0.0, size, 1.0)
        held = np.where(slips, mu * normal / safe, 1.0)
        force = normal[:, None] * self.normal + held[:, None] / SHEAR * across
        return force, along[:, None] * self.normal + across

    def squares(self, y: Array) -> Array:
        """Sums (k,) of the squares of forces by their ease."""
        force, _ = self.forces(y)
        pushes = np.einsum("ni,ni->n", force, self.normal)
        squares = np.einsum("ni,ni->n", force, force) * SHEAR**2 - (SHEAR**2 - 1.0) * pushes**2
        squares /= self.ease
        return np.add.reduceat(squares, self.first[:-1])

    def dual(self, y: Array, goal: Array) -> tuple[Array, Array]:
        """The gradient (k, 6) of the dual function and a generalised Hessian (k, 6, 6)."""
        force, g = self.forces(y)
        arm = MOMENTS * self.arm
        wrench = np.concatenate([force, np.cross(arm, force)], axis=1)
        slope = y - goal + np.add.reduceat(wrench, self.first[:-1], axis=0)
        bend = np.add.reduceat(self._bends(force, g, arm), self.first[:-1], axis=0)
        return slope, bend + np.eye(6)

    def _bends(self, force: Array, g: Array, arm: Array) -> Array:
        """Derivatives (n, 6, 6) of the places' scaled wrenches by y."""
        along = np.einsum("ni,ni->n", g, self.normal)
        across = g - along[:, None] * self.normal
        size = np.linalg.norm(across, axis=1)
        pushes = np.einsum("ni,ni->n", force, self.normal)
        mu = SHEAR * self.friction
        slips = size > mu * along
        tangent = across / np.where(size > 0.0, size, 1.0)[:, None]
        edge = self.normal + self.friction[:, None] * tangent
        turning = mu * pushes / np.where(size > 0.0, size, 1.0) / SHEAR**2
        # Of the projection on the cone: 1 inside, 0 where nothing is pushed.
        rank = np.where(slips, 1.0 / (1.0 + mu**2), 0.0)
        plane = np.eye(3) - _outer(self.normal) - _outer(tangent)
        curved = rank[:, None, None] * _outer(edge) + turning[:, None, None] * plane
        inside = _outer(self.normal) + (np.eye(3) - _outer(self.normal)) / SHEAR**2
        inner = np.where(slips[:, None, None], curved, inside)
        inner *= (self.ease * (pushes > 0.0))[:, None, None]
        lever = np.zeros((len(arm), 6, 3))
        lever[:, :3] = np.eye(3)
        x, z = arm, np.zeros(len(arm))
        lever[:, 3:] = np.stack(
            [
                np.stack([z, -x[:, 2], x[:, 1]], axis=1),
                np.stack([x[:, 2], z, -x[:, 0]], axis=1),
                np.stack([-x[:, 1], x[:, 0], z], axis=1),
            ],
            axis=1,
        )
        result: Array = lever @ inner @ np.swapaxes(lever, 1, 2)
        return result


def _outer(vectors: Array) -> Array:
    return vectors[:, :, None] * vectors[:, None, :]
