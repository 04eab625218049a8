"""OMOMO joblib `.p`: id -> clip, some thousands in one file; z-up, 30 fps, no fingers.

A clip is `seq_name` ("sub3_largebox_003"), `betas (1, 16)`, `gender`, `trans root_orient (T, 3)`,
`pose_body (T, 63)` of SMPL-X (its own loader poses SMPL-X with 16 betas), and the object named in
`seq_name`: `obj_trans (T, 3, 1)`, `obj_rot (T, 3, 3)`, `obj_scale (T,)`; for vacuum and
mop these are the top part, and `obj_bottom_*` the bottom part. In the world, vertices are
`scale * (R v) + t`. Meshes: `captured_objects/NAME_cleaned_simplified.obj`, of parts
`NAME_cleaned_simplified_top.obj` and `_bottom.obj`.

The person's bones are `rest_offsets (24, 3)` or `(22, 3)`, of joints 0 to 21 and of the two middle
knuckles (SMPL-X 28 and 43): each joint from its parent at rest. Row 0 is unused: readers write
`trans` there. The pelvis is at `trans - trans2joint (3,)`, so at rest at `-trans2joint`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.reader_warnings import warn
from halfphysics.base.stored_objects import write
from halfphysics.body.body import Body
from halfphysics.errors import FileError, InputError
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.datasets.assets import find
from halfphysics.formats.datasets.recorded import add_recorded
from halfphysics.formats.format import Format, Options, Source
from halfphysics.formats.gender_names import said_gender
from halfphysics.formats.motion_builder import (
    file_parameters,
    lost_joints,
    lost_model,
    lost_rate,
    motion_of,
    own_name,
    rotations_of,
    same_length,
)
from halfphysics.geometry.mesh_files import load_mesh
from halfphysics.motion import skeleton
from halfphysics.motion.motion import MODELS, Motion
from halfphysics.scene.scene import Scene
from halfphysics.simulation.sequence import Sequence

Array = NDArray[np.float64]

NAME = "omomo"
FPS = 30.0
_BETAS = 16
_PERSON = ("trans", "root_orient", "pose_body")
#: Keys of the training windows that the data set's own loader cuts from clips: not motions.
_WINDOW = {"motion", "start_t_idx", "end_t_idx"}
#: Usual folders of the meshes, under the root of the data set.
_FOLDERS = ("captured_objects/", "data/captured_objects/", "objects/", "")
#: SMPL-X joints of the rows of `rest_offsets`.
_BONES = (*skeleton.SMPL_JOINTS, *(skeleton.JOINT_INDEX[f"{s}_middle1"] for s in ("left", "right")))
#: Relative size change of a rigid object above which a warning is given.
_SAME_SIZE = 0.01


@dataclass(frozen=True)
class _Part:
    """A rigid object of a clip: prefix of its fields, endings of its name and mesh file."""

    fields: str
    ending: str
    mesh: str


_WHOLE = _Part("obj_", "", "")
_TOP = _Part("obj_", "", "_top")
_BOTTOM = _Part("obj_bottom_", "_bottom", "_bottom")
_OBJECT = tuple(f"{p.fields}{k}" for p in (_WHOLE, _BOTTOM) for k in ("trans", "rot", "scale"))


def _sniff(source: Source) -> bool:
    data = source.data
    if not isinstance(data, dict) or not data:
        return False
    first = next(iter(data.values()))
    if not isinstance(first, Mapping) or "seq_name" not in first:
        return False
    if set(first) >= _WINDOW:
        raise FileError(
            f"{source.path}: OMOMO's windows for training, cut and turned; expected its clips, "
            "such as train_diffusion_manip_seq_joints24.p beside it"
        )
    return any(key in first for key in _PERSON)


_Clips: TypeAlias = dict[str, tuple[Any, Mapping[str, Any]]]
#: Clips of each open file: it has thousands, and all are loaded in turn.
_KNOWN: WeakKeyDictionary[Source, _Clips] = WeakKeyDictionary()


def _by_name(source: Source) -> _Clips:
    """Name -> id and fields of every clip."""
    if source in _KNOWN:
        return _KNOWN[source]
    clips: _Clips = {}
    for id, fields in source.data.items():
        if not isinstance(fields, Mapping):
            raise FileError(
                f"{source.path}: clip {id!r}: found {type(fields).__name__}, expected a dict of "
                "its fields"
            )
        name = Record(f"{source.path}, clip {id!r}", fields).text("seq_name")
        clips[own_name(name, clips)] = id, fields
    _KNOWN[source] = clips
    return clips


def _names(source: Source) -> Iterable[str]:
    return _by_name(source)


def _record(source: Source, options: Options) -> tuple[Any, Record]:
    """Id and fields of the chosen clip; per-frame fields have equal lengths."""
    id, fields = _by_name(source)[options.clip]
    record = Record(f"{source.path}, clip {options.clip!r}", fields)
    lengths = {
        key: len(fields[key])
        for key in (*_PERSON, *_OBJECT, "obj_com_pos")
        if getattr(fields.get(key), "ndim", 0) > 0
    }
    if lengths:
        same_length(record.where, lengths)
    return id, record


def _load(source: Source, options: Options) -> Motion:
    id, record = _record(source, options)
    translation = record.array("trans", None, 3, frames=options.frames)
    root = record.array("root_orient", None, 3, frames=options.frames)
    if getattr(record.fields.get("pose_body"), "ndim", 0) == 3:
        body = record.array("pose_body", None, 21, 3, frames=options.frames)
    else:
        body = record.array("pose_body", None, 63, frames=options.frames)
    frames = len(record.fields["trans"])
    betas = record.raw("betas", f"(1, {_BETAS})")
    per_frame, constant = {}, {}
    for key, value in record.fields.items():
        if key in (*_PERSON, "betas", "gender"):
            continue
        rows = isinstance(value, np.ndarray) and value.ndim > 0 and len(value) == frames
        if rows and value.dtype.kind == "f" and key.startswith("obj_"):
            per_frame[key] = value[options.frames]
        else:
            constant[key] = value
    return motion_of(
        record.where,
        options,
        format=NAME,
        translation=translation,
        rotations=rotations_of({(0,): root, skeleton.BODY_JOINTS: body}),
        fps=FPS,
        up="z",
        model="smplx",
        gender=said_gender(record),
        betas=record.array("betas", *getattr(betas, "shape", (None,))),
        hands=None,
        fields={"id": id, "constant": constant},
        per_frame=per_frame,
    )


def _load_sequence(source: Source, options: Options) -> Sequence:
    motion = _load(source, options)
    _, record = _record(source, options)
    body = _body(record, options)
    if not any(key in record for key in _OBJECT):
        return Sequence(motion, Scene(), body=body)
    title = record.text("seq_name")
    words = title.split("_")
    if len(words) < 2:
        raise record.error(
            "seq_name", f"found {title!r}, expected SUBJECT_OBJECT_NUMBER: which object"
        )
    parts = (_TOP, _BOTTOM) if any(k.startswith(_BOTTOM.fields) for k in record.fields) else None
    scene, tracks = Scene(), {}
    for part in parts or (_WHOLE,):
        name = words[1] + part.ending
        mesh = f"{words[1]}_cleaned_simplified{part.mesh}.obj"
        path = find(source, options, [f + mesh for f in _FOLDERS], f"the mesh of {name!r}")
        trans = f"{part.fields}trans"
        column = (1,) if getattr(record.fields.get(trans), "ndim", 0) == 3 else ()
        position = record.array(trans, None, 3, *column, frames=options.frames).reshape(-1, 3)
        rotation = record.array(f"{part.fields}rot", None, 3, 3, frames=options.frames)
        sizes = _sizes(record, f"{part.fields}scale", options.frames)
        if np.ptp(sizes):
            # Scaling is about the mesh origin, which may be far away: keep the centre in place.
            middle = load_mesh(path, up="z")[0].vertices
            middle = 0.5 * (middle.min(axis=0) + middle.max(axis=0))
            position += (sizes - sizes[0])[:, None] * (rotation @ middle)
        tracks[name] = add_recorded(
            scene,
            name,
            path,
            position,
            rotation,
            where=record.where,
            axes=motion.axes,
            fps=motion.fps,
            options=options,
            scale=float(sizes[0]),
        )
    if parts and options.objects == "free":
        warn(f"{record.where}: nothing holds the two parts of {words[1]!r} together here")
    return Sequence(motion, scene, body=body, recorded=tracks)


def _body(record: Record, options: Options) -> Body | None:
    """The default body with the person's bones; None: the caller has a model, or none are there."""
    if options.model is not None and str(options.model) not in MODELS:
        return None
    bones = np.full((skeleton.N_JOINTS, 3), np.nan)
    try:
        if "rest_offsets" not in record:
            raise InputError("field 'rest_offsets' is missing")
        offsets = record.array("rest_offsets", None, 3)
        if len(offsets) not in (22, len(_BONES)):
            raise InputError(f"field 'rest_offsets': found {len(offsets)} rows, expected 24 or 22")
        bones[list(_BONES[: len(offsets)])] = offsets
        bones[0] = np.nan
        if "trans2joint" in record:
            bones[0] = -record.array("trans2joint", 3)
        body = Body.default(bones=bones)
    except (FileError, InputError) as error:
        text = str(error).removeprefix(f"{record.where}: ")
        warn(
            f"{record.where}: {text}: the person is as big as Body.default(), which is taken. "
            "Give a body of your own, or model="
        )
        return None
    warn(
        f"{record.where}: the default body has the recorded bones: stature {body.stature:.2f} "
        "m. For the person's own shape give a body of their model"
    )
    return body


def _sizes(record: Record, key: str, frames: slice) -> Array:
    """The sizes (T,); the caller uses that of the first frame throughout."""
    scale = record.array(key, None, frames=frames)
    if (scale <= 0.0).any():
        at = int(np.argmax(scale <= 0.0))
        raise record.error(key, f"found {scale[at]:g} in frame {at}, expected a number above 0")
    off = float(np.abs(scale / scale[0] - 1.0).max())
    if off > _SAME_SIZE:
        warn(
            f"{record.where}: field '{key}': the object changes its size by {100 * off:.2g} %; "
            f"that of the first frame, {scale[0]:.4g}, is taken all the time"
        )
    return scale


def _save(motion: Motion, path: Path, body: Body | None) -> None:
    translation, rotations, said = file_parameters(motion, NAME)
    betas = np.zeros((1, _BETAS))
    if motion.betas is not None:
        count = min(len(motion.betas), _BETAS)
        betas[0, :count] = motion.betas[:count]
    clip = {
        "seq_name": path.stem,
        **said.get("constant", {}),
        "betas": betas,
        "gender": motion.gender,
        "trans": translation,
        "root_orient": rotations[:, 0],
        "pose_body": rotations[:, list(skeleton.BODY_JOINTS)].reshape(-1, 63),
    }
    if said and motion.origin is not None:
        for key, rows in motion.origin.per_frame.items():
            clip[key] = _nearest_rotations(rows) if key.endswith("_rot") else rows
    write(path, {said.get("id", 0): clip})


def _nearest_rotations(matrices: NDArray[Any]) -> Array:
    """The nearest rotations to matrices (T, 3, 3) that were interpolated by entry."""
    u, _, v = np.linalg.svd(matrices.astype(np.float64))
    return np.asarray(u @ v)


def _loses(motion: Motion) -> tuple[str, ...]:
    lost = [*lost_joints(motion, skeleton.SMPL_JOINTS), *lost_model(motion)]
    if motion.betas is not None and motion.betas[_BETAS:].any():
        lost.append(f"betas after the first {_BETAS}")
    lost += lost_rate(motion, FPS)
    return tuple(lost)


FORMAT = Format(
    name=NAME,
    about="OMOMO: people who move objects, thousands of clips in a file",
    invents="fingers, the girth of the person",
    expects="joblib .p of id -> clip with seq_name, trans, root_orient, pose_body, obj_trans",
    sniff=_sniff,
    load=_load,
    load_sequence=_load_sequence,
    clips=_names,
    save=_save,
    tells_bones=True,
    suffixes=(".p",),
    loses=_loses,
)
