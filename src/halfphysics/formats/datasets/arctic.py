"""ARCTIC npy: a person who handles an object of two parts; z-up, 30 fps.

`s01/box_grab_01.smplx.npy` is a pickled dict: `transl, global_orient (T, 3) body_pose (T, 63)
jaw_pose, leye_pose, reye_pose (T, 3) left_hand_pose, right_hand_pose (T, 45)`, fingers on a flat
hand. Beside it, `box_grab_01.object.npy (T, 7)`: see `arctic_object`. The body has no betas but the
subject's own template, `meta/subject_vtemplates/s01.obj`; its gender is in `meta/misc.json`.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import stored_objects as stored
from halfphysics.base.atomic import atomic_write
from halfphysics.base.npy import Npy
from halfphysics.base.stored_objects import write_object_array
from halfphysics.errors import FileError
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.datasets.arctic_object import PARTS as OBJECT_PARTS
from halfphysics.formats.datasets.arctic_object import add_hinged
from halfphysics.formats.datasets.assets import ends, find, note, seek
from halfphysics.formats.datasets.recorded import of_file
from halfphysics.formats.datasets.subject import subject_body
from halfphysics.formats.format import Format, Options, Source
from halfphysics.formats.motion_builder import (
    file_parameters,
    lost_rate,
    motion_of,
    own_fields,
    rotations_of,
    same_length,
)
from halfphysics.motion.motion import Motion
from halfphysics.motion.smplx_names import PARTS
from halfphysics.scene.scene import Scene
from halfphysics.simulation.sequence import Sequence

if TYPE_CHECKING:
    from halfphysics.body.body import Body

Array = NDArray[np.float64]

NAME = "arctic"
FPS = 30.0
_ENDING, _OBJECT = ".smplx.npy", ".object.npy"
_FIELDS = ("transl", *PARTS)
_ENOUGH = 4
#: Other files of a clip -> the keys that identify them.
_BESIDE = {
    "the hands (MANO)": {"left", "right"},
    "the head camera": {"R_k_cam_np", "T_k_cam_np"},
}


def _sniff(source: Source) -> bool:
    npy = source.npy
    if npy is None:
        return False
    if not npy.dtype.hasobject:
        if source.path.name.endswith(_OBJECT) and npy.shape[1:] == (7,):
            raise _not_the_body(source, "the object")
        return False
    data = source.data
    if not isinstance(data, dict):
        return False
    for what, keys in _BESIDE.items():
        if keys <= data.keys():
            raise _not_the_body(source, what)
    # Dicts with betas come from other programs, with other axes.
    return len(data.keys() & set(_FIELDS)) >= _ENOUGH and "betas" not in data


def _not_the_body(source: Source, what: str) -> FileError:
    name = source.path.name.split(".")[0] + _ENDING
    return FileError(
        f"{source.path}: this is {what} of an ARCTIC clip, expected its body. Load {name} beside "
        "it; load_sequence finds the object by itself"
    )


def _load(source: Source, options: Options) -> Motion:
    record = Record(source.path, source.data)
    parts = {
        key: record.array(key, None, 3 * len(joints), frames=options.frames)
        for key, joints in PARTS.items()
    }
    translation = record.array("transl", None, 3, frames=options.frames)
    same_length(record.where, {key: len(record.raw(key)) for key in _FIELDS})
    return motion_of(
        record.where,
        options,
        format=NAME,
        translation=translation,
        rotations=rotations_of({PARTS[key]: part for key, part in parts.items()}),
        fps=FPS,
        up="z",
        model="smplx",
        gender=_gender(source, options),
        fields={"template": f"meta/subject_vtemplates/{_subject(source)}.obj"},
    )


def _subject(source: Source) -> str:
    return source.path.resolve().parent.name


def _gender(source: Source, options: Options) -> str | None:
    """The subject's gender in the data set's table; None if it is not there."""
    if options.gender is not None:
        return options.gender
    path = seek(source, options, ends("meta/misc.json"))
    if path is None:
        return None
    try:
        said = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise FileError(
            f"{source.path}: its subjects' table {path} cannot be read ({error}). Copy it again, "
            "or say gender="
        ) from None
    subject = said.get(_subject(source)) if isinstance(said, dict) else None
    return str(subject["gender"]) if isinstance(subject, dict) and "gender" in subject else None


def _load_sequence(source: Source, options: Options) -> Sequence:
    motion = _load(source, options)
    scene = Scene()
    name, pose = _object(source, options)
    meshes = {
        part: find(
            source,
            options,
            ends(f"meta/object_vtemplates/{name}/{part}.obj")[:-1],
            f"the mesh of the {part} of {name!r}",
        )
        for part in OBJECT_PARTS
    }
    with of_file(str(source.path)):
        tracks = add_hinged(
            scene,
            name,
            meshes,
            pose,
            where=str(source.path),
            axes=motion.axes,
            fps=motion.fps,
            options=options,
        )
    template = ends(own_fields(motion)["template"])
    body = subject_body(source, options, motion=motion, tracks=tracks, template=template)
    return Sequence(motion, scene, body, recorded=tracks)


def _object(source: Source, options: Options) -> tuple[str, Array]:
    """Name and poses (T, 7) of the object."""
    clip = source.path.name.removesuffix(_ENDING).removesuffix(".npy")
    path = source.path.with_name(clip + _OBJECT)
    if not path.is_file():
        raise FileError(
            f"{source.path}: its object is in {path.name} beside it, which is not there. Copy it "
            "there, or read the motion alone with Motion.load"
        )
    npy = Npy(note(path))
    array: Any = stored.read(path) if npy.dtype.hasobject else npy.array
    record = Record(path, {"array": array})
    total = len(Record(source.path, source.data).raw("transl"))
    pose = record.array("array", None, 7, frames=options.frames)
    same_length(str(source.path), {"transl": total, path.name: len(array)})
    return clip.split("_")[0], pose


def _save(motion: Motion, path: Path, body: Body | None) -> None:
    translation, rotations, _ = file_parameters(motion, NAME)
    fields = {
        key: rotations[:, list(joints)].reshape(len(motion), -1) for key, joints in PARTS.items()
    }
    with atomic_write(path) as handle:
        write_object_array(handle, {"transl": translation, **fields})


def _loses(motion: Motion) -> tuple[str, ...]:
    lost = []
    if motion.betas is not None and motion.betas.any():
        lost.append("the shape (betas)")
    lost += lost_rate(motion, FPS)
    if motion.gender != "neutral" and (motion.origin is None or motion.origin.format != NAME):
        lost.append(f"the gender {motion.gender!r}: readers look for it in meta/misc.json")
    return tuple(lost)


FORMAT = Format(
    name=NAME,
    about="ARCTIC: hands and articulated objects",
    invents="the person's shape, the frame rate (30)",
    expects="npy with a dict of transl, global_orient, body_pose, left_hand_pose, right_hand_pose",
    sniff=_sniff,
    load=_load,
    load_sequence=_load_sequence,
    save=_save,
    suffixes=(".npy",),
    up="z",
    loses=_loses,
)
