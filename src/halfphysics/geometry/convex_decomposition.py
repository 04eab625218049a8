"""Convex decomposition of a mesh for contact: by coacd, cached by content, with a measured error.

A mesh is divided into its connected solids first (`mesh_parts`). A solid that is convex to within
the tolerance is kept: a table of boxes needs no decomposition. The others go to coacd
(`solid_cutting`). What takes longer than two seconds shows a progress bar at a terminal, and is
kept on the disk for the next time (`piece_cache`).
"""

from __future__ import annotations

import hashlib
import logging
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import progress as bars
from halfphysics.base.made_by import made_by
from halfphysics.base.stopwatch import Stopwatch
from halfphysics.errors import InputError
from halfphysics.geometry import piece_cache
from halfphysics.geometry.mesh import Mesh
from halfphysics.geometry.mesh_parts import bridged, solids_of
from halfphysics.geometry.piece_error import PieceError, piece_error
from halfphysics.geometry.solid_cutting import pieces_of

logger = logging.getLogger(__name__)

Array = NDArray[np.float64]

#: How far pieces may stick out of the mesh, unless said otherwise [m].
THRESHOLD = 0.003
#: Pieces that stick out of the mesh or leave it uncovered by more cause a warning [mm].
WARN_MM = 5.0
#: A solid that fills its hull to this is its hull where that sticks out by at most this share of
#: its longest extent.
_FULL, _SEAMS = 1.03, 0.02
#: What decides how pieces are made and measured: folders of the package, and other packages.
_CODE, _ENGINES = ("base", "geometry"), ("coacd", "trimesh")


@dataclass(frozen=True, kw_only=True)
class Cut:
    """Options: `pieces` "auto", "hull" or "given"; threshold [m] and largest number of pieces."""

    pieces: str = "auto"
    threshold: float = THRESHOLD
    max_pieces: int | None = None


USUAL = Cut()


@dataclass(frozen=True, kw_only=True, eq=False)
class Decomposition(PieceError):
    """Convex pieces that touch in place of a mesh, and how well they stand for it.

    `pieces` in the mesh's frame; `outside_mm`, `inside_mm` and `volume_percent` as in `PieceError`.
    """

    pieces: tuple[Mesh, ...] = field(repr=False)


def decompose(mesh: Mesh, cut: Cut) -> Decomposition:
    """Pieces of a mesh, from the cache or computed and cached; deterministic.

    Raises:
        MissingDependencyError: coacd is needed and is not installed.
        InputError: The mesh spans no volume.
    """
    key = content_key(mesh, cut)
    kept = piece_cache.read(key)
    if kept is not None and kept[1].shape == (3,):
        outside, inside, volume = kept[1].tolist()
        logger.debug("%d pieces of a mesh were kept (%s)", len(kept[0]), key[:12])
        return Decomposition(
            pieces=tuple(kept[0]), outside_mm=outside, inside_mm=inside, volume_percent=volume
        )
    clock = Stopwatch(logger)
    made = judged(mesh, _pieces(mesh.outward, cut))
    clock.done(
        "cut a mesh of %d triangles into %d convex pieces, %.1f mm off at most",
        len(mesh.faces),
        len(made.pieces),
        max(made.outside_mm, made.inside_mm),
    )
    figures = np.array([made.outside_mm, made.inside_mm, made.volume_percent])
    piece_cache.write(key, list(made.pieces), figures)
    return made


def judged(mesh: Mesh, pieces: Sequence[Mesh]) -> Decomposition:
    """Pieces with their error against the mesh, whose holes are closed as for cutting it."""
    whole = bridged(mesh.outward)
    return Decomposition(pieces=tuple(pieces), **asdict(piece_error(whole, pieces)))


def content_key(mesh: Mesh, cut: Cut) -> str:
    """Differs where vertices, faces or options do, and what makes pieces of them."""
    program = made_by(_CODE, packages=_ENGINES)
    digest = hashlib.sha256(f"{program} {cut.threshold!r} {cut.max_pieces} ".encode())
    for array in (mesh.vertices, mesh.faces):
        digest.update(repr(array.shape).encode())
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def checked_pieces(what: str, given: Sequence[object]) -> list[Mesh]:
    """The caller's own pieces: convex meshes or trimeshes, in the object's frame [m].

    Raises:
        InputError: None, no mesh, not convex, flat.
    """
    pieces = []
    for index, one in enumerate(given):
        here = f"{what}: pieces[{index}]"
        if not isinstance(one, Mesh):
            vertices, faces = getattr(one, "vertices", None), getattr(one, "faces", None)
            if vertices is None or faces is None:
                raise InputError(
                    f"{here}: found {type(one).__name__}, expected a convex Mesh or trimesh.Trimesh"
                )
            one = Mesh(vertices, faces)
        try:
            hull = one.hull
        except InputError as error:
            raise InputError(f"{here}: {error}") from None
        if not one.is_convex:
            more = 1000.0 * (hull.volume - one.solid_volume)
            raise InputError(
                f"{here}: is not convex (its hull has {more:.3g} litres more), expected convex, "
                'closed meshes; pieces="auto" cuts the mesh itself'
            )
        pieces.append(hull)
    if not pieces:
        raise InputError(f'{what}: pieces: found none, expected "auto", "hull" or convex meshes')
    return pieces


def _pieces(mesh: Mesh, cut: Cut) -> list[Mesh]:
    solids = solids_of(mesh, cut.threshold)
    most = cut.max_pieces
    if most is not None and len(solids) > most:
        solids = [mesh]
    hulls = [_hull_that_fits(solid, cut.threshold) for solid in solids]
    ragged = sum(hull is None for hull in hulls)
    each = -1 if most is None else 1 + (most - len(solids)) // max(ragged, 1)
    pieces: list[Mesh] = []
    todo = sum(len(s.faces) for s, hull in zip(solids, hulls, strict=True) if not hull)
    kept = piece_cache.folder()
    what = "cutting a mesh into convex pieces" + (f" (kept in {kept})" if kept else "")
    with bars.bar(todo, what, "triangle", unasked=True) as bar:
        for solid, hull in zip(solids, hulls, strict=True):
            if hull is not None:
                pieces.append(hull)
                continue
            pieces += pieces_of(solid, cut.threshold, each)
            bar.update(len(solid.faces))
    return pieces


def _hull_that_fits(solid: Mesh, threshold: float) -> Mesh | None:
    """The hull of a closed solid, if it sticks out by no more than the threshold.

    Of a solid that nearly fills its hull by a share of its size, unless a finer threshold than the
    usual is asked for: the seams of a cushion are hundreds of cuts, and minutes.
    """
    if not solid.closed:
        return None
    hull = solid.hull
    if hull.volume > 2.0 * solid.solid_volume:
        return None
    most = threshold
    if threshold >= THRESHOLD and hull.volume <= _FULL * solid.solid_volume:
        most = max(most, _SEAMS * float(np.ptp(solid.vertices, axis=0).max()))
    return hull if piece_error(solid, [hull]).outside_mm <= 1000.0 * most else None
