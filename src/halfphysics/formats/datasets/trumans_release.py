"""The TRUMANS release: a folder of arrays with one row per frame, clip after clip; y-up.

`human_pose (N, 63) human_orient human_transl (N, 3) seg_name (N,)`, and optionally
`left_hand_pose right_hand_pose (N, 45) object_flag (N, K) object_mat (N, 5, 4, 4) object_list
scene_flag (N,) scene_list bad_frames`. N is 3,792,068: the arrays are memory-mapped and never read
whole. The flag of an object is the index of its matrix, -1 if it is absent; its vertices are
`v @ M[:3, :3] + M[:3, 3]`. Meshes: `Object_mesh/NAME.obj`, `Scene_mesh/NAME.obj`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.npy import Npy
from halfphysics.base.reader_warnings import warn
from halfphysics.errors import FileError
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.datasets.assets import find
from halfphysics.formats.datasets.recorded import add_recorded, of_file
from halfphysics.formats.format import Format, Options, Source
from halfphysics.formats.motion_builder import motion_of, own_name, rotations_of, same_length
from halfphysics.motion import skeleton
from halfphysics.motion.motion import Motion
from halfphysics.scene.scene import Scene
from halfphysics.simulation.sequence import Sequence

NAME = "trumans"
FPS = 30.0
_NEEDED = ("human_pose", "human_orient", "human_transl", "seg_name")
_HANDS = {
    "left_hand_pose": skeleton.LEFT_HAND_JOINTS,
    "right_hand_pose": skeleton.RIGHT_HAND_JOINTS,
}
# Number of names compared at once: bounds the memory for any number of frames.
_CHUNK = 50_000


def _sniff(source: Source) -> bool:
    if not source.is_folder:
        return False
    there = [name for name in _NEEDED if (source.path / f"{name}.npy").is_file()]
    if 2 <= len(there) < len(_NEEDED):
        missing = [f"{name}.npy" for name in _NEEDED if name not in there]
        raise FileError(
            f"{source.path}: looks like the TRUMANS release, but {', '.join(missing)} is missing"
        )
    return len(there) == len(_NEEDED)


class _Arrays(Mapping[str, Any]):
    """The arrays of a folder by name, memory-mapped on access."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def __contains__(self, key: object) -> bool:
        return (self._folder / f"{key}.npy").is_file()

    def __getitem__(self, key: str) -> NDArray[Any]:
        return Npy(self._folder / f"{key}.npy").array

    def __iter__(self) -> Any:
        return (path.stem for path in sorted(self._folder.glob("*.npy")))

    def __len__(self) -> int:
        return len(list(iter(self)))

    def describe(self) -> str:
        return ", ".join(self)


@lru_cache(maxsize=4)
def _segments(path: Path, stamp: tuple[int, int]) -> dict[str, tuple[int, int]]:
    """Name of a clip -> its rows [start, stop); `stamp` (file time, size) is for the cache."""
    npy = Npy(path)
    if npy.dtype.kind not in "US" or len(npy.shape) != 1 or not npy.shape[0]:
        raise FileError(f"{path}: found shape {npy.shape} of {npy.dtype}, expected text (N,)")
    count, width = npy.shape[0], npy.dtype.itemsize
    starts, names = [], []
    with path.open("rb") as handle:  # not mapped: the pages read would stay in memory
        handle.seek(npy.offset)
        last = None
        for first in range(0, count, _CHUNK):
            rows = np.fromfile(handle, np.uint8, min(_CHUNK, count - first) * width)
            words = rows.reshape(-1, width).view(np.uint32 if width % 4 == 0 else np.uint8)
            new = np.ones(len(words), dtype=bool)
            new[1:] = (words[1:] != words[:-1]).any(axis=1)
            new[0] = last is None or (words[0] != last).any()
            starts += (first + np.flatnonzero(new)).tolist()
            names += words[new].view(npy.dtype).reshape(-1).tolist()
            last = words[-1].copy()
    segments: dict[str, tuple[int, int]] = {}
    for name, start, stop in zip(names, starts, [*starts[1:], count], strict=True):
        text = name.decode("utf-8", "replace") if isinstance(name, bytes) else str(name)
        # A name may occur again after rows of another clip.
        segments[own_name(text, segments)] = (start, stop)
    return segments


def _clips(source: Source) -> dict[str, tuple[int, int]]:
    path = source.path / "seg_name.npy"
    status = path.stat()
    return _segments(path, (status.st_mtime_ns, status.st_size))


def _names(source: Source) -> Iterable[str]:
    return _clips(source)


def _rows(source: Source, options: Options) -> tuple[Record, slice]:
    start, stop = _clips(source)[options.clip]
    rows = range(start, stop)[options.frames]
    arrays = _Arrays(source.path)
    per_frame = (*_NEEDED, *_HANDS, "scene_flag", "object_flag", "object_mat")
    lengths = {k: arrays[k].shape[0] for k in per_frame if k in arrays and arrays[k].ndim}
    same_length(str(source.path), lengths)
    return Record(source.path, arrays), slice(rows.start, rows.stop, rows.step)


def _load(source: Source, options: Options) -> Motion:
    record, rows = _rows(source, options)
    where = f"{source.path}, clip {options.clip!r}"
    parts = {
        (0,): record.array("human_orient", None, 3, frames=rows),
        skeleton.BODY_JOINTS: record.array("human_pose", None, 63, frames=rows),
    }
    fingers = {
        joints: record.array(key, None, 45, frames=rows)
        for key, joints in _HANDS.items()
        if key in record
    }
    translation = record.array("human_transl", None, 3, frames=rows)
    if "bad_frames" in record:
        bad = record.flat("bad_frames")
        count = int(((bad >= rows.start) & (bad < rows.stop)).sum())
        if count:
            warn(f"{where}: the data set calls {count} of its frames bad (bad_frames.npy)")
    bent = any(part.any() for part in fingers.values())
    return motion_of(
        where,
        options,
        format=NAME,
        translation=translation,
        rotations=rotations_of({**parts, **fingers}),
        fps=FPS,
        up="y",
        model="smplx",
        gender="neutral",
        hands="unsaid" if bent else "flat" if fingers else None,
    )


def _load_sequence(source: Source, options: Options) -> Sequence:
    motion = _load(source, options)
    record, rows = _rows(source, options)
    where = f"{source.path}, clip {options.clip!r}"
    scene = Scene()
    if "scene_flag" in record and "scene_list" in record:
        flag = int(record.numbers("scene_flag", None, frames=rows)[0])
        name = _listed(record, "scene_list", flag)
        path = find(source, options, (f"Scene_mesh/{name}.obj",), f"the mesh of the scene {name!r}")
        with of_file(str(path)):
            if options.up in (None, "y"):
                scene.add_static(name, path, up="y")
            else:  # turned as the people and the things are
                scene.add_static(name, path, quaternion=rot.from_matrix(motion.axes), up="z")
    tracks = {}
    if "object_flag" in record and "object_mat" in record:
        width = record.shape("object_flag")[1:]
        flags = record.numbers("object_flag", None, *width[:1], frames=rows).astype(np.int64)
        matrices = record.array("object_mat", None, 5, 4, 4, frames=rows)
        for index in np.flatnonzero((flags >= 0).all(axis=0)):
            name = _listed(record, "object_list", int(index))
            found = flags[:, index]
            if found.max() >= matrices.shape[1]:
                raise record.error(
                    "object_flag", f"found {found.max()}, expected at most {matrices.shape[1] - 1}"
                )
            poses = matrices[np.arange(len(found)), found]
            path = find(
                source, options, (f"Object_mesh/{name}.obj",), f"the mesh of the object {name!r}"
            )
            tracks[name] = add_recorded(
                scene,
                name,
                path,
                poses[:, :3, 3],
                np.swapaxes(poses[:, :3, :3], 1, 2),
                where=where,
                axes=motion.axes,
                fps=motion.fps,
                options=options,
            )
    return Sequence(motion, scene, recorded=tracks)


def _listed(record: Record, key: str, index: int) -> str:
    names = record.flat(key, "(text)")
    if not 0 <= index < len(names):
        raise record.error(key, f"found {len(names)} names, expected one of number {index}")
    name = names[index]
    text = name.decode("utf-8", "replace") if isinstance(name, bytes) else str(name)
    return text.removesuffix(".npy")


FORMAT = Format(
    name=NAME,
    about="the TRUMANS release: people, rooms and objects",
    invents="the frame rate (30)",
    expects="folder with human_pose.npy, human_orient.npy, human_transl.npy, seg_name.npy",
    sniff=_sniff,
    load=_load,
    load_sequence=_load_sequence,
    clips=_names,
)
