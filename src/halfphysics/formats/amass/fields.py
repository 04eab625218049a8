"""Reading and writing of fields, shared by the AMASS layouts (SMPL-X, SMPL-H, SMPL).

Layouts differ in the columns of `poses`. A motion is written with the keys of the file it came
from; rotations that its columns cannot hold (fingers bent by contact in a file without fingers) go
into the extra key ``poses_smplx (T, 165)``, which other readers ignore.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.npz import Npz
from halfphysics.base.npz_objects import NpzObjects
from halfphysics.base.reader_warnings import warn
from halfphysics.base.validation import shown
from halfphysics.errors import FileError, InputError
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.format import Options, Source
from halfphysics.formats.gender_names import gender_named
from halfphysics.formats.motion_builder import (
    file_parameters,
    made,
    mean_hands,
    rate_of,
    rotations_of,
    same_length,
    shape_of,
)
from halfphysics.formats.rate_names import is_of_video, is_rate, rate_keys
from halfphysics.motion import skeleton
from halfphysics.motion.file_metadata import FileMetadata
from halfphysics.motion.motion import GENDERS, MODELS, Motion

Array = NDArray[np.float64]
Fields = dict[str, NDArray[Any]]

#: Columns of `poses` -> the SMPL-X joint of each three (-1: none, SMPL's rigid hands).
COLUMNS: Mapping[int, tuple[int, ...]] = {
    165: tuple(range(skeleton.N_JOINTS)),
    156: skeleton.SMPLH_JOINTS,
    72: (*skeleton.SMPL_JOINTS, -1, -1),
    66: skeleton.SMPL_JOINTS,
}
_MODEL_OF_WIDTH = {165: "smplx", 156: "smplh", 72: "smpl"}
#: The same rotations by part, which SMPL-X files have besides or instead of `poses`.
SPLIT: Mapping[str, tuple[int, ...]] = {
    "root_orient": (0,),
    "pose_body": skeleton.BODY_JOINTS,
    "pose_hand": skeleton.LEFT_HAND_JOINTS + skeleton.RIGHT_HAND_JOINTS,
    "pose_jaw": (22,),
    "pose_eye": (23, 24),
}
#: The frame rate, the first of them that is there; else another name of it (`rate_names`).
FPS_KEYS = ("mocap_frame_rate", "mocap_framerate", "fps")
FULL_KEY = "poses_smplx"
#: Shape coefficients of the largest model (300, and 100 of the face).
_MOST_BETAS = 400
#: Bytes of a field beside the motion that is kept for writing.
_MOST_KEPT = 2**26
_KNOWN = {
    "trans", "poses", "betas", "num_betas", "gender", "surface_model_type", "mocap_time_length",
    FULL_KEY, *SPLIT,
}  # fmt: skip
#: Fields of one number or word.
_WORDS = ("gender", "surface_model_type", "mocap_time_length", "num_betas")


def width_of(source: Source) -> int | None:
    """Number of columns of `poses` (or of the split fields); None if the file is not AMASS.

    Raises:
        FileError: The keys are AMASS's, but no layout has this width.
    """
    npz = source.npz
    if npz is None or "v_template" in npz:
        return None
    if "poses" in npz:
        shape, _ = npz.header("poses")
        width = row_width(shape)
        if width in COLUMNS:
            return width
        raise FileError(
            f"{source.path}: field 'poses': found shape {shape}, expected (T, 165) for SMPL-X, "
            "(T, 156) for SMPL-H, (T, 72) for SMPL or (T, 66) without hands, or (T, joints, 3). "
            "Axis-angle of all joints in one row per frame"
        )
    if "root_orient" in npz and "pose_body" in npz:
        if "pose_jaw" in npz or "pose_eye" in npz:
            return 165
        return 156 if "pose_hand" in npz else 66
    return None


def row_width(shape: tuple[int, ...]) -> int:
    """Numbers in a row of rotations (T, 3 joints) or (T, joints, 3); 0: it is neither."""
    if len(shape) == 3 and shape[2] == 3:
        return 3 * shape[1]
    return shape[1] if len(shape) == 2 else 0


def _rows(npz: Npz, key: str, width: int, frames: slice) -> NDArray[Any]:
    """Rotations (T, width), also of a field (T, joints, 3)."""
    apart = len(npz.header(key)[0]) == 3
    columns = (width // 3, 3) if apart else (width,)
    rows = Record(npz.path, npz).numbers(key, None, *columns, frames=frames)
    return rows.reshape(len(rows), width)


def _rotations(npz: Npz, width: int, frames: slice) -> tuple[Array, Array | None]:
    """Rotations (T, 55, 3) in file axes, and SMPL's rigid hands (T, 2, 3) if present."""
    rigid = None
    if "poses" in npz:
        columns = COLUMNS[width]
        poses = np.array(_rows(npz, "poses", width, frames), dtype=np.float64)
        poses = poses.reshape(-1, len(columns), 3)
        if columns == tuple(range(skeleton.N_JOINTS)):
            full = poses
        else:
            full = np.zeros((len(poses), skeleton.N_JOINTS, 3))
            count = sum(joint >= 0 for joint in columns)  # SMPL's rigid hands are last
            full[:, columns[:count]] = poses[:, :count]
            for key, joints in SPLIT.items():
                # A face field beside `poses` without a face.
                if key in npz and not set(joints) & set(columns):
                    part = _rows(npz, key, 3 * len(joints), frames)
                    same_length(str(npz.path), {"poses": len(poses), key: len(part)})
                    full[:, list(joints)] = part.reshape(-1, len(joints), 3)
            rigid = poses[:, count:] if count < len(columns) else None
    else:
        parts = {
            key: _rows(npz, key, 3 * len(joints), frames)
            for key, joints in SPLIT.items()
            if key in npz
        }
        same_length(str(npz.path), {key: len(part) for key, part in parts.items()})
        full = rotations_of({SPLIT[key]: part for key, part in parts.items()})
    if FULL_KEY in npz:
        whole = Record(npz.path, npz).array(FULL_KEY, None, 3 * skeleton.N_JOINTS, frames=frames)
        whole = whole.reshape(-1, 55, 3)
        held = [joint for joint in COLUMNS[width] if joint >= 0]
        if "poses" not in npz:
            held = [joint for key, joints in SPLIT.items() if key in npz for joint in joints]
        if whole.shape == full.shape and np.array_equal(whole[:, held], full[:, held]):
            full = whole
        else:
            warn(f"{npz.path}: field '{FULL_KEY}' does not belong to the poses beside it: ignored")
    return full, rigid


def _fps(npz: Npz, options: Options, usual: float | None) -> tuple[float, str]:
    """The frame rate, and its key; `usual` is that of the format where the file has none."""
    keys = rate_keys((key for key in npz if "/" not in key), FPS_KEYS)
    if options.fps is not None:
        return options.fps, keys[0] if keys else FPS_KEYS[0]
    said = ((key, _small(npz, key)) for key in keys)
    key, value = next(((k, v) for k, v in said if v is not None), (FPS_KEYS[0], None))
    if value is None:
        return rate_of(str(npz.path), options, usual), keys[0] if keys else key
    if value.size != 1 or value.dtype.kind not in "fiu" or not 0.0 < float(value.flat[0]) < 1e6:
        raise FileError(
            f"{npz.path}: field '{key}': found {value.tolist()!r}, expected a positive number of "
            "frames per second. Say it with fps=, for example fps=30"
        )
    return float(value.flat[0]), key


def _small(npz: Npz, key: str, most: int = 16) -> NDArray[Any] | None:
    """A field of few numbers or words, refused where it has more; None: it is missing, or None."""
    if key not in npz:
        return None
    shape, dtype = npz.header(key)
    if not dtype.hasobject and math.prod(shape) > most:  # before it is read
        raise _too_many(npz, key, shape, most)
    array = _unpacked(npz, key) if dtype.hasobject else npz[key]
    if array is not None and array.size > most:
        raise _too_many(npz, key, array.shape, most)
    return array


def _unpacked(npz: Npz, key: str) -> NDArray[Any] | None:
    """The word or the numbers in a field of Python objects, as programs that save a dict leave
    them."""
    value = NpzObjects(npz.path)[key]
    if value is None:
        return None
    try:
        array = np.array(value.tolist() if isinstance(value, np.ndarray) else value)
    except ValueError:  # rows of different lengths
        array = np.array(None)
    if array.dtype.kind not in "fiuSU":
        raise FileError(
            f"{npz.path}: field '{key}' holds Python objects, found {shown(value)}; expected "
            "numbers or text. Save it as a plain array or a string"
        )
    return array


def _too_many(npz: Npz, key: str, shape: tuple[int, ...], most: int) -> FileError:
    return FileError(
        f"{npz.path}: field '{key}': found shape {shape}, expected at most {most} numbers"
    )


def _text(value: NDArray[Any]) -> str:
    """The string in a 0-d or one-element array of bytes or str."""
    item = value.flat[0] if value.size == 1 else value.tolist()
    text = item.decode("utf-8", "replace") if isinstance(item, bytes) else str(item)
    return text.strip().removeprefix("b'").removesuffix("'").lower()


def _gender(npz: Npz, options: Options) -> str:
    if options.gender is not None:
        return options.gender
    said = _small(npz, "gender")
    if said is None:
        found = "no gender in field" if "gender" in npz else "no field"
        warn(f"{npz.path}: {found} 'gender': taken as neutral. Say it with gender=")
        return "neutral"
    gender = gender_named(_text(said))
    if gender not in GENDERS:
        raise FileError(
            f"{npz.path}: field 'gender': found {gender!r}, expected one of {', '.join(GENDERS)}. "
            "Say it with gender="
        )
    return gender


def _model(npz: Npz, width: int, options: Options) -> str:
    if options.model is not None and str(options.model) in MODELS:
        return str(options.model)
    stated = _small(npz, "surface_model_type")
    if stated is not None and _text(stated) in MODELS:
        return _text(stated)
    if width in _MODEL_OF_WIDTH:
        return _MODEL_OF_WIDTH[width]
    raise FileError(
        f"{npz.path}: 22 joints without hands fit SMPL-X, SMPL-H and SMPL alike and no field "
        "'surface_model_type' says which. Say it with model='smplx', 'smplh' or 'smpl'"
    )


def load(
    source: Source,
    options: Options,
    format: str,
    *,
    up: str = "z",
    fps: float | None = None,
    root: Array | None = None,
) -> Motion:
    """A motion of any AMASS layout.

    Args:
        source, options, format: As of `Format.load`, and its name.
        up: The axis that is up in the format.
        fps: The frame rate of the format, where the file has none.
        root: Rotations (T, 3) of the root, where they are not in the poses.
    """
    npz, width = source.npz, width_of(source)
    if npz is None or width is None:
        raise FileError(f"{source.path}: not an AMASS file")
    where = str(source.path)
    model = _model(npz, width, options)
    rate, fps_key = _fps(npz, options, fps)
    trans = Record(npz.path, npz).array("trans", None, 3, frames=options.frames)
    rotations, rigid = _rotations(npz, width, options.frames)
    if len(trans) != len(rotations):
        raise FileError(
            f"{source.path}: field 'trans' has {len(trans)} frames and the poses {len(rotations)}; "
            "expected the same number"
        )
    if root is not None:
        rotations[:, 0] = root[options.frames]
    gender = _gender(npz, options)
    mean = None
    if options.hands == "mean":
        if width not in (165, 156):
            raise InputError(f"hands: found 'mean', but {source.path} has no fingers. Leave it out")
        mean = mean_hands(options.model, gender)
    betas, betas_shape = None, None
    frames = npz.header("trans")[0][0]
    value = _small(npz, "betas", _MOST_BETAS * max(1, frames))
    if value is not None:
        betas = shape_of(where, value, frames)
        betas_shape = value.shape
    metadata = _file_metadata(npz, format, options.frames, fps_key, rigid)
    own = {"width": width, "fps_key": fps_key, "betas_shape": betas_shape}
    return made(
        where,
        options,
        format=format,
        translation=trans,
        rotations=rotations,
        fps=rate,
        up=options.up or up,
        betas=betas,
        gender=gender,
        model=model,
        mean=mean,
        fields={**metadata.fields, **own},
        per_frame=metadata.per_frame,
        # The motion of a result file was checked when its input was read.
        quick=any("/" in key for key in npz),
    )


def _file_metadata(
    npz: Npz, format: str, frames: slice, fps_key: str, rigid: Array | None
) -> FileMetadata:
    """All fields besides the motion, without pickled ones and the parts of result files (keys with
    a slash)."""
    constants: Fields = {}
    per_frame: Fields = {}
    dtypes, keys, apart = {}, [], []
    total = npz.header("trans")[0][0]  # of the file, whatever part of it is read
    for key in npz:
        shape, dtype = npz.header(key)
        if "/" in key or key == FULL_KEY or dtype.hasobject:
            continue
        keys.append(key)
        dtypes[key] = dtype
        if key in ("poses", *SPLIT) and len(shape) == 3:
            apart.append(key)
        if key in _WORDS or key == fps_key:
            value = _small(npz, key)
            if value is not None:
                constants[key] = value
        elif key not in _KNOWN:
            if math.prod(shape) * dtype.itemsize > _MOST_KEPT:
                warn(f"{npz.path}: field '{key}' {shape} is no part of the motion: not kept")
            elif shape[:1] == (total,):
                per_frame[key] = npz[key][frames]
            else:
                constants[key] = npz[key]
    if rigid is not None:
        per_frame["_rigid_hands"] = rigid
    fields = {"keys": tuple(keys), "dtypes": dtypes, "constants": constants, "total": total}
    if apart:
        fields["apart"] = tuple(apart)  # (T, joints, 3)
    return FileMetadata(format=format, fields=fields, per_frame=per_frame)


def encode(motion: Motion, format: str, width: int, fps_key: str) -> Fields:
    """The arrays of an AMASS file, with the keys, axes, hands and types of the motion's file.

    Args:
        motion: The motion to write.
        format: Name of the layout to write.
        width: Number of columns of `poses`, for motions not from this layout.
        fps_key: Key of the frame rate, likewise.
    """
    own = motion.origin if motion.origin and motion.origin.format == format else None
    trans, rotations, said = file_parameters(motion, format)
    constants: Fields = dict(said.get("constants", {}))
    width, fps_key = said.get("width", width), said.get("fps_key", fps_key)
    frames = len(motion)
    columns = COLUMNS[width]
    poses = np.zeros((frames, len(columns), 3))
    held = [i for i, joint in enumerate(columns) if joint >= 0]
    poses[:, held] = rotations[:, [columns[i] for i in held]]
    if own and "_rigid_hands" in own.per_frame:
        poses[:, [i for i, joint in enumerate(columns) if joint < 0]] = own.per_frame[
            "_rigid_hands"
        ]
    out: Fields = {"trans": trans, "poses": poses.reshape(frames, -1)}
    for key, joints in SPLIT.items():
        if key in said.get("keys", ()) or (own is None and width == 165):
            out[key] = rotations[:, list(joints)].reshape(frames, -1)
    betas = np.zeros(0) if motion.betas is None else motion.betas
    shape = said.get("betas_shape")
    if shape is not None and len(shape) > 1 and betas.size:
        betas = np.tile(betas, (1 if shape[0] == 1 else frames, 1))
    out["betas"] = betas
    out["num_betas"] = np.array(betas.shape[-1])
    out["gender"] = _same(constants.get("gender"), motion.gender)
    out["surface_model_type"] = _same(constants.get("surface_model_type"), motion.model)
    out[fps_key] = np.array(motion.fps)
    out["mocap_time_length"] = np.array(frames / motion.fps)
    if own:
        same_rate = _is_number(constants.get(fps_key), motion.fps)
        if frames == said["total"] and same_rate:
            for key in ("mocap_time_length", fps_key):
                out[key] = constants.get(key, out[key])
        keys = {*said["keys"], "betas", "gender", fps_key}
        out = {key: value for key, value in out.items() if key in keys}
        out |= {k: v for k, v in own.per_frame.items() if not k.startswith("_")}
        out |= {
            k: v
            for k, v in constants.items()
            if k not in {*_KNOWN, fps_key} and (same_rate or is_of_video(k) or not is_rate(k))
        }
        order = [k for k in said["keys"] if k in out]
        out = {key: out[key] for key in (*order, *(k for k in out if k not in order))}
        out = {key: _exact(value, said["dtypes"].get(key)) for key, value in out.items()}
        for key in said.get("apart", ()):
            out[key] = out[key].reshape(frames, -1, 3)
    beside = [joint for key, joints in SPLIT.items() if key in out for joint in joints]
    kept = [*columns, *beside] if "poses" in out else beside
    lost = np.setdiff1d(np.arange(skeleton.N_JOINTS), kept)
    if rotations[:, lost].any():
        out[FULL_KEY] = rotations.reshape(frames, -1)
    return out


def _is_number(raw: NDArray[Any] | None, number: float) -> bool:
    """Whether a field is this one number."""
    return (
        raw is not None
        and raw.size == 1
        and raw.dtype.kind in "fiu"
        and float(raw.flat[0]) == number
    )


def _same(raw: NDArray[Any] | None, text: str) -> NDArray[Any]:
    """The file's own spelling (bytes or str, any case) if it equals `text`, else `text`."""
    return raw if raw is not None and _text(raw) == text else np.array(text)


def _exact(value: NDArray[Any], dtype: np.dtype[Any] | None) -> NDArray[Any]:
    """`value` in the file's own number type if that represents it exactly."""
    if dtype is None or dtype.kind not in "fiu" or value.dtype.kind not in "fiu":
        return value
    with np.errstate(over="ignore", invalid="ignore"):
        cast = value.astype(dtype)
        return cast if np.array_equal(cast.astype(value.dtype), value) else value
