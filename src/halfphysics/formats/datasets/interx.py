"""Inter-X: two people who do something with each other; SMPL-X, y-up, 120 fps.

A sequence is a folder with `P1.npz` and `P2.npz`: `root_orient, trans (T, 3)`, `pose_body (T, 21,
3)`, `pose_lhand, pose_rhand (T, 15, 3)`, `betas (1, 10)`, `gender`. The files have no rate and do
not say what zero fingers mean: the data set's viewer poses a flat hand. The folder, or one of the
files alone, is loaded.
"""

from __future__ import annotations

from pathlib import Path

from halfphysics.base.npz import Npz
from halfphysics.base.reader_warnings import warn
from halfphysics.errors import FileError
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.datasets.median_shape import median_shape
from halfphysics.formats.format import Format, Options, Source
from halfphysics.formats.gender_names import said_gender
from halfphysics.formats.motion_builder import motion_of, rotations_of, same_length
from halfphysics.formats.people import Track
from halfphysics.formats.rate_names import said_rate
from halfphysics.motion import skeleton
from halfphysics.motion.motion import Motion

NAME = "interx"
FPS = 120.0
PEOPLE = ("P1", "P2")
_PARTS = {
    "pose_body": skeleton.BODY_JOINTS,
    "pose_lhand": skeleton.LEFT_HAND_JOINTS,
    "pose_rhand": skeleton.RIGHT_HAND_JOINTS,
}


def _sniff(source: Source) -> bool:
    if source.is_folder:
        return any((source.path / f"{name}.npz").is_file() for name in PEOPLE)
    keys = set(source.npz or ())
    return bool(keys & {"pose_lhand", "pose_rhand"}) and bool(keys & {"root_orient", "pose_body"})


def _path(source: Source, name: str) -> Path:
    return source.path / f"{name}.npz" if source.is_folder else source.path


def _people(source: Source) -> list[Track]:
    names = PEOPLE if source.is_folder else (source.path.stem,)
    tracks = []
    for name in names:
        path = _path(source, name)
        if path.is_file():
            record = Record(path, Npz(path))
            tracks.append(Track(name, 0, len(record.numbers("root_orient", None, 3))))
    return tracks


def _load(source: Source, options: Options) -> Motion:
    path = _path(source, options.clip)
    if not path.is_file():
        raise FileError(f"{path}: no such file, expected one person of an Inter-X sequence")
    record = Record(path, Npz(path))
    parts = {
        joints: record.array(key, None, len(joints), 3, frames=options.frames)
        for key, joints in _PARTS.items()
    }
    root = record.array("root_orient", None, 3, frames=options.frames)
    translation = record.array("trans", None, 3, frames=options.frames)
    lengths = {key: len(record.raw(key)) for key in ("trans", "root_orient", *_PARTS)}
    frames = same_length(record.where, lengths)
    said = said_rate(record)
    if options.hands is None:
        rate = "" if said else "no frame rate, and "
        taken = "" if said else f"{options.fps or FPS:g} fps and "
        ways = "hands=" if said else "fps=, hands="
        warn(
            f"{source.path}: Inter-X says {rate}not what zero fingers mean: "
            f"{taken}a flat hand are taken ({ways})"
        )
    return motion_of(
        record.where,
        options,
        format=NAME,
        translation=translation,
        rotations=rotations_of({(0,): root, **parts}),
        fps=said or FPS,
        up="y",
        model="smplx",
        gender=said_gender(record),
        betas=median_shape(record, frames),
    )


FORMAT = Format(
    name=NAME,
    about="Inter-X: two people who do something with each other",
    invents="the frame rate (120), flat or relaxed hands",
    expects=f"a folder with {' and '.join(f'{n}.npz' for n in PEOPLE)} (root_orient (T, 3), "
    "pose_body (T, 21, 3), pose_lhand, pose_rhand (T, 15, 3), trans)",
    sniff=_sniff,
    load=_load,
    people=_people,
)
