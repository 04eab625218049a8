"""ParaHome: a person in a room with things that open and turn; SMPL-X, 30 fps.

`smplx_seq/s1/` has `smplx_params.pkl`: `beta (20,)`, `gender`; and `smplx_pose.pkl`:
`global_orient, transl (T, 3)`, `body_pose (T, 21, 3)`, `hand_pose (T, 30, 3)`, on a flat hand.
`seq/s1/object_transformations.pkl` has for each frame the 4 x 4 matrices, world from part, of
"NAME_base", "NAME_part1", "NAME_part2"; meshes `scan/NAME/simplified/base.obj`. The up axis is not
documented: it is found by how the person stands.

What hinges and drawers join is in another download (`joint_info`): the moving parts of such a thing
follow their record, a part that does not move is static, a thing of one part is free.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.reader_warnings import warn
from halfphysics.base.stored_objects import read
from halfphysics.errors import FileError
from halfphysics.formats.checked_fields import Record, shape_of
from halfphysics.formats.datasets.assets import find, seek
from halfphysics.formats.datasets.median_shape import median_shape
from halfphysics.formats.datasets.recorded import add_recorded, of_file
from halfphysics.formats.datasets.rigid_place import rigid
from halfphysics.formats.datasets.standing_axis import standing_axis
from halfphysics.formats.datasets.subject import body_of_betas
from halfphysics.formats.format import Format, Options, Source
from halfphysics.formats.gender_names import said_gender
from halfphysics.formats.motion_builder import motion_of, rotations_of, same_length
from halfphysics.motion import skeleton
from halfphysics.motion.motion import Motion
from halfphysics.results.result import ObjectTrack
from halfphysics.scene.scene import Scene
from halfphysics.simulation.sequence import Sequence

Array = NDArray[np.float64]

NAME = "parahome"
FPS = 30.0
POSE, SHAPE = "smplx_pose.pkl", "smplx_params.pkl"
OBJECTS = "object_transformations.pkl"
_KEYS = ("global_orient", "body_pose", "transl", "hand_pose")
_HANDS = skeleton.LEFT_HAND_JOINTS + skeleton.RIGHT_HAND_JOINTS
_PARTS = ("base", "part1", "part2")
#: A part that moves and turns by less than this in the clip is static [m, rad]: the noise of the
#: cameras of the room.
_STILL = (0.01, 0.05)

_UNSAID = "nothing says how tall the person is in metres"


def _sniff(source: Source) -> bool:
    if source.is_folder:
        if (source.path / OBJECTS).is_file() and not (source.path / POSE).is_file():
            raise FileError(
                f"{source.path}: the objects and joints of a ParaHome sequence, expected its "
                f"person. Load the folder smplx_seq/{source.path.name} with {POSE}"
            )
        return (source.path / POSE).is_file()
    data = source.data
    return isinstance(data, dict) and {"hand_pose", "body_pose", "global_orient"} <= data.keys()


def _folder(source: Source) -> Path:
    return source.path if source.is_folder else source.path.resolve().parent


def _fields(path: Path) -> Record:
    data = read(path)
    if not isinstance(data, dict):
        raise FileError(f"{path}: found a {type(data).__name__}, expected a dict of arrays")
    return Record(path, data)


def _load(source: Source, options: Options) -> Motion:
    record = _fields(source.path / POSE) if source.is_folder else Record(source.path, source.data)
    root = record.array("global_orient", None, 3, frames=options.frames)
    body = record.array("body_pose", None, 21, 3, frames=options.frames)
    hands = record.array("hand_pose", None, 30, 3, frames=options.frames)
    translation = record.array("transl", None, 3, frames=options.frames)
    frames = same_length(record.where, {key: len(record.raw(key)) for key in _KEYS})
    path = _folder(source) / SHAPE
    shape = _fields(path) if path.is_file() else None
    gender = None if shape is None else said_gender(shape)
    return motion_of(
        record.where,
        options,
        format=NAME,
        translation=translation,
        rotations=rotations_of({(0,): root, skeleton.BODY_JOINTS: body, _HANDS: hands}),
        fps=FPS,
        up=standing_axis(record.where, root, options, rule="z", others=("y", "-y"), of="ParaHome"),
        model="smplx",
        gender=gender,
        betas=None if shape is None else median_shape(shape, frames, "beta"),
    )


def _load_sequence(source: Source, options: Options) -> Sequence:
    motion = _load(source, options)
    scene, tracks = Scene(), {}
    here = _folder(source)
    beside = [str(here / OBJECTS), f"seq/{here.name}/{OBJECTS}"]
    path = seek(source, options, beside)
    if path is None:
        raise FileError(
            f"{source.path}: its objects are in seq/{here.name}/{OBJECTS}, which is not there. "
            "Name the data set's folder with assets=, or read the motion alone with Motion.load"
        )
    where = source.path / POSE if source.is_folder else source.path
    total = len(_fields(where).raw("transl"))
    for name, poses in _poses(path, total).items():
        track = _add_part(source, options, motion, scene, path, name, poses[options.frames])
        if track is not None:
            tracks[name] = track
    body = body_of_betas(options, motion, tracks, f"{source.path}: {_UNSAID}")
    return Sequence(motion, scene, body, recorded=tracks)


def _poses(path: Path, total: int) -> dict[str, Array]:
    """Matrices (T, 4, 4) of each part; while it is not there, those of the nearest frame."""
    data = read(path)
    if isinstance(data, Mapping):
        try:
            data = [data[key] for key in sorted(data)]
        except TypeError:
            raise FileError(f"{path}: found frames named by numbers and by text") from None
    if not isinstance(data, list) or not all(isinstance(frame, Mapping) for frame in data):
        raise FileError(f"{path}: expected for each frame a dict of name -> matrix (4, 4)")
    same_length(str(path), {POSE: total, "object_transformations": len(data)})
    names = list(dict.fromkeys(str(name) for frame in data for name in frame))
    found, partly = {}, []
    for name in names:
        there = np.flatnonzero([name in frame for frame in data])
        known = np.stack([_matrix(path, name, data[k][name]) for k in there])
        found[name] = known[_nearest(there, total)]
        partly += [name] if len(there) < total else []
    if partly:
        warn(
            f"{path}: not there in all frames, and kept at its nearest pose in the others: "
            f"{', '.join(partly)}"
        )
    return found


def _nearest(there: NDArray[np.intp], total: int) -> NDArray[np.intp]:
    """Of every frame the index of the nearest of some frames; of two the earlier one."""
    after = np.clip(np.searchsorted(there, np.arange(total)), 0, len(there) - 1)
    before = np.maximum(after - 1, 0)
    frames = np.arange(total)
    nearer = np.abs(frames - there[before]) <= np.abs(there[after] - frames)
    return np.where(nearer, before, after)


def _matrix(path: Path, name: str, value: Any) -> Array:
    matrix = np.asarray(value, dtype=np.float64) if shape_of(value) == (4, 4) else np.zeros((4, 4))
    out = np.eye(4)
    try:
        out[:3, :3], out[:3, 3] = rigid(path, matrix[:3, :3], matrix[:3, 3])
    except FileError:
        raise FileError(f"{path}: {name!r}: found no rigid transform (4, 4)") from None
    return out


def _add_part(
    source: Source,
    options: Options,
    motion: Motion,
    scene: Scene,
    path: Path,
    name: str,
    poses: Array,
) -> ObjectTrack | None:
    """Add a part: static, free or replayed; the record of one that moves."""
    thing, _, part = name.rpartition("_")
    if part not in _PARTS or not thing or {"/", "\\", ":"} & set(name) or ".." in name:
        raise FileError(f"{path}: found a part {name!r}, expected NAME_base, NAME_part1, ...")
    mesh = find(source, options, [f"scan/{thing}/simplified/{part}.obj"], f"the mesh of {name!r}")
    places, turns = poses[:, :3, 3], poses[:, :3, :3]
    sized = options.unit * places
    quaternions = rot.from_matrix(motion.axes @ turns)
    moved = np.linalg.norm(places - places[0], axis=1).max()
    steps = rot.log(rot.multiply(rot.conjugate(quaternions[:1]), quaternions))
    turned = np.linalg.norm(steps, axis=1).max()
    with of_file(str(path)):
        if moved < _STILL[0] and turned < _STILL[1]:
            scene.add_static(
                name, mesh, position=motion.axes @ sized[0], quaternion=quaternions[0], up="z"
            )
            return None
        if _has_parts(path, source, options, thing) and options.objects == "free":
            warn(f"{path}: what joins the parts of {thing!r} is not here: they move as recorded")
            track = ObjectTrack(position=sized @ motion.axes.T, quaternion=quaternions)
            scene.add_moving(name, mesh, track.position, track.quaternion, fps=motion.fps, up="z")
            return track
        return add_recorded(
            scene, name, mesh, places, turns,
            where=str(path), axes=motion.axes, fps=motion.fps, options=options,
        )  # fmt: skip


def _has_parts(path: Path, source: Source, options: Options, thing: str) -> bool:
    files = [f"scan/{thing}/simplified/{part}.obj" for part in _PARTS[1:]]
    return seek(source, options, files) is not None


FORMAT = Format(
    name=NAME,
    about="ParaHome: a person in a room with things that open",
    invents="what joins the parts of things, the up axis, the frame rate (30)",
    expects=f"a folder with {POSE} (global_orient, transl (T, 3), body_pose (T, 21, 3), hand_pose "
    f"(T, 30, 3)) and {SHAPE}",
    sniff=_sniff,
    load=_load,
    load_sequence=_load_sequence,
)
