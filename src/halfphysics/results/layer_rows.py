"""What presses one soft thing of a result, in the thing's own frame.

A row of `SoftContacts` is in it as the layer, or as the one that has the sample: a pillow that lies
on a hard floor is pressed by it. Of two soft things each gives by its share: their springs are in
series, so the softer one gives more.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot

if TYPE_CHECKING:
    from halfphysics.results.result import Result
    from halfphysics.results.soft_contacts import SoftContacts
    from halfphysics.scene.items import Object, Static
    from halfphysics.scene.soft import Soft

Array = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, kw_only=True, eq=False)
class LayerRows:
    """Samples that press one layer over time, in its frame, ordered by frame.

    Attributes:
        frame: The frame (n,).
        position: Of the sample, put on the unloaded surface of what it presses (n, 3) [m]; a sample
            of the layer itself is near there anyway.
        normal: From the layer outward (n, 3).
        depth: By how much the layer gives (n,) [m].
        force: Along the normal (n,) [N].
        area: Of the sample, seen along the normal (n,) [m^2].
    """

    frame: Ints
    position: Array
    normal: Array
    depth: Array
    force: Array
    area: Array

    def __len__(self) -> int:
        return len(self.frame)

    def __getitem__(self, rows: NDArray[np.bool_]) -> LayerRows:
        return LayerRows(
            frame=self.frame[rows],
            position=self.position[rows],
            normal=self.normal[rows],
            depth=self.depth[rows],
            force=self.force[rows],
            area=self.area[rows],
        )


def item_of(result: Result, index: int) -> Static | Object | None:
    """The static or object of a name's index; None: a person, or a link."""
    name = result.names[index]
    return result.scene.statics.get(name) or result.scene.objects.get(name)


@dataclass(frozen=True, kw_only=True, eq=False)
class SoftThing:
    """A soft static or object of a result.

    Attributes:
        index, name: In `Result.names`.
        item: The static or object.
        soft: Its layer.
    """

    index: int
    name: str
    item: Static | Object
    soft: Soft


def pressed_things(result: Result, contacts: SoftContacts) -> list[SoftThing]:
    """The soft statics and objects that something presses, in the order of `Result.names`."""
    found = []
    for index in np.union1d(contacts.layer, contacts.other).tolist():
        item = item_of(result, index)
        if item is not None and item.soft is not None:
            thing = SoftThing(index=index, name=item.name, item=item, soft=item.soft)
            found.append(thing)
    return found


def rows_of(result: Result, contacts: SoftContacts, index: int) -> LayerRows:
    """What presses the soft static or object of a name's index."""
    rows = np.flatnonzero((contacts.layer == index) | (contacts.other == index))
    mine = contacts[rows]
    own = mine.layer == index
    normal = np.where(own[:, None], mine.normal, -mine.normal)
    lift = np.where(own, mine.depth, 0.0)
    partner = np.where(own, mine.other, mine.layer)
    share = np.ones(len(mine))
    for other in np.unique(partner).tolist():
        share[partner == other] = _share(result, index, other)
    position, turn = poses(result, result.names[index], mine.frame)
    back = rot.conjugate(turn)
    return LayerRows(
        frame=mine.frame,
        position=rot.rotate(back, mine.position + lift[:, None] * normal - position),
        normal=rot.rotate(back, normal),
        depth=share * mine.depth,
        force=mine.pressure * mine.area,
        area=mine.area,
    )


def _share(result: Result, index: int, other: int) -> float:
    """The part of the depth by which a thing gives where another one presses it."""
    item, partner = item_of(result, index), item_of(result, other)
    if item is None or partner is None or item.soft is None or partner.soft is None:
        return 1.0
    return partner.soft.stiffness / (item.soft.stiffness + partner.soft.stiffness)


def poses(result: Result, name: str, frame: Ints) -> tuple[Array, Array]:
    """World positions (n, 3) [m] and quaternions (n, 4) of a static or an object in frames (n,)."""
    static = result.scene.statics.get(name)
    if static is None:
        track = result.objects[name]
        return np.asarray(track.position)[frame], np.asarray(track.quaternion)[frame]
    count = len(frame)
    return np.tile(static.position, (count, 1)), np.tile(static.quaternion, (count, 1))
