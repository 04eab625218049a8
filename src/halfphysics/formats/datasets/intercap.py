"""InterCap: a person and an object before six Kinects; SMPL-X, y-down, 30 fps.

`RES/SUBJECT/OBJECT/Seg_0/res.pkl` is a dict of `global_orient, transl (T, 3)`, `body_pose (T,
63)`, `left_hand_pose, right_hand_pose (T, 12)`, `betas (T, 10)`, and the object's `ob_pose (T, 3)`
axis-angle and `ob_trans (T, 3)`; or, joined, `poses (T, 90)` and `trans`. All is in the frame of
the first camera: x right, y down. Hands are 12 principal components about the relaxed hand.

The object's mesh at the first frame is `Mesh/00000_second_obj.ply` beside it;
`objects/NAME/NAME.obj` has it in its own frame. The subjects' gender is known by their number, the
folder's name.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.stored_objects import read
from halfphysics.errors import FileError
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.datasets.assets import find
from halfphysics.formats.datasets.median_shape import median_shape
from halfphysics.formats.datasets.recorded import add_recorded, of_file
from halfphysics.formats.datasets.relaxed_fingers import HANDS, relaxed_fingers
from halfphysics.formats.datasets.subject import body_of_betas
from halfphysics.formats.format import Format, Options, Source
from halfphysics.formats.gender_names import said_gender
from halfphysics.formats.motion_builder import motion_of, rotations_of, same_length
from halfphysics.geometry.mesh import Mesh
from halfphysics.geometry.mesh_files import load_mesh
from halfphysics.motion import skeleton
from halfphysics.motion.motion import Motion
from halfphysics.scene.scene import Scene
from halfphysics.simulation.sequence import Sequence

Array = NDArray[np.float64]

NAME = "intercap"
FPS = 30.0
FILE = "res.pkl"
#: Number of an object, the name of a folder -> its name.
OBJECTS = {
    "01": "suitcase", "02": "skateboard", "03": "soccerball", "04": "umbrella", "05": "racket",
    "06": "toolbox", "07": "chair", "08": "fantabottle", "09": "cup", "10": "stool",
}  # fmt: skip
_MEN, _WOMEN = ("01", "02", "04", "05", "10"), ("03", "06", "07", "08", "09")
_FIRST = "Mesh/00000_second_obj.ply"
_COMPONENTS = 12
_JOINED = 90

_UNSAID = "nothing says how tall the person is in metres"


def _sniff(source: Source) -> bool:
    if source.is_folder:
        path = source.path / FILE
        return path.is_file() and _is_ours(read(path))
    return _is_ours(source.data)


def _is_ours(data: object) -> bool:
    if not isinstance(data, dict):
        return False
    if {"ob_pose", "ob_trans"} & data.keys():
        return True
    poses = data.get("poses")
    return isinstance(poses, np.ndarray) and poses.shape[1:] == (_JOINED,) and "trans" in data


def _record(source: Source) -> Record:
    if source.is_folder:
        return Record(source.path / FILE, read(source.path / FILE))
    return Record(source.path, source.data)


def _numbers_above(source: Source) -> tuple[str, str]:
    """Names of the subject's and the object's folders."""
    folder = source.path.resolve() if source.is_folder else source.path.resolve().parent
    return folder.parent.parent.name, folder.parent.name


def _load(source: Source, options: Options) -> Motion:
    record = _record(source)
    rows = options.frames
    if "poses" in record and "global_orient" not in record:
        joined = record.array("poses", None, _JOINED, frames=rows)
        root, body, left, right = np.split(joined, [3, 66, 78], axis=1)
        hands, keys, place = dict(zip(HANDS, (left, right), strict=True)), ["poses"], "trans"
    else:
        root = record.array("global_orient", None, 3, frames=rows)
        flat = len(record.shape("body_pose", "(T, 63)")) != 3
        body = record.array("body_pose", *((None, 63) if flat else (None, 21, 3)), frames=rows)
        found = [key for key in HANDS if key in record]
        hands = {key: record.array(key, None, _COMPONENTS, frames=rows) for key in found}
        keys, place = ["global_orient", "body_pose", *found], "transl"
    translation = record.array(place, None, 3, frames=rows)
    frames = same_length(record.where, {key: len(record.raw(key)) for key in (*keys, place)})
    subject = _numbers_above(source)[0]
    gender = "male" if subject in _MEN else "female" if subject in _WOMEN else None
    gender = said_gender(record) or gender
    fingers, meaning = relaxed_fingers(
        record, options, options.gender or gender or "neutral", hands
    )
    return motion_of(
        record.where,
        options,
        format=NAME,
        translation=translation,
        rotations=rotations_of({(0,): root, skeleton.BODY_JOINTS: body, **fingers}),
        fps=FPS,
        up="-y",
        model="smplx",
        gender=gender,
        betas=median_shape(record, frames),
        hands=meaning,
    )


def _load_sequence(source: Source, options: Options) -> Sequence:
    motion, record = _load(source, options), _record(source)
    turns = record.array("ob_pose", None, 3)
    places = record.array("ob_trans", None, 3)
    person = "transl" if "transl" in record else "trans"
    lengths = {"ob_pose": len(turns), "ob_trans": len(places), person: len(record.raw(person))}
    same_length(record.where, lengths)
    number = _numbers_above(source)[1]
    name = OBJECTS.get(number, "object")
    matrix = rot.rotvec_to_matrix(turns)
    mesh = _mesh(source, options, name, matrix[0], options.unit * places[0])
    scene = Scene()
    with of_file(record.where):
        track = add_recorded(
            scene,
            name,
            mesh,
            places[options.frames],
            matrix[options.frames],
            where=record.where,
            axes=motion.axes,
            fps=motion.fps,
            options=options,
        )
    tracks = {name: track}
    body = body_of_betas(options, motion, tracks, f"{source.path}: {_UNSAID}")
    return Sequence(motion, scene, body, recorded=tracks)


def _mesh(source: Source, options: Options, name: str, turn: Array, place: Array) -> Path | Mesh:
    """The object in its own frame: of the mesh at the first frame, or of the data set's copy."""
    folder = source.path if source.is_folder else source.path.parent
    files = [str(folder.resolve() / _FIRST), f"objects/{name}/{name}.obj", f"{name}/{name}.obj"]
    path = find(source, options, files, f"the mesh of {name!r}")
    if path.name != Path(_FIRST).name:
        return path
    posed = load_mesh(path, up="z")[0]
    if not len(posed.vertices):
        raise FileError(f"{path}: found no vertices, expected the object's mesh")
    return Mesh((posed.vertices - place) @ turn, posed.faces)


FORMAT = Format(
    name=NAME,
    about="InterCap: a person and an object before Kinects",
    invents="fingers (components, without the model), the person's size in metres, the floor",
    expects=f"{FILE} with global_orient, transl, ob_pose, ob_trans (T, 3), body_pose (T, 63)",
    sniff=_sniff,
    load=_load,
    load_sequence=_load_sequence,
)
