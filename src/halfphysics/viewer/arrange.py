"""Several results side by side: their offsets, and a camera that has all of them in view."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from halfphysics.render.rasterizer import Camera
from halfphysics.render.result_meshes import Drawing, Item
from halfphysics.render.viewpoint import FOV, choose_direction, glass, spread, subject
from halfphysics.viewer.framing import framed, on_people

Array = NDArray[np.float64]

# Free space between the scenes of neighbouring results, and margin around a person's pelvis [m].
_GAP, _REACH = 0.4, 0.7
# Number of frames that must be in the picture, and of frames that decide the direction.
_FRAMES, _PROBES = 6, 2
# Stride of the points that frame a picture.
_SPARSE = 9
# Number of directions tried for the row, per half turn.
_ROWS = 12
# A camera whose cosine with the row is larger is turned to 45 degrees from the row.
_ALONG = 0.75


@dataclass(frozen=True, kw_only=True)
class Arrangement:
    """Positions of the results and direction of the camera.

    Attributes:
        offsets: Offset of each result (N, 3) [m]; zero for the first.
        direction: Unit vector from the results to the camera (3,).
        points: World points that belong in the picture (M, 3) [m].
        people: World points of the people's skins in the first frame (P, 3) [m].
        reach: Largest horizontal distance of a person from the middle of all in that frame [m].
        faint: For each result, names of the statics to draw translucent.
    """

    offsets: Array
    direction: Array
    points: Array
    people: Array
    reach: float
    faint: tuple[frozenset[str], ...]

    def camera(self, window: tuple[int, int]) -> Camera:
        """Camera that has all results in the free part of a window of this size [pixels]."""
        return framed(self.points, self.direction, window)

    def first(self, window: tuple[int, int], *, panel: bool = True) -> Camera:
        """Camera of the first picture, in which people fill half of the height."""
        return on_people(self.people, self.direction, window, panel=panel)


def arrange(
    drawings: Sequence[Drawing], size: tuple[int, int], *, headroom: float = 0.0
) -> Arrangement:
    """Put results in the shortest row without overlap.

    Args:
        drawings: The results.
        size: Size of the picture that decides which statics hide people or objects [pixels].
        headroom: Extra height above the highest point, such as for a name [m].
    """
    probes = spread(len(drawings[0]), _PROBES + 2)[1:-1] or [0]
    direction = choose_direction(drawings[0], probes, size)
    offsets = np.zeros((len(drawings), 3))
    if len(drawings) > 1:
        row, offsets = _row(drawings, direction)
        direction = _across(direction, row)
    points, scenes, people, middles = [], [], [], []
    for k, drawing in enumerate(drawings):
        story = []
        for frame in spread(len(drawing), _FRAMES):
            surfaces = drawing.surfaces(frame)
            moving = {n: s for n, s in surfaces.items() if not n.startswith("static/")}
            story.append(subject(drawing, frame, moving)[::_SPARSE])
            scenes.append((k, surfaces))
        skins = [
            s.vertices for n, s in drawing.story(0, ghost=False).items() if n.startswith("person/")
        ]
        people += [skin[::_SPARSE] + offsets[k] for skin in skins]
        middles += [(skin.mean(axis=0) + offsets[k])[:2] for skin in skins]
        seen = np.concatenate(story)
        top = seen[np.argmax(seen[:, 2])]
        points.append(np.vstack([seen, top + np.array([0.0, 0.0, headroom])]) + offsets[k])
    everything = np.concatenate(points)
    camera = Camera.framing(everything, direction, size=size, fov=FOV)
    faint: list[set[str]] = [set() for _ in drawings]
    for k, surfaces in scenes:
        faint[k] |= glass(surfaces, _moved(camera, -offsets[k]), size)
    return Arrangement(
        offsets=offsets,
        direction=direction,
        points=everything,
        people=np.concatenate(people),
        reach=float(np.linalg.norm(middles - np.mean(middles, axis=0), axis=1).max()),
        faint=tuple(map(frozenset, faint)),
    )


def _row(drawings: Sequence[Drawing], direction: Array) -> tuple[Array, Array]:
    """The horizontal direction of the shortest row, and the offsets along it."""
    found = []
    for angle in np.arange(2 * _ROWS) * (np.pi / _ROWS):
        row = np.array([np.cos(angle), np.sin(angle), 0.0])
        if np.cross(direction, row)[2] < 0.0:
            continue  # keep the first result on the left
        along = [0.0]
        spans = [_span(drawing, row) for drawing in drawings]
        for (_, high), (low, _) in pairwise(spans):
            along.append(along[-1] + high + _GAP - low)
        # A row across the picture is preferred to a row in depth.
        cost = along[-1] * (1.0 + 0.5 * abs(_level(direction) @ row))
        found.append((cost, row, np.array(along)[:, None] * row))
    _, row, offsets = min(found, key=lambda entry: entry[0])
    return row, offsets


def _level(vector: Array) -> Array:
    flat = vector * np.array([1.0, 1.0, 0.0])
    result: Array = flat / max(float(np.linalg.norm(flat)), 1e-12)
    return result


def _across(direction: Array, row: Array) -> Array:
    """The direction, turned about the vertical so that it is not along the row."""
    level = _level(direction)
    if abs(level @ row) <= _ALONG:
        return direction
    side = np.array([-row[1], row[0], 0.0])
    turned = np.sign(level @ row) * row + (1.0 if level @ side >= 0.0 else -1.0) * side
    height = direction[2]
    result: Array = turned / np.linalg.norm(turned) * np.sqrt(1.0 - height**2) + np.array(
        [0, 0, height]
    )
    return result


def _moved(camera: Camera, by: Array) -> Camera:
    return Camera(
        position=camera.position + by,
        target=camera.target + by,
        up=camera.up,
        fov=camera.fov,
        near=camera.near,
    )


def _span(drawing: Drawing, row: Array) -> tuple[float, float]:
    """Extent of a result's people and static geometry along a direction, without planes.

    Objects do not count: they may fly away.
    """
    reach = []
    for person in drawing.result.people:
        for motion in (person.motion, person.recorded):
            along = person.body.joints(motion)[:, 0] @ row
            reach += [along.min() - _REACH, along.max() + _REACH]
    for item in drawing.statics.values():
        if not is_plane(item):
            along = item.at(0).vertices @ row
            reach += [along.min(), along.max()]
    return float(min(reach)), float(max(reach))


def is_plane(item: Item) -> bool:
    """Whether the item is an infinite plane."""
    return item.surface.cull == "back"


def floor_height(item: Item) -> float | None:
    """Height of a horizontal plane [m]; None: not a horizontal plane."""
    if not is_plane(item) or item.surface.fade is None:
        return None
    return float(item.surface.vertices[:, 2].mean())
