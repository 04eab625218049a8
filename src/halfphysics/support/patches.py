"""Patches: the places of the skin that can carry, because they are near a surface and slow on it.

The readiness of a place at height h over a surface that it passes at speed v is

    exp(-h^2 / (2 HEIGHT^2)) / (1 + v^2 / SPEED^2) min(1, cos a / FACING),    h < 0 counts as 0

with a the angle between the skin's outward normal and the way to the surface. Its tolerances are so
wide that a reference that floats or sinks by a centimetre or two, as recorded and estimated motion
does, is carried by the same places as an exact one. The speed only chooses among places: what
slides carries too where nothing stands.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.progress import over
from halfphysics.body import skinning
from halfphysics.motion.skeleton import N_JOINTS
from halfphysics.support.skin_grid import SkinGrid, skin_grid
from halfphysics.support.surface_distance import surface_distance

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion
    from halfphysics.support.surfaces import Surface

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Height over a surface at which readiness has dropped to 0.61 [m]: the errors of fitted feet and
#: the give of heel pads and shoes.
HEIGHT = 0.015
#: Speed at which it has dropped to a half [m/s]: over the noise of feet that stand (0.1 m/s), under
#: the speed of feet that are being set down or lifted (0.5 to 3 m/s).
SPEED = 0.25
#: Cosine of the angle from which on the skin faces a surface fully: 60 degrees. The back of a hand
#: and the instep are near the floor too, and do not touch it.
FACING = 0.5
#: Nearness that counts as none; what is left is scaled so that it fades to 0 without a step.
LEAST = 0.02
#: Nearness is under `LEAST` beyond this height [m].
REACH = HEIGHT * float(np.sqrt(-2.0 * np.log(LEAST)))
#: Speeds are measured over this time before and after a frame [s], whatever the frame rate: two
#: frames of a clip of 60 fps, so that the noise of a faster one does not read as speed.
WINDOW = 1.0 / 60.0
#: Frames that are posed at a time.
CHUNK = 256


@dataclass(frozen=True, kw_only=True, eq=False)
class Patches:
    """Places that can carry: n of them, ordered by frame, surface and vertex.

    Attributes:
        frame, surface: Frame, and index into the surfaces (n,).
        vertex, part: Vertex of the skin, and the part that it belongs to (n,).
        position: The nearest point of the surface, in the world (n, 3) [m].
        normal: Unit vector from the surface into the body (n, 3).
        friction: Coefficient of friction (n,).
        ready: Readiness (n,), over 0, at most 1.
    """

    frame: Ints
    surface: Ints
    vertex: Ints
    part: Ints
    position: Array
    normal: Array
    friction: Array
    ready: Array

    def __len__(self) -> int:
        return len(self.frame)


def find_patches(body: Body, motion: Motion, surfaces: Sequence[Surface]) -> Patches:
    """The places of a person that can carry.

    Args:
        body, motion: The person, T frames.
        surfaces: What could hold them up.
    """
    grid, step = skin_grid(body), max(1, round(WINDOW * motion.fps))
    count = len(motion)
    frames = body.joint_frames(motion)
    found = [_none()]
    for first in over(range(0, count, CHUNK), "supporting surfaces", "frame", size=CHUNK):
        last = min(first + CHUNK, count)
        low, high = max(first - step, 0), min(last + step, count)
        posed = _Posed(body, motion, frames, grid, slice(low, high))
        for index, surface in enumerate(surfaces):
            found.append(_near(posed, index, surface, range(first, last), step))
    whole = Patches(
        **{f.name: np.concatenate([getattr(p, f.name) for p in found]) for f in fields(Patches)}
    )
    order = np.lexsort((whole.vertex, whole.surface, whole.frame))
    return Patches(**{f.name: getattr(whole, f.name)[order] for f in fields(Patches)})


class _Posed:
    """The grid of a person in some frames; parts are skinned in the frames that ask for them."""

    def __init__(
        self,
        body: Body,
        motion: Motion,
        frames: tuple[Array, Array],
        grid: SkinGrid,
        some: slice,
    ) -> None:
        self.grid, self.first, self.last = grid, some.start, some.stop
        self.fps = motion.fps
        self.joints, self.turns = frames[0][some], frames[1][some]
        middle = np.broadcast_to(grid.middle, self.joints.shape)
        self.middles = self.joints + rot.rotate(self.turns, middle)
        self._body, self._rotations = body, motion.rotations[some]
        self._points = np.empty((some.stop - some.start, len(grid.vertex), 3))
        self._done = np.zeros((some.stop - some.start, N_JOINTS), dtype=bool)

    def points(self, wanted: NDArray[np.bool_]) -> Array:
        """World positions (t, n, 3) [m] of the grid, valid where its part is wanted (t, 55)."""
        more = wanted & ~self._done
        rows = np.flatnonzero(more.any(axis=1))
        parts = np.flatnonzero(more.any(axis=0))
        if len(rows):
            first = self.grid.first
            pieces = [np.arange(first[p], first[p + 1]) for p in parts]
            starts = np.cumsum([0, *(len(piece) for piece in pieces)]).astype(np.int32)
            columns = np.concatenate(pieces)
            some = slice(rows[0], rows[-1] + 1)
            posed = skinning.skin(
                self._body.skin,
                self._rotations[some],
                self.joints[some],
                self.turns[some],
                indices=self.grid.vertex[columns],
                wanted=(starts, np.ascontiguousarray(more[some][:, parts])),
            )
            target = self._points[some]
            if self._done[some][:, parts].any():  # another surface asked for some before
                fresh = more[some][:, self.grid.part[columns]]
                posed = np.where(fresh[..., None], posed, target[:, columns])
            target[:, columns] = posed
            self._done |= more
        return self._points


def _near(posed: _Posed, index: int, surface: Surface, frames: range, step: int) -> Patches:
    """The places that are near one surface in some frames."""
    asked = np.arange(frames.start, frames.stop)
    if surface.holds is not None:
        asked = asked[surface.holds[asked]]
    close = _close_parts(posed, surface, asked)
    if not close.any():
        return _none()
    wanted = np.zeros((posed.last - posed.first, N_JOINTS), dtype=bool)
    here = asked - posed.first
    before = np.maximum(here - step, 0)
    after = np.minimum(here + step, posed.last - posed.first - 1)
    for rows in (here, before, after):
        np.logical_or.at(wanted, rows, close)
    points = posed.points(wanted)
    part = posed.grid.part
    row, column = np.nonzero(close[:, part])
    local = surface.local(points[here[row], column], asked[row])
    bounds = _bounds(surface)
    if bounds is not None:  # the distance from a mesh is dear
        some = ((local > bounds[0] - REACH) & (local < bounds[1] + REACH)).all(axis=1)
        row, column, local = row[some], column[some], local[some]
    inner = surface.local(posed.middles[here[row], part[column]], asked[row])
    height, normal = surface_distance(surface.shape, local, inner)
    keep = np.flatnonzero(height < REACH)
    row, column, frame = row[keep], column[keep], asked[row[keep]]
    height, local = height[keep], local[keep] - height[keep, None] * normal[keep]
    normal = surface.world(normal[keep], frame)
    skin = rot.rotate(posed.turns[here[row], part[column]], posed.grid.normal[column])
    facing = np.clip(-np.einsum("ni,ni->n", skin, normal) / FACING, 0.0, 1.0)
    ends = [
        surface.local(points[rows[row], column], posed.first + rows[row])
        for rows in (before, after)
    ]
    time = np.maximum(after - before, 1)[row] / posed.fps
    speed = np.linalg.norm(ends[1] - ends[0], axis=1) / time
    near = np.exp(-0.5 * (np.maximum(height, 0.0) / HEIGHT) ** 2)
    ready = facing * (near - LEAST) / (1.0 - LEAST) / (1.0 + (speed / SPEED) ** 2)
    good = np.flatnonzero(ready > 0.0)
    of_part = part[column[good]].astype(np.int64)
    return Patches(
        frame=frame[good],
        surface=np.full(len(good), index, dtype=np.int64),
        vertex=posed.grid.vertex[column[good]].astype(np.int64),
        part=of_part,
        position=surface.world(local[good], frame[good]) + surface.origin(frame[good]),
        normal=normal[good],
        friction=surface.friction[of_part],
        ready=ready[good],
    )


def _close_parts(posed: _Posed, surface: Surface, asked: Ints) -> NDArray[np.bool_]:
    """Parts (k, 55) whose ball about their middle reaches a surface in frames asked for (k,)."""
    middles = posed.middles[asked - posed.first]
    frame, part = np.divmod(np.arange(middles[..., 0].size), N_JOINTS)
    local = surface.local(middles.reshape(-1, 3), asked[frame])
    reach = (posed.grid.radius + REACH)[part]
    able = (np.diff(posed.grid.first) > 0) & ~np.isnan(surface.friction)
    maybe = able[part]
    bounds = _bounds(surface)
    if bounds is not None:
        outside = np.maximum(np.maximum(bounds[0] - local, local - bounds[1]), 0.0)
        maybe &= np.einsum("ni,ni->n", outside, outside) < reach**2
    some = np.flatnonzero(maybe)
    close = np.zeros(len(part), dtype=bool)
    if len(some):
        distance, _ = surface_distance(surface.shape, local[some], local[some])
        close[some] = distance < reach[some]
    return close.reshape(len(asked), N_JOINTS)


def _bounds(surface: Surface) -> Array | None:
    """Corners (2, 3) of the box around a mesh, in its frame; None for other shapes."""
    query = getattr(surface.shape, "query", None)
    return None if query is None else np.asarray(query.bounds)


def _none() -> Patches:
    whole, vectors = np.zeros(0, dtype=np.int64), np.zeros((0, 3))
    return Patches(
        frame=whole,
        surface=whole,
        vertex=whole,
        part=whole,
        position=vectors,
        normal=vectors,
        friction=np.zeros(0),
        ready=np.zeros(0),
    )
