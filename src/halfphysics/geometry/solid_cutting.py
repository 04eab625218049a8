"""A solid cut into convex pieces by coacd (Wei et al. 2022), at the precision that contact needs.

coacd wants a surface that is closed and a manifold. Left to itself it makes one of voxels of a
fiftieth of the longest extent (2 cm of a chair, which then sticks out of itself by 1 cm), and
searches its cuts with ten times the effort that pays: 50 s of a processor for a chair, whatever its
number of triangles. Here a solid is prepared by `remesh` and `simplify`, each of which keeps within
the threshold, and cut with less search: a chair of 140,000 triangles takes 6 s and is 5 mm off.

coacd uses all cores (OMP_NUM_THREADS limits them); the pieces are the same for any number of them.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from halfphysics.errors import InputError, MissingDependencyError
from halfphysics.geometry.box_frame import box_frame
from halfphysics.geometry.mesh import Mesh
from halfphysics.geometry.piece_error import Hull, distance_to_union
from halfphysics.geometry.remesh import cell_for, remeshed
from halfphysics.geometry.simplify import is_manifold, simplified

#: The command that installs coacd.
MEND = "pip install 'halfphysics[pieces]'"

#: Triangles that are cut: more take longer and are no better.
_TRIANGLES = 8_000
#: Triangles that are simplified as they are; a surface of more is made anew, of so many quads.
_MOST_TRIANGLES, _QUADS = 100_000, 40_000
#: Share of the threshold by which simplifying may move the surface.
_SHARE = 0.5
#: coacd's search: of 166 pieces against 122 for a chair, in a third of the time.
_SEARCH = {"mcts_iterations": 15, "mcts_nodes": 10, "mcts_max_depth": 1}
#: The range of coacd's own threshold, a share of half the longest extent.
_LEAST, _MOST = 0.01, 1.0
#: An error of more, as a multiple of what is asked of coacd, is no matter of the threshold: cuts
#: went wrong, and another surface may do.
_WRONG = 5.0
#: Points of the surface at which it is looked for.
_LOOKS = 5_000


def pieces_of(solid: Mesh, threshold: float, most: int) -> list[Mesh]:
    """Convex pieces of a solid; always the same.

    Args:
        solid: Holes bridged or not.
        threshold: Target for how far pieces stick out of it [m].
        most: Largest number of pieces; -1: any.

    Raises:
        MissingDependencyError: coacd is not installed.
    """
    try:
        import coacd
    except ImportError as error:
        raise MissingDependencyError(f"cutting a mesh into pieces needs coacd: {MEND}") from error
    coacd.set_log_level("error")
    frame = box_frame(solid)
    if frame is None:
        return _best(coacd, solid, threshold, most)
    turned = Mesh(solid.vertices @ frame, solid.faces)
    found = _best(coacd, turned, threshold, most)
    return [Mesh(piece.vertices @ frame.T, piece.faces).hull for piece in found]


def _best(coacd: object, solid: Mesh, threshold: float, most: int) -> list[Mesh]:
    """Pieces of a solid in its own frame: those of the surface that serves best."""
    best, least = [solid.hull], math.inf
    for surface in _surfaces(solid, threshold):
        pieces = _cut(coacd, surface, threshold, most, clean=surface is not solid)
        if not pieces:
            continue
        worst = _worst(solid, pieces)
        if worst < least:
            best, least = pieces, worst
        if least <= _WRONG * max(threshold, _LEAST * _half(solid)) or most > 0:
            break
    return best


def _surfaces(solid: Mesh, threshold: float) -> Iterator[Mesh]:
    """Surfaces to cut in place of the solid, the best first."""
    fine = is_manifold(solid.faces)
    if fine and len(solid.faces) <= _MOST_TRIANGLES:
        yield _fewer(solid, threshold)
    new = None
    with contextlib.suppress(InputError):  # nothing of it is left
        new = _fewer(remeshed(solid, cell_for(solid, _QUADS, threshold)), threshold)
    if new is not None:
        yield new
    yield solid


def _fewer(solid: Mesh, threshold: float) -> Mesh:
    if len(solid.faces) <= _TRIANGLES:
        return solid
    return simplified(solid, _TRIANGLES, _SHARE * threshold)


def _worst(solid: Mesh, pieces: list[Mesh]) -> float:
    """Roughly how far pieces stick out of a solid, or it out of them [m]."""
    hulls = [Hull(piece) for piece in pieces]
    # Corners, and the middles of faces: a hull over a hollow has its corners on the solid.
    skin = np.concatenate([p.vertices[p.faces].mean(axis=1) for p in pieces])
    skin = np.concatenate([skin, *(piece.vertices for piece in pieces)])
    out = skin[~solid.query.inside(skin)]
    outside = float(solid.query.closest(out)[0].max()) if len(out) else 0.0
    bare = solid.vertices[:: -(-len(solid.vertices) // _LOOKS)]
    for hull in hulls:
        bare = bare[~hull.holds(bare)]
    if not len(bare):
        return outside
    return max(outside, float(distance_to_union(hulls, bare).max()))


def _cut(coacd: object, surface: Mesh, threshold: float, most: int, *, clean: bool) -> list[Mesh]:
    """Convex pieces of a surface; `clean`: it needs no voxels, which thicken it."""
    found = coacd.run_coacd(  # type: ignore[attr-defined]
        coacd.Mesh(surface.vertices, surface.faces),  # type: ignore[attr-defined]
        threshold=min(max(threshold / _half(surface), _LEAST), _MOST),
        max_convex_hull=most,
        preprocess_mode="off" if clean or is_manifold(surface.faces) else "auto",
        # Merging takes as long as the cuts and mostly joins few; a limit is kept by it alone.
        merge=most > 0,
        seed=0,
        **_SEARCH,
    )
    pieces = []
    for vertices, _ in found:
        points = vertices[np.isfinite(vertices).all(axis=1)]
        try:
            hull = Mesh(points, _any_faces(len(points))).hull
        except InputError:  # a sliver without volume: its neighbours cover it
            continue
        if math.isfinite(hull.volume) and hull.volume > 0.0:
            pieces.append(hull)
    return pieces


def _half(mesh: Mesh) -> float:
    """Half the longest extent [m]: coacd's unit."""
    return 0.5 * float(np.ptp(mesh.vertices, axis=0).max())


def _any_faces(count: int) -> NDArray[np.int32]:
    """Triangles that name every one of `count` vertices: of a hull only the points matter."""
    if count < 3:
        return np.zeros((0, 3), dtype=np.int32)
    i = np.arange(count, dtype=np.int32)
    return np.stack([i, np.roll(i, -1), np.roll(i, -2)], axis=1)
