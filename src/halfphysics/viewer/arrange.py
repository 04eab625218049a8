"""Several results side by side: where each stands, and the camera that sees them all."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halfphysics.drawing import Drawing, Item
from halfphysics.render import Camera
from halfphysics.viewpoint import FOV, choose_direction, glass, spread, subject

Array = NDArray[np.float64]

# Free space between one result's things and the next one's [m].
_GAP = 0.6
# Frames that must be in the picture, and those that the direction is chosen by.
_FRAMES, _PROBES = 6, 2


@dataclass(frozen=True, kw_only=True)
class Arrangement:
    """Where results stand and where to look from.

    Attributes:
        offsets: Of every result (N, 3) [m]; the first stays where it is.
        camera: Sees the stories of all.
        faint: Of every result, names of the statics to see through.
        heads: Of every result, a point above all that happens (N, 3) [m], in its own frame.
    """

    offsets: Array
    camera: Camera
    faint: tuple[frozenset[str], ...]
    heads: Array


def arrange(
    drawings: Sequence[Drawing], size: tuple[int, int] = (1280, 720), *, apart: bool = True
) -> Arrangement:
    """Results in a row across the picture, none in another.

    Args:
        drawings: The results.
        size: Of the picture that the camera frames for [pixels].
        apart: In a row; False: all where they are.
    """
    probes = spread(len(drawings[0]), _PROBES + 2)[1:-1] or [0]
    direction = choose_direction(drawings[0], probes, size)
    right = np.array([-direction[1], direction[0], 0.0])
    right /= np.linalg.norm(right)
    offsets = np.zeros((len(drawings), 3))
    if apart:
        edge = 0.0
        for k, drawing in enumerate(drawings):
            low, high = _span(drawing, right)
            if k:
                offsets[k] = right * (edge + _GAP - low)
            edge = high + float(offsets[k] @ right)
    points, heads, scenes = [], [], []
    for drawing, offset in zip(drawings, offsets, strict=True):
        story = []
        for frame in spread(len(drawing), _FRAMES):
            surfaces = drawing.surfaces(frame)
            moving = {n: s for n, s in surfaces.items() if not n.startswith("static/")}
            story.append(subject(drawing, frame, moving))
            scenes.append((len(heads), surfaces))
        seen = np.concatenate(story)
        points.append(seen + offset)
        middle = 0.5 * (seen.min(axis=0) + seen.max(axis=0))
        heads.append([middle[0], middle[1], seen[:, 2].max()])
    camera = Camera.framing(np.concatenate(points), direction, size=size, fov=FOV)
    faint: list[set[str]] = [set() for _ in drawings]
    for k, surfaces in scenes:
        faint[k] |= glass(surfaces, _moved(camera, -offsets[k]), size)
    return Arrangement(
        offsets=offsets,
        camera=camera,
        faint=tuple(map(frozenset, faint)),
        heads=np.array(heads),
    )


def _moved(camera: Camera, by: Array) -> Camera:
    return Camera(
        position=camera.position + by,
        target=camera.target + by,
        up=camera.up,
        fov=camera.fov,
        near=camera.near,
    )


def _span(drawing: Drawing, right: Array) -> tuple[float, float]:
    """How far a result reaches along a direction, planes left out."""
    reach = [(drawing.middle @ right) + s * (drawing.radius + 0.5) for s in (-1.0, 1.0)]
    for item in drawing.statics.values():
        if not is_plane(item):
            along = item.at(0).vertices @ right
            reach += [along.min(), along.max()]
    return float(min(reach)), float(max(reach))


def is_plane(item: Item) -> bool:
    """Whether it stands for a plane without end."""
    return item.surface.cull == "back"


def floor_height(item: Item) -> float | None:
    """Height of a level plane [m], None: something else."""
    if not is_plane(item) or item.surface.fade is None:
        return None
    return float(item.surface.vertices[:, 2].mean())
