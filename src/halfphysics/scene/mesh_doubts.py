"""The warning that a static mesh seems to be in another unit, or to have another axis up."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from halfphysics.base.reader_warnings import warn
from halfphysics.geometry.mesh import Mesh, MeshSource
from halfphysics.geometry.room_check import doubts
from halfphysics.geometry.shape_base import Shape


def warn_of_doubts(
    what: str,
    shape: Shape,
    pose: Mapping[str, Any],
    source: MeshSource | None,
    scale: float,
    up: str | None,
) -> None:
    """Warn where a mesh from a file seems to be read wrongly and the caller did not say how.

    Args:
        what: Begins the message.
        shape: As it was read.
        pose: Its position and quaternion: who turns or moves it has looked at it.
        source: Its file; None: nothing is checked.
        scale, up: As the caller gave them.

    Warns:
        HalfPhysicsWarning: Its extent is that of a room in another unit, or its floor or its
            origin says that another axis is up.
    """
    if source is None or not isinstance(shape, Mesh) or (scale != 1.0 and up is not None):
        return
    found = doubts(shape, source.up)
    placed = bool(np.any(pose["position"]) or np.any(pose["quaternion"] != (1.0, 0.0, 0.0, 0.0)))
    if found.unit is not None and scale == 1.0:
        per, name = found.unit
        x, y, z = found.extent
        warn(
            f"{what}: the mesh is {x:.0f} x {y:.0f} x {z:.0f} m; is it in {name}? Then say "
            f"scale={per:g}"
        )
    if found.up is not None and up is None and not placed:
        warn(
            f"{what}: the mesh is read with {source.up} up, and its {found.up} axis is along its "
            f"height, by its floor or by where it begins; is {found.up} up? Then say "
            f"up='{found.up}' (up='{source.up}': it is right)"
        )
