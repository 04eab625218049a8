"""The skin of a motion, a few frames at a time."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Any

import numpy as np

from halfphysics.base.arrays import as_array
from halfphysics.base.progress import over
from halfphysics.metrics.argument_checks import Array

_BATCH = 32  # frames skinned at a time: about 10 MB of vertices


def frames_of(motion: Any) -> int:
    """Number of frames of a motion; 1 for a single pose."""
    return np.shape(motion.rotations)[0] if np.ndim(motion.rotations) == 3 else 1


def frames_in(motion: Any, part: slice) -> Any:
    """The frames `part` of a motion; all of it, or a single pose, as it is."""
    return motion if part == slice(0, frames_of(motion)) else motion[part]


def batches(frames: int, what: str) -> Iterator[slice]:
    """Slices of nearly equal length that cover all frames, none of a single frame of several.

    `what` is measured, for the progress bar.
    """
    edges = np.linspace(0, frames, -(-frames // _BATCH) + 1).round().astype(int)
    parts = [slice(int(i), int(j)) for i, j in itertools.pairwise(edges)]
    return over(parts, what, "frame", size=parts[0].stop)


def skin(motion: Any, body: Any, part: slice) -> Array:
    """Vertices (t, V, 3) of the frames `part` of a motion, or of a single pose [m]."""
    vertices = as_array(body.vertices(frames_in(motion, part)))
    return vertices.reshape(-1, *vertices.shape[-2:])
