"""Colours of a take's people and props, the same as in pictures and in the viewer."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.render.look import BODIES, LIGHT, OBJECTS
from halfphysics.render.rasterizer import Color
from halfphysics.render.result_meshes import StaticColors
from halfphysics.writers.take import Actor, Prop


def actors_coloured(actors: Iterable[Actor]) -> Iterator[tuple[Actor, Color]]:
    """Each person with a colour (sRGB)."""
    for k, actor in enumerate(actors):
        yield actor, BODIES[k % len(BODIES)]


def props_coloured(props: Iterable[Prop]) -> Iterator[tuple[Prop, Color]]:
    """Each prop with its colour (sRGB): moving ones have accents, static ones are pale."""
    moving, statics = 0, StaticColors()
    for prop in props:
        if prop.moves:
            yield prop, OBJECTS[moving % len(OBJECTS)]
            moving += 1
        else:
            size = np.ptp(rot.rotate(prop.quaternion[0], prop.vertices), axis=0)
            yield prop, LIGHT.ground if size[2] < 1e-9 else statics.of(prop.name, size)


def linear(color: Color) -> list[float]:
    """Linear light (3,) of an sRGB colour."""
    return [round(c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4, 5) for c in color]
