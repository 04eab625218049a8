"""What MuJoCo reads anew of its model in every step, and what of it hangs on people's mirrors."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from halfphysics.mujoco.host_model import HostModel

Array = NDArray[np.float64]


class HostMasses:
    """Keeps a core's masses, inertias, armatures and gravity those of its MuJoCo model.

    Whoever randomises a model changes them in place, between two steps or at any reset.
    """

    def __init__(self, model: Any, host: HostModel) -> None:
        self._model, self._bodies = model, np.array(host.bodies)
        self._given = self._read()

    def follow(self, world: Any) -> None:
        """Give the core's `HostedWorld` what has changed since the last time.

        Raises:
            ValueError: A mass that no body can have; then nothing has changed.
        """
        now = self._read()
        if all(np.array_equal(a, b) for a, b in zip(now, self._given, strict=True)):
            return
        world.set_masses(*now)
        self._given = now

    def _read(self) -> tuple[Array, ...]:
        """Masses (n,), moments (n, 3), centres (n, 3), their axes (n, 4), armatures (nv,), gravity
        (3,)."""
        m, b = self._model, self._bodies
        return (
            m.body_mass[b], m.body_inertia[b], m.body_ipos[b], m.body_iquat[b],
            np.array(m.dof_armature), gravity_of(m),
        )  # fmt: skip


def gravity_of(model: Any) -> Array:
    """Gravity (3,) [m/s^2], which a flag can take away."""
    import mujoco

    off = model.opt.disableflags & int(mujoco.mjtDisableBit.mjDSBL_GRAVITY)
    return np.zeros(3) if off else np.array(model.opt.gravity)


def hangs_on_people(model: Any, host: HostModel) -> bool:
    """Whether something in MuJoCo moves by where people's mirrors are: ties, tendons, joints.

    Then they have to be shown before every timestep, even where they meet nothing.
    """
    import mujoco

    on = np.isin(model.body_mocapid, host.mirrors[:, 1]) & (np.asarray(model.body_mocapid) >= 0)
    for body in range(1, model.nbody):  # parents come first
        on[body] |= on[model.body_parentid[body]]
    sites, geoms = on[model.site_bodyid], on[model.geom_bodyid]
    tied = np.isin(model.eq_type, (mujoco.mjtEq.mjEQ_CONNECT, mujoco.mjtEq.mjEQ_WELD))
    by_site = np.asarray(model.eq_objtype) == int(mujoco.mjtObj.mjOBJ_SITE)
    ends = [model.eq_obj1id, model.eq_obj2id]
    ties = [tied & by_site & _of(sites, end) | tied & ~by_site & _of(on, end) for end in ends]
    kind, wrapped = np.asarray(model.wrap_type), model.wrap_objid
    round_ = (mujoco.mjtWrap.mjWRAP_SPHERE, mujoco.mjtWrap.mjWRAP_CYLINDER)
    tendons = [
        (kind == int(mujoco.mjtWrap.mjWRAP_SITE)) & _of(sites, wrapped),
        np.isin(kind, round_) & _of(geoms, wrapped),
    ]
    at_site = np.isin(
        model.actuator_trntype,
        (mujoco.mjtTrn.mjTRN_SITE, mujoco.mjtTrn.mjTRN_SLIDERCRANK),
    )
    pulled = [at_site & _of(sites, model.actuator_trnid[:, k]) for k in range(2)]
    joints, flex = on[model.jnt_bodyid], _of(on, model.flex_vertbodyid)
    return any(bool(found.any()) for found in (*ties, *tendons, *pulled, joints, flex))


def _of(marked: NDArray[np.bool_], ids: NDArray[np.int32]) -> NDArray[np.bool_]:
    """Marks of some ids; -1 has none."""
    ids = np.asarray(ids)
    out = np.zeros(ids.shape, dtype=bool)
    known = (ids >= 0) & (ids < len(marked))
    out[known] = marked[ids[known]]
    return out
