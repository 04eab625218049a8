"""Sitting down on the sofa of a furnished room: seat, back and feet on finely divided meshes."""

from __future__ import annotations

from collections.abc import Iterator

from halfphysics.bench.clips import body
from halfphysics.bench.pressing import Play, pressed
from halfphysics.bench.record import Options, Record
from halfphysics.bench.room import room, sizes
from halfphysics.bench.sofa import sitting
from halfphysics.scene.scene import Scene

#: Final depth of the feet's target in the floor [m].
_FLOOR = 0.06


def settle(options: Options) -> Iterator[Record]:
    """Records of both sizes of the room, both drives."""
    motion = sitting(body(), floor=_FLOOR)
    if options.quick:
        motion = motion[20:40]
    for triangles in sizes(options):
        made = room(triangles)
        scene = Scene()
        scene.add_static("room", made.mesh)
        play = Play(motion=motion, scene=scene, hulls={"room": made.hulls})
        for record, _, _ in pressed("settle", f"{len(made.mesh.faces):,} triangles", play, options):
            yield record
