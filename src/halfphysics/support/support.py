"""Support: what the surroundings must supply so that a person's motion is physical."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.copying import ReadOnly
from halfphysics.base.short_repr import counted, frames_repr
from halfphysics.base.suggestions import did_you_mean
from halfphysics.errors import InputError
from halfphysics.motion.skeleton import JOINT_INDEX, JOINT_NAMES
from halfphysics.results.table import Ints, Table

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

#: Share of the weight that nothing supplies over which a frame is unsupported.
UNSUPPORTED = 0.05
#: Known forces under this part of the weight are rounding.
KNOWN = 1e-9


@dataclass(frozen=True, kw_only=True, eq=False)
class Pressure(Table):
    """Forces on the skin: columns of one length n, ordered by frame.

    Attributes:
        frame: The frame (n,).
        vertex: Vertex of the skin (n,).
        part: Index into `JOINT_NAMES`: the part with the largest weight there (n,).
        surface: Index into `Support.names` of the surface that presses (n,).
        position: The point of the surface where it presses (n, 3) [m].
        normal: Unit vector from the surface into the body (n, 3).
        force: On the skin (n, 3) [N].
    """

    NAME: ClassVar[str] = "pressure"
    VECTORS: ClassVar[frozenset[str]] = frozenset({"position", "normal", "force"})
    UNITS: ClassVar[Mapping[str, str]] = MappingProxyType({"position": "m", "force": "N"})

    frame: Ints
    vertex: Ints
    part: Ints
    surface: Ints
    position: Array
    normal: Array
    force: Array

    def __repr__(self) -> str:
        if not len(self):
            return "Pressure(none)"
        points = f"{counted(len(self), 'row')} in {frames_repr(self.frame)}"
        strongest = np.linalg.norm(self.force, axis=1).max()
        return f"Pressure({points}, forces up to {strongest:.3g} N)"


@dataclass(frozen=True, kw_only=True, eq=False)
class Support(ReadOnly):
    """What holds a person up, in T frames: forces on the person, world frame.

    A residual is what no surface can supply: a motion whose residual is large is not possible
    where it takes place. docs/support.md says how all of it is found.

    Attributes:
        fps: Frames per second.
        mass: Of the person [kg].
        gravity: Acceleration of free fall (3,) [m/s^2].
        names: What can act on the person, S names: statics, objects, links, other people.
        force: Force of each of them (T, S, 3) [N]. Of things that move freely and of people it
            holds their contact impulses; of what is fixed it is found here.
        cop: Centre of pressure of each (T, S, 3) [m]; nan where it exerts no force, or the force
            is but a trace that the filter leaves before and after contact impulses.
        pressure: Forces on vertices of the skin, found here (those of contact impulses are in
            `Result.contacts`).
        torque: Torque in each joint (T, 55, 3) [N m], with gravity and inertia, in the frame of
            the joint's child. Row 0 is the residual moment.
        power: Of each joint (T, 55) [W]; positive: it does work.
        residual: Force [N] and moment about the pelvis [N m] that nothing supplies (T, 6).
        required: Force and moment about the pelvis that the motion needs (T, 6).
        airborne: Frames of a flight, a jump's or a fall's (T,): nothing is near enough to carry,
            and over the whole of it the person falls as gravity has it.
        com: Centre of mass (T, 3) [m].
        momentum: (T, 3) [kg m/s].
        angular_momentum: About the centre of mass (T, 3) [kg m^2/s].
        cutoff: Of the low-pass filter of velocities [Hz]; None: no filter.
    """

    fps: float
    mass: float
    gravity: Array
    names: tuple[str, ...]
    force: Array
    cop: Array
    pressure: Pressure
    torque: Array
    power: Array
    residual: Array
    required: Array
    airborne: Mask
    com: Array
    momentum: Array
    angular_momentum: Array
    cutoff: float | None

    def __post_init__(self) -> None:
        for value in vars(self).values():
            if isinstance(value, np.ndarray):
                value.setflags(write=False)

    def __len__(self) -> int:
        return len(self.com)

    def __repr__(self) -> str:
        names = ", ".join(self.names) or "nothing"
        return (
            f"Support({len(self)} frames, {self.mass:.1f} kg, on {names}: "
            f"{self.unsupported_percent:.0f} % of the frames unsupported)"
        )

    @property
    def weight(self) -> float:
        """Weight of the person [N]."""
        return self.mass * float(np.linalg.norm(self.gravity))

    @property
    def up(self) -> Array:
        """Unit vector against gravity (3,); +z where there is none."""
        size = np.linalg.norm(self.gravity)
        return -self.gravity / size if size > 0.0 else np.array([0.0, 0.0, 1.0])

    @cached_property
    def total(self) -> Array:
        """Sum of all forces on the person (T, 3) [N]."""
        result: Array = self.force.sum(axis=1)
        return result

    @property
    def weight_percent(self) -> Array:
        """Upward force of everything together (T,) [% of the weight]; nan without gravity."""
        return self._percent(self.total @ self.up)

    @property
    def residual_percent(self) -> Array:
        """Upward force that nothing supplies (T,) [% of the weight]; nan without gravity."""
        return self._percent(self.residual[:, :3] @ self.up)

    @property
    def unsupported(self) -> Mask:
        """Frames (T,) in which the person is held up by nothing: not airborne, and of the upward
        force over 5 % of the weight is residual. Without gravity nobody is held up.
        """
        upward = self.residual[:, :3] @ self.up
        return ~self.airborne & (self.weight > 0.0) & (upward > UNSUPPORTED * self.weight)

    @property
    def unsupported_percent(self) -> float:
        """Share of unsupported frames among those that are not airborne [%]."""
        count = int((~self.airborne).sum())
        return 100.0 * float(self.unsupported.sum()) / count if count else 0.0

    @cached_property
    def total_cop(self) -> Array:
        """Centre of pressure of everything together (T, 3) [m], weighted by the upward forces on
        the skin, those of soft layers and of other known impulses included; nan without any. Traces
        of impulses, which have no centre of pressure of their own, have no part in it.
        """
        upward = np.maximum(self.pressure.force @ self.up, 0.0)[:, None]
        rows = np.concatenate([upward * self.pressure.position, upward], axis=1)
        total = sums(rows, self.pressure.frame, (len(self),))
        known = self._known @ self.up
        placed = np.isfinite(self.cop).all(axis=2)
        known = np.where(placed & (known > KNOWN * self.weight), known, 0.0)
        total[:, :3] += np.einsum("ts,tsi->ti", known, np.nan_to_num(self.cop))
        total[:, 3] += known.sum(axis=1)
        return _mean(total)

    @property
    def _known(self) -> Array:
        """Force of each of `names` (T, S, 3) [N] but what was found here: that of impulses."""
        shape = (len(self), len(self.names))
        place = self.pressure.frame * shape[1] + self.pressure.surface
        known: Array = self.force - sums(self.pressure.force, place, shape)
        return known

    def surface(self, name: str) -> tuple[Array, Array]:
        """Force (T, 3) [N] and centre of pressure (T, 3) [m] of one of `names`.

        Raises:
            InputError: No such name.
        """
        if name not in self.names:
            hint = did_you_mean(name, self.names, form=repr)
            known = ", ".join(self.names) or "none"
            raise InputError(f"support: found no surface {name!r}{hint or '.'} It has: {known}")
        index = self.names.index(name)
        return self.force[:, index], self.cop[:, index]

    def on(self, *parts: str) -> tuple[Array, Array]:
        """Force (T, 3) [N] and centre of pressure (T, 3) [m] of surfaces on some parts.

        A foot is ``support.on("left_ankle", "left_foot")``. Contact impulses are not included.

        Args:
            parts: Names of `JOINT_NAMES`.

        Raises:
            InputError: No such part.
        """
        for part in parts:
            if part not in JOINT_INDEX:
                hint = did_you_mean(part, JOINT_NAMES, form=repr)
                raise InputError(f"support: a person has no part {part!r}{hint}")
        some = self.pressure[np.isin(self.pressure.part, [JOINT_INDEX[part] for part in parts])]
        force = sums(some.force, some.frame, (len(self),))
        pushes = np.einsum("ni,ni->n", some.force, some.normal)
        return force, _weighted(some, pushes, len(self))

    def _percent(self, upward: Array) -> Array:
        weight = self.weight if self.weight > 0.0 else np.nan
        return np.asarray(100.0 * upward / weight)


def sums(values: Array, place: Ints, shape: tuple[int, ...]) -> Array:
    """Sums (*shape, k) of rows (n, k) by their place (n,) in an array of a shape, flattened."""
    size = int(np.prod(shape))
    columns = [np.bincount(place, weights=column, minlength=size) for column in values.T]
    result: Array = np.stack(columns, axis=-1).astype(np.float64, copy=False)
    return result.reshape(*shape, values.shape[1])


def _weighted(pressure: Pressure, weight: Array, frames: int) -> Array:
    """Mean position (T, 3) of rows by weights (n,); nan where they have none."""
    rows = np.concatenate([weight[:, None] * pressure.position, weight[:, None]], axis=1)
    return _mean(sums(rows, pressure.frame, (frames,)))


def _mean(total: Array) -> Array:
    """Mean (T, 3) of sums of weighted positions and of weights (T, 4); nan without weight."""
    some = total[:, 3:] > 0.0
    return np.where(some, total[:, :3] / np.where(some, total[:, 3:], 1.0), np.nan)
