"""BEHAVE, annotated at 30 fps: a person and an object before four Kinects; y-down, no floor.

A sequence is a folder such as `sequences/Date01_Sub01_boxlarge_hand` with

- `smpl_fit_all.npz`: `poses (T, 156)` of SMPL-H, fingers on a flat hand, `trans (T, 3)` [m],
  `betas (T, 10)`, `frame_times (T,)` as "t0003.000" [s];
- `object_fit_all.npz`: `angles (T, 3)` axis-angle, `trans (T, 3)` [m], `frame_times (T,)`;
- `info.json`: `gender`, and `cat`, the object.

All is in the frame of the first Kinect: x right, y down, z ahead. Copies that were turned so
that y is up (InterAct's) are recognised by how the person stands. The object's poses are of its
mesh `objects/NAME/NAME_f1000.ply`, or another with fewer faces than the scan, after the mean of its
vertices was subtracted.

The person's size is in the betas. Without the SMPL-H model they say nothing in metres, and neither
does anything else in the files: it is taken from the motion (`size_from_motion`), and the pelvis of
SMPL-H at rest, to which `trans` adds, is that of the free body.
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.npz_objects import NpzObjects
from halfphysics.base.reader_warnings import warn
from halfphysics.body.model_files import mesh_vertices
from halfphysics.errors import FileError
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.datasets.assets import find, note
from halfphysics.formats.datasets.median_shape import median_shape
from halfphysics.formats.datasets.recorded import add_recorded, of_file
from halfphysics.formats.datasets.subject import body_of_betas
from halfphysics.formats.format import Format, Options, Source
from halfphysics.formats.motion_builder import motion_of, rotations_of, same_length
from halfphysics.motion import skeleton
from halfphysics.motion.motion import Motion
from halfphysics.results.result import ObjectTrack
from halfphysics.scene.scene import Scene
from halfphysics.simulation.sequence import Sequence

Array = NDArray[np.float64]

NAME = "behave"
FPS = 30.0
PERSON, OBJECT, INFO = "smpl_fit_all.npz", "object_fit_all.npz", "info.json"
_PERSON_KEYS, _OBJECT_KEYS = {"poses", "trans", "frame_times"}, {"angles", "trans", "frame_times"}
_WIDTH = 156
#: Numbers of faces in the names of the meshes to which poses belong.
_FACES = ("f1000", "f2500", "f2000", "f1500", "closed_f1000")
#: Frames farther apart than this many periods are a gap.
_GAP = 1.5

_UNSAID = "nothing says how tall the person is in metres"


def _sniff(source: Source) -> bool:
    if source.is_folder:
        return (source.path / PERSON).is_file()
    if source.npz is None:
        return False
    keys = set(source.npz)
    if keys >= _OBJECT_KEYS:
        raise FileError(
            f"{source.path}: this is the object of a BEHAVE sequence, expected its person. Load "
            f"{PERSON} beside it, or their folder; load_sequence finds the object by itself"
        )
    return keys >= _PERSON_KEYS


def _folder(source: Source) -> Path:
    return source.path if source.is_folder else source.path.resolve().parent


def _person(source: Source) -> Record:
    path = source.path / PERSON if source.is_folder else source.path
    return Record(path, NpzObjects(path))


def _info(source: Source) -> dict[str, Any]:
    """The content of `info.json`; empty if there is none."""
    path = _folder(source) / INFO
    if not path.is_file():
        return {}
    try:
        said = json.loads(note(path).read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise FileError(f"{path}: cannot be read ({error}). Copy it again, or remove it") from None
    return said if isinstance(said, dict) else {}


def _load(source: Source, options: Options) -> Motion:
    record = _person(source)
    poses = record.array("poses", None, _WIDTH, frames=options.frames)
    translation = record.array("trans", None, 3, frames=options.frames)
    times = _times(record)
    lengths = {key: len(record.raw(key)) for key in ("poses", "trans")}
    same_length(record.where, lengths | {"frame_times": len(times)})
    _warn_of_gaps(record.where, times[options.frames])
    rotations = rotations_of({skeleton.SMPLH_JOINTS: poses})
    gender = _info(source).get("gender")
    return motion_of(
        record.where,
        options,
        format=NAME,
        translation=translation,
        rotations=rotations,
        fps=FPS,
        up=_up(record.where, rotations, options),
        model="smplh",
        gender=str(gender) if gender is not None else None,
        betas=median_shape(record, len(times)),
    )


def _up(where: str, rotations: Array, options: Options) -> Literal["y", "-y"]:
    """Where up is: against the camera's y axis, unless the person stands the other way."""
    if not len(rotations) or options.up is not None:
        return "-y"
    trunk = rot.to_matrix(rot.exp(rotations[:, 0]))[:, :, 1].mean(axis=0)
    if trunk[1] <= 0.0:
        return "-y"
    warn(
        f"{where}: BEHAVE has y down, and the person stands along y: read with y up, as in turned "
        "copies of it"
    )
    return "y"


def _times(record: Record) -> Array:
    """Times of the frames (T,) [s]; text of any kind that ends in a number."""
    values = record.flat("frame_times", "(T,)")
    out = np.empty(len(values))
    for row, value in enumerate(values):
        text = value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)
        found = re.fullmatch(r"t?(\d+(?:\.\d+)?)", text.strip())
        if found is None:
            raise record.error(
                "frame_times", f"found {text!r} in frame {row}, expected a time such as 't0003.000'"
            )
        out[row] = float(found[1])
    return out


def _warn_of_gaps(where: str, times: Array) -> None:
    steps = np.diff(times)
    if len(steps) and steps.max() > _GAP / FPS:
        at = int(np.argmax(steps))
        warn(
            f"{where}: {int((steps > _GAP / FPS).sum())} gaps: between frames {at} and {at + 1} "
            f"are {steps[at]:.2f} s. Read a part without gaps with frames=(start, stop)"
        )


def _load_sequence(source: Source, options: Options) -> Sequence:
    motion = _load(source, options)
    scene = Scene()
    tracks = _add_object(source, options, motion, scene)
    body = body_of_betas(options, motion, tracks, f"{source.path}: {_UNSAID}")
    return Sequence(motion, scene, body, recorded=tracks)


def _add_object(
    source: Source, options: Options, motion: Motion, scene: Scene
) -> dict[str, ObjectTrack]:
    path = _folder(source) / OBJECT
    if not path.is_file():
        raise FileError(
            f"{source.path}: its object is in {OBJECT} beside it, which is not there. Copy it "
            "there, or read the motion alone with Motion.load"
        )
    record = Record(note(path), NpzObjects(path))
    turns = record.array("angles", None, 3, frames=options.frames)
    places = record.array("trans", None, 3, frames=options.frames)
    own, others = _times(_person(source)), _times(record)
    lengths = {"angles": len(record.raw("angles")), "trans": len(record.raw("trans"))}
    same_length(record.where, lengths | {PERSON: len(own)})
    if len(others) != len(own) or np.abs(others - own).max(initial=0.0) > 0.5 / FPS:
        raise record.error(
            "frame_times", f"found other times than in {PERSON}, expected the same frames in both"
        )
    name = _object_name(source)
    files = [f"objects/{name}/{name}_{faces}.ply" for faces in _FACES]
    files += [f"{name}/{name}_{faces}.ply" for faces in _FACES]
    files += [f"objects/{name}/{name}.obj", f"{name}/{name}.obj"]
    mesh = find(source, options, files, f"the mesh of {name!r}")
    matrix = rot.rotvec_to_matrix(turns)
    middle = mesh_vertices(mesh).mean(axis=0) / options.unit
    with of_file(record.where):
        track = add_recorded(
            scene,
            name,
            mesh,
            places - matrix @ middle,
            matrix,
            where=record.where,
            axes=motion.axes,
            fps=motion.fps,
            options=options,
        )
    return {name: track}


def _object_name(source: Source) -> str:
    """The object that `info.json` names, or the third word of the folder's name."""
    named = _info(source).get("cat")
    words = _folder(source).name.split("_")
    if isinstance(named, str) and named:
        return named
    if len(words) < 3:
        raise FileError(
            f"{source.path}: which object it is, is in {INFO} ('cat') or in the folder's name, "
            "expected DATE_SUBJECT_OBJECT, found neither"
        )
    return words[2]


FORMAT = Format(
    name=NAME,
    about="BEHAVE at 30 fps: a person and an object before Kinects",
    invents="the person's size in metres, the floor",
    expects=f"a folder with {PERSON} (poses (T, {_WIDTH}), trans, frame_times) and {OBJECT}",
    sniff=_sniff,
    load=_load,
    load_sequence=_load_sequence,
)
