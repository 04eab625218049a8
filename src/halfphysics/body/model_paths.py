"""Search for model files: by path, in a folder by gender and model, in $HALFPHYSICS_MODELS."""

from __future__ import annotations

import os
import re
from pathlib import Path

from halfphysics.base.validation import file_path
from halfphysics.errors import FileError, InputError

#: Environment variable that names the default folder of licensed models.
MODELS_VARIABLE = "HALFPHYSICS_MODELS"
GENDERS = ("neutral", "male", "female")

#: Models whose files are read, the preferred one first.
MODELS = ("smplx", "smplh", "smpl")
_PREFIXES = {"smplx": "SMPLX", "smplh": "SMPLH", "smpl": "SMPL"}
_SHORT = {"n": "neutral", "m": "male", "f": "female"}


def gender_of(path: Path) -> str | None:
    """The gender in a model file's name: SMPLX_MALE, basicmodel_f_lbs_10_207_0, male/model."""
    words = re.split(r"[^a-z]+", path.stem.lower())
    if path.stem.lower() == "model":
        words = [path.parent.name.lower()]
    if words[0] == "basicmodel":
        words = [_SHORT.get(word, word) for word in words]
    return next((word for word in words if word in GENDERS), None)


def find_model(path: str | os.PathLike[str] | None, gender: str | None, model: str | None) -> Path:
    """The model file at `path`: a file, or a folder with one of that `gender` and `model`.

    Raises:
        FileError: There is none. InputError: Several, and no `gender`.
    """
    default = os.environ.get(MODELS_VARIABLE)
    if path is None:
        if not default:
            raise FileError(
                "no body model named: give the path of a file or a folder, set "
                f"${MODELS_VARIABLE} to the folder of your models, or use Body.default()"
            )
        where = Path(default)
    else:
        where = file_path(path)
        if not where.exists() and default and (Path(default) / where).exists():
            where = Path(default) / where
    if where.is_file():
        return where
    if not where.is_dir():
        raise FileError(
            f"{where}: no such file or folder. Body models come with a licence of their own: "
            "download them from their makers (smpl-x.is.tue.mpg.de), or use Body.default()"
        )
    for name in (model,) if model else MODELS:
        files = {g: file for g in GENDERS if (file := _in_folder(where, name, g))}
        if gender in files:
            return files[gender]
        if gender is None and len(files) == 1:
            return next(iter(files.values()))
        if gender is None and files:
            raise InputError(
                f"gender: {where} has {name} for {', '.join(files)}. Say which with gender="
            )
    example = f"{_PREFIXES[model or 'smplx']}_{(gender or 'neutral').upper()}.npz"
    raise FileError(
        f"{where}: no {model or 'SMPL-X, SMPL-H or SMPL'} model"
        f"{f' for gender {gender!r}' if gender else ''} in this folder, expected "
        f"{example} or {model or 'smplx'}/{example} (.npz or .pkl)"
    )


def genders_in(folder: Path) -> tuple[str, ...]:
    """The genders for which a folder has a file of any model."""
    return tuple(g for g in GENDERS if any(_in_folder(folder, name, g) for name in MODELS))


def _in_folder(folder: Path, model: str, gender: str) -> Path | None:
    for base in (folder / model, folder / "models" / model, folder):
        for suffix in (".npz", ".pkl"):
            file = base / f"{_PREFIXES[model]}_{gender.upper()}{suffix}"
            if file.is_file():
                return file
        if model == "smplh" and (file := base / gender / "model.npz").is_file():
            return file
        if model == "smpl" and base.is_dir():
            for file in sorted(base.glob("basic[mM]odel_*.pkl")):
                if gender_of(file) == gender:
                    return file
    return None
