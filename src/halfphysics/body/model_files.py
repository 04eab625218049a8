"""Model files of SMPL-X, SMPL-H and SMPL, .npz and .pkl, fitted into the 55 SMPL-X joints."""

from __future__ import annotations

import logging
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.base import restricted_pickle
from halfphysics.base.arrays import array_of
from halfphysics.base.digests import sha256_of
from halfphysics.base.npz_objects import NpzObjects
from halfphysics.base.stopwatch import Stopwatch
from halfphysics.body.model_paths import GENDERS, find_model, gender_of
from halfphysics.body.shape_space import ShapeSpace, Source
from halfphysics.errors import FileError, HalfPhysicsError, InputError
from halfphysics.geometry.mesh_file_checks import FolderResolver, check_mesh_file
from halfphysics.motion.skeleton import (
    JOINT_INDEX,
    JOINT_NAMES,
    N_JOINTS,
    PARENTS,
    SMPL_JOINTS,
    SMPLH_JOINTS,
)

logger = logging.getLogger(__name__)

Array = NDArray[np.float64]

_WRISTS = (JOINT_INDEX["left_wrist"], JOINT_INDEX["right_wrist"])
#: Model -> which of the 55 joints carries the skin of each joint of its files. SMPL's joints 22
#: and 23 are rigid hands: their skin is the wrists'.
_LAYOUTS = {
    "smplx": tuple(range(N_JOINTS)),
    "smplh": SMPLH_JOINTS,
    "smpl": (*SMPL_JOINTS, *_WRISTS),
}
#: Number of columns of SMPL-X shape directions -> how many of them are shape, not expression.
_SMPLX_SHAPE_COLUMNS = {400: 300, 20: 10}


def read_model(
    path: str | os.PathLike[str] | None = None,
    *,
    gender: str | None = None,
    model: str | None = None,
    v_template: ArrayLike | str | os.PathLike[str] | None = None,
) -> ShapeSpace:
    """Read a model file; arguments and exceptions are those of `Body.load`."""
    if gender is not None and gender not in GENDERS:
        raise InputError(f"gender: found {gender!r}, expected one of {', '.join(GENDERS)}")
    if model is not None and model not in _LAYOUTS:
        raise InputError(f"model: found {model!r}, expected one of {', '.join(_LAYOUTS)}")
    clock = Stopwatch(logger)
    file = find_model(path, gender, model)
    named = gender_of(file)
    if gender is not None and named is not None and gender != named:
        raise InputError(
            f"gender: found {gender!r}, but {file} is {named} by its name. Leave it out"
        )
    fields = _Fields(file)
    template = fields.array("v_template", (None, 3))
    count = len(template)
    weights = fields.array("weights", (count, None))
    found = _model_of(fields, weights, model)
    layout = _LAYOUTS[found]
    _check_tree(fields, layout)
    template_source = None
    if v_template is None:
        _check_size(template, str(file), FileError)
    else:
        template, template_source = _template(v_template, count)
    space = ShapeSpace(
        model=found,
        gender=gender or named or fields.gender() or "unknown",
        template=_locked(template),
        faces=_locked(_faces(fields, count)),
        weights=_locked(_weights(fields, weights, layout)),
        joint_regressor=_locked(_regressor(fields, count, layout)),
        shapedirs=_locked(_shapedirs(fields, count, found)),
        posedirs=_locked(_posedirs(fields, count, layout)),
        hands_mean=_locked(_hands(fields, ("hands_meanl", "hands_meanr"), (45,))),
        hands_components=_locked(
            _hands(fields, ("hands_componentsl", "hands_componentsr"), (45, 45))
        ),
        source=_source(file),
        template_source=template_source,
        given_template=v_template is not None and template_source is None,
    )
    clock.done("read the body model %s", file)
    return space


def _model_of(fields: _Fields, weights: Array, model: str | None) -> str:
    """The model whose joints the skin weights are for; `model`: the one that was requested."""
    count = weights.shape[1]
    found = next((m for m, joints in _LAYOUTS.items() if len(joints) == count), None)
    if found is None:
        known = ", ".join(f"{len(joints)} ({m})" for m, joints in _LAYOUTS.items())
        raise FileError(
            f"{fields.path}: field 'weights' is for {count} joints, expected one of {known}. "
            "Hand and face models (MANO, FLAME) have no body"
        )
    if model is not None and model != found:
        raise InputError(
            f"model: found {model!r}, but {fields.path} has the {len(_LAYOUTS[found])} joints of "
            f"{found}"
        )
    return found


def _check_size(template: Array, name: str, kind: type[HalfPhysicsError]) -> None:
    size = np.ptp(template, axis=0).max() if len(template) else 0.0
    if not 0.3 < size < 4.0:
        raise kind(
            f"{name}: the template is {size:g} long, "
            "expected a person in metres (0.3 to 4). Scale it"
        )


def read_hands(path: str | os.PathLike[str], gender: str | None = None) -> tuple[Array, Array]:
    """Mean hands (2, 45) [rad] and their components (2, 45, 45) of an SMPL-X or SMPL-H file.

    Args:
        path: The file, or a folder of files of which `gender` picks one.
        gender: Selects a file of a folder.

    Raises:
        FileError: The file has no hands, or cannot be read.
    """
    file = find_model(path, gender, None)
    fields = _Fields(file)
    mean = _hands(fields, ("hands_meanl", "hands_meanr"), (45,))
    components = _hands(fields, ("hands_componentsl", "hands_componentsr"), (45, 45))
    if mean is None or components is None:
        raise FileError(
            f"{file}: this body model has no fields hands_mean and hands_components, expected an "
            "SMPL-X or SMPL-H file that has"
        )
    return mean, components


class _Fields:
    """The named arrays of a model file, each checked on access."""

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            with path.open("rb") as handle:
                head = handle.read(2)
        except OSError as error:
            raise FileError(f"{path}: cannot read: {error.strerror}") from None
        self.fields: Mapping[str, Any]
        if head == b"PK":
            self.fields = NpzObjects(path)
        else:
            content = restricted_pickle.load(path)
            if not isinstance(content, dict):
                raise FileError(
                    f"{path}: holds a {type(content).__name__}, expected a dict of arrays (a body "
                    "model)"
                )
            self.fields = content
        missing = [
            key
            for key in ("v_template", "f", "weights", "J_regressor", "kintree_table", "shapedirs")
            if key not in self.fields
        ]
        if missing:
            keys = sorted(str(key) for key in self.fields)
            raise FileError(
                f"{path}: not a body model: no field {', '.join(missing)}. Found: "
                f"{', '.join(keys[:24]) or 'nothing'}. Expected an SMPL-X, SMPL-H or SMPL file"
            )

    def __contains__(self, key: str) -> bool:
        return key in self.fields

    def gender(self) -> str | None:
        """The gender that the file states; None if it does not."""
        if "gender" not in self.fields:
            return None
        stated = np.asarray(self.fields["gender"]).reshape(-1)
        word = stated[0] if stated.size else ""
        word = (word.decode("latin1") if isinstance(word, bytes) else str(word)).lower()
        return word if word in GENDERS else None

    def array(
        self, key: str, shape: tuple[int | None, ...], dtype: type | None = np.float64
    ) -> NDArray[Any]:
        """A field as an array of finite numbers of that shape (None: any length)."""
        array = np.asarray(self.fields[key])
        wanted = "(" + ", ".join("n" if n is None else str(n) for n in shape) + ")"
        if array.dtype.kind not in "iuf":
            raise FileError(
                f"{self.path}: field '{key}' is {array.dtype}, expected numbers {wanted}"
            )
        fits = array.ndim == len(shape) and all(
            want is None or want == have for want, have in zip(shape, array.shape, strict=True)
        )
        if not fits:
            raise FileError(
                f"{self.path}: field '{key}' has shape {array.shape}, expected {wanted}"
            )
        if not np.isfinite(array).all():
            raise FileError(
                f"{self.path}: field '{key}' holds NaN or infinity. Download the file again"
            )
        return array if dtype is None else np.ascontiguousarray(array, dtype=dtype)


def _source(path: Path) -> Source:
    return Source(str(path), sha256_of(path))


def _locked(array: Any) -> Any:
    """Make an array read-only: all bodies of one file share it."""
    if array is not None:
        array.setflags(write=False)
    return array


def _check_tree(fields: _Fields, layout: tuple[int, ...]) -> None:
    """Refuse a file whose joints have other parents than those of the model."""
    table = fields.array("kintree_table", (2, len(layout)), dtype=None).astype(np.int64)
    place = {int(joint): i for i, joint in enumerate(table[1])}
    for i, joint in enumerate(layout):
        # The root's parent is written as -1, as 2^32 - 1, or as the root itself.
        parent = place.get(int(table[0, i]), -1) if i else -1
        found = layout[parent] if parent >= 0 else -1
        rigid_hand = joint in layout[:i]  # SMPL's 22 and 23 hang on the wrists they merge into
        expected = joint if rigid_hand else int(PARENTS[joint])
        if found != expected:
            names = {-1: "no joint", **dict(enumerate(JOINT_NAMES))}
            raise FileError(
                f"{fields.path}: field 'kintree_table' hangs joint {i} ({names[joint]}) on "
                f"{names[found]}, expected {names[expected]}: another skeleton than SMPL's"
            )


def _faces(fields: _Fields, count: int) -> NDArray[np.int32]:
    faces = fields.array("f", (None, 3), dtype=None)
    if not len(faces) or faces.min() < 0 or faces.max() >= count or np.any(faces % 1):
        raise FileError(
            f"{fields.path}: field 'f' names vertices outside 0 to {count - 1}, expected triangles"
        )
    return np.ascontiguousarray(faces, dtype=np.int32)


def _weights(fields: _Fields, weights: Array, layout: tuple[int, ...]) -> Array:
    total = weights.sum(axis=1, keepdims=True)
    if np.abs(total - 1.0).max() > 1e-3:
        worst = int(np.abs(total - 1.0).argmax())
        raise FileError(
            f"{fields.path}: field 'weights' sums to {total[worst, 0]:g} for vertex {worst}, "
            "expected 1"
        )
    # Weights in single precision do not sum to exactly one, which would distort a skin far from the
    # origin.
    full = np.zeros((len(weights), N_JOINTS))
    for column, joint in enumerate(layout):
        full[:, joint] += weights[:, column]
    result: Array = full / total
    return result


def _regressor(fields: _Fields, count: int, layout: tuple[int, ...]) -> Array:
    regressor = fields.array("J_regressor", (len(layout), count))
    full = np.zeros((N_JOINTS, count))
    for joint in range(N_JOINTS):
        # The first index of a joint: SMPL's rigid hands come after the wrists.
        if joint in layout:
            full[joint] = regressor[layout.index(joint)]
        else:
            full[joint] = full[PARENTS[joint]]
    return full


def _shapedirs(fields: _Fields, count: int, model: str) -> NDArray[np.floating]:
    directions = fields.array("shapedirs", (count, 3, None), dtype=None)
    columns = directions.shape[2]
    shape = _SMPLX_SHAPE_COLUMNS.get(columns, columns) if model == "smplx" else columns
    return np.ascontiguousarray(directions[:, :, :shape])


def _posedirs(fields: _Fields, count: int, layout: tuple[int, ...]) -> Array | None:
    if "posedirs" not in fields:
        return None
    directions = fields.array("posedirs", (count, 3, 9 * (len(layout) - 1)))
    if not directions.any():
        return None
    if len(layout) == N_JOINTS:
        return directions
    full = np.zeros((count, 3, 9 * (N_JOINTS - 1)))
    for column, joint in enumerate(layout[1:]):
        # SMPL's rigid hands never turn: their columns would be multiplied by zero.
        if joint not in layout[: column + 1]:
            full[:, :, 9 * (joint - 1) : 9 * joint] = directions[:, :, 9 * column : 9 * column + 9]
    return full


def _hands(fields: _Fields, keys: tuple[str, str], shape: tuple[int, ...]) -> Array | None:
    if not all(key in fields for key in keys):
        return None
    return np.stack([fields.array(key, shape) for key in keys])


def _template(
    template: ArrayLike | str | os.PathLike[str], count: int
) -> tuple[Array, Source | None]:
    """A per-subject template, checked against the model's vertices."""
    source = None
    name = "v_template"
    if isinstance(template, (str, os.PathLike)):
        path = Path(template)
        name = f"v_template: {path}"
        template, source = mesh_vertices(path), _source(path)
    try:
        vertices = np.array(array_of(template), dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"{name}: not an array of numbers ({error})") from None
    if vertices.shape != (count, 3):
        raise InputError(
            f"{name}: found shape {vertices.shape}, expected ({count}, 3): the model's vertices "
            "in their order. Is it made for another model?"
        )
    if not np.isfinite(vertices).all():
        raise InputError(f"{name}: found NaN or infinity, expected vertices in metres")
    _check_size(vertices, name, InputError if source is None else FileError)
    return vertices, source


def mesh_vertices(path: Path) -> Array:
    """Vertices of a PLY or OBJ file, in the file's order."""
    if not path.is_file():
        raise FileError(f"{path}: no such file, expected a template (.ply or .obj)")
    suffix = path.suffix.lower()
    try:
        if suffix == ".obj":
            # Parsed here: mesh readers split and reorder vertices at texture seams.
            lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
            rows = [line.split()[1:4] for line in lines if line.startswith("v ")]
            return np.array(rows, dtype=np.float64)
        if suffix == ".ply":
            import trimesh

            check_mesh_file(path)
            with path.open("rb") as stream:
                resolver: Any = FolderResolver(path)
                mesh: Any = trimesh.load(
                    stream, file_type="ply", resolver=resolver, process=False, skip_materials=True
                )
            return np.asarray(mesh.vertices, dtype=np.float64)
    except FileError:
        raise
    except Exception as error:  # readers of damaged meshes raise exceptions of any type
        raise FileError(f"{path}: not a readable template ({error})") from None
    raise FileError(f"{path}: found a template of type '{suffix}', expected .ply or .obj")
