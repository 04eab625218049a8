"""Camera positions and directions of a film, frame by frame."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.render.look import WALL
from halfphysics.render.rasterizer import Camera
from halfphysics.render.result_meshes import Drawing, Item
from halfphysics.render.viewpoint import FOV, NEAR, choose_direction, facing, glass, spread

Array = NDArray[np.float64]

# Assumed distance of the skin from the joints [m].
_SKIN = 0.14
# Space around the story: a sixth.
_MARGIN = 1.16
# Time constants over which a following camera smooths its position and its distance [s].
_SMOOTH, _SMOOTH_DISTANCE = 0.45, 0.8
# Speed [degrees/s] and elevation [degrees] of a turning camera.
_TURN, _TURN_HEIGHT = 24.0, 14.0
# Elevations of the cameras around the person, and of the one above [degrees].
_SIDE_HEIGHT, _TOP_HEIGHT = 10.0, 74.0
# Azimuths from the person's facing direction [degrees].
_SIDES = {"front": 0.0, "left": 90.0, "back": 180.0, "right": -90.0}
# Smallest share of the picture's height for a person, with the whole story in view.
_LARGE_ENOUGH = 0.5
# Number of frames in which hiding statics are searched.
_LOOKS = 8


class Story:
    """Content of the picture: joints of people and ghosts, objects near people.

    Attributes:
        people: World positions of all joints in every frame (T, N, 3) [m].
        boxes: Corners of each object (T, 8, 3) [m] and whether it is near a person (T,).
    """

    def __init__(self, drawings: Sequence[Drawing], ghost: bool) -> None:
        self.drawings = drawings
        self.boxes: list[tuple[Array, NDArray[np.bool_]]] = []
        joints = []
        for drawing in drawings:
            own = []
            for person in drawing.result.people:
                motions = (person.motion, person.recorded) if ghost else (person.motion,)
                own += [person.body.joints(m) for m in motions]
            people = np.concatenate(own, axis=1)
            joints.append(people)
            self.boxes += [_box(item, people) for item in drawing.objects.values()]
        self.people: Array = np.concatenate(joints, axis=1)

    def __len__(self) -> int:
        return len(self.people)

    def at(self, frame: int) -> Array:
        """Points (N, 3) around all content at a frame."""
        around = _SKIN * np.concatenate([np.eye(3), -np.eye(3)])
        skin = (self.people[frame][:, None] + around).reshape(-1, 3)
        near = [corners[frame] for corners, shown in self.boxes if shown[frame]]
        return np.concatenate([skin, *near])

    def direction(self, size: tuple[int, int]) -> Array:
        """Unit direction to the camera with the best view of the story."""
        return choose_direction(self.drawings[0], spread(len(self), 6), size)

    def facing(self) -> Array:
        """Horizontal unit vector that people face, mean over the story."""
        ways = facing(self.drawings[0], spread(len(self), 9))
        mean = ways.mean(axis=0)
        result: Array = mean / np.linalg.norm(mean) if np.linalg.norm(mean) > 1e-6 else ways[0]
        return result


def _box(item: Item, people: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Corners of an object's bounding box over time, and whether it is near a person."""
    low, high = item.surface.vertices.min(axis=0), item.surface.vertices.max(axis=0)
    local = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    local = low + local * (high - low)
    corners = item.position[:, None] + rot.rotate(item.quaternion[:, None], local)
    centre = corners.mean(axis=1)
    gap = np.maximum(people.min(axis=1) - centre, centre - people.max(axis=1))
    return corners, np.linalg.norm(np.maximum(gap, 0.0), axis=1) < NEAR


def track(story: Story, name: str, size: tuple[int, int], rate: float) -> list[Camera]:
    """A camera per frame.

    Args:
        story: Content of the picture, in all frames.
        name: One of `CAMERAS`.
        size: Size of the picture [pixels]; only the ratio matters.
        rate: Frames of the story per second of film.
    """
    if name in _SIDES:
        level = _turned(story.facing(), _SIDES[name])
        return _following(story, [_raised(level, _SIDE_HEIGHT)] * len(story), size, rate)
    best = story.direction(size)
    if name == "follow":
        return _following(story, [best] * len(story), size, rate)
    if name == "top":
        return _following(story, [_raised(best, _TOP_HEIGHT)] * len(story), size, rate)
    if name == "orbit":
        turns = _TURN / rate * (np.arange(len(story)) - 0.5 * (len(story) - 1))
        ways = [_raised(_turned(best, angle), _TURN_HEIGHT) for angle in turns]
        return _following(story, ways, size, rate)
    fixed = _fixed(story, best, size)
    if name == "auto" and _height(story, fixed) < _LARGE_ENOUGH:
        return _following(story, [best] * len(story), size, rate)
    return [fixed] * len(story)


def _turned(direction: Array, degrees: float) -> Array:
    """`direction` turned about the vertical."""
    return rot.rotate(rot.exp(np.array([0.0, 0.0, np.radians(degrees)])), direction)


def _raised(direction: Array, degrees: float) -> Array:
    """`direction` with the same azimuth, at an elevation of `degrees`."""
    level = direction * np.array([1.0, 1.0, 0.0])
    level = level / np.linalg.norm(level)
    angle = np.radians(degrees)
    result: Array = np.cos(angle) * level + np.sin(angle) * np.array([0.0, 0.0, 1.0])
    return result


def _fixed(story: Story, direction: Array, size: tuple[int, int]) -> Camera:
    """The nearest camera that has the whole story in view."""
    points = np.concatenate([story.at(frame) for frame in range(len(story))])
    return Camera.framing(points, direction, size=size, fov=FOV, margin=_MARGIN)


def _height(story: Story, camera: Camera) -> float:
    """Share of the picture's height that people take, median over the story."""
    tangent = np.tan(np.radians(camera.fov) / 2)
    parts = []
    for frame in spread(len(story), 25):
        local = (story.people[frame] - camera.position) @ camera.axes().T
        rows = local[:, 1] / (2 * tangent * local[:, 2])
        parts.append(float(np.ptp(rows)))
    return float(np.median(parts))


def _following(
    story: Story, directions: Sequence[Array], size: tuple[int, int], rate: float
) -> list[Camera]:
    """Cameras aimed at the middle of the story, near, with all of it in view, smoothly moved."""
    points = [story.at(frame) for frame in range(len(story))]
    middles = np.array([0.5 * (p.min(axis=0) + p.max(axis=0)) for p in points])
    targets = _smooth(middles, _SMOOTH * rate)
    tan_y = np.tan(np.radians(FOV) / 2) / _MARGIN
    tan_x = tan_y * size[0] / size[1]
    needed = np.empty((len(story), 1))
    for k, (own, target, direction) in enumerate(zip(points, targets, directions, strict=True)):
        right, down, _ = Camera(position=direction).axes()
        local = (own - target) @ np.stack([right, down, direction]).T
        wide = np.maximum(abs(local[:, 0]) / tan_x, abs(local[:, 1]) / tan_y) + local[:, 2]
        needed[k] = wide.max()
    # Largest within the filter's reach: the smoothed distance is never below the needed one.
    width = _SMOOTH_DISTANCE * rate
    distances = _smooth(_largest(needed, _reach(width)), width)
    return [
        Camera(position=target + float(distance) * direction, target=target, fov=FOV)
        for target, distance, direction in zip(targets, distances[:, 0], directions, strict=True)
    ]


def _reach(width: float) -> int:
    """Half width [frames] of the filter, for a Gaussian of `width` frames."""
    return max(1, int(np.ceil(2.5 * width)))


def _smooth(path: Array, width: float) -> Array:
    """A path (T, D) smoothed with a Gaussian of `width` frames; beyond the ends it is constant."""
    reach = _reach(width)
    weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) / max(width, 1e-6)) ** 2)
    weights /= weights.sum()
    padded = np.concatenate([path[:1]] * reach + [path] + [path[-1:]] * reach)
    columns = [np.convolve(column, weights, mode="valid") for column in padded.T]
    return np.stack(columns, axis=1)


def _largest(values: Array, reach: int) -> Array:
    """Maximum of each value (T, 1) and `reach` values on either side."""
    padded = np.pad(values, ((reach, reach), (0, 0)), mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * reach + 1, axis=0)
    result: Array = windows.max(axis=-1)
    return result


def hiding(drawing: Drawing, cameras: Sequence[Camera], size: tuple[int, int]) -> set[str]:
    """Names of the statics that hide the story in any frame: they are drawn as glass.

    If one piece of furniture ("table", "table_leg_1") hides it, all its pieces are named.
    """
    faint: set[str] = set()
    for frame in spread(len(cameras), _LOOKS):
        faint |= glass(drawing.surfaces(frame), cameras[frame], size)
    furniture = {
        name: name.split("_")[0]
        for name, item in drawing.statics.items()
        if item.surface.color != WALL and item.surface.cull != "back"
    }
    pieces = {furniture[name] for name in faint if name in furniture}
    return faint | {name for name, piece in furniture.items() if piece in pieces}
