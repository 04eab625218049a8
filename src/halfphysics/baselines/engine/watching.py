"""What is kept of a run in MuJoCo: coordinates after every substep, contacts of every frame."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from halfphysics.baselines.engine.model import EngineModel

Array = NDArray[np.float64]

#: Points of one pair are one contact where the cosine between their normals is larger.
_ALIKE = 0.95


class Recorder:
    """Told of every substep: moves what is on a trajectory, keeps what came of it.

    Args:
        engine: The model.
        data: Its `mujoco.MjData`.
        substeps: MuJoCo steps per frame.
    """

    def __init__(self, engine: EngineModel, data: Any, substeps: int) -> None:
        import mujoco

        self._mujoco, self._engine, self._data = mujoco, engine, data
        self._h = float(engine.model.opt.timestep)
        self._steps = 0
        self.qpos = np.empty((substeps, engine.model.nq))
        self._force = np.zeros(6)
        self.begin()

    def begin(self) -> None:
        """Forget the frame before."""
        # Of a pair of geoms, the one that acts first: sums of impulse, weight x position and
        # weight x normal, weight; one row per direction.
        self._pairs: dict[tuple[int, int], list[Array]] = {}

    def before(self, substep: int) -> None:
        """Puts objects on a trajectory where they will be at the end of the substep."""
        self._steps += 1
        for place, item in self._engine.moving:
            position, quaternion = item.at(self._steps * self._h)
            self._data.mocap_pos[place], self._data.mocap_quat[place] = position, quaternion

    def after(self, substep: int) -> None:
        """The coordinates, and the impulses of the substep's contacts."""
        data = self._data
        self.qpos[substep] = data.qpos
        if not data.ncon:
            return
        contact, rank, name = data.contact, self._engine.rank, self._engine.shape_name
        geoms, at = np.array(contact.geom), np.array(contact.pos)
        axes = np.array(contact.frame).reshape(-1, 3, 3)
        for i in np.flatnonzero(np.asarray(contact.efc_address) >= 0):
            self._mujoco.mj_contactForce(self._engine.model, data, i, self._force)
            first, second = (int(g) for g in geoms[i])
            # MuJoCo's normal and force are those on the second.
            sign = 1.0
            if (rank[second], name[second], second) > (rank[first], name[first], first):
                sign = -1.0
            subject, other = (second, first) if sign > 0.0 else (first, second)
            impulse = sign * self._h * (self._force[:3] @ axes[i])
            weight = self._h * self._force[0]
            self._add((subject, other), impulse, at[i], sign * axes[i, 0], weight)

    def _add(
        self, pair: tuple[int, int], impulse: Array, position: Array, normal: Array, weight: float
    ) -> None:
        # What carries nothing counts a little, for a place and a direction of its own.
        weight = max(weight, 1e-12)
        new = np.concatenate([weight * position, weight * normal, impulse, [weight]])
        rows = self._pairs.setdefault(pair, [])
        for row in rows:
            if row[3:6] @ normal > _ALIKE * np.linalg.norm(row[3:6]):
                row += new
                return
        rows.append(new)

    def rows(self) -> Array:
        """The frame's contacts as `contact_rows` reads them (n, 12)."""
        rows = []
        for (subject, other), sums in self._pairs.items():
            stands = self._engine.rank[other] == 2
            place = (subject, other, -1) if stands else (subject, -1, other)
            for row in sums:
                normal = row[3:6] / np.linalg.norm(row[3:6])
                rows.append(np.concatenate([place, row[:3] / row[9], normal, row[6:9]]))
        return np.array(rows).reshape(-1, 12)
