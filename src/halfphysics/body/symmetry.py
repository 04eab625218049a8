"""The mirror image of a skin in itself: which vertex and which face is the image of which.

Bodies have a left and a right side, at x > 0 and x < 0 of the rest frame. What is chosen on a skin
(cuts, samples, points of the soles) is chosen on one side and taken over to the other, so that a
person in a mirrored scene has the mirrored problem.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

#: A vertex may be this far from where its image's mirror image is [m]: under the distance of
#: vertices of lips and eyelids, over what people's models differ by from side to side.
TOLERANCE = 1e-3
#: Most vertices of a skin: the numbers of three of them fit one integer.
LARGEST = 2_000_000
#: A point times this is its mirror image, in the rest frame.
FLIP = np.array([-1.0, 1.0, 1.0])


@dataclass(frozen=True, eq=False)
class Symmetry:
    """Images of a skin's vertices and faces; the image of an image is the thing itself.

    Attributes:
        vertex: Of each vertex its image (V,); itself: it is in the middle.
        face: Of each face its image (F,), never itself.
    """

    vertex: Ints
    face: Ints

    def even(self, rest_vertices: Array) -> Array:
        """The vertices (V, 3) [m] that are their own mirror image, nearest to the given ones.

        Those of a skin that is mirrored to the last bit are returned as they are.
        """
        even: Array = 0.5 * (rest_vertices + rest_vertices[self.vertex] * FLIP)
        return even

    def is_exact(self, rest_vertices: Array) -> bool:
        """Whether these vertices (V, 3) are mirrored to the last bit."""
        return bool((rest_vertices[self.vertex] * FLIP == rest_vertices).all())


def symmetry_of(faces: NDArray[np.integer], rest_vertices: Array) -> Symmetry | None:
    """The mirror image at x = 0 of a skin in itself; None if it has none.

    Args:
        faces: Triangles (F, 3).
        rest_vertices: Skin at rest [m], shape (V, 3).
    """
    if not len(faces) or len(rest_vertices) > LARGEST:
        return None
    vertex = _exact(rest_vertices)
    if vertex is None:
        vertex = _near(rest_vertices)
    if vertex is None:
        return None
    triangles = faces.astype(np.int64)
    size = len(rest_vertices)
    face = _same_rows(_keys(triangles, size), _keys(vertex[triangles], size))
    if face is None or (face == np.arange(len(face))).any():
        return None
    return Symmetry(vertex, face)


def _exact(points: Array) -> Ints | None:
    """Images of points that are mirrored to the last bit; no scipy, as a default body is."""
    mirrored = points * FLIP
    order, other = np.lexsort(points.T), np.lexsort(mirrored.T)
    found = points[order]
    if not np.array_equal(found, mirrored[other]) or (found[1:] == found[:-1]).all(axis=1).any():
        return None
    image = np.empty(len(points), dtype=np.int64)
    image[other] = order
    return image


def _near(points: Array) -> Ints | None:
    """Images of points that are mirrored within `TOLERANCE`."""
    from scipy.spatial import cKDTree

    distance, image = cKDTree(points).query(points * FLIP)
    image = np.asarray(image, dtype=np.int64)
    whole = distance.max() <= TOLERANCE and np.array_equal(image[image], np.arange(len(points)))
    return image if whole else None


def _keys(triangles: Ints, size: int) -> Ints:
    """Numbers (F,) that are equal where three vertices are, in any order, of `size` vertices."""
    a, b, c = np.sort(triangles, axis=1).T
    keys: Ints = (a * size + b) * size + c
    return keys


def _same_rows(keys: Ints, mirrored: Ints) -> Ints | None:
    """Of each key the row whose mirrored key it is; None unless that is one to one."""
    order, other = np.argsort(keys, kind="stable"), np.argsort(mirrored, kind="stable")
    found = keys[order]
    if not np.array_equal(found, mirrored[other]) or (found[1:] == found[:-1]).any():
        return None
    image = np.empty(len(keys), dtype=np.int64)
    image[other] = order
    return image
