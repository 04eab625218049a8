"""Files of every format whose content is turned, scaled or mirrored against the format's rule."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.base import stored_objects as stored
from halfphysics.base.axes import axes_of
from halfphysics.formats import FORMATS

#: Format -> where the translation is: a key, a key in each of several clips, or columns.
TRANSLATIONS = {
    "amass-smplx": "trans",
    "amass-smplh": "trans",
    "amass-smpl": "trans",
    "blender": "trans",
    "emage": "trans",
    "hy-motion": "trans",
    "aist": "smpl_trans",
    "arctic": "transl",
    "trumans-clip": "transl",
    "omomo": "trans",
    "smpl-codec": "bodyTranslation",
    "motionx": slice(309, 312),
}
#: What each format needs to be told about a file that `written` made, but for what is wrong in it.
TOLD = {"trumans-clip": {"hands": "flat"}, "arctic": {"gender": "neutral"}}
TOLD["motionx"] = TOLD["arctic"]


@cache
def walker() -> hp.Motion:
    """Who walks ahead and turns nowhere, three seconds on a floor at z = 0."""
    motion = hp.scenarios.load("kick_ball").motion[20:110]
    turns = np.array(motion.rotations)
    turns[:, 22:] = 0.0  # what all formats hold
    return hp.Motion(motion.translation, turns, motion.fps)


def turned(motion: hp.Motion, up: str) -> hp.Motion:
    """The motion as a reader with z up has it of a file in which `up` is up."""
    rest = hp.Body.default().rest_joints[0]
    turn = axes_of(up).T
    places = (motion.translation + rest) @ turn.T - rest
    turns = np.array(motion.rotations)
    turns[:, 0] = rot.log(rot.multiply(rot.from_matrix(turn), rot.exp(turns[:, 0])))
    return hp.Motion(places, turns, motion.fps)


def mirrored(motion: hp.Motion) -> hp.Motion:
    """Every rotation and place mirrored at x = 0, and left still called left."""
    return hp.Motion(
        motion.translation * [-1.0, 1.0, 1.0], motion.rotations * [1.0, -1.0, -1.0], motion.fps
    )


def written(name: str, motion: hp.Motion, folder: Path) -> Path:
    """The motion as a file of a format of the registry."""
    path = folder / f"a{FORMATS[name].suffixes[0]}"
    motion.save(path, format=name, body=hp.Body.default())
    return path


def rescaled(name: str, path: Path, factor: float) -> None:
    """Multiply the translations in a file by a factor, and nothing else."""
    where = TRANSLATIONS[name]
    if path.suffix in (".npz", ".smpl"):
        with np.load(path) as old:
            fields = dict(old)
        fields[where] = factor * fields[where]
        with path.open("wb") as handle:
            np.savez(handle, **fields)
    elif name == "motionx":
        rows = np.load(path)
        rows[:, where] *= factor
        np.save(path, rows)
    else:
        data = stored.read(path)
        for fields in data.values() if name == "omomo" else [data]:
            fields[where] = factor * np.asarray(fields[where])
        if name == "arctic":
            np.save(path, np.array(data, dtype=object), allow_pickle=True)
        else:
            stored.write(path, data)


def heights(motion: hp.Motion) -> np.ndarray:
    """Of the joints but fingers and face (T, 22) [m]: what no turn about z changes."""
    return hp.Body.default().joints(motion)[:, :22, 2]
