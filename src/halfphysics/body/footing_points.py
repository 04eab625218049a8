"""Points of the skin by which a person stands, sits and lies: soles, hands, some all over.

What the core's footing (src/native/footing) looks under. A point is carried by the two joints that
weigh most on its vertex; pose blend shapes, of a millimetre or two there, are left out.

They are chosen on the left, with their mirror images on the right (`body/symmetry.py`): a person in
a mirrored scene stands as the mirror image does. A skin that is not its own mirror image has those
of each side by themselves.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from halfphysics.motion.skeleton import JOINT_INDEX, JOINT_NAMES

if TYPE_CHECKING:
    from halfphysics.body.body import Body

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

SIDES = ("left", "right")
#: Cells along and across a sole, of which each gives its lowest vertex: 3 cm apart on an adult.
SOLE_CELLS = (8, 3)
#: Height of a sole above a foot's lowest vertex, relative to the stature: 2 cm on an adult.
SOLE_HEIGHT = 0.012
#: Weight of ankle and toes in the vertices of a foot, of which the sole is.
FOOT_WEIGHT = 0.6
#: Directions along the ground in each of which a sole gives its farthest vertex, some 2 cm apart:
#: without, an edge that the skin of a heel lies on is seen from 2 cm on, and the foot comes down.
OUTLINE_DIRECTIONS = 24
#: Number of further points all over a foot, some 2 cm apart: toe caps and heels touch ground too.
FOOT_POINTS = 40
#: Number of points on the rest of the skin: some 10 cm apart. With 72, in pairs of images, somebody
#: who sits down on a bed was pushed 26 cm aside instead of 9.
SKIN_POINTS = 150
#: Number of points on both hands: some 4 cm apart, fingertips among them.
HAND_POINTS = 40
#: Parts of hands: they do not rest as a body does, they reach.
_HAND = ("wrist", "index", "middle", "ring", "pinky", "thumb")
#: Further parts on which nobody sits or lies: feet have soles, a face has no seat.
_NOT_RESTING = (*_HAND, "ankle", "foot", "eye", "jaw")


@dataclass(frozen=True)
class FootingPoints:
    """Points of one body's skin at rest.

    Attributes:
        joints: The two joints that carry each (n, 2), indices into `JOINT_NAMES`.
        weights: Their weights (n, 2), which sum to one.
        local: Where the point is in the frames of both (n, 2, 3) [m].
        normals: Outward normals at rest (n, 3), in the rest frame.
        soles: Number of points of the left and the right sole; these come first.
        hands: Number of points of both hands; these come last.
    """

    joints: Ints
    weights: Array
    local: Array
    normals: Array
    soles: tuple[int, int]
    hands: int


def footing_points(body: Body) -> FootingPoints:
    """The points of a body, made once."""
    found = _MADE.get(body)
    if found is None:
        found = _MADE[body] = _made(body)
    return found


_MADE: WeakKeyDictionary[Body, FootingPoints] = WeakKeyDictionary()


def _made(body: Body) -> FootingPoints:
    image = None if body.symmetry is None else body.symmetry.vertex
    rest = body.rest_vertices if body.symmetry is None else body.symmetry.even(body.rest_vertices)
    soles = [_sole(body, rest, side) for side in SIDES]
    hands = np.flatnonzero(_carried_by(body, _HAND))
    resting = np.flatnonzero(~_carried_by(body, _NOT_RESTING))
    if image is not None:
        soles[1] = image[soles[0]]
    skin = _far_apart(rest, resting, SKIN_POINTS, image)
    hands = _far_apart(rest, hands, HAND_POINTS, image)
    vertex = np.concatenate([*soles, skin, hands])
    joints = np.argsort(-body.weights[vertex], axis=1, kind="stable")[:, :2]
    weights = np.take_along_axis(body.weights[vertex], joints, axis=1)
    weights = weights / weights.sum(axis=1, keepdims=True)
    local = body.rest_vertices[vertex][:, None] - body.rest_joints[joints]
    normals = _normals(body)[vertex]
    counts = (len(soles[0]), len(soles[1]))
    return FootingPoints(joints, weights, local, normals, counts, len(hands))


def _sole(body: Body, rest: Array, side: str) -> Ints:
    """The lowest vertex of each cell of a sole, its outline, and points all over the foot."""
    of_foot = [JOINT_INDEX[f"{side}_ankle"], JOINT_INDEX[f"{side}_foot"]]
    vertex = np.flatnonzero(body.weights[:, of_foot].sum(axis=1) > FOOT_WEIGHT)
    if not len(vertex):
        return vertex
    foot, (x, height, along) = vertex, rest[vertex].T
    low = height < height.min() + SOLE_HEIGHT * body.stature
    vertex, x, height, along = vertex[low], x[low], height[low], along[low]
    cell = _cells(along, SOLE_CELLS[0]) * SOLE_CELLS[1] + _cells(x, SOLE_CELLS[1])
    order = np.lexsort((vertex, height, cell))
    first = np.unique(cell[order], return_index=True)[1]
    lowest, spread = vertex[order[first]], _far_apart(rest, foot, FOOT_POINTS, None)
    angle = 2.0 * np.pi * np.arange(OUTLINE_DIRECTIONS) / OUTLINE_DIRECTIONS
    way = np.outer(np.cos(angle), x - x.mean()) + np.outer(np.sin(angle), along - along.mean())
    outline = vertex[way.argmax(axis=1)]
    sole: Ints = np.unique(np.concatenate([lowest, outline, spread]))
    return sole


def _cells(x: Array, count: int) -> Ints:
    size = max(float(np.ptp(x)), 1e-9)
    cell: Ints = np.minimum((count * (x - x.min()) / size).astype(np.int64), count - 1)
    return cell


def _carried_by(body: Body, parts: tuple[str, ...]) -> NDArray[np.bool_]:
    """Per vertex (V,): it weighs most on a joint whose name has one of these parts."""
    named = np.array([any(part in name for part in parts) for name in JOINT_NAMES])
    carried: NDArray[np.bool_] = named[body.weights.argmax(axis=1)]
    return carried


def _far_apart(rest: Array, vertex: Ints, count: int, image: Ints | None) -> Ints:
    """So many of some vertices, each as far as can be from those before it; the lowest first.

    With the `image` of each vertex (V,) the image of what is chosen is chosen next; one that is in
    the middle may be left over, so there may be one less.
    """
    if not len(vertex):
        return vertex
    at = rest[vertex]
    chosen: list[int] = []
    distance = np.where(at[:, 1] == at[:, 1].min(), np.inf, np.finfo(np.float64).max)
    while len(chosen) < min(count, len(at)):
        k = int(np.argmax(distance))
        found = [int(vertex[k])]
        if image is not None and image[found[0]] != found[0]:
            found.append(int(image[found[0]]))
        if len(chosen) + len(found) > count:
            break
        for one in found:
            chosen.append(one)
            distance = np.minimum(distance, ((at - rest[one]) ** 2).sum(axis=1))
    return np.array(chosen, dtype=np.int64)


def _normals(body: Body) -> Array:
    a, b, c = (body.rest_vertices[body.faces[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    total = np.zeros_like(body.rest_vertices)
    for k in range(3):
        np.add.at(total, body.faces[:, k], normal)
    size = np.linalg.norm(total, axis=1, keepdims=True)
    unit: Array = total / np.where(size > 0, size, 1.0)
    return unit
