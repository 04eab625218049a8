"""From the numbers of an estimator of people in video to a `Motion`: what is invented is said.

A track has numbers of its frames, with gaps; the frame rate is the video's and in no file; the
floor's height, the fingers and often the world are not there. Each of these is taken as said here,
told in one line, and kept in `Motion.origin.fields["invented"]`.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping
from collections.abc import Sequence as Listing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, TypeVar
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.reader_warnings import warn
from halfphysics.body.body import Body
from halfphysics.errors import FileError
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.datasets.subject import named_model
from halfphysics.formats.format import Format, Options, Source, alone, nothing
from halfphysics.formats.motion_builder import USUAL_FPS, motion_of, same_length
from halfphysics.formats.people import Track, filled
from halfphysics.formats.smplx_params import parts_of
from halfphysics.formats.written_people import Written, written
from halfphysics.motion.motion import Motion
from halfphysics.motion.skeleton import JOINT_INDEX

Array = NDArray[np.float64]
T = TypeVar("T")

FPS = USUAL_FPS
#: What may be invented -> how it is told.
RATE = {"fps": f"the frame rate: {FPS:g} (fps= says another)"}
FINGERS = {"hands": "fingers: straight"}
FLOOR = {"floor": "the floor's height: as it is (floor='lowest' puts the lowest skin on z = 0)"}
CAMERA = {
    "world": "the world: it is in the frame of the camera, whose y is down: turned upright, and "
    "how far the person is from the camera is a rough guess"
}
#: A track may be so many times longer than the frames in which it was seen, and so many frames.
_SPARSE, _FEW = 50, 1000
#: The place between the hips is taken from the hip joints.
HIPS = {"hips": "the point between the hips: that of the hip joints"}
#: Where the pelvis is at rest is in SMPL's model file only.
PELVIS = {"pelvis": "SMPL's joints at rest: the default body's (model= a model file has its own)"}
_HIPS = [JOINT_INDEX["left_hip"], JOINT_INDEX["right_hip"]]


@dataclass(frozen=True, eq=False)
class Seen:
    """One person of a file.

    Attributes:
        frames: Numbers (n,) of the frames in which they were seen.
        record: Fields with one row for each of these frames, under the name for messages.
    """

    frames: ArrayLike
    record: Record


def seen(path: Path, people: Mapping[str, tuple[ArrayLike, Mapping[str, Any]]]) -> dict[str, Seen]:
    """People by name, of their frames and fields."""
    several = len(people) > 1
    return {
        name: Seen(frames, Record(f"{path}, clip {name!r}" if several else path, fields))
        for name, (frames, fields) in people.items()
    }


def tracked(
    name: str,
    expects: str,
    *,
    about: str,
    invents: str,
    sniff: Callable[[Source], bool],
    people: Callable[[Source], dict[str, Seen]],
    read: Callable[[Seen, Options], Motion],
    write: Callable[[Mapping[str, Written], Path], None] | None = None,
    suffix: str = ".pkl",
    up: Literal["y", "-y"] = "y",
    loses: Callable[[Motion], tuple[str, ...]] = nothing,
    with_body: Callable[[Seen, Options], tuple[Motion, Body]] | None = None,
) -> Format:
    """The format of an estimator's files.

    Args:
        name, expects, about, invents, sniff: As of `Format`.
        people: The people of a file by name; looked for once per file.
        read: The motion of one of them.
        write: Writes people by name; None: the format is read-only.
        suffix, up, loses: Of the files written.
        with_body: Their motion on their own body, and that body; None: `read`, on the default one.
    """
    known = once(people)

    def tracks(source: Source) -> Listing[Track]:
        return [track_of(who.record.where, key, who.frames) for key, who in known(source).items()]

    def person(source: Source, options: Options) -> tuple[str, Seen]:
        found = known(source)
        key = options.clip or next(iter(found), "")
        if key not in found:
            raise FileError(f"{source.path}: found nobody in it, expected at least one person")
        return key, found[key]

    def load(source: Source, options: Options) -> Motion:
        key, who = person(source, options)
        return _named(read(who, options), key)

    save_people = None if write is None else _saving(name, write)
    return Format(
        name=name,
        about=about,
        expects=expects,
        invents=invents,
        sniff=sniff,
        load=load,
        people=tracks,
        save=None if save_people is None else alone(save_people),
        save_people=save_people,
        suffixes=(suffix,),
        up=up,
        loses=loses,
        load_person=None if with_body is None else _on_own_body(person, with_body),
    )


def _on_own_body(
    person: Callable[[Source, Options], tuple[str, Seen]],
    with_body: Callable[[Seen, Options], tuple[Motion, Body]],
) -> Callable[[Source, Options], tuple[Motion, Body]]:
    """`Format.load_person`."""

    def load_person(source: Source, options: Options) -> tuple[Motion, Body]:
        key, who = person(source, options)
        motion, body = with_body(who, options)
        return _named(motion, key), body

    return load_person


def _saving(
    name: str, write: Callable[[Mapping[str, Written], Path], None]
) -> Callable[[Listing[Motion], Path, Listing[Body | None]], None]:
    """`Format.save_people`."""
    return lambda motions, path, bodies: write(written(motions, name), path)


def _named(motion: Motion, track: str) -> Motion:
    """The motion, whose file's data has the name of the person, for the writer."""
    own = motion.origin
    if own is None:
        return motion
    return replace(motion, origin=replace(own, fields={**own.fields, "track": track}))


def grouped(ids: Array) -> dict[str, NDArray[np.intp]]:
    """Rows of each person, by name, from the numbers (M,) of the people in all rows."""
    names, inverse = np.unique(ids, return_inverse=True)
    order = np.argsort(inverse, kind="stable")
    ends = np.cumsum(np.bincount(inverse, minlength=len(names)))
    said = [str(int(name)) if name % 1 == 0 else f"{name:g}" for name in names]
    return dict(zip(said, np.split(order, ends[:-1]), strict=True))


def files_in(folder: Path, pattern: re.Pattern[str]) -> list[tuple[re.Match[str], Path]]:
    """The files of a folder whose names fit; none of a folder that cannot be listed."""
    try:
        names = sorted(os.listdir(folder))
    except OSError:
        return []
    return [(match, folder / name) for name in names if (match := pattern.fullmatch(name))]


def once(build: Callable[[Source], T]) -> Callable[[Source], T]:
    """`build`, run once for each open file."""
    known: WeakKeyDictionary[Source, T] = WeakKeyDictionary()

    def given(source: Source) -> T:
        if source not in known:
            known[source] = build(source)
        return known[source]

    return given


def relaxed(options: Options) -> tuple[Literal["flat", "mean"], dict[str, str]]:
    """What zero fingers mean where the estimator takes SMPL-X's relaxed hand, and what is told."""
    if named_model(options) is not None:
        return "mean", {}
    return "flat", {
        "hands": "the relaxed hand, about which fingers are: a flat one (model= the SMPL-X file "
        "has it)"
    }


def estimated(
    where: str,
    options: Options,
    *,
    format: str,
    translation: Array,
    rotations: Array,
    up: Literal["y", "z", "-y"],
    model: str,
    invented: Mapping[str, str],
    frames: ArrayLike | None = None,
    fps: float | None = None,
    gender: str = "neutral",
    betas: Array | None = None,
    hands: Literal["flat", "mean", "unsaid"] | None = None,
    fields: Mapping[str, Any] | None = None,
) -> Motion:
    """A motion of all rows of a track, in the file's axes; gaps are filled, then it is cut.

    Args:
        where, options, format, translation, rotations, up, model, betas: As of `motion_of`; the
            options' `frames` are applied here.
        invented: What the file does not say -> how it is told. Without `fps` the rate is added.
        frames: Numbers (n,) of the rows in the video, in any order; None: all, in order.
        fps: The frame rate of the file; None: it does not say.
        gender: Of the model that the estimator fits.
        hands: As of `motion_of`; "unsaid" is taken as flat, and said.
        fields: Further data for `Motion.origin`.

    Raises:
        FileError: Nothing is there, or frame numbers are impossible.
    """
    same_length(where, {"translation": len(translation), "rotations": len(rotations)})
    if not len(translation):
        raise FileError(f"{where}: found no frames, expected at least one")
    if frames is not None:
        translation, rotations = _without_gaps(where, frames, translation, rotations)
    translation, rotations = held(where, translation, rotations)
    first = 0 if frames is None else int(np.min(np.asarray(frames)))
    first += options.frames.indices(len(translation))[0]
    said = {**(RATE if fps is None and options.fps is None else {}), **invented}
    if hands is None and options.hands is None:
        said |= FINGERS
    if hands == "unsaid" and options.hands is None:
        said["hands"] = "what zero fingers mean: a flat hand (hands='mean', model= a model file)"
    if said:
        warn(f"{where}: not in the file, and taken as: {'; '.join(said.values())}")
    return motion_of(
        where,
        options,
        format=format,
        translation=translation[options.frames],
        rotations=rotations[options.frames],
        fps=FPS if fps is None else fps,
        up=up,
        model=model,
        gender=gender,
        betas=betas,
        hands="flat" if hands == "unsaid" else hands,
        fields={**(fields or {}), "invented": said, "first": first},
    )


def estimated_smplx(
    where: str, record: Record, options: Options, *, format: str, world: bool
) -> Motion:
    """The motion of one person in parameters of the `smplx` package, with its relaxed hand.

    Args:
        where: Name of the file in messages.
        record: The parameters.
        options, format: As of `estimated`.
        world: They are in a world with y up; else in the camera's frame.
    """
    parts = parts_of(record, options)
    hands, told = relaxed(options)
    return estimated(
        where,
        options,
        format=format,
        translation=parts.translation,
        rotations=parts.rotations,
        up="y" if world else "-y",
        model="smplx",
        betas=parts.betas,
        hands=hands,
        invented={**({} if world else CAMERA), **told, **FLOOR},
    )


def held(where: str, translation: Array, rotations: Array) -> tuple[Array, Array]:
    """A single frame twice, with a warning: a motion has two frames at least."""
    if len(translation) != 1:
        return translation, rotations
    warn(f"{where}: found a single frame, which is held for two")
    return np.repeat(translation, 2, axis=0), np.repeat(rotations, 2, axis=0)


def track_of(where: str, name: str, frames: ArrayLike) -> Track:
    """A person with the numbers of the frames in which they were seen; one frame counts as two, as
    in `held`.

    Raises:
        FileError: There are none, or they are no numbers of frames of one video.
    """
    numbers = np.asarray(frames)
    whole = numbers.dtype.kind in "iuf" and numbers.ndim == 1 and numbers.size > 0
    if not whole or not np.isfinite(numbers).all() or (numbers % 1 != 0).any():
        raise FileError(
            f"{where}: found frame numbers of shape {numbers.shape}, {numbers.dtype}, expected a "
            "whole number for each frame"
        )
    first, last = int(numbers.min()), int(numbers.max())
    if first < 0 or last - first >= _SPARSE * len(numbers) + _FEW:
        raise FileError(
            f"{where}: {len(numbers)} frames are numbered {first} to {last}, expected the numbers "
            "of one video"
        )
    return Track(name, first, max(last + 1, first + 2))


def _without_gaps(
    where: str, frames: ArrayLike, translation: Array, rotations: Array
) -> tuple[Array, Array]:
    track_of(where, "", frames)
    numbers = np.asarray(frames, dtype=np.float64)
    same_length(where, {"frames": len(numbers), "translation": len(translation)})
    order = np.argsort(numbers, kind="stable")
    return filled(where, numbers[order], translation[order], rotations[order])


def rest_joints(options: Options, model: str, betas: Array | None) -> tuple[Array, bool]:
    """Joints (55, 3) [m] of the body at rest, and whether they are of the user's model file."""
    named = named_model(options)
    if named is None:
        return np.asarray(Body.default().rest_joints), False
    folder = named.is_dir()
    body = Body.load(
        named,
        betas,
        gender=(options.gender or "neutral") if folder else None,
        model=model if folder else None,
    )
    return np.asarray(body.rest_joints), True


def from_hips(places: Array, root: Array, rest: Array) -> Array:
    """The translation (T, 3) that puts the point midway between the hip joints at `places`.

    The pelvis is at J0 + translation, and the hips turn about it: with m the point between the hips
    at rest, places = J0 + translation + R (m - J0).

    Args:
        places: (T, 3) [m].
        root: Axis-angle (T, 3) of the pelvis.
        rest: Joints (55, 3) at rest.
    """
    off = rest[_HIPS].mean(axis=0) - rest[0]
    return np.asarray(places - rot.rotate(rot.exp(root), off) - rest[0])


def hips_of(translation: Array, root: Array, rest: Array) -> Array:
    """The inverse of `from_hips`: the point (T, 3) [m] midway between the hip joints."""
    off = rest[_HIPS].mean(axis=0) - rest[0]
    return np.asarray(translation + rest[0] + rot.rotate(rot.exp(root), off))


def by_camera(
    rotation: Array, place: Array, translation: Array, rotations: Array, pelvis: Array
) -> tuple[Array, Array]:
    """From the frame of a moving camera to the world: x_world = R x_camera + t in each frame.

    The pelvis is at J0 + translation, so translation_world = R (J0 + translation) + t - J0.

    Args:
        rotation, place: R (T, 3, 3) and t (T, 3) [m].
        translation, rotations: (T, 3) and axis-angle (T, J, 3) in the camera's frame.
        pelvis: J0 (3,), the pelvis of the body at rest.
    """
    moved = np.einsum("tij,tj->ti", rotation, translation + pelvis) + place - pelvis
    turned = np.array(rotations)
    turned[:, 0] = rot.log(rot.multiply(rot.from_matrix(rotation), rot.exp(rotations[:, 0])))
    return moved, turned
