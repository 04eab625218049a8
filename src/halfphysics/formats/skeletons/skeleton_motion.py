"""From a skeleton in motion to a `Motion`: retargeted by names, or unchanged if it is SMPL-X's."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.reader_warnings import warn
from halfphysics.errors import FileError
from halfphysics.formats.format import Options
from halfphysics.formats.motion_builder import motion_of
from halfphysics.formats.skeletons.animated_skeleton import AnimatedSkeleton
from halfphysics.formats.skeletons.rest_alignment import rest_turn
from halfphysics.formats.skeletons.retarget import Retargeted, names_of, retarget, up_axis
from halfphysics.formats.skeletons.source_skeleton import SourceSkeleton
from halfphysics.motion import skeleton
from halfphysics.motion.motion import Motion

Array = NDArray[np.float64]

#: Key in `FileMetadata.fields`: the motion was retargeted to the default body.
DEFAULT_BODY = "default_body"
#: Legs of people from hip to ankle [m].
_LEG = (0.35, 1.3)
#: Metres per unit in which files have them: metres, centimetres, millimetres, and what an armature
#: leaves that is scaled to metres twice.
_UNITS = (1.0, 0.01, 0.001, 100.0)
# Long legs of nobody [unit of the file], and their unit.
_METRES, _CENTIMETRE = 4.0, 0.01


def retargeted(
    where: str, options: Options, animated: AnimatedSkeleton, fps: float, format: str
) -> tuple[Motion, Retargeted]:
    """The motion of any human skeleton on the default body, and how it was put there.

    Warns:
        HalfPhysicsWarning: What was matched and what not, the unit and the up axis, in one line.

    Raises:
        FileError: The skeleton is not a person's.
    """
    found, pelvis = _on_default_body(where, animated)
    up = options.up or found.up
    lines = [
        f"{where}: put on the default body by joint names; unit {found.unit} (a leg is "
        f"{found.scale:.4g} m per unit), {up} up"
    ]
    if missing := names_of(found.matched):
        lines.append(f"at rest, without a match in the file: {missing}")
    if found.unmatched:
        lines.append(f"not used of the file: {', '.join(found.unmatched)}")
    warn("; ".join(lines))
    motion = motion_of(
        where,
        options,
        format=format,
        translation=found.pelvis - pelvis,
        rotations=found.rotations,
        fps=fps,
        up=found.up,
        model="smplx",
        gender="neutral",
        hands="flat" if _has_fingers(found) else None,
        fields={DEFAULT_BODY: True},
    )
    return motion, found


def retargeted_known(
    where: str,
    options: Options,
    animated: AnimatedSkeleton,
    fps: float,
    format: str,
    *,
    up: Literal["y", "-y"],
    invented: Mapping[str, str],
) -> tuple[Motion, float | None]:
    """The motion of a skeleton whose joints, unit and axes its format prescribes, without a word.

    Args:
        where, options, animated, fps, format: As of `retargeted`.
        up: The axis that is up in the format; "-y": y is down.
        invented: What the file does not say -> how it is told, for `Motion.origin`.

    Returns:
        The motion on the default body, and the factor on places with which its legs are met.
    """
    found, pelvis = _on_default_body(where, animated)
    motion = motion_of(
        where,
        options,
        format=format,
        translation=found.pelvis - pelvis,
        rotations=found.rotations,
        fps=fps,
        up=up,
        model="smplx",
        gender="neutral",
        hands="flat" if _has_fingers(found) else None,
        fields={DEFAULT_BODY: True, "invented": dict(invented)},
    )
    return motion, found.scale


def _on_default_body(where: str, animated: AnimatedSkeleton) -> tuple[Retargeted, Array]:
    """The skeleton's motion on the default body, and that body's pelvis (3,) at rest."""
    from halfphysics.body.body import Body

    rest = np.asarray(Body.default().rest_joints)
    return retarget(where, animated, rest), rest[0]


def _has_fingers(found: Retargeted) -> bool:
    hands = {*skeleton.LEFT_HAND_JOINTS, *skeleton.RIGHT_HAND_JOINTS}
    return bool(hands & set(found.matched))


class SmplxMotion(NamedTuple):
    """The motion of a skeleton with SMPL-X's joints and rest pose.

    Attributes:
        motion: As the file has it.
        unit: Metres per unit of the file; None: these are legs of nobody, taken as centimetres
            where they are long, else as metres.
        turn: File's axes at rest from SMPL-X's (4,); None: they are the same.
    """

    motion: Motion
    unit: float | None
    turn: Array | None


def smplx_motion(
    where: str,
    options: Options,
    animated: AnimatedSkeleton,
    fps: float,
    format: str,
    *,
    pelvis: Array | None,
) -> SmplxMotion:
    """The motion of a skeleton with the joints and the rest pose of SMPL-X, in any axes.

    In SMPL-X's own axes it is y up; where a program has turned the rest pose (Blender writes BVH
    with z up), what is up is found as for other skeletons.

    Args:
        where: Name of the file in messages.
        options: The caller's.
        animated: With the 55 names of SMPL-X.
        fps: Frames per second.
        format: Name of the format.
        pelvis: The pelvis at rest (3,) [unit and axes of the file]; None: that of the default body.

    Warns:
        HalfPhysicsWarning: The rest pose is turned, and what is taken as up.

    Raises:
        FileError: A joint hangs on another than in SMPL-X.
    """
    from halfphysics.body.body import Body

    source = SourceSkeleton.of(where, animated)
    index = _smplx_joints(where, animated)
    usual = _CENTIMETRE if source.leg > _METRES else 1.0
    scale = metres_per_unit(source.leg) or usual
    own = np.asarray(Body.default().rest_joints)
    world = animated.quaternions[:, index]
    up: Literal["y", "z"] = "y"
    turn = rest_turn(source, own)
    if turn is not None:
        world = rot.multiply(world, turn)
        up = up_axis(world[:, 0])
        degrees = np.degrees(np.linalg.norm(rot.log(turn)))
        warn(
            f"{where}: its rest pose is SMPL-X's, turned by {degrees:.0f} degrees: turned back; "
            f"{options.up or up} up"
        )
        pelvis = None if pelvis is None else rot.rotate(rot.conjugate(turn), pelvis)
    local = world.copy()
    local[:, 1:] = rot.multiply(rot.conjugate(world[:, skeleton.PARENTS[1:]]), world[:, 1:])
    at_rest = own[0] if pelvis is None else scale * pelvis
    motion = motion_of(
        where,
        options,
        format=format,
        translation=scale * animated.positions[:, index[0]] - at_rest,
        rotations=rot.log(local),
        fps=fps,
        up=up,
        model="smplx",
        gender="neutral",
    )
    return SmplxMotion(motion, metres_per_unit(source.leg), turn)


def _smplx_joints(where: str, animated: AnimatedSkeleton) -> list[int]:
    """The joints of the file (55,) in SMPL-X's order.

    Raises:
        FileError: A joint hangs on another than in SMPL-X.
    """
    index = [animated.names.index(name) for name in skeleton.JOINT_NAMES]
    for joint, parent in enumerate(skeleton.PARENTS):
        if parent >= 0 and animated.parents[index[joint]] != index[parent]:
            raise FileError(
                f"{where}: joint {skeleton.JOINT_NAMES[joint]!r} hangs on "
                f"{animated.names[animated.parents[index[joint]]]!r}, expected "
                f"{skeleton.JOINT_NAMES[parent]!r}, as in SMPL-X"
            )
    return index


def metres_per_unit(leg: float) -> float | None:
    """The unit in which a leg from hip to ankle is a person's; None: it is in none of them."""
    low, high = _LEG
    return next((unit for unit in _UNITS if low < unit * leg < high), None)
