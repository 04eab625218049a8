"""How long a room of a million triangles takes before the first frame."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from halfphysics import _native
from halfphysics.bench.record import Options, Record
from halfphysics.bench.room import room, sizes
from halfphysics.bench.timing import alone


def tree(options: Options) -> Iterator[Record]:
    """Seconds for the tree of both sizes, built and found again by its content."""
    for triangles in sizes(options):
        mesh = room(triangles).mesh
        vertices = np.ascontiguousarray(mesh.vertices)
        faces = np.ascontiguousarray(mesh.faces, dtype=np.int32)

        def found(v=vertices, f=faces) -> _native.MeshTree:  # type: ignore[no-untyped-def]
            return _native.MeshTree(v, f)

        def built() -> None:
            # Nobody keeps it: the next one is built anew.
            found()

        once = Options(repeats=options.repeats, quick=True)  # a pass is long enough for a run
        yield Record(
            case="tree",
            setting=f"{len(faces):,} triangles, built",
            frames=1,
            unit="s",
            ours=alone(built, once).ours,
        )
        kept = found()
        yield Record(
            case="tree",
            setting=f"{len(faces):,} triangles, again",
            frames=1,
            unit="s",
            ours=alone(found, once).ours,
        )
        del kept
