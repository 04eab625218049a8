"""InterAct: one layout for the people and objects of many data sets; y-up, floor at 0, 30 fps.

A sequence is a folder with `human.npz`: `poses`, `trans (T, 3)`, `betas (n,)`, `gender`; and
`object.npz`, or several `object_NAME.npz`: `angles (T, 3)` axis-angle, `trans (T, 3)` [m], `name`.
Columns of `poses` are root 3, body 63, left hand 45, right hand 45 (156: SMPL-H, or SMPL-X without
a face); then jaw, left eye, right eye (165: SMPL-X, in another order than AMASS has); or root,
body and 12 principal components for each hand (90: InterCap). The keys are those of AMASS: these
files are told by the objects beside them, or by their name and no other fields. They have no rate.

Meshes: `objects/NAME/NAME.obj`; of parts ("book_base") `objects/book/base.obj`.
"""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.npz import Npz
from halfphysics.base.npz_objects import NpzObjects
from halfphysics.base.reader_warnings import warn
from halfphysics.errors import FileError
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.datasets.assets import find, note
from halfphysics.formats.datasets.median_shape import median_shape
from halfphysics.formats.datasets.recorded import add_recorded, of_file
from halfphysics.formats.datasets.relaxed_fingers import HANDS, relaxed_fingers
from halfphysics.formats.datasets.subject import body_of_betas
from halfphysics.formats.format import Format, Options, Source
from halfphysics.formats.gender_names import said_gender
from halfphysics.formats.motion_builder import motion_of, rotations_of, same_length
from halfphysics.motion import skeleton
from halfphysics.motion.motion import MODELS, Motion
from halfphysics.results.result import ObjectTrack
from halfphysics.scene.scene import Scene
from halfphysics.simulation.sequence import Sequence

Array = NDArray[np.float64]

NAME = "interact"
FPS = 30.0
PERSON, OBJECT = "human.npz", "object.npz"
_PERSON_KEYS, _OBJECT_KEYS = {"poses", "trans"}, {"angles", "trans"}
#: All fields of a person. Any other, such as a rate, is another program's.
_ALL = {"poses", "trans", "betas", "gender"}
_BODY = skeleton.SMPL_JOINTS
#: Columns of `poses` -> the joints of each three.
_WIDTHS = {156: skeleton.SMPLH_JOINTS, 165: (*skeleton.SMPLH_JOINTS, *skeleton.FACE_JOINTS)}
#: Columns of jaw and eyes in the order of AMASS; here these are the left index and middle finger.
_AMASS_FACE = slice(66, 75)
_COMPONENTS = 12
_WITH_COMPONENTS = 3 * len(_BODY) + 2 * _COMPONENTS

_UNSAID = "nothing says how tall the person is in metres"


def _sniff(source: Source) -> bool:
    if source.is_folder:
        path = source.path / PERSON
        return path.is_file() and set(Npz(path)) >= _PERSON_KEYS
    keys = set(source.npz or ())
    if keys >= _OBJECT_KEYS and "poses" not in keys and keys & {"name", "instance_name"}:
        raise FileError(
            f"{source.path}: this is the object of an InterAct sequence, expected its person. Load "
            f"{PERSON} beside it, or their folder; load_sequence finds the object by itself"
        )
    if not _PERSON_KEYS <= keys <= _ALL:
        return False
    return source.path.name == PERSON or bool(_object_files(source))


def _folder(source: Source) -> Path:
    return source.path if source.is_folder else source.path.resolve().parent


def _object_files(source: Source) -> list[Path]:
    folder = _folder(source)
    one = folder / OBJECT
    found = [one] if one.is_file() else sorted(folder.glob("object_*.npz"))
    return [path for path in found if set(Npz(path)) >= _OBJECT_KEYS]


def _person(source: Source) -> Record:
    path = source.path / PERSON if source.is_folder else source.path
    return Record(path, NpzObjects(path))


def _load(source: Source, options: Options) -> Motion:
    record = _person(source)
    shape = record.shape("poses", "(T, 156)")
    width = shape[1] if len(shape) == 2 else 0
    if width not in (*_WIDTHS, _WITH_COMPONENTS):
        raise record.error(
            "poses", f"found shape {shape}, expected (T, 156), (T, 165), or (T, 90) with "
            "principal components"
        )  # fmt: skip
    poses = record.array("poses", None, width, frames=options.frames)
    translation = record.array("trans", None, 3, frames=options.frames)
    frames = same_length(record.where, {k: len(record.raw(k)) for k in ("poses", "trans")})
    gender = said_gender(record)
    hands: Literal["flat", "mean"] = "flat"
    if width == _WITH_COMPONENTS:
        parts = dict(zip(HANDS, np.split(poses[:, 3 * len(_BODY) :], 2, axis=1), strict=True))
        fingers, hands = relaxed_fingers(record, options, gender or "neutral", parts)
        rotations = rotations_of({_BODY: poses[:, : 3 * len(_BODY)], **fingers})
    else:
        rotations = rotations_of({_columns(source, poses): poses})
        _warn_of_guesses(source, options, width)
    return motion_of(
        record.where,
        options,
        format=NAME,
        translation=translation,
        rotations=rotations,
        fps=FPS,
        up="y",
        model="smplh" if width == 156 else "smplx",
        gender=gender,
        betas=median_shape(record, frames),
        hands=hands,
    )


def _columns(source: Source, poses: Array) -> tuple[int, ...]:
    """The joints of each three columns: those of AMASS, if its face is still and fingers are not.

    A file with still fingers fits both orders.
    """
    order = _WIDTHS[poses.shape[1]]
    if len(order) != skeleton.N_JOINTS or poses[:, _AMASS_FACE].any():
        return order
    if not poses[:, _AMASS_FACE.stop : 156].any():
        return order
    warn(
        f"{source.path}: field 'poses': a still face before the fingers: read in the order of AMASS"
    )
    return tuple(range(skeleton.N_JOINTS))


def _warn_of_guesses(source: Source, options: Options, width: int) -> None:
    guesses = [f"{options.fps or FPS:g} fps"]
    if width == 156 and (options.model is None or str(options.model) not in MODELS):
        guesses.append("SMPL-H (model='smplx' for those of its data sets that have SMPL-X)")
    if options.hands is None:
        guesses.append("a flat hand where fingers are zero (hands=)")
    warn(f"{source.path}: files of InterAct do not say what is taken: {', '.join(guesses)}")


def _load_sequence(source: Source, options: Options) -> Sequence:
    motion = _load(source, options)
    files = _object_files(source)
    if not files:
        raise FileError(
            f"{source.path}: its object is in {OBJECT} or object_NAME.npz beside it, which are not "
            "there. Copy them there, or read the motion alone with Motion.load"
        )
    scene, tracks = Scene(), {}
    total = len(_person(source).raw("trans"))
    for path in files:
        name, track = _add_object(source, options, motion, scene, note(path), total)
        tracks[name] = track
    body = body_of_betas(options, motion, tracks, f"{source.path}: {_UNSAID}")
    return Sequence(motion, scene, body, recorded=tracks)


def _add_object(
    source: Source, options: Options, motion: Motion, scene: Scene, path: Path, total: int
) -> tuple[str, ObjectTrack]:
    record = Record(path, NpzObjects(path))
    turns = record.array("angles", None, 3, frames=options.frames)
    places = record.array("trans", None, 3, frames=options.frames)
    lengths = {"angles": len(record.raw("angles")), "trans": len(record.raw("trans"))}
    same_length(record.where, lengths | {PERSON: total})
    name = _name(record)
    whole, _, part = name.rpartition("_")
    files = [f"{name}/{name}.obj", f"{name}/mesh.obj"]
    files += [f"{whole}/{part}.obj", f"{whole}/{whole}.obj"] if whole else []
    below = [f"{folder}{file}" for folder in ("objects/", "") for file in files]
    mesh = find(source, options, below, f"the mesh of {name!r}")
    with of_file(record.where):
        track = add_recorded(
            scene,
            name,
            mesh,
            places,
            rot.rotvec_to_matrix(turns),
            where=record.where,
            axes=motion.axes,
            fps=motion.fps,
            options=options,
        )
    return name, track


def _name(record: Record) -> str:
    """The object's name, which becomes part of a path."""
    key = "instance_name" if "name" not in record and "instance_name" in record else "name"
    name = record.text(key)
    if not name or {"/", "\\", ":"} & set(name) or ".." in name:
        raise record.error(key, f"found {name!r}, expected the name of an object, such as 'chair'")
    return name


FORMAT = Format(
    name=NAME,
    about="InterAct: people and objects of many data sets in one layout",
    invents="the frame rate (30), SMPL-H or SMPL-X, flat or relaxed hands, the size in metres",
    expects=f"a folder with {PERSON} (poses (T, 156) or (T, 165), trans, betas, gender) and "
    f"{OBJECT} (angles, trans, name)",
    sniff=_sniff,
    load=_load,
    load_sequence=_load_sequence,
)
