"""SAM 3D Body: people of images or of a video, on MHR's skeleton; the camera's frame, y down.

`process_one_image` gives a dict for each person (`sam3d_file` has the ways in which they are
saved): `pred_joint_coords` (127, 3) and `pred_keypoints_3d` (70, 3) [m] from the person's origin,
`pred_cam_t`
(3,) [m], the origin in the frame of the camera, `bbox` (4,), `pred_vertices`, parameters of MHR,
... `pred_global_rots` are in MHR's own axes with y up, and not used.

Joints and keypoints say the pose (`sam3d_fit`); where only one of both was saved, that one does.
Frames were estimated one by one: nobody tracked people, and the rate is not there. People are
followed from frame to frame by where they are.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.arrays import as_array
from halfphysics.base.reader_warnings import warn
from halfphysics.body.body import Body
from halfphysics.errors import FileError
from halfphysics.formats.estimates import CAMERA as WORLD
from halfphysics.formats.estimates import FLOOR, Seen, estimated, seen, tracked
from halfphysics.formats.format import Options, Source
from halfphysics.formats.positions.posed import described
from halfphysics.formats.video.mhr_skeleton import N_MHR, N_POINTS
from halfphysics.formats.video.sam3d_file import (
    CAMERA,
    JOINTS,
    POINTS,
    Sighting,
    content_of,
    files_of,
    is_output,
    sightings,
)
from halfphysics.formats.video.sam3d_fit import Fitted, fitted
from halfphysics.motion.motion import Motion

Array = NDArray[np.float64]

NAME = "sam3d-body"
_SHAPES = {JOINTS: (N_MHR, 3), POINTS: (N_POINTS, 3), CAMERA: (3,)}
#: A person goes no farther from one frame in which they are seen to the next than this, as a part
#: of their length from head to feet; depth is guessed anew in each. Somebody not seen for so many
#: frames is somebody else.
_STEP, _LOST = 0.8, 30
#: No place is farther from the camera than this, in any unit.
_FAR = 1e8
#: Sizes that differ by less than this over the frames are one.
_ONE_SIZE = 0.01
_known: WeakKeyDictionary[Seen, Fitted] = WeakKeyDictionary()


def _sniff(source: Source) -> bool:
    if not source.is_folder:
        return is_output(content_of(source))
    files = files_of(source.path)
    try:
        return bool(files) and is_output(content_of(Source(files[0][2])))
    except FileError:
        return False


def _people(source: Source) -> dict[str, Seen]:
    found, rate = sightings(source)
    rows = [(each, _checked(source, each)) for each in found]
    tracks, followed = _followed(rows)
    if followed and len(tracks) > 1:
        warn(
            f"{source.path}: people are followed from frame to frame by where they are: the file "
            "has no tracks"
        )
    people: dict[str, tuple[Any, Mapping[str, Any]]] = {}
    for who, own in tracks.items():
        keys = set.intersection(*(set(fields) for _, fields in own))
        columns: dict[str, Any] = {
            key: np.stack([fields[key] for _, fields in own]) for key in _SHAPES if key in keys
        }
        if rate is not None:
            columns["fps"] = rate
        people[who] = np.array([number for number, _ in own]), columns
    return seen(source.path, people)


def _checked(source: Source, sighting: Sighting) -> dict[str, Array]:
    """The fields that are used, of the shapes that they have in every frame."""
    fields, found = sighting.fields, {}
    for key, shape in _SHAPES.items():
        if key not in fields:
            continue
        try:
            array = as_array(fields[key])
        except (TypeError, ValueError, MemoryError):
            array = np.empty(0, dtype=object)
        squeezed = array.reshape(shape) if array.size == np.prod(shape) else array
        fits = squeezed.shape == shape and array.shape in (shape, (1, *shape))
        if not fits or array.dtype.kind not in "fiu":
            raise FileError(
                f"{source.path}: field '{key}': found shape {array.shape} of {array.dtype}, "
                f"expected numbers of {shape} for each person"
            )
        found[key] = np.array(squeezed, dtype=np.float64)
        if not (np.abs(found[key]) < _FAR).all():
            raise FileError(
                f"{source.path}: field '{key}': NaN, infinite or over {_FAR:g} in frame "
                f"{sighting.number}, expected finite numbers. Leave that person out there: the gap "
                "is filled"
            )
    if not {JOINTS, POINTS} & set(found):
        raise FileError(
            f"{source.path}: this output of SAM 3D Body has the pose of MHR, and no places of its "
            f"joints: expected {JOINTS} {_SHAPES[JOINTS]} or {POINTS} {_SHAPES[POINTS]}. Save "
            "these, too, or convert it with convert_sam3d_output_to_smpl of MHR's repository "
            "(tools/mhr_smpl_conversion)"
        )
    if CAMERA not in found:
        raise FileError(
            f"{source.path}: field '{CAMERA}' is missing, expected the place (3,) of every person "
            "in the frame of the camera"
        )
    return found


def _followed(
    rows: list[tuple[Sighting, dict[str, Array]]],
) -> tuple[dict[str, list[tuple[int, dict[str, Array]]]], bool]:
    """Frames and fields of each person, and whether they were followed here.

    Numbers that a tracker gave are kept. Others go, closest first, to who was last seen closest.
    """
    tracks: dict[str, list[tuple[int, dict[str, Array]]]] = {}
    frames: dict[int, list[tuple[Sighting, dict[str, Array]]]] = {}
    for sighting, fields in rows:
        frames.setdefault(sighting.number, []).append((sighting, fields))
    followed = False
    for number in sorted(frames):
        loose = []
        for sighting, fields in frames[number]:
            if sighting.who is None:
                loose.append(fields)
            else:
                tracks.setdefault(sighting.who, []).append((number, fields))
        followed = followed or (bool(loose) and bool(tracks))
        _continue(tracks, number, loose)
    return tracks, followed


def _continue(
    tracks: dict[str, list[tuple[int, dict[str, Array]]]],
    number: int,
    loose: list[dict[str, Array]],
) -> None:
    """Give the people of a frame to tracks, closest first; who is left begins one."""
    last = {
        who: own[-1]
        for who, own in tracks.items()
        if own[-1][0] < number and number - own[-1][0] <= _LOST
    }
    pairs = sorted(
        (float(np.linalg.norm(_place(fields) - _place(before))) / _length(before), row, who)
        for row, fields in enumerate(loose)
        for who, (_, before) in last.items()
    )
    given: dict[int, str] = {}
    for distance, row, who in pairs:
        if distance <= _STEP and row not in given and who not in given.values():
            given[row] = who
    for row, fields in enumerate(loose):
        new = str(next(k for k in range(len(tracks) + 1) if str(k) not in tracks))
        tracks.setdefault(given.get(row, new), []).append((number, fields))


def _place(fields: Mapping[str, Array]) -> Array:
    """The middle of a person (3,) in the frame of the camera."""
    return np.asarray(fields[JOINTS if JOINTS in fields else POINTS].mean(axis=0) + fields[CAMERA])


def _length(fields: Mapping[str, Array]) -> float:
    """From one end of a person to the other, in the unit of the file."""
    ends = np.ptp(fields[JOINTS if JOINTS in fields else POINTS], axis=0)
    return max(float(np.linalg.norm(ends)), 1e-12)


def _fit(who: Seen) -> Fitted:
    """The person on their own bones; found once."""
    if who not in _known:
        record = who.record
        camera = record.array(CAMERA, None, 3)[:, None]
        joints, points = (
            record.array(key, None, *_SHAPES[key]) + camera if key in record else None
            for key in (JOINTS, POINTS)
        )
        _known[who] = fitted(record.where, joints, points)
    return _known[who]


def _read(who: Seen, options: Options, *, own: bool) -> Motion:
    fit, where = _fit(who), who.record.where
    body, scale = (fit.body, 1.0) if own else (Body.default(), fit.ratio)
    invented = {**WORLD, **FLOOR}
    invented["betas"] = "the shape: the default body's skin"
    invented["rotations"] = "turns of straight limbs about themselves: as people bend"
    if POINTS not in who.record:
        invented["head"] = f"where the head faces: along the neck ({POINTS} has the face)"
    spread = float(np.ptp(fit.sizes))
    if spread > _ONE_SIZE:
        invented["size"] = (
            f"one size of the person, who changes it by {spread:.0%}: every frame is scaled about "
            "the camera to the median"
        )
    met = 1e3 * float(fit.solved.errors.mean())
    if fit.said:
        warn(f"{where}: {fit.said}")
    warn(f"{where}: MHR's joints put on {described(body, scale)}, met to {met:.0f} mm")
    fps = float(who.record.fields["fps"]) if "fps" in who.record else None
    return estimated(
        where,
        options,
        format=NAME,
        frames=who.frames,
        translation=scale * fit.solved.pelvis - np.asarray(body.rest_joints)[0],
        rotations=fit.solved.rotations,
        fps=fps,
        up="-y",
        model="smplx",
        hands="flat",
        invented=invented,
    )


def _with_body(who: Seen, options: Options) -> tuple[Motion, Body]:
    return _read(who, options, own=True), _fit(who).body


FORMAT = tracked(
    NAME,
    "npz, npy, pkl or json of dicts with pred_joint_coords (127, 3) or pred_keypoints_3d (70, 3), "
    "and pred_cam_t (3,), for each person",
    about="SAM 3D Body: people of images or a video, on MHR's skeleton",
    invents="frame rate, shape, turns of straight limbs, floor, the world (it is the camera's "
    "frame), who is who",
    sniff=_sniff,
    people=_people,
    read=lambda who, options: _read(who, options, own=False),
    with_body=_with_body,
)
