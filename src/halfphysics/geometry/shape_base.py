"""The base class of all shapes, primitives and meshes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.base.validation import number
from halfphysics.errors import InputError

Array = NDArray[np.float64]
Triangles = tuple[Array, NDArray[np.int32]]


@dataclass(frozen=True, kw_only=True)
class MassProperties:
    """Mass [kg], centre of mass (3,) [m] and inertia (3, 3) about it [kg m^2], shape's axes."""

    mass: float
    com: Array
    inertia: Array


class Shape:
    """Base of all shapes. Points and results are in the shape's own frame [m]."""

    @property
    def volume(self) -> float:
        """Volume [m^3]."""
        raise NotImplementedError

    def unit_inertia(self) -> Array:
        """Inertia (3, 3) about the centre of mass at 1 kg [m^2]."""
        raise NotImplementedError

    @property
    def centre(self) -> Array:
        """Centre of mass (3,) [m] for even density."""
        return np.zeros(3)

    def mass_properties(
        self, *, mass: float | None = None, density: float | None = None
    ) -> MassProperties:
        """Mass, centre and inertia for a mass [kg] or an even density [kg/m^3].

        Raises `InputError` unless exactly one of them is given and positive.
        """
        name = type(self).__name__
        if (mass is None) == (density is None):
            found = "neither" if mass is None else "both"
            raise InputError(f"{name}: expected mass= [kg] or density= [kg/m^3], found {found}")
        if mass is not None:
            mass = number(mass, f"{name}: mass", above=0.0, unit="kg")
        else:
            density = number(density, f"{name}: density", above=0.0, unit="kg/m^3")
            mass = density * self.volume
        return MassProperties(mass=mass, com=self.centre, inertia=mass * self.unit_inertia())

    def triangles(self) -> Triangles:
        """Vertices (V, 3) and outward faces (F, 3) of a triangulation, for drawing."""
        raise NotImplementedError

    def depth(self, points: ArrayLike, *, threads: int = 1) -> Array:
        """How far points (n, 3) are inside [m], (n,): distance to the surface, 0 outside."""
        raise NotImplementedError
