"""Cache on disk of what is derived from a body's skin: its rigid parts, the corners of its hulls.

One small npz per body and kind, in the folder `bodies` of the `cache_folder`, named by a digest of
the skin, of the code that derives it and of the machine: what is read is what would be made, bit
for bit. A file that is damaged, or that says anything impossible, is as good as none. Files are
written whole, hold no pickles, and only the latest `MOST` are kept.
"""

from __future__ import annotations

import contextlib
import hashlib
import logging
import os
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import progress as bars
from halfphysics.base.cache_folder import cache_folder
from halfphysics.base.made_by import made_by
from halfphysics.base.npz import Npz, write_npz
from halfphysics.base.stopwatch import Stopwatch
from halfphysics.body.rigid_parts import Part, Variant, build_variant
from halfphysics.body.skin_hulls import SkinHulls
from halfphysics.errors import FileError
from halfphysics.motion.skeleton import JOINT_NAMES, N_JOINTS

if TYPE_CHECKING:
    from halfphysics.body.body import Body

logger = logging.getLogger(__name__)

Arrays = Mapping[str, NDArray[Any]]

#: Files that are kept, of some 0.1 MB each; the oldest make room.
MOST = 256
#: Largest size of a file that is read [bytes].
LARGEST = 64 * 2**20
#: Folders of the package whose code decides the numbers, and files.
_CODE, _DATA = ("base", "body", "geometry", "motion"), ("assets/body_cut.npz",)


def variant_of(body: Body) -> Variant:
    """The rigid parts of a body: those that were kept, or made and kept now.

    Warns:
        HalfPhysicsWarning: As `build_variant` does; parts that it warns of are not kept.
    """
    variant = read_variant(body)
    if variant is not None:
        logger.debug("the rigid parts of %r were kept", body)
        return variant
    clock = Stopwatch(logger)
    making = bars.bar(1, "making the parts of a body", "body")
    with warnings.catch_warnings(record=True) as caught, making:
        warnings.simplefilter("always")
        variant = build_variant(body)
    for warning in caught:
        warnings.warn(warning.message, warning.category, stacklevel=4)
    if not caught:
        write_variant(body, variant)
    clock.done("made the rigid parts of %r", body)
    return variant


def corners_of(body: Body) -> SkinHulls:
    """The corners of the hulls of a body's skin: those that were kept, or made and kept now."""
    corners = read_corners(body)
    if corners is None:
        from halfphysics.body.skin_corners import without_inner  # imports scipy

        clock = Stopwatch(logger)
        with bars.bar(1, "making the hulls of a skin", "body"):
            hulls = body.skin_hulls
            image = None if body.symmetry is None else body.symmetry.vertex
            corners = without_inner(hulls, body.weights, body.rest_vertices, body.posedirs, image)
        write_corners(body, corners)
        clock.done("made the hulls of the skin of %r", body)
    return corners


def read_variant(body: Body) -> Variant | None:
    """The rigid parts that were kept of a body; None: there are none."""
    variant: Variant | None = _read("parts", _parts_key(body), _variant_from)
    return variant


def write_variant(body: Body, variant: Variant) -> None:
    """Keep the rigid parts of a body."""
    parts = variant.parts
    arrays = {
        "vertices": np.concatenate([part.vertices for part in parts]),
        "faces": np.concatenate([part.faces for part in parts]),
        "n_vertices": np.array([len(part.vertices) for part in parts]),
        "n_faces": np.array([len(part.faces) for part in parts]),
        "mass": np.array([part.mass for part in parts]),
        "com": np.stack([part.com for part in parts]),
        "inertia": np.stack([part.inertia for part in parts]),
        "joint_offsets": variant.joint_offsets,
        "totals": np.array([variant.volume, variant.mass]),
    }
    _write("parts", _parts_key(body), arrays)


def read_corners(body: Body) -> SkinHulls | None:
    """The corners of a skin's hulls that were kept; None: there are none."""
    key = _corners_key(body)
    corners: SkinHulls | None = _read("corners", key, lambda file: _corners_from(file, body))
    return corners


def write_corners(body: Body, corners: SkinHulls) -> None:
    """Keep the corners of the hulls of a skin."""
    arrays: Arrays = {"part": corners.part, "first": corners.first, "vertex": corners.vertex}
    _write("corners", _corners_key(body), arrays)


def _variant_from(file: Arrays) -> Variant:
    """Raises `ValueError` for what cannot be the parts of a body."""
    vertices, faces = _of(file, "vertices", float, None, 3), _of(file, "faces", np.int32, None, 3)
    mass, com = _of(file, "mass", float, N_JOINTS), _of(file, "com", float, N_JOINTS, 3)
    inertia = _of(file, "inertia", float, N_JOINTS, 3, 3)
    corners = _cut(vertices, _of(file, "n_vertices", np.int64, N_JOINTS))
    triangles = _cut(faces, _of(file, "n_faces", np.int64, N_JOINTS))
    _need(bool((mass > 0.0).all()))
    for own, its in zip(triangles, corners, strict=True):
        _need(not len(own) or 0 <= own.min() <= own.max() < len(its))
    parts = tuple(
        Part(
            name=name,
            index=i,
            vertices=corners[i],
            faces=triangles[i],
            mass=float(mass[i]),
            com=com[i],
            inertia=inertia[i],
        )
        for i, name in enumerate(JOINT_NAMES)
    )
    volume, total = _of(file, "totals", float, 2).tolist()
    offsets = _of(file, "joint_offsets", float, N_JOINTS, 3)
    return Variant(parts=parts, joint_offsets=offsets, volume=volume, mass=total)


def _corners_from(file: Arrays, body: Body) -> SkinHulls:
    """Raises `ValueError` for what cannot be hulls of the body's skin."""
    part, first = _of(file, "part", np.int64, None), _of(file, "first", np.int64, None)
    vertex = _of(file, "vertex", np.int32, None)
    _need(len(first) == len(part) + 1 and first[0] == 0 and first[-1] == len(vertex))
    _need(bool((np.diff(first) > 0).all()) and bool(((part >= 0) & (part < N_JOINTS)).all()))
    _need(bool(((vertex >= 0) & (vertex < len(body.rest_vertices))).all()))
    return SkinHulls(part=part, first=first, vertex=vertex)


def _of(file: Arrays, name: str, kind: Any, *shape: int | None) -> NDArray[Any]:
    """An array of that type and shape (None: any), finite, read-only."""
    array = file[name]
    _need(array.dtype == np.dtype(kind) and array.ndim == len(shape))
    _need(all(want in (None, have) for want, have in zip(shape, array.shape, strict=True)))
    _need(bool(np.isfinite(array).all()))
    array.setflags(write=False)
    return array


def _cut(rows: NDArray[Any], counts: NDArray[np.int64]) -> list[NDArray[Any]]:
    _need(bool((counts >= 0).all()) and int(counts.sum()) == len(rows))
    return np.split(rows, np.cumsum(counts)[:-1])


def _need(sound: bool) -> None:
    if not sound:
        raise ValueError("not what was written")


def _read(kind: str, key: str, make: Any) -> Any:
    path = _path(kind, key)
    try:
        if path is None or path.stat().st_size > LARGEST:
            return None
        npz = Npz(path)
        file = {name: npz[name] for name in npz}
        digest = str(file.pop("digest"))
        made = make(file) if digest == _digest(key, file) else None
        if made is not None:
            with contextlib.suppress(OSError):
                os.utime(path)  # the latest that was used
        return made
    except (FileError, OSError, KeyError, ValueError, TypeError):
        return None


def _write(kind: str, key: str, arrays: Arrays) -> None:
    path = _path(kind, key)
    if path is None:
        return
    # Where nothing can be kept the next process makes it again, in a second.
    with contextlib.suppress(FileError, OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        write_npz(path, {**arrays, "digest": np.array(_digest(key, arrays))})
        _make_room(path.parent)


def _make_room(folder: Path) -> None:
    """Delete the files that were not used for longest."""
    files = [(path.stat().st_mtime_ns, path) for path in folder.glob("*.npz")]
    for _, path in sorted(files)[:-MOST]:
        path.unlink(missing_ok=True)


def _path(kind: str, key: str) -> Path | None:
    folder = cache_folder()
    return None if folder is None else folder / "bodies" / f"{kind}-{key}.npz"


def _digest(key: str, arrays: Arrays) -> str:
    digest = hashlib.sha256(key.encode())
    for name, array in sorted(arrays.items()):
        digest.update(f"{name} {array.dtype.str} {array.shape}\n".encode())
        digest.update(np.ascontiguousarray(array).data)
    return digest.hexdigest()


def _parts_key(body: Body) -> str:
    names = ("rest_vertices", "rest_joints", "faces", "weights")
    return _digest(made_by(_CODE, _DATA), {name: getattr(body, name) for name in names})


def _corners_key(body: Body) -> str:
    mean = body.mean_vertices is not None and body.mean_joints is not None
    names = ["rest_vertices", "rest_joints", "faces", "weights"]
    names += ["mean_vertices", "mean_joints"] if mean else []
    names += [] if body.posedirs is None else ["posedirs"]
    return _digest(made_by(_CODE, _DATA), {name: getattr(body, name) for name in names})
