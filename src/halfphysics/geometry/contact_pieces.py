"""The shape that an object collides with: itself, its convex hull or convex pieces."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from halfphysics.base.reader_warnings import warn
from halfphysics.base.validation import number, shown
from halfphysics.errors import InputError, MissingDependencyError
from halfphysics.geometry.convex_decomposition import (
    WARN_MM,
    Cut,
    Decomposition,
    checked_pieces,
    decompose,
    judged,
)
from halfphysics.geometry.mesh import Mesh
from halfphysics.geometry.shape_base import Shape
from halfphysics.geometry.solid_cutting import MEND


def asked(
    what: str, given: Shape, pieces: Any, threshold: float, max_pieces: int | None
) -> tuple[list[Mesh] | None, Cut]:
    """The caller's own pieces, if given, and the checked options."""
    if max_pieces is not None:
        most = number(max_pieces, f"{what}: max_pieces", least=1.0)
        if most != int(most):
            raise InputError(f"{what}: max_pieces: expected a whole number, found {most:g}")
        max_pieces = int(most)
    threshold = number(threshold, f"{what}: threshold", above=0.0, unit="m")
    if isinstance(pieces, str):
        if pieces not in ("auto", "hull"):
            raise InputError(
                f'{what}: pieces: found {shown(pieces)}, expected "auto", "hull" or convex meshes'
            )
        return None, Cut(pieces=pieces, threshold=threshold, max_pieces=max_pieces)
    if not isinstance(pieces, list | tuple):
        raise InputError(
            f'{what}: pieces: found {type(pieces).__name__}, expected "auto", "hull" or a list of '
            "convex meshes"
        )
    if not isinstance(given, Mesh):
        raise InputError(
            f"{what}: pieces are for meshes; a {type(given).__name__} touches as it is"
        )
    return checked_pieces(what, pieces), Cut(pieces="given")


def touching(
    what: str, given: Shape, cut: Cut, own: list[Mesh] | None
) -> tuple[Shape, Decomposition | None]:
    """The solid and the convex pieces that collide; warns of inaccurate pieces and open meshes."""
    if not isinstance(given, Mesh):
        return given, None
    try:
        hull = given.hull
    except InputError as error:
        raise InputError(f"{what}: {error}") from None
    said = []
    if own is not None:
        made = judged(given, own)
    elif given.is_convex:
        return hull, None
    elif cut.pieces == "hull":
        made = judged(given, [hull])
    else:
        try:
            made = decompose(given, cut)
        except MissingDependencyError:
            made = judged(given, [hull])
            added = f", which adds {made.volume_percent:.1f} % to its volume"
            said.append(
                "the mesh is not convex, and cutting it into pieces needs coacd, which is not "
                f"installed: it touches as its convex hull{added if given.solid_volume else ''}. "
                f'Install it ({MEND}), give pieces=[convex meshes], or say pieces="hull"'
            )
    many = len(made.pieces)
    if not said and cut.pieces != "hull" and max(made.outside_mm, made.inside_mm) > WARN_MM:
        way = (
            "Own pieces are in the object's frame [m], after scale and up"
            if own is not None
            else "A smaller threshold= or a larger max_pieces= cuts finer; pieces=[convex meshes] "
            "gives your own"
        )
        said.append(
            f"its {many} pieces stick out of the mesh by up to {made.outside_mm:.1f} mm and leave "
            f"up to {made.inside_mm:.1f} mm of it bare. {way}"
        )
    if not given.closed:
        said.append(
            f"the mesh is not a closed surface: its holes count as filled, "
            f"mass and inertia are spread over its {f'{many} pieces' if many > 1 else 'hull'}"
        )
    for text in said:  # shown at the caller of `Scene.add_object`
        warn(f"{what}: {text}.")
    if many == 1:
        return made.pieces[0], made
    return given if given.closed else joined(made.pieces), made


def joined(pieces: Sequence[Shape]) -> Mesh:
    """Pieces as one mesh."""
    vertices, faces, count = [], [], 0
    for piece in pieces:
        v, f = piece.triangles()
        vertices.append(v)
        faces.append(f + count)
        count += len(v)
    return Mesh(np.concatenate(vertices), np.concatenate(faces))
