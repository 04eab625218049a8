"""Pressure maps: what presses a soft thing, on a grid over one of its sides.

Every sample under pressure is spread over the cells around it by a Gaussian as wide as the sample's
own area, which keeps its force: the sum over the cells of a frame, times the area of a cell, is the
force on that side.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.copying import ReadOnly
from halfphysics.base.suggestions import did_you_mean
from halfphysics.base.validation import number, shown
from halfphysics.errors import InputError
from halfphysics.results.dents import layer_of
from halfphysics.results.layer_pressure import SHOWN
from halfphysics.results.layer_rows import pressed_things, rows_of

if TYPE_CHECKING:
    from halfphysics.results.result import Result
    from halfphysics.results.soft_contacts import SoftContacts

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Side of a thing -> rows: the directions of the map's columns and rows (right and up in the
#: picture) and the one from which it is seen, in the thing's own axes.
SIDES: Mapping[str, tuple[tuple[int, int, int], ...]] = MappingProxyType(
    {
        "top": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
        "bottom": ((1, 0, 0), (0, -1, 0), (0, 0, -1)),
        "front": ((1, 0, 0), (0, 0, 1), (0, -1, 0)),
        "back": ((-1, 0, 0), (0, 0, 1), (0, 1, 0)),
        "right": ((0, 1, 0), (0, 0, 1), (1, 0, 0)),
        "left": ((0, -1, 0), (0, 0, 1), (-1, 0, 0)),
    }
)
#: Side of a cell [m].
CELL = 0.01
#: Most numbers of a map: 4 bytes each.
MOST_NUMBERS = 2**27
# Width of a sample, as a share of the side of its area: a row of them is even to half a percent.
_WIDTH = 0.55
# Samples are spread this far [widths].
_SPREAD = 3.0
# A sample is on a side that its normal is within 60 degrees of.
_FACING = 0.5
# A thing without end is shown this far around what presses it [m].
_MARGIN = 0.1
# Samples that are spread at once.
_BLOCK = 4096


@dataclass(frozen=True, kw_only=True, eq=False)
class PressureMap(ReadOnly):
    """Pressure on one side of a soft thing, in T frames.

    Attributes:
        name: The thing, as in `Result.names`.
        side: One of `SIDES`, of the thing's own axes.
        pressure: Of every cell (T, H, W) [Pa], float32: columns to the right, rows upwards.
        cell: Side of a cell [m].
        corner: Of the map's lower left corner, the place along columns and rows [m], own axes.
        outline: Lower left and upper right corner of the thing (2, 2) [m]; a plane has none: None.
        missed: Share of the force of all frames that is on other sides.
        fps: Frames per second.
    """

    name: str
    side: str
    pressure: NDArray[np.float32]
    cell: float
    corner: Array
    outline: Array | None
    missed: float
    fps: float

    def __len__(self) -> int:
        """Number of frames."""
        return len(self.pressure)

    @property
    def peak(self) -> NDArray[np.float32]:
        """The largest pressure of every cell over time (H, W) [Pa]."""
        result: NDArray[np.float32] = self.pressure.max(axis=0)
        return result

    @property
    def force(self) -> Array:
        """Normal force on this side in every frame (T,) [N]."""
        total = self.pressure.sum(axis=(1, 2), dtype=np.float64)
        result: Array = total * self.cell**2
        return result

    def area(self, least: float = SHOWN) -> Array:
        """Area of the cells with at least this pressure [Pa], in every frame (T,) [m^2]."""
        result: Array = (self.pressure >= least).sum(axis=(1, 2)) * self.cell**2
        return result


def pressure_map(
    result: Result, name: str | None = None, *, side: str | None = None, cell: float = CELL
) -> PressureMap:
    """The pressure on a soft static or object of a result.

    Args:
        result: The result.
        name: The thing; None: the one that is pressed most.
        side: One of `SIDES`, in the thing's own axes (top: z, front: -y, right: x); None: the one
            that carries most.
        cell: Side of a cell [m].

    Raises:
        InputError: Nothing soft is pressed, another name or side, or cells so small that the map
            has over 2^27 numbers.
    """
    contacts = checked_contacts(result)
    name = _chosen(result, contacts, name)
    cell = number(cell, "cell", least=1e-3, most=1.0, unit="m")
    if side is not None and side not in SIDES:
        raise InputError(f"side: found {shown(side)}, expected one of {', '.join(SIDES)}")
    rows = rows_of(result, contacts, result.names.index(name))
    place, normal, force = rows.position, rows.normal, rows.force
    if side is None:
        views = [np.array(axes[2]) for axes in SIDES.values()]
        carried = [(np.clip(normal @ view, 0.0, None) * force).sum() for view in views]
        side = list(SIDES)[int(np.argmax(carried))]
    axes = np.array(SIDES[side], dtype=np.float64)
    facing = normal @ axes[2]
    seen = facing > _FACING
    other = float((force * (1.0 - np.clip(facing, 0.0, None)))[~seen].sum())
    missed = other / max(float((force * facing)[seen].sum()) + other, 1e-12)
    flat = place[seen] @ axes[:2].T
    outline = _outline(result, name, axes)
    width = _WIDTH * np.sqrt(rows.area[seen] * facing[seen])
    low, shape = _grid(flat, outline, cell, float(width.max(initial=cell)))
    if len(result) * shape[0] * shape[1] > MOST_NUMBERS:
        raise InputError(
            f"cell: found {cell:g} m, for which {name!r} has {shape[1]} x {shape[0]} cells in "
            f"{len(result)} frames, over {MOST_NUMBERS} numbers; expected larger cells"
        )
    pressure = _spread(
        (flat - low) / cell,
        (force * facing)[seen] / cell**2,
        np.maximum(width, 0.5 * cell) / cell,
        rows.frame[seen],
        (len(result), *shape),
    )
    return PressureMap(
        name=name,
        side=side,
        pressure=pressure,
        cell=cell,
        corner=low,
        outline=outline,
        missed=missed,
        fps=result.fps,
    )


def checked_contacts(result: Result) -> SoftContacts:
    """The soft contacts of a result.

    Raises:
        InputError: It has none.
    """
    contacts = result.soft_contacts
    if contacts is None:
        raise InputError(
            "pressure: found a result without anything soft. Let a static, an object or the "
            "people's skin be soft (docs/soft.md), and simulate"
        )
    if not len(contacts):
        raise InputError("pressure: found a result in which nothing presses anything soft")
    return contacts


def _chosen(result: Result, contacts: SoftContacts, name: str | None) -> str:
    """The name of a soft thing that is pressed; None: the one that is pressed most."""
    force = contacts.pressure * contacts.area
    pressed = {}
    for thing in pressed_things(result, contacts):
        mine = (contacts.layer == thing.index) | (contacts.other == thing.index)
        pressed[thing.name] = float(force[mine].sum())
    if name is not None and name in pressed:
        return name
    if name is None and pressed:
        return max(pressed, key=lambda thing: pressed[thing])
    hint = did_you_mean(name, pressed, otherwise=".")
    there = ", ".join(pressed) or "no things; pressure on skins: --skin, skin_pressure()"
    raise InputError(f"pressure: nothing presses on {shown(name)}{hint} Pressed are: {there}")


def _outline(result: Result, name: str, axes: Array) -> Array | None:
    """Corners (2, 2) of a thing along the map's axes [m]; None: it is a plane."""
    from halfphysics.scene.items import Static

    item = result.scene.statics.get(name) or result.scene.objects[name]
    if isinstance(item, Static) and not np.isfinite(item.shape.volume):
        return None
    points = item.mesh()[0] if item.soft is None else layer_of(item, item.soft).surface
    flat = np.asarray(points) @ axes[:2].T
    return np.stack([flat.min(axis=0), flat.max(axis=0)])


def _grid(
    flat: Array, outline: Array | None, cell: float, width: float
) -> tuple[Array, tuple[int, int]]:
    """Lower left corner of a map [m], and its rows and columns, for samples at `flat` (n, 2)."""
    room = _SPREAD * width + cell
    ends = [] if not len(flat) else [flat.min(axis=0) - room, flat.max(axis=0) + room]
    if outline is not None:
        ends += list(outline)
    elif ends:
        ends += [ends[0] - _MARGIN, ends[1] + _MARGIN]
    if not ends:
        ends = [np.zeros(2), np.full(2, cell)]
    low = np.floor(np.min(ends, axis=0) / cell - 1e-9) * cell
    count = np.maximum(np.ceil((np.max(ends, axis=0) - low) / cell - 1e-9), 1).astype(int)
    return low, (int(count[1]), int(count[0]))


def _spread(
    place: Array, value: Array, width: Array, frame: Ints, shape: tuple[int, int, int]
) -> NDArray[np.float32]:
    """Values (n,) at places (n, 2) [cells] spread by Gaussians of widths (n,) [cells]."""
    out = np.zeros(int(np.prod(shape)), dtype=np.float32)
    reach = int(np.ceil(_SPREAD * width.max(initial=0.5)))
    steps = np.arange(-reach, reach + 1)
    for start in range(0, len(place), _BLOCK):
        rows = slice(start, start + _BLOCK)
        middle = np.floor(place[rows]).astype(np.int64)
        off = (middle + 0.5 - place[rows])[:, None, :] + steps[None, :, None]  # (b, k, 2)
        share = np.exp(-0.5 * (off / width[rows, None, None]) ** 2)
        share[np.abs(off) > _SPREAD * width[rows, None, None] + 0.5] = 0.0
        share /= share.sum(axis=1, keepdims=True)
        column = np.clip(middle[:, None, 0] + steps, 0, shape[2] - 1)
        line = np.clip(middle[:, None, 1] + steps, 0, shape[1] - 1)
        index = (frame[rows, None] * shape[1] + line)[:, :, None] * shape[2] + column[:, None, :]
        add = value[rows, None, None] * share[:, :, None, 1] * share[:, None, :, 0]
        low, high = int(index.min()), int(index.max()) + 1
        out[low:high] += np.bincount((index - low).ravel(), add.ravel(), high - low).astype(
            np.float32
        )
    return out.reshape(shape)
