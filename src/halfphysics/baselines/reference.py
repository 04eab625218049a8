"""`Ablation` and `Torque` in plain numpy, beside the drive of `halfphysics.reference.step`; see
docs/physics.md, "Baselines"."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics._native import tuning
from halfphysics.base import rotations as rot
from halfphysics.reference import step as reference

Array = NDArray[np.float64]

#: Internal forces turn no joint faster than this, or than it was [rad/s].
FASTEST = tuning.fastest_internal_spin


def bias(model: Any, qpos: Array, qvel: Array) -> Array:
    """Coriolis, centrifugal and gyroscopic forces c (nv,) of M dv/dt + c = forces.

    For trees of free and ball joints, as people are: every body's change of momentum where all
    joint velocities stay as they are, through its Jacobian.
    """
    x, q = frames = reference.body_frames(model, qpos)
    axes = reference.dof_axes(model, qpos, frames)
    w, a, alpha = (np.zeros((model.nbody, 3)) for _ in range(3))  # a: of the frame's origin
    c = np.zeros(model.nv)
    for b in range(1, model.nbody):
        parent = model.body_parentid[b]
        turn = np.zeros(3)
        if model.body_dofnum[b]:
            last = model.body_dofadr[b] + model.body_dofnum[b]
            turn = rot.rotate(q[b], qvel[last - 3 : last])
        r = x[b] - x[parent]
        if parent:
            a[b] = a[parent] + np.cross(alpha[parent], r)
            a[b] += np.cross(w[parent], np.cross(w[parent], r))
        w[b], alpha[b] = w[parent] + turn, alpha[parent] + np.cross(w[parent], turn)
        arm = rot.rotate(q[b], model.body_ipos[b])
        R = rot.to_matrix(rot.multiply(q[b], model.body_iquat[b]))
        inertia = R @ np.diag(model.body_inertia[b]) @ R.T
        pull = a[b] + np.cross(alpha[b], arm) + np.cross(w[b], np.cross(w[b], arm))
        spin = inertia @ alpha[b] + np.cross(w[b], inertia @ w[b])
        J_v, J_w = reference.jacobian(model, qpos, b, x[b] + arm, axes)
        c += model.body_mass[b] * J_v.T @ pull + J_w.T @ spin
    return c


def damping(drive: reference.ReferenceDrive) -> Array:
    """D (n,) of a person's dofs [N m s/rad]: the root has none."""
    d = np.full_like(drive.v_ref, drive.settings.drive.joint_damping)
    d[:6] = 0.0
    return d


def heavier(drive: reference.ReferenceDrive, h: float, M: Array, stiff: Array) -> Array:
    """M^ + h D (n, n)."""
    return np.asarray(drive.heavier(h, M, stiff) + np.diag(h * damping(drive)))


def with_own_forces(
    drive: reference.ReferenceDrive, h: float, v: Array, M: Array, stiff: Array, c: Array
) -> Array:
    """v* (n,) with damping and the internal forces c (n,) (0: without them), `v` being without."""
    pull = np.linalg.solve(heavier(drive, h, M, stiff), -h * c - h * damping(drive) * v)
    own = np.array(v + pull)
    if drive.settings.drive.internal_forces:
        for i in range(3, len(v), 3):
            most = max(FASTEST, float(np.linalg.norm(v[i : i + 3])))
            own[i : i + 3] *= min(1.0, most / max(float(np.linalg.norm(own[i : i + 3])), 1e-300))
    return own


class TorqueDrive(reference.ReferenceDrive):
    """PD torques in place of the joints' velocities; the root's are set as Algorithm 1 does."""

    def __post_init__(self) -> None:
        self.settings = replace(self.settings, drive_time=None)
        self.h = 1.0 / 240.0  # of the substeps
        super().__post_init__()

    @property
    def firmness(self) -> Array:
        """What the torques add to the joints' inertia I, as a share of it (55,).

        kp = I w^2 and kd = 2 z I w act at the end of a substep: h kd + h^2 kp.
        """
        wh = self.settings.drive.torque_frequency * self.h
        return np.full(
            1 + (len(self.v_ref) - 6) // 3, wh * (wh + 2.0 * self.settings.drive.torque_damping)
        )

    def begin_frame(self, target: Array, dt: float, qpos: Array, qvel: Array) -> None:
        joints = qvel[self.dofs][6:].copy()
        super().begin_frame(target, dt, qpos, qvel)
        qvel[self.dofs][6:] = joints
        self.v_ref = np.zeros_like(self.v_ref)  # all of a velocity is deviation
        self.h = dt / self.settings.substeps_for(dt)

    def free_velocity(
        self, k: int, h: float, qpos: Array, qvel: Array, M: Array, stiff: Array
    ) -> Array:
        """(M + h kd + h^2 kp) (v* - v) = h kp (eps - h v) - h kd v; `stiff` (n,): h kd + h^2 kp."""
        s, v = self.settings.drive, qvel[self.dofs]
        kp = stiff / self.firmness[0] * s.torque_frequency**2
        kd = 2.0 * s.torque_damping / s.torque_frequency * kp
        turns = reference.turns(self.coordinates(qpos), self.target)
        eps = np.concatenate([np.zeros(3), turns.ravel()])
        pull = h * kp * (eps - h * v) - h * kd * v
        return np.asarray(v + np.linalg.solve(M + np.diag(stiff), pull))
