"""Adds the recorded objects of a data set to a scene."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.reader_warnings import warn
from halfphysics.errors import FileError, InputError
from halfphysics.formats.format import Options
from halfphysics.geometry.mesh import Mesh
from halfphysics.geometry.mesh_files import load_mesh
from halfphysics.results.result import ObjectTrack

if TYPE_CHECKING:
    from halfphysics.scene.scene import Scene

Array = NDArray[np.float64]

#: Density of household objects without a mass in the data set [kg/m^3].
DENSITY = 400.0
#: Larger ones are hollow: what is beyond this volume [m^3] has this density [kg/m^3]. A suitcase of
#: 45 l weighs 7 kg, and not the 18 that nobody carries between two palms.
SOLID, HOLLOW = 0.015, 40.0
#: A thing that moves and turns by less than this [m, rad] within so long [s] rests.
_STILL, _RESTS = (0.01, 0.05), 0.2
# Tolerance of the entries of a rotation matrix in single precision.
_TOLERANCE = 1e-3


def assumed_mass(volume: float) -> float:
    """What a household object of this volume [m^3] weighs, where nothing says so [kg]."""
    return DENSITY * min(volume, SOLID) + HOLLOW * max(volume - SOLID, 0.0)


@contextmanager
def of_file(where: str) -> Iterator[None]:
    """Turn an InputError of a scene (a name, a mesh without volume) into a FileError."""
    try:
        yield
    except InputError as error:
        raise FileError(f"{where}: {error}") from None


def add_recorded(
    scene: Scene,
    name: str,
    mesh: Path | Mesh,
    position: Array,
    rotation: Array,
    *,
    where: str,
    axes: Array,
    fps: float,
    options: Options,
    scale: float = 1.0,
    pieces: str | Sequence[Mesh] = "auto",
) -> ObjectTrack:
    """Add an object whose vertices in the file's axes are ``rotation @ (scale * v) + position``.

    Args:
        scene: Scene to add it to, free from its first pose or replayed (`Options.objects`).
        name: Name of the object.
        mesh: Its mesh file, or mesh, in its own axes [m, times `scale`].
        position: Positions (T, 3) in the unit of the file (`Options.unit`), file axes.
        rotation: Rotations (T, 3, 3), file axes.
        where: Name of the clip in messages.
        axes: World from file axes (3, 3), as `Motion.axes`.
        fps: Frame rate of the poses.
        options: Options of the caller.
        scale: Metres per unit of the mesh file.
        pieces: What collides, as in `Scene.add_object`.

    Returns:
        The recorded poses in the world.

    Raises:
        FileError: A matrix is no rotation, or the mesh cannot be used.
    """
    off = np.abs(rotation @ np.swapaxes(rotation, 1, 2) - np.eye(3)).max(axis=(1, 2))
    bad = (off > _TOLERANCE) | (np.linalg.det(rotation) < 0.0)
    if bad.any():
        raise FileError(
            f"{where}: object {name!r}: the matrix of frame {int(np.argmax(bad))} is no rotation; "
            "expected orthonormal 3 x 3 matrices"
        )
    places = options.unit * position @ axes.T
    turns = rot.from_matrix(axes @ rotation)
    track = ObjectTrack(position=places, quaternion=turns)
    if options.objects == "replayed":
        scene.add_moving(name, mesh, places, turns, fps=fps, scale=scale, up="z")
        return track
    solid = mesh if isinstance(mesh, Mesh) else load_mesh(mesh, scale=scale, up="z")[0]
    mass = assumed_mass(solid.volume if solid.closed else solid.hull.volume)
    warn(
        f"{where}: nothing says what {name!r} weighs: {mass:.3g} kg is taken, that is "
        f"{DENSITY:g} kg/m^3 up to {1000.0 * SOLID:g} l and {HOLLOW:g} beyond. "
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
        start="asleep" if rests(track, fps) else "awake",
        pieces=pieces,
    )
    return track


def rests(track: ObjectTrack, fps: float) -> bool:
    """Whether a recorded thing rests at first: what it stood on is often not in the data set."""
    frames = slice(0, max(2, round(_RESTS * fps)))
    moved = np.linalg.norm(track.position[frames] - track.position[0], axis=1).max()
    turns = rot.multiply(rot.conjugate(track.quaternion[:1]), track.quaternion[frames])
    turned = np.linalg.norm(rot.log(turns), axis=1).max()
    return bool(moved < _STILL[0] and turned < _STILL[1])
