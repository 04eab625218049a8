"""People's contacts in the last timestep, in the fields of MuJoCo's `data.contact`."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.short_repr import short_repr

if TYPE_CHECKING:
    from halfphysics.mujoco.host_model import HostModel

Array = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class PersonContact:
    """One contact point; fields as those of `mujoco.MjContact`, and its force."""

    geom1: int
    geom2: int
    pos: Array
    frame: Array
    dist: float
    force: Array

    __repr__ = short_repr


@dataclass(frozen=True, eq=False)
class PersonContacts:
    """Contact points between people and the world, and among people, as arrays of one length n.

    A single one is a `PersonContact`; so is each of an iteration.

    Attributes:
        geom1, geom2: Geoms of the MuJoCo model (n,): first the world's or another person's, then
            the person's part; -1 for a part without a geom.
        pos: In the world (n, 3) [m].
        frame: Rows are the contact's axes in the world (n, 9); the first is the normal, from geom1
            into geom2.
        dist: Distance of the two at the start of the timestep (n,) [m]; MuJoCo's is negative where
            bodies overlap.
        force: Force and torque on geom2 in the contact's frame (n, 6) [N, N m], as
            `mujoco.mj_contactForce` writes it: normal, two tangents, and no torque.
    """

    geom1: Ints
    geom2: Ints
    pos: Array
    frame: Array
    dist: Array
    force: Array

    __repr__ = short_repr

    def __len__(self) -> int:
        return len(self.dist)

    def __getitem__(self, i: int) -> PersonContact:
        return PersonContact(
            int(self.geom1[i]),
            int(self.geom2[i]),
            self.pos[i],
            self.frame[i],
            float(self.dist[i]),
            self.force[i],
        )

    def __iter__(self) -> Iterator[PersonContact]:
        return (self[i] for i in range(len(self)))

    @property
    def world_force(self) -> Array:
        """Force on geom2 in the world (n, 3) [N]; on geom1 acts the opposite."""
        axes = self.frame.reshape(-1, 3, 3)
        force: Array = np.einsum("ni,nij->nj", self.force[:, :3], axes)
        return force


def person_contacts(host: HostModel, rows: Array, timestep: float) -> PersonContacts:
    """The core's rows (n, 13) of a timestep of that length [s], as MuJoCo has contacts."""
    if not len(rows):
        return _NONE
    shape, static, other = rows[:, :3].astype(np.int64).T
    # One more entry for index -1: a row has either a static or a second shape.
    geom = np.append(host.shape_geom, -1)
    second = geom[shape]
    first = np.where(static >= 0, np.append(host.static_geom, -1)[static], geom[other])
    # The core may have the world's shape first: then the person's part is the other.
    part = np.append(host.shape_part, -1)
    swapped = (part[shape] < 0) & (other >= 0)
    sign = np.where(swapped, -1.0, 1.0)[:, None]
    normal = sign * rows[:, 7:10]
    force = sign * rows[:, 10:13] / timestep
    axes = _frames(normal)
    local = np.zeros((len(rows), 6))
    local[:, :3] = np.einsum("nij,nj->ni", axes, force)
    return PersonContacts(
        geom1=np.where(swapped, second, first),
        geom2=np.where(swapped, first, second),
        pos=rows[:, 4:7].copy(),
        frame=axes.reshape(-1, 9),
        dist=rows[:, 3].copy(),
        force=local,
    )


def _frames(normal: Array) -> Array:
    """Right-handed axes (n, 3, 3), by rows, whose first is the normal (n, 3)."""
    steep = np.abs(normal[:, 1]) >= 0.5
    aside = np.where(steep[:, None], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0])
    first = aside - normal * np.sum(aside * normal, axis=1, keepdims=True)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([normal, first, np.cross(normal, first)], axis=1)


_NONE = PersonContacts(
    geom1=np.zeros(0, dtype=np.int64),
    geom2=np.zeros(0, dtype=np.int64),
    pos=np.zeros((0, 3)),
    frame=np.zeros((0, 9)),
    dist=np.zeros(0),
    force=np.zeros((0, 6)),
)
