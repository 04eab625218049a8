"""Set-up time of a room of a million triangles before the first frame."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from halfphysics import _native
from halfphysics.bench.record import Options, Record
from halfphysics.bench.room import room, sizes
from halfphysics.bench.sides import measure


def tree(options: Options) -> Iterator[Record]:
    """Seconds for the mesh tree of both sizes, built and found again by its content."""
    once = replace(options, quick=True)  # a pass is long enough for a run
    for triangles in sizes(options):
        mesh = room(triangles).mesh
        vertices = np.ascontiguousarray(mesh.vertices)
        faces = np.ascontiguousarray(mesh.faces, dtype=np.int32)

        def found(v=vertices, f=faces) -> _native.MeshTree:  # type: ignore[no-untyped-def]
            return _native.MeshTree(v, f)

        def built(found=found) -> None:  # type: ignore[no-untyped-def]
            # The tree is not kept, so the next call builds it again.
            found()

        size = f"{len(faces):,} triangles"
        yield measure("tree", f"{size}, built", 1, once, ours=built, unit="s").record
        kept = found()
        yield measure("tree", f"{size}, again", 1, once, ours=found, unit="s").record
        del kept
