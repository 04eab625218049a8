"""The core's rows of samples under pressure, in terms of names, parts and vertices."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.body.skin_samples import skin_samples
from halfphysics.results.soft_contacts import SoftContacts

if TYPE_CHECKING:
    from halfphysics.results.table import Ints
    from halfphysics.simulation.world import World

Array = NDArray[np.float64]

#: Columns of the core's rows: layer's static, layer's shape, shape, sample, position, normal,
#: depth, pressure, area.
COLUMNS = 13
#: Samples that a layer sees edgewise carry nothing and are left out: their area along the normal is
#: at most this [m^2], a few hundredths of the smallest.
EDGEWISE = 1e-7


def soft_rows(world: World, rows: Array, frame: Ints) -> SoftContacts | None:
    """Pressures in terms of people and names; None where nothing in the world is soft.

    Args:
        world: The world whose core gave the rows.
        rows: (n, 13), see `COLUMNS`.
        frame: The frame of every row (n,).
    """
    if not world.soft:
        return None
    seen = rows[:, 12] > EDGEWISE
    # As single precision has them: recorded rows are no finer, and so are those of a live frame.
    rows, frame = rows[seen].astype(np.float32).astype(np.float64), frame[seen]
    if not len(rows):
        return SoftContacts.none()
    static, under, shape, sample = rows[:, :4].astype(np.int64).T
    # One more entry for index -1: a layer is of a static or of a shape.
    static_name, shape_name = np.append(world.static_name, -1), np.append(world.shape_name, -1)
    other, part = shape_name[shape], world.shape_part[shape].copy()
    vertex = np.full(len(rows), -1, dtype=np.int64)
    if world.settings.contact == "skin":
        first = len(world.names) - len(world.people)
        for index, body in enumerate(world.bodies):
            own = other == first + index
            samples = skin_samples(body)
            vertex[own], part[own] = samples.vertex[sample[own]], samples.part[sample[own]]
    return SoftContacts(
        frame=frame,
        layer=np.where(static >= 0, static_name[static], shape_name[under]),
        other=other,
        part=part,
        vertex=vertex,
        position=rows[:, 4:7],
        normal=rows[:, 7:10],
        depth=np.maximum(rows[:, 10], 0.0),
        pressure=np.maximum(rows[:, 11], 0.0),
        area=np.maximum(rows[:, 12], 0.0),
    )


def rows_of(stepper: Any) -> Array:
    """The rows (n, 13) of the core's last frame."""
    got = stepper.soft_contacts()
    names = ("layer_static", "layer_shape", "shape", "sample")
    columns = [got[name][:, None].astype(np.float64) for name in names]
    columns += [got["position"], got["normal"]]
    columns += [got[name][:, None] for name in ("depth", "pressure", "area")]
    return np.concatenate(columns, axis=1)
