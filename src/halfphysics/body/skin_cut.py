"""Division of a skin into pieces with tight convex hulls: by joints, then where hulls bulge most.

The bulge of a hull over a face is measured along the face's normal, from the face to the exit from
the hull, as the distance of the exit from all skin: it is zero if the exit is inside other skin and
small in a crease. It is evaluated in a few bent poses, because hollows open and close. Cuts are
planes of the rest pose; each next cut is the one that reduces most

    sum over poses, hulls and faces of area * bulge^2

(greedily: the best cut of a piece is computed when its whole sum is the largest one left).
Of a skin that is its own mirror image the pieces are, too: those of the left are cut, and with them
their images; what is in the middle is cut across, or into its two sides, which then are images.
Hulls are approximated by their support in some hundred directions, faces by samples. The
approximation only selects cuts; that the hulls cover the skin does not depend on it.
"""

from __future__ import annotations

import heapq
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from halfphysics.body import skinning
from halfphysics.motion.skeleton import (
    JOINT_INDEX,
    LEFT_HAND_JOINTS,
    MIRRORED,
    N_JOINTS,
    RIGHT_HAND_JOINTS,
)

Array = NDArray[np.float64]
Floats = NDArray[np.float32]
Ints = NDArray[np.int64]

#: Number of pieces of the skin, one or more per joint.
PIECES = 90
#: Number of faces that sample a part's neighbourhood: one in 16, at least and at most.
SAMPLES = (64, 256)
#: Normals of a piece that stand for its hull's, and directions of the sphere beside them. Twice as
#: many of these and of the samples change the gaps by under a tenth.
NORMALS, SPHERE = 32, 64
#: Number of positions along each axis at which a cut is evaluated.
LEVELS = 5
#: A part's hulls are compared with all faces whose weight of it is at least this: a hull also
#: bulges over the faces beside it.
BLEND = 0.2
#: Steps [m] along a normal at which the distance from all skin is computed; constant beyond.
STEPS = (0.0, 0.005, 0.01, 0.02, 0.04)
#: Factor of the area of hands: they are small, and touch most.
HAND_FACTOR = 5.0
#: Left and right bulge alike: of what differs by less than this share the first counts, so that
#: rounding does not choose, and machines agree.
TIE = 1e-3
#: Lift of a level [m]: more than rounding, less than anything else.
NUDGE = 1e-6
#: Directions within about this cosine of a right angle to a normal say nothing about its bulge.
GRAZING = 0.05

#: Where each step starts and how long it is, against (steps, P, m).
_STARTS = np.array(STEPS[:-1], dtype=np.float32)[:, None, None]
_WIDTHS = np.diff(STEPS).astype(np.float32)[:, None, None]

_HANDS = [
    *(JOINT_INDEX["left_wrist"], *LEFT_HAND_JOINTS),
    *(JOINT_INDEX["right_wrist"], *RIGHT_HAND_JOINTS),
]
_FINGERS = tuple(f"{f}{k}" for f in ("index", "middle", "pinky", "ring") for k in (1, 2, 3))
#: Rotations [rad] that open and close the hollows of a body, given for the left side; the right
#: side is the mirror image. Sitting; standing, arched; arms up, legs apart; and at rest.
_BENDS: tuple[dict[str, tuple[float, float, float]], ...] = (
    {},
    {
        "hip": (-1.6, 0.1, 0.2), "knee": (1.9, 0.0, 0.0), "ankle": (-0.4, 0.0, 0.0),
        "foot": (-0.4, 0.0, 0.0), "spine1": (0.3, 0.0, 0.0), "spine2": (0.3, 0.0, 0.0),
        "spine3": (0.2, 0.0, 0.0), "neck": (0.3, 0.0, 0.0), "head": (0.3, 0.0, 0.0),
        "shoulder": (0.0, -0.9, -0.5), "elbow": (0.0, -2.0, 0.0), "wrist": (0.0, 0.0, -0.6),
        "jaw": (0.2, 0.0, 0.0), **dict.fromkeys(_FINGERS, (0.0, 0.0, -1.2)),
    },
    {
        "hip": (0.2, 0.0, 0.0), "knee": (0.4, 0.0, 0.0), "ankle": (0.5, 0.0, 0.0),
        "spine1": (-0.15, 0.0, 0.1), "spine2": (-0.15, 0.0, 0.1), "neck": (-0.3, 0.2, 0.0),
        "head": (-0.2, 0.2, 0.0), "collar": (0.0, 0.0, -0.1), "shoulder": (0.0, 0.0, -1.2),
        "elbow": (0.0, -0.4, 0.0), "wrist": (0.0, 0.0, 0.6),
        **dict.fromkeys(_FINGERS, (0.0, 0.0, -0.4)),
    },
    {
        "hip": (-0.7, 0.0, 0.3), "knee": (1.0, 0.0, 0.0), "spine1": (0.1, 0.2, 0.0),
        "spine2": (0.1, 0.2, 0.0), "collar": (0.0, 0.0, 0.25), "shoulder": (0.0, 0.0, 1.1),
        "elbow": (0.0, -1.0, 0.0), **dict.fromkeys(_FINGERS, (0.0, 0.0, -0.7)),
    },
)  # fmt: skip


def bends() -> Array:
    """Rotations of the poses in which bulges are evaluated, shape (P, 55, 3)."""
    out = np.zeros((len(_BENDS), N_JOINTS, 3))
    for rotations, bend in zip(out, _BENDS, strict=True):
        for joint, turn in bend.items():
            if joint in JOINT_INDEX:
                rotations[JOINT_INDEX[joint]] = turn
            else:
                rotations[JOINT_INDEX[f"left_{joint}"]] = turn
                rotations[JOINT_INDEX[f"right_{joint}"]] = np.multiply(turn, (1.0, -1.0, -1.0))
    return out


def parts_of_faces(faces: Ints, weights: Array) -> Ints:
    """The joint with the largest summed weight of each face, shape (F,)."""
    a, b, c = faces.T
    result: Ints = (weights[a] + weights[b] + weights[c]).argmax(axis=1)
    return result


def cut_faces(
    faces: Ints,
    weights: Array,
    rest_vertices: Array,
    rest_joints: Array,
    pieces: int = PIECES,
    image: Ints | None = None,
) -> list[Ints]:
    """Face indices of each piece, ascending: every face in one piece, no piece empty.

    Args:
        faces: Triangles, shape (F, 3).
        weights: Skinning weights, shape (V, 55).
        rest_vertices: Skin at rest [m], shape (V, 3).
        rest_joints: Joints at rest [m], shape (55, 3).
        pieces: Number of pieces. There are more if more joints have faces, fewer if there are
            fewer faces.
        image: Of each face its mirror image (F,); None: the skin has none. The image of every
            piece is one of the pieces.
    """
    part = parts_of_faces(faces, weights)
    if image is not None and (part[image] != MIRRORED[part]).any():
        image = None
    done = dict(enumerate(_first_units(part, image)))
    if not done:
        return []
    look = _Look(faces, weights, rest_vertices, rest_joints)
    number = len(done)
    count = sum(unit.size for unit in done.values())
    # Entries: minus the bulge of a piece that a cut could take away at most, or does take away once
    # the cut is known; number of the unit; the cut.
    heap: list[tuple[float, int, list[_Unit] | None]]
    heap = [(-_coarse(look.at(part, unit).bulge()), k, None) for k, unit in done.items()]
    heapq.heapify(heap)
    while heap and count < pieces:
        _, k, cut = heapq.heappop(heap)
        if count + done[k].size > pieces:
            continue
        if cut is None:
            gain, cut = look.at(part, done[k]).best_cut()
            if cut is not None:
                heapq.heappush(heap, (-_coarse(gain), k, cut))
            continue
        count -= done.pop(k).size
        for unit in cut:
            done[number] = unit
            count += unit.size
            heapq.heappush(heap, (-_coarse(look.at(part, unit).bulge()), number, None))
            number += 1
    return [piece for unit in done.values() for piece in unit.pieces()]


class _Unit(NamedTuple):
    """A piece that is cut together with its mirror image.

    A piece without `image` is alone; one that is its own image is `middle`.
    """

    faces: Ints
    image: Ints | None  # of all faces (F,)
    middle: bool

    @property
    def size(self) -> int:
        """Number of its pieces."""
        return 1 if self.image is None or self.middle else 2

    def pieces(self) -> list[Ints]:
        if self.image is None or self.middle:
            return [self.faces]
        return [self.faces, np.sort(self.image[self.faces])]

    def halves(self, under: NDArray[np.bool_]) -> list[_Unit]:
        """The unit cut in two: faces that are `under` a plane, and the others."""
        return [self._replace(faces=self.faces[some]) for some in (under, ~under)]


def _first_units(part: Ints, image: Ints | None) -> list[_Unit]:
    """A unit for each part, for a left and a right part together."""
    units = []
    for k in np.unique(part).tolist():
        own = np.flatnonzero(part == k)
        if image is None or k <= MIRRORED[k]:
            units.append(_Unit(own, image, image is not None and k == MIRRORED[k]))
    return units


class _Samples(NamedTuple):
    """Faces (m,) around a part: the area that each represents, and the distances outside it."""

    face: Ints
    area: float | Floats  # (m,) [m^2]
    slope: Floats  # (steps, P, m) of the distance from all skin on the way out, step to step


class _Look:
    """A skin in its bent poses."""

    def __init__(self, faces: Ints, weights: Array, rest: Array, joints: Array) -> None:
        from scipy.spatial import cKDTree

        rotations = bends()
        root = np.broadcast_to(joints[0], (len(rotations), 3))
        frames = skinning.kinematics(rotations, root, joints)
        skin = skinning.Skin(rest_vertices=rest, rest_joints=joints, weights=weights, posedirs=None)
        posed = skinning.skin(skin, rotations, *frames)
        a, b, c = np.moveaxis(posed[:, faces], 2, 0)
        normal = np.cross(b - a, c - a)
        size = np.linalg.norm(normal, axis=2)
        self.faces = faces
        self.rest = rest
        self.rest_centre = rest[faces].mean(axis=1)
        self.posed = posed.astype(np.float32)  # (P, V, 3)
        self.centre = ((a + b + c) / 3.0).astype(np.float32)  # (P, F, 3)
        self.normal = (normal / np.maximum(size, 1e-30)[:, :, None]).astype(np.float32)
        self.share = weights[faces].mean(axis=1)
        hand = self.share[:, _HANDS].sum(axis=1)
        self.area = (0.5 * size[0] * (1.0 + (HAND_FACTOR - 1.0) * hand)).astype(np.float32)
        self.trees = [cKDTree(centre) for centre in self.centre]
        self.samples: dict[int, _Samples] = {}

    def at(self, parts: Ints, unit: _Unit) -> _Piece:
        """A piece of its part, of the parts of all faces (F,)."""
        piece = unit.faces
        part = int(parts[piece[0]])
        if part not in self.samples:
            near = np.flatnonzero(self.share[:, part] >= min(BLEND, self.share[piece, part].max()))
            count = min(max(len(near) // 16, SAMPLES[0]), SAMPLES[1])
            face = near[_spread(len(near), count)] if len(near) > count else near
            area = self.area[face] * np.float32(len(near) / len(face))
            self.samples[part] = _Samples(face, area, self._slopes(face))
        return _Piece(self, unit, self.samples[part])

    def _slopes(self, face: Ints) -> Floats:
        """Of the distance from all skin on the way out of each face, shape (steps - 1, P, m)."""
        away = np.zeros((len(STEPS), len(self.posed), len(face)), dtype=np.float32)
        for p, tree in enumerate(self.trees):
            outside = np.ones(len(face), dtype=bool)
            for k, step in enumerate(STEPS[1:], start=1):
                point = self.centre[p, face] + np.float32(step) * self.normal[p, face]
                # Its own face is that near, so something is found.
                distance, nearest = tree.query(point, distance_upper_bound=1.01 * step)
                offset = point - self.centre[p, nearest]
                outside &= (offset * self.normal[p, nearest]).sum(axis=1) > 0.0
                away[k, p] = np.where(outside, np.minimum(distance, step), 0.0)
        return np.diff(away, axis=0) / _WIDTHS


class _Piece:
    """A piece and its hull, seen from the samples of its part.

    Arrays run over directions first (K, P, m): sums and extremes over directions are then quick.
    """

    def __init__(self, look: _Look, unit: _Unit, samples: _Samples) -> None:
        self.look, self.unit, self.samples = look, unit, samples
        self.piece = piece = unit.faces
        self.vertices = np.unique(look.faces[piece])
        own = look.normal[:, piece[_spread(len(piece), NORMALS)]]
        # A hull's facets over hollows face as the mean of what is on either side.
        between = own + own[:, (np.arange(NORMALS) * 37 + 11) % NORMALS]
        size = np.linalg.norm(between, axis=2, keepdims=True)
        between = np.where(size > 0.3, between / np.maximum(size, 0.3), own)
        sphere = np.broadcast_to(_SPHERE, (len(own), SPHERE, 3))
        ways = np.concatenate([own, between, sphere], axis=1)  # (P, K, 3)
        normal = look.normal[:, samples.face].transpose(0, 2, 1)
        centre = look.centre[:, samples.face].transpose(0, 2, 1)
        facing = np.ascontiguousarray(np.matmul(ways, normal).transpose(1, 0, 2))
        facing = np.copysign(np.maximum(np.abs(facing), np.float32(GRAZING)), facing)
        self.height = np.ascontiguousarray(np.matmul(ways, centre).transpose(1, 0, 2))
        self.per = 1.0 / facing
        # Added to the way through each plane: only those ahead end it, only those behind begin it.
        behind = np.signbit(facing)
        self.end = np.float32(1e6) * behind
        self.begin = self.end - np.float32(1e6)
        self.scratch = np.empty_like(self.height), np.empty_like(self.height)
        self.support = np.matmul(look.posed[:, self.vertices], ways.transpose(0, 2, 1))  # (P, V, K)

    def bulge(self) -> float:
        """Of the whole piece."""
        return self._bulge(self.support.max(axis=1))

    def _bulge(self, support: Floats) -> float:
        """Of the hull with support (P, K)."""
        through, some = self.scratch
        np.subtract(support.T[:, :, None], self.height, out=through)
        through *= self.per
        leave = np.add(through, self.end, out=some).min(axis=0)
        enter = np.add(through, self.begin, out=some).max(axis=0)
        leave = np.where(enter < leave, leave, 0.0)
        passed = np.minimum(np.maximum(leave - _STARTS, 0.0), _WIDTHS)  # of each step
        seen = (self.samples.slope * passed).sum(axis=0)
        return float((self.samples.area * seen * seen).sum(dtype=np.float64))

    def best_cut(self) -> tuple[float, list[_Unit] | None]:
        """How much bulge the best cut takes away, and the two units; (0, None) if none does.

        What is in the middle may become one unit, of the left half and its image.
        """
        whole = self.bulge()
        gain: float = 0.0
        cut: list[_Unit] | None = None
        vertices, centres = self.look.rest[self.vertices], self.look.rest_centre[self.piece]
        for axis in self._axes(vertices):
            along, face_along = vertices @ axis, centres @ axis
            levels = np.unique(np.quantile(face_along, np.arange(1, LEVELS + 1) / (LEVELS + 1)))
            # A level is often a face's own height, and its mirror image's: both are below.
            levels = levels[levels > face_along.min()] + NUDGE
            levels = levels[levels <= face_along.max()]
            below, above = self._sides(np.searchsorted(levels, along, side="right"), len(levels))
            for k, level in enumerate(levels):
                # What is left over cannot grow: many levels are out after one look.
                left = whole - self._bulge(below[k])
                if left > gain * (1.0 + TIE):
                    left -= self._bulge(above[k + 1])
                if left > gain * (1.0 + TIE):
                    gain, cut = left, self.unit.halves(self._evenly(face_along < level))
        if self.unit.middle and self.unit.image is not None:
            half = self._left_half(self.unit.image)
            of_half = self.look.faces[half.faces]
            own = self.support[:, np.isin(self.vertices, of_half)].max(axis=1)
            left = whole - 2.0 * self._bulge(own)
            if left > gain * (1.0 + TIE):
                gain, cut = left, [half]
        return gain, cut

    def _axes(self, vertices: Array) -> Array:
        """Directions of cuts (n, 3): of a middle piece they lie in the plane of the mirror."""
        offsets = vertices - vertices.mean(axis=0)
        first = 1 if self.unit.middle else 0
        own = np.zeros((3 - first, 3))
        own[:, first:] = np.linalg.eigh((offsets.T @ offsets)[first:, first:])[1].T
        # Which way an axis points is up to rounding.
        own *= np.sign(own[np.arange(len(own)), np.abs(own).argmax(axis=1), None])
        return np.concatenate([own, np.eye(3)[first:]])

    def _sides(self, slab: Ints, levels: int) -> tuple[Floats, Floats]:
        """Supports of what is in slab k and below (levels + 1, P, K), and in slab k and above."""
        nothing = np.full((len(self.support), self.support.shape[2]), -1e6, dtype=np.float32)
        slabs = [
            self.support[:, slab == k].max(axis=1) if (slab == k).any() else nothing
            for k in range(levels + 1)
        ]
        below: Floats = np.maximum.accumulate(slabs, axis=0)
        above: Floats = np.maximum.accumulate(slabs[::-1], axis=0)[::-1]
        return below, above

    def _evenly(self, under: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Which faces are under a plane, the images of a middle piece as the faces themselves."""
        if not self.unit.middle or self.unit.image is None:
            return under
        chosen = np.zeros(len(self.look.faces), dtype=bool)
        left = self._left_half(self.unit.image).faces
        chosen[left] = under[np.searchsorted(self.piece, left)]
        chosen[self.unit.image[left]] = chosen[left]
        return chosen[self.piece]

    def _left_half(self, image: Ints) -> _Unit:
        """The faces of a middle piece at x > 0, by the image of all faces (F,)."""
        x = self.look.rest_centre[:, 0]
        left = self.piece[x[self.piece] > x[image[self.piece]]]
        return _Unit(left, image, middle=False)


def _coarse(value: float) -> float:
    """The value to about the share `TIE`."""
    mantissa, exponent = math.frexp(value)
    return math.ldexp(round(mantissa / TIE) * TIE, exponent)


def _spread(count: int, samples: int) -> Ints:
    """Numbers 0 to count - 1, evenly, shape (samples,); some twice where there are fewer."""
    return np.arange(samples) * count // samples


def _sphere(count: int) -> Floats:
    """Directions, evenly over the sphere: a golden spiral, shape (count, 3)."""
    k = np.arange(count) + 0.5
    z = 1.0 - 2.0 * k / count
    turn = np.pi * (1.0 + np.sqrt(5.0)) * k
    ring = np.sqrt(1.0 - z * z)
    return np.stack([ring * np.cos(turn), ring * np.sin(turn), z], axis=1).astype(np.float32)


_SPHERE = _sphere(SPHERE)
