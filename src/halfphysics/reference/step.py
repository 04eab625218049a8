"""The substep in plain numpy: slow and obvious; the tests hold it equal to the native core.

Read it beside docs/physics.md. Quantities have the names of the equations: M inertia matrix, J
contact Jacobian, h substep, v* velocity without contact, p contact impulses. This module does not
detect contacts: it takes the contact points that the core found.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics._native import tuning
from halfphysics.base import rotations as rot
from halfphysics.motion.joint_groups import stiffness_array
from halfphysics.motion.skeleton import PARENTS
from halfphysics.reference.algorithm1 import resistance, returning
from halfphysics.reference.contact import contact_residual, solve_contacts
from halfphysics.reference.strength import Yielding, pull_within
from halfphysics.settings import Settings

Array = NDArray[np.float64]

#: Factor on the stiffness of joints without contact on their own or any descendant body.
HELD = tuning.untouched_resistance
FREE, BALL, SLIDE, HINGE = range(4)  # joint types, numbered as in MuJoCo


# -- bodies ------------------------------------------------------------------------------------


def body_frames(model: Any, qpos: Array) -> tuple[Array, Array]:
    """World positions (nbody, 3) and quaternions (nbody, 4) of an MjModel's bodies at `qpos`."""
    x, q = np.zeros((model.nbody, 3)), np.tile([1.0, 0.0, 0.0, 0.0], (model.nbody, 1))
    for b in range(1, model.nbody):
        parent = model.body_parentid[b]
        x[b] = x[parent] + rot.rotate(q[parent], model.body_pos[b])
        q[b] = rot.multiply(q[parent], model.body_quat[b])
        for j in _joints(model, b):
            at = model.jnt_qposadr[j]
            if model.jnt_type[j] == FREE:
                x[b], q[b] = qpos[at : at + 3], rot.normalize(qpos[at + 3 : at + 7])
                continue
            anchor = x[b] + rot.rotate(q[b], model.jnt_pos[j])
            if model.jnt_type[j] == SLIDE:
                way = qpos[at] - model.qpos0[at]
                x[b] = x[b] + way * rot.rotate(q[b], model.jnt_axis[j])
                continue
            if model.jnt_type[j] == BALL:
                turn = rot.normalize(qpos[at : at + 4])
            else:
                turn = rot.exp((qpos[at] - model.qpos0[at]) * model.jnt_axis[j])
            q[b] = rot.multiply(q[b], turn)
            x[b] = anchor - rot.rotate(q[b], model.jnt_pos[j])
    return x, q


def _joints(model: Any, body: int) -> range:
    first = model.body_jntadr[body]
    return range(first, first + model.body_jntnum[body])


def _joint_frame(model: Any, x: Array, q: Array, joint: int, qpos: Array) -> tuple[Array, Array]:
    """World anchor and orientation of a hinge or slide, after the body's earlier joints."""
    body = model.jnt_bodyid[joint]
    parent = model.body_parentid[body]
    pos = x[parent] + rot.rotate(q[parent], model.body_pos[body])
    quat = rot.multiply(q[parent], model.body_quat[body])
    for j in range(model.body_jntadr[body], joint):
        at = model.jnt_qposadr[j]
        way = (qpos[at] - model.qpos0[at]) * model.jnt_axis[j]
        if model.jnt_type[j] == SLIDE:
            pos = pos + rot.rotate(quat, way)
        else:
            anchor = pos + rot.rotate(quat, model.jnt_pos[j])
            quat = rot.multiply(quat, rot.exp(way))
            pos = anchor - rot.rotate(quat, model.jnt_pos[j])
    return pos + rot.rotate(quat, model.jnt_pos[joint]), quat


@dataclass(frozen=True)
class DofAxes:
    """Per dof (nv, 3): unit angular velocity, a point on its axis, and unit linear velocity;
    `carries` (nbody, nv) says which dofs move which body."""

    angular: Array
    anchor: Array
    linear: Array
    carries: NDArray[np.bool_]


def dof_axes(model: Any, qpos: Array, frames: tuple[Array, Array]) -> DofAxes:
    """Axes of all dofs at `qpos`; `frames`: the `body_frames` at `qpos`."""
    x, q = frames
    angular, anchor, linear = (np.zeros((model.nv, 3)) for _ in range(3))
    carries = np.zeros((model.nbody, model.nv), dtype=bool)
    for body in range(1, model.nbody):
        carries[body] = carries[model.body_parentid[body]]
        for j in _joints(model, body):
            d = model.jnt_dofadr[j]
            kind = model.jnt_type[j]
            carries[body, d : d + {FREE: 6, BALL: 3}.get(kind, 1)] = True
            if kind == FREE:
                linear[d : d + 3] = np.eye(3)
                d += 3
            if kind in (FREE, BALL):  # angular velocity is in the child's frame
                angular[d : d + 3] = rot.to_matrix(q[body]).T
                anchor[d : d + 3] = x[body] + rot.rotate(q[body], model.jnt_pos[j])
                continue
            pos, turn = _joint_frame(model, x, q, j, qpos)
            (angular if kind == HINGE else linear)[d] = rot.rotate(turn, model.jnt_axis[j])
            anchor[d] = pos
    return DofAxes(angular, anchor, linear, carries)


def jacobian(
    model: Any, qpos: Array, body: int, point: Array, axes: DofAxes | None = None
) -> tuple[Array, Array]:
    """Jacobians of a point (3,) fixed to `body`: linear (3, nv) and angular (3, nv).

    `axes`: the result of `dof_axes` at `qpos`, if it is known already.
    """
    at = axes or dof_axes(model, qpos, body_frames(model, qpos))
    carried = at.carries[body][:, None]
    linear = at.linear + np.cross(at.angular, point - at.anchor)
    return (carried * linear).T, (carried * at.angular).T


def inertia_matrix(model: Any, qpos: Array) -> Array:
    """M (nv, nv): the sum over bodies of m J_v^T J_v + J_w^T I J_w, and the armature."""
    x, q = frames = body_frames(model, qpos)
    axes = dof_axes(model, qpos, frames)
    M = np.diag(np.asarray(model.dof_armature, dtype=np.float64))
    for b in range(1, model.nbody):
        com = x[b] + rot.rotate(q[b], model.body_ipos[b])
        R = rot.to_matrix(rot.multiply(q[b], model.body_iquat[b]))
        Jv, Jw = jacobian(model, qpos, b, com, axes)
        M += model.body_mass[b] * Jv.T @ Jv
        M += Jw.T @ R @ np.diag(model.body_inertia[b]) @ R.T @ Jw
    return M


# -- the drive ---------------------------------------------------------------------------------


@dataclass
class ReferenceDrive:
    """One person's drive; `first_qpos` and `first_dof` are the addresses of its coordinates.

    A velocity has 6 entries for the root (linear in the world, angular in its own frame), then 3
    per ball joint in the model's order.
    """

    settings: Settings
    first_qpos: int
    first_dof: int
    target: Array  # reference coordinates at the last frame
    v_ref: Array = field(init=False)  # velocity of the reference
    v_drive: Array = field(init=False)  # Algorithm 1: velocity of the joints at the frame's start
    deviation: Array = field(init=False)  # e
    previous: Array = field(init=False)
    q_start: Array = field(init=False)
    # With strength: the drive's limits for the root's position [N], then the root's rotation and
    # every joint in the model's order [N m] (56,); and the reduced resistance of its joints.
    limits: Array | None = None
    yielding: Yielding = field(init=False)

    def __post_init__(self) -> None:
        self.v_ref = np.zeros(6 + 3 * ((len(self.target) - 7) // 4))
        self.deviation = self.v_drive = np.zeros_like(self.v_ref)
        self.previous = self.q_start = self.target
        self.yielding = Yielding(len(self.v_ref))

    @cached_property
    def firmness(self) -> Array:
        """lambda of the root (0) and every joint in the model's order (55,)."""
        return stiffness_array(self.settings.stiffness, "stiffness")[depth_first()]

    @property
    def dofs(self) -> slice:
        return slice(self.first_dof, self.first_dof + len(self.v_ref))

    def coordinates(self, qpos: Array) -> Array:
        return qpos[self.first_qpos : self.first_qpos + len(self.target)]

    def begin_frame(self, target: Array, dt: float, qpos: Array, qvel: Array) -> None:
        """Compute the drive's reference velocity; with Algorithm 1, write it to `qvel`."""
        s, q = self.settings, self.coordinates(qpos)
        self.previous, self.target = self.target, target
        root = (target[:3] - self.previous[:3]) / dt
        if s.root == "recover":
            u = (1.0 - np.exp(-dt / tuning.root_recovery_time)) * (self.previous[:3] - q[:3]) / dt
            root = root + u * min(1.0, s.root_speed / max(float(np.linalg.norm(u)), 1e-300))
        self.v_ref = np.concatenate([root, turns(self.previous, target).ravel() / dt])
        if s.drive_time is None:
            self.q_start = q.copy()
            joints = returning(s, turns(q, target) / dt, self.v_ref[3:].reshape(-1, 3))
            self.v_drive = np.concatenate([root, joints.ravel()])
            qvel[self.dofs] = self.v_drive

    def free_velocity(
        self, k: int, h: float, qpos: Array, qvel: Array, M: Array, stiff: Array
    ) -> Array:
        """v* of substep k of length h.

        With a time constant: the implicit, critically damped decay of the deviation. Otherwise
        PJSC of Algorithm 1; M (n, n) is the person's block of the inertia matrix, `stiff` (n,) its
        part of lambda diag(I). Every joint has its full resistance again.
        """
        self.yielding = Yielding(len(self.v_ref))
        s, q = self.settings, self.coordinates(qpos)
        expected_at = (k if s.drive_time is not None else k + 1) * h
        start = self.previous if s.drive_time is not None else self.q_start
        asked = self.v_ref if s.drive_time is not None else self.v_drive
        expected = _turned(start, expected_at * asked[3:].reshape(-1, 3))
        if s.drive_time is not None:
            tau = s.drive_time
            xi = turns(expected, q)
            size = np.linalg.norm(xi, axis=1, keepdims=True)
            limit = 2.0 * s.recovery_rate * tau
            xi = np.where(size > limit, xi * limit / np.maximum(size, 1e-300), xi)
            way = np.concatenate([np.zeros(3), xi.ravel()])
            decayed: Array = (self.deviation - h * way / tau**2) / self.scale(h)
            pull = self.deviation - decayed
            if self.limits is not None:
                pull = pull_within(pull, h * self.limits, M, self.heavier(h, M, stiff))
            return self.v_ref + self.deviation - pull
        v = qvel[self.dofs].copy()
        turn = turns(q, expected)
        # Near a half turn rounding decides the sign of the log: take the direction of v.
        angle = np.linalg.norm(turn, axis=1, keepdims=True)
        against = np.sum(turn * v[3:].reshape(-1, 3), axis=1, keepdims=True) < 0.0
        other = (1.0 - 2.0 * np.pi / np.maximum(angle, 1e-300)) * turn
        turn = np.where(against & (angle > 0.5 * np.pi), other, turn)
        epsilon = np.concatenate([np.zeros(3), turn.ravel()])
        gap = np.where(np.arange(len(v)) < 6, 0.0, epsilon - h * v)
        total = np.maximum(resistance(s, self.firmness, h), 1e-300)[1:]
        firm = np.repeat(self.firmness[1:] / total, 3)
        gap[6:] = firm * gap[6:] - (1.0 - firm) * h * (v - self.v_drive)[6:]
        return v + np.linalg.solve(M + np.diag(stiff), stiff / h * gap)

    def heavier(self, h: float, M: Array, stiff: Array) -> Array:
        """M^ (n, n) = s (M + lambda diag(I)), reduced where joints yield."""
        return self.yielding.heavier(M, self.scale(h) * (M + np.diag(stiff)))

    def exerted(self, v: Array, v_star: Array, h: float, M: Array, stiff: Array) -> Array:
        """The drive's own generalised impulse (n,) in a substep that ends with `v` (n,): the
        impulse on the deviation minus that of the contacts. Call it before end_substep."""
        contacts = self.heavier(h, M, stiff) @ (v - v_star)
        return np.asarray(M @ (v - self.v_ref - self.deviation) - contacts)

    def overcome(self, v: Array, v_star: Array, h: float, M: Array, stiff: Array) -> bool:
        """Whether a joint exceeds its limit in a round that ended with `v` (n,).

        If so, that joint resists less from now on, and the substep must be solved again.
        """
        if self.limits is None or not (v != v_star).any():
            return False
        pull = M @ (v_star - self.v_ref - self.deviation)
        return self.yielding.next(
            self.exerted(v, v_star, h, M, stiff), np.asarray(pull), h * self.limits
        )

    def scale(self, h: float) -> float:
        """s: the factor of the drive on the person's inertia."""
        if self.settings.drive_time is None:
            return 1.0
        r = h / self.settings.drive_time
        return 1.0 + 2.0 * r + r * r

    def end_substep(self, qvel: Array) -> None:
        self.deviation = qvel[self.dofs] - self.v_ref


def depth_first() -> NDArray[np.int64]:
    """Joints (55,) in the order in which a MuJoCo model numbers a person's bodies."""

    def below(joint: int) -> list[int]:
        return [joint, *(i for c in np.flatnonzero(joint == PARENTS) for i in below(int(c)))]

    return np.array(below(0), dtype=np.int64)


def _quats(q: Array) -> Array:
    """Root and joint quaternions (n, 4) of a person's coordinates."""
    return np.concatenate([q[3:7][None], q[7:].reshape(-1, 4)])


def turns(a: Array, b: Array) -> Array:
    """log(a^-1 b) (n, 3), in the children's frames."""
    return rot.log(rot.multiply(rot.conjugate(_quats(a)), _quats(b)))


def _turned(q: Array, turns: Array) -> Array:
    quats = rot.multiply(_quats(q), rot.exp(turns))
    return np.concatenate([q[:3], quats.ravel()])


def stiff_diagonal(model: Any, M: Array, drive: ReferenceDrive, h: float = 1.0 / 240.0) -> Array:
    """What joints add to M in M^ (nv,): lambda (or what damps limp joints) times, per ball joint,
    the mean of its three diagonal entries of M; h: length of the substep [s]."""
    out = np.zeros(model.nv)
    firmness = iter(resistance(drive.settings, drive.firmness, h)[1:])
    for d in range(drive.dofs.start + 6, drive.dofs.stop, 3):
        out[d : d + 3] = next(firmness) * np.diag(M)[d : d + 3].mean()
    return out


def held_diagonal(model: Any, stiff: Array, drive: ReferenceDrive, touched: Array) -> Array:
    """The addition to M in M^ (nv,): lambda * I, times `HELD` for joints without contact below.

    `touched` (nbody,) marks the bodies with contact and their ancestors, as found by the core.
    Algorithm 1 has no such factor.
    """
    if drive.settings.drive_time is None:
        return stiff
    balls = np.flatnonzero(model.jnt_type == BALL)
    out = stiff.copy()
    for d, body in zip(model.jnt_dofadr[balls], model.jnt_bodyid[balls], strict=True):
        if not touched[body]:
            out[d : d + 3] *= HELD
    return out


# -- contact -----------------------------------------------------------------------------------


def contact_jacobian(model: Any, qpos: Array, contacts: Mapping[str, Array]) -> Array:
    """J (3n, nv) of contact points: relative velocity v_a - v_b in the frame (n, t, s).

    Each side is a weighted sum of points on bodies: one body for a rigid part, the skinning joints
    for a vertex of the skin (without the term of pose blend shapes). Friction (t, s) acts at the
    points plus `inward` (n, 3) [m], across n.
    """
    rows = []
    axes = dof_axes(model, qpos, body_frames(model, qpos))
    for i in range(len(contacts["dist"])):
        frame = np.stack([contacts[name][i] for name in ("normal", "tangent", "binormal")])
        moves, slips = np.zeros((3, model.nv)), np.zeros((3, model.nv))
        if "turns" in contacts:  # a row of a joint's range: `reference.ranges.joined`
            moves[0] = contacts["turns"][i]
        for side, sign in (("a", 1.0), ("b", -1.0)):
            columns = (contacts[f"{name}_{side}"][i] for name in ("bodies", "weights", "points"))
            for b, weight, x in zip(*columns, strict=True):
                if weight > 0.0:
                    linear, angular = jacobian(model, qpos, int(b), x, axes)
                    moves += sign * weight * linear
                    turn = np.cross(angular, contacts["inward"][i], axis=0)
                    slips += sign * weight * (linear + turn)
        rows += [frame[:1] @ moves, frame[1:] @ slips]
    return np.concatenate(rows) if rows else np.zeros((0, model.nv))


@dataclass(frozen=True)
class ContactProblem:
    """The contact problem of one substep: w = A p + b, and the velocities that result from p.

    Each contact has three rows (normal, tangent, binormal); the target velocity is subtracted from
    the normal rows of `b` (3n,). `A` (3n, 3n) = J M^^-1 J^T.
    """

    A: Array
    b: Array
    friction: Array
    found: Array  # the impulses (n, 3) that the core found
    _back: Array  # M^^-1 J^T
    _v_free: Array

    def velocity(self, p: Array) -> Array:
        """v = v* + M^^-1 J^T p, shape (nv,)."""
        return self._v_free + self._back @ p.ravel()

    def violation(self, p: Array) -> float:
        """Largest violation of the law of contact, normal and friction [m/s]."""
        return float(contact_residual(self.A, self.b, self.friction, p).max(initial=0.0))

    def solve(self, tolerance: float = 1e-14, sweeps: int = 20000) -> Array:
        """Impulses (n, 3) by `solve_contacts`, started from zero."""
        start = np.zeros_like(self.found)
        return solve_contacts(
            self.A, self.b, self.friction, tolerance=tolerance, sweeps=sweeps, start=start
        )


def contact_problem(
    model: Any, qpos: Array, v_free: Array, M_hat: Array, h: float, contacts: Mapping[str, Array]
) -> ContactProblem:
    """The problem M^ (v - v*) = J^T p at the contact points (n) that the core found."""
    J = contact_jacobian(model, qpos, contacts)  # (0, nv) without contact
    back = np.asarray(np.linalg.solve(M_hat, J.T), dtype=np.float64)
    b = J @ v_free
    demand = (contacts["target"] - contacts["dist"] + contacts["shift"]) / h
    b[::3] -= np.maximum(demand, contacts["bounce"])
    frames = [contacts[name] for name in ("normal", "tangent", "binormal")]
    for row in (1, 2):  # curvature term of the tangential displacement
        b[row::3] += h * np.einsum("ij,ij->i", contacts["curve"], frames[row])
    found: Array = np.stack([np.einsum("ij,ij->i", contacts["impulse"], f) for f in frames], axis=1)
    return ContactProblem(J @ back, b, np.asarray(contacts["friction"]), found, back, v_free)
