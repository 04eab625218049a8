"""Objects as a data set recorded them, put into a scene."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.reader_warnings import warn
from halfphysics.errors import FileError, InputError
from halfphysics.formats.format import Options
from halfphysics.geometry.mesh_files import load_mesh
from halfphysics.results.result import ObjectTrack

if TYPE_CHECKING:
    from halfphysics.scene.scene import Scene

Array = NDArray[np.float64]

#: Density of household things where the data set does not weigh them [kg/m^3].
DENSITY = 400.0
# Entries of a rotation matrix as files have them, in single precision.
_TOLERANCE = 1e-3


@contextmanager
def of_file(where: str) -> Iterator[None]:
    """What a scene refuses of a file (a name, a mesh that spans no volume) is the file's fault."""
    try:
        yield
    except InputError as error:
        raise FileError(f"{where}: {error}") from None


def add_recorded(
    scene: Scene,
    name: str,
    mesh: Path,
    position: Array,
    rotation: Array,
    *,
    where: str,
    axes: Array,
    fps: float,
    options: Options,
    scale: float = 1.0,
) -> ObjectTrack:
    """Add an object whose vertices in the file's axes are ``rotation @ (scale * v) + position``.

    Args:
        scene: Where to add it: free from its first pose on, or replayed (`Options.objects`).
        name: Of the object.
        mesh: Its mesh file, in its own axes [m, times `scale`].
        position: (T, 3) [m], file axes.
        rotation: (T, 3, 3), file axes.
        where: What messages call the clip.
        axes: World from file axes (3, 3), as `Motion.axes`.
        fps: Of the poses.
        options: Of the caller.
        scale: Metres per unit of the mesh.

    Returns:
        The recorded poses in the world.

    Raises:
        FileError: Matrices that are no rotations, or a mesh that cannot be used.
    """
    off = np.abs(rotation @ np.swapaxes(rotation, 1, 2) - np.eye(3)).max(axis=(1, 2))
    bad = (off > _TOLERANCE) | (np.linalg.det(rotation) < 0.0)
    if bad.any():
        raise FileError(
            f"{where}: object {name!r}: the matrix of frame {int(np.argmax(bad))} is no rotation; "
            "expected orthonormal 3 x 3 matrices"
        )
    places = position @ axes.T
    turns = rot.from_matrix(axes @ rotation)
    track = ObjectTrack(position=places, quaternion=turns)
    if options.objects == "replayed":
        scene.add_moving(name, mesh, places, turns, fps=fps, scale=scale, up="z")
        return track
    solid, _ = load_mesh(mesh, scale=scale, up="z")
    mass = DENSITY * (solid.volume if solid.closed else solid.hull.volume)
    warn(
        f"{where}: nothing says what {name!r} weighs: {mass:.3g} kg is taken, {DENSITY:g} kg/m^3. "
        "Scenes of your own say mass="
    )
    scene.add_object(
        name,
        mesh,
        mass=mass,
        position=places[0],
        quaternion=turns[0],
        scale=scale,
        up="z",
    )
    return track
