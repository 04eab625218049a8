"""Small made-up body models in the layouts of SMPL-X, SMPL-H and SMPL files."""

from __future__ import annotations

import pickle
import sys
import types
from pathlib import Path
from typing import Any

import numpy as np

from halfphysics.motion.skeleton import PARENTS, SMPL_JOINTS, SMPLH_JOINTS

VERTICES = 90
LAYOUTS = {
    "smplx": tuple(range(55)),
    "smplh": SMPLH_JOINTS,
    "smpl": (*SMPL_JOINTS, None, None),  # two rigid hands
}


def file_parents(model: str) -> np.ndarray:
    """Parent of every joint in the file's own numbers; -1 for the root."""
    layout = LAYOUTS[model]
    parents = [layout.index(int(PARENTS[j])) if j else -1 for j in layout if j is not None]
    return np.array([*parents, 20, 21] if model == "smpl" else parents)


def fields(model: str = "smplx", columns: int = 400, seed: int = 3) -> dict[str, Any]:
    """All arrays of a model file, float64, random but plausible."""
    rng = np.random.default_rng(seed)
    joints = len(LAYOUTS[model])
    weights = np.where(rng.random((VERTICES, joints)) < 0.08, rng.random((VERTICES, joints)), 0.0)
    weights[np.arange(VERTICES), np.arange(VERTICES) % joints] += 0.5
    regressor = np.where(rng.random((joints, VERTICES)) < 0.1, 1.0, 0.0)
    regressor[:, 0] += 1.0
    table = np.stack([file_parents(model), np.arange(joints)]).astype(np.int64)
    table[0, 0] = 2**32 - 1
    out = {
        "v_template": rng.uniform(-0.8, 0.8, (VERTICES, 3)),
        "f": rng.integers(0, VERTICES, (40, 3)).astype(np.uint32),
        "weights": weights / weights.sum(axis=1, keepdims=True),
        "J_regressor": regressor / regressor.sum(axis=1, keepdims=True),
        "kintree_table": table.astype(np.uint32),
        "shapedirs": rng.normal(size=(VERTICES, 3, columns)) * 0.01,
        "posedirs": rng.normal(size=(VERTICES, 3, 9 * (joints - 1))) * 0.01,
    }
    if model != "smpl":
        for side in "lr":
            out[f"hands_mean{side}"] = rng.normal(size=45) * 0.2
            out[f"hands_components{side}"] = rng.normal(size=(45, 45))
    return out


def write_npz(path: Path, content: dict[str, Any]) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    np.savez(path, **content)
    return path


def write_pkl(path: Path, content: dict[str, Any], protocol: int = 2) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    with chumpy_stand_in():
        path.write_bytes(pickle.dumps(content, protocol))
    return path


class chumpy_stand_in:
    """Context with a package `chumpy` to pickle objects of; never to unpickle them."""

    def __enter__(self) -> chumpy_stand_in:
        for module, name in (("chumpy.ch", "Ch"), ("chumpy.reordering", "Select")):
            sys.modules[module] = types.ModuleType(module)
            setattr(sys.modules[module], name, CLASSES[f"{module}.{name}"])
        sys.modules["chumpy"] = types.ModuleType("chumpy")
        return self

    def __exit__(self, *_: object) -> None:
        for module in ("chumpy.ch", "chumpy.reordering", "chumpy"):
            del sys.modules[module]


CLASSES = {
    "chumpy.ch.Ch": type("Ch", (), {"__module__": "chumpy.ch"}),
    "chumpy.reordering.Select": type("Select", (), {"__module__": "chumpy.reordering"}),
}


def chumpy(array: np.ndarray) -> Any:
    """The pickled form of chumpy.array(array)."""
    out = CLASSES["chumpy.ch.Ch"]()
    out.__dict__.update(x=array, _dirty_vars=set(), _itr=None, _depends_on_deps=False)
    return out


def chumpy_select(array: np.ndarray, indices: np.ndarray, shape: tuple[int, ...]) -> Any:
    """The pickled form of a chumpy slice."""
    out = CLASSES["chumpy.reordering.Select"]()
    out.__dict__.update(a=chumpy(array), idxs=indices, preferred_shape=shape)
    return out
