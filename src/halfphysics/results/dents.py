"""Dents: the visible surfaces of a result's soft layers, frame by frame.

Where something presses, the surface follows it (`halfphysics.results.layer_surface`). Foam that is
left comes back as its law says: of a spring k beside a spring h k in series with a dashpot, which
has crept to the depth s, what nothing presses stands at

    w = s h / (1 + h),  ds/dt = (w - s) / recovery,

so that most of the dent springs back at once and the rest slowly.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.copying import FrozenMapping
from halfphysics.results.layer_rows import LayerRows, pressed_things, rows_of
from halfphysics.results.layer_surface import REACH, LayerSurface
from halfphysics.scene.soft_frame import soft_frame

if TYPE_CHECKING:
    from halfphysics.results.result import Result
    from halfphysics.scene.items import Object, Static
    from halfphysics.scene.soft import Soft

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Shallower dents are none [m]: nobody sees them.
LEAST = 1e-4
# Vertices farther from all samples never give [m]: paths along edges are longer than straight ones.
_FARTHEST = 1.2 * REACH
# Samples nearer to each other than this ask for the same edges [m].
_CUBE = 0.01


@dataclass(frozen=True, kw_only=True, eq=False)
class Dent:
    """One layer's surface over T frames, in the frame of the thing that has it.

    Attributes:
        name: The thing, as in `Result.names`.
        layer: The surface with edges short enough for its dents.
        vertices: Those that ever give (m,).
        depth: How far these have given in every frame (T, m), float32 [m].
    """

    name: str
    layer: LayerSurface
    vertices: Ints
    depth: NDArray[np.float32]

    def __len__(self) -> int:
        """Number of frames."""
        return len(self.depth)

    @property
    def faces(self) -> Ints:
        """Faces (F, 3) of the surface."""
        return self.layer.faces

    def depth_at(self, frame: int) -> Array:
        """How far every vertex has given in a frame (V,) [m]; later ones are as the last."""
        out = np.zeros(len(self.layer.surface))
        out[self.vertices] = self.depth[min(frame, len(self.depth) - 1)]
        return out

    def at(self, frame: int) -> Array:
        """The vertices (V, 3) [m] in a frame."""
        return self.layer.at(self.depth_at(frame))

    def sampled(self, low: Ints, high: Ints, weight: Array) -> Dent:
        """The dent at other times: between the frames `low` and `high` (N,), by `weight` (N,)."""
        share = np.asarray(weight, dtype=np.float32)[:, None]
        depth = (1.0 - share) * self.depth[low] + share * self.depth[high]
        return replace(self, depth=depth.astype(np.float32))


def dents_of(result: Result) -> Mapping[str, Dent]:
    """Name -> dent, for every soft thing of a result that anything ever presses."""
    contacts = result.soft_contacts
    found: dict[str, Dent] = {}
    if contacts is None:
        return FrozenMapping(found)
    for thing in pressed_things(result, contacts):
        rows = rows_of(result, contacts, thing.index)
        base = layer_of(thing.item, thing.soft)
        made = dent_of(thing.name, base, rows, len(result), 1.0 / result.fps, thing.soft)
        if len(made.vertices):
            found[thing.name] = made
    return FrozenMapping(found)


def layer_of(item: Static | Object, soft: Soft) -> LayerSurface:
    """The layer `soft` of a static or an object, with the faces of its own shape."""
    frame = soft_frame(item.true_shape, soft)
    return LayerSurface(
        surface=np.asarray(frame.surface),
        inner=np.asarray(frame.inner),
        faces=np.asarray(frame.faces, dtype=np.int64),
        thickness=np.asarray(frame.thickness),
    )


def dent_of(
    name: str, base: LayerSurface, rows: LayerRows, frames: int, seconds: float, soft: Soft
) -> Dent:
    """The dent of one layer.

    Args:
        name: The thing.
        base: Its layer; edges are made short where samples are.
        rows: The samples.
        frames: Number of frames T of the result.
        seconds: From one frame to the next [s].
        soft: The foam, which says how it comes back.
    """
    rows = rows[rows.depth > 0.0]
    # What slides along a side does not press it in.
    rows = rows[base.facing(rows.position, rows.normal)]
    places = base.pressed(rows.position, rows.normal, rows.depth).place
    layer = base.finer(_thinned(places))
    pressed = layer.pressed(rows.position, rows.normal, rows.depth)
    some = layer.near(pressed.place, _FARTHEST)
    part = layer.part(some)
    corner = np.searchsorted(some, pressed.corner)
    pressed = replace(pressed, corner=np.minimum(corner, max(len(some) - 1, 0)))
    first = np.searchsorted(rows.frame, np.arange(frames + 1))
    depth = np.zeros((frames, len(some)), dtype=np.float32)
    back = Recovery(soft, seconds, len(some))
    for frame in range(frames):
        w = part.depths(pressed[first[frame] : first[frame + 1]])
        depth[frame] = back.after(w)
    depth[depth < LEAST] = 0.0
    gives = depth.any(axis=0)
    return Dent(name=name, layer=layer, vertices=some[gives], depth=depth[:, gives])


class Recovery:
    """What nothing presses, of V vertices of a layer."""

    def __init__(self, soft: Soft, seconds: float, count: int) -> None:
        foam = soft.law == "foam" and soft.hysteresis > 0.0
        self._share = soft.hysteresis / (1.0 + soft.hysteresis) if foam else 0.0
        self._kept = float(np.exp(-seconds / soft.recovery)) if foam else 0.0
        slower = soft.recovery * (1.0 + soft.hysteresis)
        self._free = float(np.exp(-seconds / slower)) if foam else 0.0
        self._crept = np.zeros(count)

    def after(self, pressed: Array, frames: int = 1) -> Array:
        """Depths (V,) [m] so many frames later, where samples press to `pressed` (V,) [m]."""
        if not self._share:
            return pressed
        free = self._free**frames * self._crept
        held = pressed > self._share * free
        self._crept = np.where(held, pressed + (self._crept - pressed) * self._kept**frames, free)
        return np.where(held, pressed, self._share * free)


def _thinned(places: Array) -> Array:
    """The places (n, 3) [m], one for each cube of a centimetre."""
    cubes = np.unique(np.round(places / _CUBE).astype(np.int64), axis=0)
    return _CUBE * cubes.astype(np.float64)
