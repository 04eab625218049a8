"""Choice of a camera direction from which the story is visible and not hidden by a wall."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.render.rasterizer import Camera, Surface, visible
from halfphysics.render.result_meshes import Drawing

Array = NDArray[np.float64]

FOV = 32.0
# Compared directions: azimuths of a full turn, at two elevations [degrees].
_AZIMUTHS = 16
_ELEVATIONS = (16.0, 28.0)
# Angle of a three-quarter view from the facing direction [degrees].
_THREE_QUARTER = 50.0
# Small pictures are enough to count hidden pixels.
_PROBE = (96, 72)
# They are no taller than this many times that width: more pixels tell no more.
_TALLEST = 4
# Number of frames that are evaluated to choose one direction for all.
_PROBE_FRAMES = 5
#: An object further from every person than this [m] does not pull the camera back.
NEAR = 1.6
# A static item that hides more than this share of the story is drawn as glass.
_HIDES = 0.02
# Weights of the score of a view: visible share, front view, view across the correction.
_OPEN, _FRONT, _ACROSS = 2.0, 0.3, 0.3
# Views with more than this share of the story visible are equal: hiding items become glass.
_ENOUGH = 0.85
# Scores that differ by less are equal: the first of them is taken.
_EQUAL = 1e-9


@dataclass(frozen=True, kw_only=True)
class Sight:
    """Visibility of the story from a camera.

    Attributes:
        share: Share of the story's picture that no static item hides, 0 to 1.
        hiding: Name of a static item -> the share of the story that it hides.
    """

    share: float
    hiding: Mapping[str, float]


def look_at(surfaces: Mapping[str, Surface], camera: Camera, size: tuple[int, int]) -> Sight:
    """Count, pixel by pixel, how much of the story is hidden and by which items.

    Args:
        surfaces: All surfaces at a frame (`Drawing.surfaces`); items `static/...` may hide.
        camera: The camera.
        size: Size of the counted picture [pixels]; use the ratio of the final picture.
    """
    statics = {n: s for n, s in surfaces.items() if n.startswith("static/")}
    story = [s for n, s in surfaces.items() if n not in statics]
    # The story has most triangles: it is drawn only once, the statics separately.
    alone, behind = visible(story, camera, size)
    nearest, depth = visible(list(statics.values()), camera, size)
    shown = alone >= 0
    total = int(shown.sum())
    if not total:
        return Sight(share=0.0, hiding={})
    before = shown & (depth < behind)
    hiding = {}
    for k, name in enumerate(statics):
        count = int((before & (nearest == k)).sum())
        if count:
            hiding[name] = count / total
    return Sight(share=1.0 - sum(hiding.values()), hiding=hiding)


def subject(drawing: Drawing, frame: int, story: Mapping[str, Surface]) -> Array:
    """World points (N, 3) that belong in the picture: people, ghosts and objects near them."""
    people = [s.vertices for n, s in story.items() if not n.startswith("object/")]
    points = list(people)
    # The corners of a coarse box are enough to measure how near an item is.
    low = np.array([p.min(axis=0) for p in people])
    high = np.array([p.max(axis=0) for p in people])
    for name, item in drawing.objects.items():
        vertices = story[name].vertices
        centre = item.position[min(frame, len(item.position) - 1)]
        gap = np.linalg.norm(np.maximum(np.maximum(low - centre, centre - high), 0.0), axis=1)
        if gap.min() < NEAR:
            points.append(vertices)
    return np.concatenate(points)


def spread(total: int, count: int) -> list[int]:
    """At most `count` frames of `total`, evenly spread, first and last among them."""
    return sorted({round(float(k)) for k in np.linspace(0, total - 1, min(count, total))})


def choose_direction(drawing: Drawing, frames: Sequence[int], size: tuple[int, int]) -> Array:
    """Unit world direction from the story to the camera, one for all frames.

    The best direction has no item in the way, shows the person three-quarter from the front,
    and is across the line between the body and its ghost, so that they appear apart.
    """
    picked = [frames[k] for k in spread(len(frames), _PROBE_FRAMES)]
    scenes = [drawing.surfaces(f) for f in picked]
    points = [subject(drawing, f, s) for f, s in _stories(picked, scenes)]
    ways, apart = facing(drawing, picked), _apart(drawing, picked)
    probe = _probe(size, _PROBE[0])

    def share(towards: Array) -> float:
        shares = [
            look_at(scene, Camera.framing(p, towards, size=probe, fov=FOV), probe).share
            for scene, p in zip(scenes, points, strict=True)
        ]
        return _OPEN * min(float(np.mean(shares)), _ENOUGH)

    candidates = [_candidate(e, a, ways, apart) for e in _ELEVATIONS for a in range(_AZIMUTHS)]
    most = np.array([rest for _, rest in candidates]) + _OPEN * _ENOUGH
    scores = np.full(len(candidates), -np.inf)
    # Pictures are drawn for the promising ones only: in an open scene, for those that tie.
    for k in np.argsort(-most, kind="stable"):
        if most[k] < scores.max() - 2.0 * _EQUAL:
            break
        towards, rest = candidates[k]
        scores[k] = share(towards) + rest
    best = candidates[int(np.argmax(scores > scores.max() - _EQUAL))][0]
    result: Array = best / np.linalg.norm(best)
    return result


def _candidate(elevation: float, azimuth: int, ways: Array, apart: Array) -> tuple[Array, float]:
    """A direction, and its score but for what hides the story."""
    around, up = azimuth * (2 * np.pi / _AZIMUTHS), np.radians(elevation)
    level = np.array([np.cos(around), np.sin(around), 0.0])
    towards = np.cos(up) * level + np.sin(up) * np.array([0, 0, 1.0])
    turned = np.arccos(np.clip(ways @ level, -1.0, 1.0))
    front = float(np.cos(turned - np.radians(_THREE_QUARTER)).mean())
    across = float(np.linalg.norm(np.cross(apart, level), axis=1).mean()) if len(apart) else 0.0
    return towards, _FRONT * front + _ACROSS * across


def _probe(size: tuple[int, int], width: int) -> tuple[int, int]:
    """A small picture of the ratio of one of `size`, `width` wide, or less where that is tall."""
    width = min(width, max(1, round(_TALLEST * width * size[0] / size[1])))
    return width, max(1, round(width * size[1] / size[0]))


def _stories(
    frames: Sequence[int], scenes: Sequence[Mapping[str, Surface]]
) -> list[tuple[int, dict[str, Surface]]]:
    return [
        (frame, {n: s for n, s in scene.items() if not n.startswith("static/")})
        for frame, scene in zip(frames, scenes, strict=True)
    ]


def _level(vectors: Array) -> Array:
    """Horizontal unit vectors; vertical ones are left out."""
    flat = vectors * np.array([1.0, 1.0, 0.0])
    norm = np.linalg.norm(flat, axis=1)
    result: Array = flat[norm > 1e-6] / norm[norm > 1e-6, None]
    return result


def facing(drawing: Drawing, frames: Sequence[int]) -> Array:
    """Level directions that the people's bodies face, shape (N, 3); at least one."""
    out = []
    for person in drawing.result.people:
        quaternion = person.body.joint_frames(person.motion)[1][list(frames), 0]
        out.append(rot.rotate(quaternion, np.array([0.0, 0.0, 1.0])))
    ways = _level(np.concatenate(out))
    return ways if len(ways) else np.array([[0.0, -1.0, 0.0]])


def _apart(drawing: Drawing, frames: Sequence[int]) -> Array:
    """Level directions from body to ghost, in frames where they are over a centimetre apart."""
    out = []
    for person in drawing.result.people:
        bodies = [person.body.joints(m)[list(frames)] for m in (person.motion, person.recorded)]
        offset = (bodies[1] - bodies[0]).mean(axis=1)
        out.append(offset[np.linalg.norm(offset, axis=1) > 0.01])
    return _level(np.concatenate(out))


def cameras(
    drawing: Drawing, frames: Sequence[int], direction: Array, size: tuple[int, int]
) -> list[Camera]:
    """A camera per frame that follows the story from one direction, at a nearly constant scale."""
    near = []
    for frame in frames:
        points = subject(drawing, frame, drawing.story(frame))
        near.append((points, Camera.framing(points, direction, size=size, fov=FOV)))
    distance = [float(np.linalg.norm(c.position - c.target)) for _, c in near]
    common = float(np.median(distance))
    return [
        Camera.framing(points, direction, size=size, fov=FOV, distance=common) for points, _ in near
    ]


def glass(surfaces: Mapping[str, Surface], camera: Camera, size: tuple[int, int]) -> set[str]:
    """Names of the static items that hide the story and should be drawn as glass."""
    probe = _probe(size, 2 * _PROBE[0])
    faint: set[str] = set()
    scene = dict(surfaces)
    # Items behind the first wall hide the story as well: search again without those found.
    for _ in range(len(surfaces)):
        hiding = look_at(scene, camera, probe).hiding
        found = {name for name, share in hiding.items() if share > _HIDES}
        if not found:
            break
        faint |= found
        for name in found:
            del scene[name]
    return faint
