"""From joint positions to a `Motion`, shared by the readers of files that hold them.

The body of a sequence is the default body with the skeleton's own bones, on which every joint is
met. `Motion.load` has no body to give: its motion is for `Body.default()`, at the places as they
are where its legs have nearly the same length, else with all places scaled by the ratio of the legs
so that feet reach the floor. Where its bones are others, some joints give way (`compromise`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.reader_warnings import warn
from halfphysics.body.body import Body
from halfphysics.body.proportions import checked_bones
from halfphysics.errors import FileError, InputError
from halfphysics.formats.datasets.fingers_from_joints import fingers_from_joints
from halfphysics.formats.datasets.shape_from_joints import Bones, default_like, world_turns
from halfphysics.formats.format import Options, Source
from halfphysics.formats.motion_builder import motion_of
from halfphysics.formats.positions.bones import bones_of, change, facing, leg
from halfphysics.formats.positions.compromise import pulls
from halfphysics.formats.positions.inverse_kinematics import Marks, Solved, solve
from halfphysics.formats.positions.layouts import BODY, Places, fps_of, in_order
from halfphysics.motion import skeleton
from halfphysics.motion.motion import Motion
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.scene.scene import Scene
from halfphysics.simulation.sequence import Sequence

Array = NDArray[np.float64]

#: Bones of the trunk, which each model cuts at other places: their lengths against the default
#: body's, within what a body takes (`body.proportions.RATIOS`).
_TRUNK = tuple(
    JOINT_INDEX[j] for j in ("spine1", "spine2", "spine3", "left_collar", "right_collar")
)
_CUT = (0.3, 3.9)
#: Legs of people from hip to ankle [m], and units in which they may be written.
_LEG = (0.35, 1.3)
UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001}
#: Bones of arms and legs that change more than this are none: other joints, or rotations.
_RIGID = 0.35
#: A skeleton whose bones differ less than this [m] is the default body's.
_SAME = 0.003
#: Where legs differ less than this, relative, feet reach the floor without scaling.
_NEAR = 0.1
#: Toes that point so far from where the body faces (a cosine, over the clip) are of a mirror image.
BACK = -0.5
_SIDES = ("left", "right")
_HANDS = {"left": skeleton.LEFT_HAND_JOINTS, "right": skeleton.RIGHT_HAND_JOINTS}
#: Bones that stand for a hand: SMPL's hand joint is a point of the palm, no knuckle.
_PALMS = tuple(JOINT_INDEX[f"{side}_middle1"] for side in _SIDES)
_KNUCKLES = {
    side: tuple(JOINT_INDEX[f"{side}_{finger}1"] for finger in ("index", "middle", "pinky", "ring"))
    for side in _SIDES
}


class Found(NamedTuple):
    """Joint positions that a reader found.

    Attributes:
        where: Name of the file or clip in messages.
        positions: (T, J, 3), y up, of a layout in `layouts`, cut to the caller's frames.
        fps: None: the documented rate of the layout.
        said: What the reader did, for the warning; "" for nothing.
        fields: For `FileMetadata.fields`.
    """

    where: str
    positions: Array
    fps: float | None = None
    said: str = ""
    fields: Mapping[str, Any] = {}


def as_motion(found: Found, options: Options, format: str) -> Motion:
    """The motion for the default body.

    Raises:
        FileError: Too few frames, or no joints of a person.

    Warns:
        HalfPhysicsWarning: What the file does not say, in one line.
    """
    return _posed(found, options, format, own=False)[0]


def as_sequence(found: Found, options: Options, format: str) -> Sequence:
    """The motion for a body with the skeleton's bones, and that body; as `as_motion`."""
    motion, body = _posed(found, options, format, own=True)
    return Sequence(motion, Scene(), body)


def loaders(
    format: str, found: Callable[[Source, Options], Found]
) -> tuple[Callable[[Source, Options], Motion], Callable[[Source, Options], Sequence]]:
    """`Format.load` and `Format.load_sequence` of a format whose files hold nothing else."""

    def load(source: Source, options: Options) -> Motion:
        return as_motion(found(source, options), options, format)

    def load_sequence(source: Source, options: Options) -> Sequence:
        return as_sequence(found(source, options), options, format)

    return load, load_sequence


def _posed(found: Found, options: Options, format: str, *, own: bool) -> tuple[Motion, Body]:
    where, positions = found.where, found.positions
    if len(positions) < 2:
        raise FileError(
            f"{where}: found {len(positions)} frame(s), expected at least 2: velocities need a "
            "next frame"
        )
    rest = np.asarray(Body.default().rest_joints)
    places, unit = in_metres(where, in_order(positions, rest))
    said = found.said
    if facing(places.all) < BACK:
        places = places._replace(all=places.all * [-1.0, 1.0, 1.0])
        mirrored = "toes point backwards: taken for a mirror image, x negated"
        said = f"{said}; {mirrored}" if said else mirrored
    body, scale, same = body_for(where, places, own)
    scaled = places._replace(all=scale * places.all)
    solved = solved_for(scaled, np.asarray(body.rest_joints), gives_way=not same)
    fps = fps_of(positions.shape[1]) if found.fps is None else found.fps
    invented = {"rotations": "turns of bones about themselves", "betas": "the shape"}
    if not places.fingers:
        invented["hands"] = "fingers" if places.hands else "hands"
    if found.fps is None and options.fps is None:
        invented["fps"] = f"the rate ({fps:g} fps)"
    lines = [said, f"joint positions put on {described(body, scale)}"]
    lines += ["" if unit == "m" else f"unit {unit}"]
    lines += [f"met to {1e3 * float(solved.errors.mean()):.0f} mm"]
    lines += [f"not in the file: {', '.join(invented.values())}"]
    warn(f"{where}: {'; '.join(line for line in lines if line)}")
    motion = motion_of(
        where,
        options,
        format=format,
        translation=solved.pelvis - np.asarray(body.rest_joints)[0],
        rotations=solved.rotations,
        fps=fps,
        up="y",
        model="smplx",
        gender="neutral",
        hands="flat" if places.fingers else None,
        fields={**found.fields, "invented": invented},
    )
    return motion, body


def body_for(
    where: str, places: Places, own: bool, bones: Array | None = None
) -> tuple[Body, float, bool]:
    """The body that is moved, the factor on the places for it, and whether it has their bones.

    Args:
        where: Name in messages.
        places: In metres.
        own: Whether the body has the skeleton's bones; else it is the default body.
        bones: These bones (55, 3) [m]; None: by `bones_of` with the default body's directions.

    Raises:
        FileError: Nobody has such bones.
    """
    body = Body.default()
    rest = np.asarray(body.rest_joints)
    bones = bones_of(places.all, rest) if bones is None else np.array(bones)
    if not places.fingers:
        bones[len(BODY) :] = np.nan
    offsets = rest - rest[np.maximum(skeleton.PARENTS, 0)]
    bones = _plausible(where, bones, offsets, rest)
    if float(np.nanmax(np.linalg.norm(bones - offsets, axis=1))) < _SAME:
        return body, 1.0, True
    if own:
        return default_like(where, Bones(bones, 0.0)), 1.0, True
    return body, scale_for(leg(places.all)), False


def _plausible(where: str, bones: Array, offsets: Array, rest: Array) -> Array:
    """Bones (55, 3) that a person may have; those of a trunk that is cut otherwise are limited."""
    lengths = np.linalg.norm(bones, axis=1)
    own = np.linalg.norm(offsets, axis=1)
    for joint in _TRUNK:
        limited = float(np.clip(lengths[joint], _CUT[0] * own[joint], _CUT[1] * own[joint]))
        way = bones[joint] / lengths[joint] if lengths[joint] > 0.0 else offsets[joint] / own[joint]
        bones[joint] = limited * way
    try:
        return checked_bones(bones, rest)
    except InputError as error:
        raise FileError(f"{where}: no joint positions of a person: {error}") from None


def scale_for(length: float) -> float:
    """The factor on places for the default body, of a skeleton whose legs are so long [m]."""
    ratio = leg(np.asarray(Body.default().rest_joints)[None]) / length
    return ratio if abs(ratio - 1.0) > _NEAR else 1.0


def described(body: Body, scale: float) -> str:
    """The body and the factor of `body_for` in words."""
    if body.given_bones is not None:
        return f"the default body with the skeleton's bones ({body.stature:.2f} m)"
    return "the default body" + ("" if scale == 1.0 else f", all scaled by {scale:.3f}")


def in_metres(
    where: str, places: Places, order: str = "SMPL (or KIT for 21 joints)"
) -> tuple[Places, str]:
    """The same in metres, and the unit of the file, by the length of the legs.

    Args:
        where: Name in messages.
        places: In the unit of the file.
        order: The skeletons whose order the file may have, in messages.

    Raises:
        FileError: These are no joints of a person in this order.
    """
    length, varied = leg(places.all), change(places.all)
    unit = next((u for u, s in UNITS.items() if _LEG[0] < s * length < _LEG[1]), None)
    if unit is None or varied > _RIGID:
        found = f"legs of {length:.3g}" if unit is None else f"bones that change by {varied:.0%}"
        raise FileError(
            f"{where}: no joint positions of a person: found {found}, expected legs of "
            f"{_LEG[0]:g} to {_LEG[1]:g} m and rigid bones, in the order of {order}. Are "
            "these rotations, normalized values (un-normalize them with Mean and Std), or joints "
            "of another skeleton?"
        )
    return places._replace(all=UNITS[unit] * places.all), unit


def solved_for(
    places: Places, rest: Array, marks: Marks | None = None, *, gives_way: bool = False
) -> Solved:
    """The rotations for places on a body with joints `rest`; fingers where the file has them.

    `gives_way`: joints that cannot be met pull less (`compromise`). Places with tips of fingers in
    the rows of `fingers_from_joints` turn the last joints, too.
    """
    seen, rest = list(BODY), np.array(rest)
    if places.fingers:
        seen += [joint for joints in _KNUCKLES.values() for joint in joints]
    elif places.hands:
        # The palm's point counts by its direction.
        seen += _PALMS
        for palm in _PALMS:
            wrist = int(skeleton.PARENTS[palm])
            length = np.median(np.linalg.norm(places.all[:, palm] - places.all[:, wrist], axis=1))
            way = rest[palm] - rest[wrist]
            rest[palm] = rest[wrist] + way * length / np.linalg.norm(way)
    given = places.all[:, seen]
    weights = pulls(given, seen, rest) if gives_way else None
    solved = solve(given, seen, rest, weights, marks)
    if places.fingers:
        turns = world_turns(solved.rotations)
        for side, joints in _HANDS.items():
            palm_turn = turns[:, JOINT_INDEX[f"{side}_wrist"]]
            solved.rotations[:, list(joints)] = fingers_from_joints(side, places.all, palm_turn)
    return solved._replace(errors=solved.errors[:, : len(BODY)])
