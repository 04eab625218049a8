"""Pressures on soft layers in numbers of every frame: peak, mean, area and force of each pair."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from halfphysics.results.result import Result
    from halfphysics.results.soft_contacts import SoftContacts

Array = NDArray[np.float64]

#: Samples count as contact area from this pressure on [Pa]: 5 mmHg, from which seat mats show it.
SHOWN = 667.0


@dataclass(frozen=True, kw_only=True, eq=False)
class LayerPressure:
    """What one thing or person does to one layer, frame by frame.

    Attributes:
        layer, other: Names of what is pressed in, and of what presses.
        peak: Largest pressure (T,) [Pa].
        area: Area with at least `SHOWN` (T,) [m^2], seen along the normals.
        mean: Mean pressure on that area (T,) [Pa]; 0 where there is none.
        force: On what presses, in the world (T, 3) [N].
    """

    layer: str
    other: str
    peak: Array
    area: Array
    mean: Array
    force: Array


def pressures(result: Result) -> tuple[LayerPressure, ...]:
    """One entry for each pair that pressed, in the order of `Result.names`; empty: none."""
    rows = result.soft_contacts
    if rows is None or not len(rows):
        return ()
    pairs = np.unique(np.stack([rows.layer, rows.other], axis=1), axis=0)
    return tuple(
        _of_pair(result, rows[(rows.layer == layer) & (rows.other == other)])
        for layer, other in pairs.tolist()
    )


def _of_pair(result: Result, rows: SoftContacts) -> LayerPressure:
    count = len(result)
    peak, force = np.zeros(count), np.zeros((count, 3))
    np.maximum.at(peak, rows.frame, rows.pressure)
    np.add.at(force, rows.frame, rows.force)
    shown = rows.pressure >= SHOWN
    at, area = rows.frame[shown], rows.area[shown]
    total: Array = np.bincount(at, area, count).astype(np.float64)
    pressed = np.bincount(at, area * rows.pressure[shown], count)
    return LayerPressure(
        layer=result.names[rows.layer[0]],
        other=result.names[rows.other[0]],
        peak=peak,
        area=total,
        mean=np.divide(pressed, total, out=np.zeros(count), where=total > 0.0),
        force=force,
    )


def carried_share(
    result: Result, person: int, pairs: Sequence[LayerPressure] | None = None
) -> Array:
    """Share of a person's weight that soft things carry (T,): their force upward over the weight.

    The force of all contacts with what the person presses, friction and hard frame included, mean
    over the frame: pressures alone would count what a backrest presses upwards and its friction
    takes back. Zero where nothing is soft, and without gravity.

    Args:
        result: The result.
        person: Index into `Result.people`.
        pairs: What presses, where it is known already: of `pressures`, those of the person.

    Raises:
        FileError: In a result from a file: the body is missing.
    """
    name = result.people[person].name
    gravity = np.asarray(result.scene.gravity)
    g = float(np.linalg.norm(gravity))
    if g == 0.0:
        return np.zeros(len(result))
    found = pressures(result) if pairs is None else pairs
    layers = [result.names.index(its.layer) for its in found if its.other == name]
    contacts = result.contacts
    rows = contacts[(contacts.person == person) & np.isin(contacts.other, layers)]
    lifted = np.zeros((len(result), 3))
    np.add.at(lifted, rows.frame, result.fps * rows.impulse)
    share: Array = lifted @ (-gravity / g) / (result.people[person].body.mass * g)
    return share
