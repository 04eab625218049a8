"""Rotations between the joint frames of a source skeleton, in any rest pose, and those of SMPL-X.

The result is a constant rotation for each matched joint, ``C = source joint from SMPL-X joint``, so
that the SMPL-X joint's world rotation is ``R_source(t) C``: the SMPL-X bone points in the direction
of the source bone.

- If the file's zero pose is a standing person (T, A, arms hanging), trunk, head and collars take it
  as SMPL-X's rest pose, and the bones of limbs and fingers are turned the shortest way from
  SMPL-X's rest direction to the file's, each after its parent's rotation.
- If the zero pose is no posture (MotionBuilder and LAFAN1 have every bone along its own x axis),
  bone directions give all but the twist about the bone. The several branches of trunk and hands fix
  their twist; knees and elbows are hinges, whose axis is estimated from the motion; collars, feet
  and fingers have zero mean twist against their parents, neck and head zero mean rotation.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.formats.limb_bones import BONES, HINGES
from halfphysics.formats.skeletons.source_skeleton import NEEDED, SAME_PLACE, SourceSkeleton
from halfphysics.motion.skeleton import JOINT_INDEX, JOINT_NAMES, PARENTS

Array = NDArray[np.float64]

_SIDES = ("left", "right")
_TRUNK = tuple(JOINT_INDEX[n] for n in ("neck", "head", "left_collar", "right_collar", "jaw"))
_UPRIGHT = tuple(JOINT_INDEX[n] for n in ("neck", "head", "jaw"))
_SPINE = tuple(JOINT_INDEX[f"spine{k}"] for k in (1, 2, 3))
#: Joint -> the joint at the end of its bone; for fingers the next finger joint.
_NEXT = BONES | {
    JOINT_INDEX[f"{side}_{joint}"]: JOINT_INDEX[f"{side}_{then}"]
    for side in _SIDES
    for joint, then in (
        ("wrist", "middle1"),
        *(
            (f"{f}{k}", f"{f}{k + 1}")
            for f in ("index", "middle", "pinky", "ring", "thumb")
            for k in (1, 2)
        ),
    )
}
_ANKLES = tuple(JOINT_INDEX[f"{side}_ankle"] for side in _SIDES)
_FEET = tuple(JOINT_INDEX[f"{side}_foot"] for side in _SIDES)
_WRISTS = tuple(JOINT_INDEX[f"{side}_wrist"] for side in _SIDES)
#: Upper and lower bone of the hinges -> their flexion axis in SMPL-X's rest pose.
_HINGES = {(hinge.upper, hinge.joint): hinge.axis for hinge in HINGES}
# Cosine of the largest angle between a rest direction and that of a standing person.
_STANDING = np.cos(np.radians(55.0))
# Cosine of the angle to the axes below which a trunk frame is snapped to them.
_ALONG = np.cos(np.radians(35.0))
# The same for SMPL-X's own rest pose, whose trunk leans by its shape alone: a few degrees.
_ALONG_OWN = np.cos(np.radians(15.0))
# The same for a head, which may be turned throughout the clip.
_ALONG_HEAD = np.cos(np.radians(42.0))
# Mean sine of flexion below which a hinge's axis cannot be estimated.
_BENT = 0.05


class RestAlignment:
    """The rotations C of all matched joints.

    Args:
        source: The source skeleton.
        rest: SMPL-X joints at rest (55, 3) [m].
        quaternions: World from source joint over the clip (T, J, 4).
    """

    def __init__(self, source: SourceSkeleton, rest: Array, quaternions: Array) -> None:
        self._source = source
        self._rest = rest
        self._quaternions = quaternions
        upright = _upright(source)
        #: Whether the zero pose of the file is a standing person.
        self.is_pose = upright is not None
        self._turns: dict[int, Array] = {}
        if upright is not None:
            self._from_pose(upright)
        else:
            self._from_movement()

    def turn(self, joint: int) -> Array:
        """C (4,) of a matched SMPL-X joint, of the pelvis, or of the spine's joints."""
        return self._turns[joint]

    # -- directions --------------------------------------------------------------------------

    def _ours(self, joint: int) -> Array | None:
        """Rest direction of the bone of an SMPL-X joint."""
        then = _NEXT.get(joint)
        if then is not None:
            return _unit(self._rest[then] - self._rest[joint])
        if joint in _FEET:
            return np.array([0.0, 0.0, 1.0])
        if joint == JOINT_INDEX["head"]:
            return np.array([0.0, 1.0, 0.0])
        parent = int(PARENTS[joint])
        return _unit(self._rest[joint] - self._rest[parent])

    def _theirs(self, joint: int) -> Array | None:
        """Bone direction of the matched joint in its own frame; None: the bone has no length."""
        source = self._source
        own, then = source.joints[joint], _NEXT.get(joint)
        least = SAME_PLACE * source.leg
        if then is not None and then in source.joints:
            # In the rest pose all joints between are rigid; joints in one place have no direction.
            way = source.rest[source.joints[then]] - source.rest[own]
            return _unit(way, least)
        if own in source.skeleton.ends:
            return _unit(source.skeleton.ends[own], least)
        children = [c for c, parent in enumerate(source.skeleton.parents) if parent == own]
        offsets = [source.skeleton.offsets[c] for c in children]
        return _unit(max(offsets, key=np.linalg.norm), least) if offsets else None

    def _branch(self, base: int, to: int) -> Array | None:
        """The first non-zero offset on the path from a source joint to one below it."""
        source, path, joint = self._source, [], to
        while joint != base:
            path.append(joint)
            joint = source.skeleton.parents[joint]
            if joint < 0:
                return None
        for joint in reversed(path):
            way = _unit(source.skeleton.offsets[joint], SAME_PLACE * source.leg)
            if way is not None:
                return np.array(source.skeleton.offsets[joint])
        return None

    # -- a zero pose that is a posture -------------------------------------------------------

    def _from_pose(self, upright: Array) -> None:
        source, turns = self._source, self._turns
        for joint in (0, *_SPINE, *_TRUNK):
            turns[joint] = upright
        for joint in sorted(source.joints):
            if joint in turns:
                continue
            parent = int(PARENTS[joint])
            base = turns.get(parent, upright)
            if joint in _ANKLES:
                turns[joint] = self._heading(joint, upright)
            elif joint in _WRISTS and (hand := self._hand(joint)) is not None:
                turns[joint] = hand
            else:
                turns[joint] = self._swung(joint, base) if joint not in _FEET else base

    def _heading(self, ankle: int, upright: Array) -> Array:
        """C of an ankle: a foot flat at rest, like SMPL-X's, rotated about the vertical."""
        ours, theirs = self._ours(ankle), self._theirs(ankle)
        if ours is None or theirs is None:
            return upright
        up = rot.rotate(upright, [0.0, 1.0, 0.0])
        ours = rot.rotate(upright, ours)
        ours, theirs = _unit(ours - up * (up @ ours), 0.2), _unit(theirs - up * (up @ theirs), 0.2)
        if ours is None or theirs is None:
            return upright
        return rot.multiply(_shortest(ours, theirs), upright)

    def _swung(self, joint: int, base: Array) -> Array:
        """`base` turned the shortest way to align the bone with the source's."""
        ours, theirs = self._ours(joint), self._theirs(joint)
        if ours is None or theirs is None:
            return base
        return rot.multiply(_shortest(rot.rotate(base, ours), theirs), base)

    # -- frames that are no posture -----------------------------------------------------------

    def _from_movement(self) -> None:
        source, turns = self._source, self._turns
        turns[0] = self._trunk(source.joints[0], "hip", source.spine[:1] or (source.chest,))
        above = [source.joints[j] for j in _TRUNK[:2] if j in source.joints]
        turns[_SPINE[2]] = self._trunk(source.chest, "shoulder", above[:1])
        turns[_SPINE[0]] = turns[_SPINE[1]] = turns[_SPINE[2]]
        hinges = {joint: pair for pair in _HINGES for joint in pair}
        for joint in sorted(source.joints):
            if joint in turns:
                continue
            parent = int(PARENTS[joint])
            while parent not in turns:
                parent = int(PARENTS[parent])
            turn = self._hand(joint) if joint in _WRISTS else None
            if turn is None and joint in hinges:
                turn = self._hinged(joint, hinges[joint])
            turns[joint] = self._untwisted(joint, parent) if turn is None else turn

    def _trunk(self, base: int, pair: str, above: tuple[int, ...] | list[int]) -> Array:
        """C of a trunk joint from the offsets of its two sides and the spine."""
        left, right = (
            self._branch(base, self._source.joints[JOINT_INDEX[f"{side}_{pair}"]])
            for side in _SIDES
        )
        up = self._branch(base, above[0]) if above else None
        if left is not None and right is not None:
            if up is None or _frame(left - right, up) is None:
                # Hips lie under the spine, collars over it.
                middle = (left + right) / 2
                up = -middle if pair == "hip" else middle
            frame = _frame(left - right, up)
            if frame is not None:
                return rot.from_matrix(_snapped(frame))
        return (
            self._mean(base, self._source.joints[0])
            if base != self._source.joints[0]
            else (np.array([1.0, 0.0, 0.0, 0.0]))
        )

    def _hand(self, wrist: int) -> Array | None:
        """C of a wrist from the offsets of the fingers; None: they do not determine it."""
        side = JOINT_NAMES[wrist].split("_")[0]
        source = self._source
        bases = [JOINT_INDEX[f"{side}_{finger}1"] for finger in ("index", "pinky")]
        if any(joint not in source.joints for joint in bases):
            return None
        own = source.rest[source.joints[wrist]]
        if self.is_pose:
            theirs = [source.rest[source.joints[joint]] - own for joint in bases]
        else:
            found = [self._branch(source.joints[wrist], source.joints[joint]) for joint in bases]
            theirs = [way for way in found if way is not None]
        if len(theirs) < 2:
            return None
        ours = [self._rest[joint] - self._rest[wrist] for joint in bases]
        frames = [_frame(_unit_of(b) - _unit_of(a), a + b) for a, b in (ours, theirs)]
        if frames[0] is None or frames[1] is None:
            return None
        return rot.from_matrix(frames[1] @ frames[0].T)

    def _hinged(self, joint: int, pair: tuple[int, int]) -> Array | None:
        """C of a hinge's bone from its direction and the axis estimated from the motion."""
        source = self._source
        upper, lower = pair
        above, below = self._theirs(upper), self._theirs(lower)
        ours, theirs = self._ours(joint), self._theirs(joint)
        if above is None or below is None or ours is None or theirs is None:
            return None
        q_above = self._quaternions[:, source.joints[upper]]
        q_below = self._quaternions[:, source.joints[lower]]
        axes = np.cross(rot.rotate(q_above, above), rot.rotate(q_below, below))
        own = q_above if joint == upper else q_below
        axis = rot.rotate(rot.conjugate(own), axes).mean(axis=0)
        if np.linalg.norm(axis) < _BENT:
            return None
        ours_frame, their_frame = _frame(_HINGES[pair], ours), _frame(axis, theirs)
        if ours_frame is None or their_frame is None:
            return None
        return rot.from_matrix(their_frame @ ours_frame.T)

    def _untwisted(self, joint: int, parent: int) -> Array:
        """C of a bone from its direction, with zero mean twist against its parent."""
        source = self._source
        above = source.chest if parent in _SPINE else source.joints[parent]
        own = source.joints[joint]
        base = rot.multiply(self._quaternions[:, above], self._turns[parent])
        ours, theirs = self._ours(joint), self._theirs(joint)
        relative = rot.multiply(rot.conjugate(base), self._quaternions[:, own])
        if joint in _UPRIGHT:
            # A neck's bone direction depends on anatomy, and a head's End Site may point anywhere:
            # on average both are upright, with their axes along the parent's.
            mean = rot.to_matrix(_average(rot.conjugate(relative)))
            return rot.from_matrix(_snapped(mean, _ALONG_HEAD))
        if ours is None or theirs is None:
            return _average(rot.conjugate(relative))
        swing = _shortest(ours, theirs)
        turned = rot.multiply(relative, swing)
        # Twist about the bone, as a point on the circle: half angles doubled.
        half = turned[:, 0] + 1j * (turned[:, 1:] @ ours)
        angle = -np.angle((half**2).mean())
        return rot.multiply(swing, rot.exp(angle * ours))

    def _mean(self, own: int, above: int) -> Array:
        """The rotation with which a joint equals its parent on average."""
        base = rot.multiply(self._quaternions[:, above], self._turns[0])
        return _average(rot.multiply(rot.conjugate(self._quaternions[:, own]), base))


def rest_turn(source: SourceSkeleton, rest: Array) -> Array | None:
    """How the rest pose of SMPL-X's own joints is turned: file from SMPL-X axes (4,).

    Args:
        source: The source skeleton, whose zero pose is SMPL-X's but for its axes and its shape.
        rest: SMPL-X joints at rest (55, 3) [m].

    Returns:
        None if it lies in SMPL-X's own axes, or if it is no standing person.
    """
    theirs = _standing({joint: source.rest[source.joints[joint]] for joint in NEEDED})
    ours = _standing({joint: rest[joint] for joint in NEEDED})
    if theirs is None or ours is None:
        return None
    turn = _snapped(theirs @ ours.T, _ALONG_OWN)
    return None if np.array_equal(turn, np.eye(3)) else rot.from_matrix(turn)


def _upright(source: SourceSkeleton) -> Array | None:
    """File from SMPL-X axes (4,) if the zero pose is a standing person, else None."""
    frame = _standing({joint: source.rest[source.joints[joint]] for joint in NEEDED})
    return None if frame is None else rot.from_matrix(_snapped(frame))


def _standing(rest: Mapping[int, Array]) -> Array | None:
    """Axes to the left, up and forward (columns) of who stands; None: it is no such posture.

    Args:
        rest: SMPL-X joint -> its place (3,), of those that are `NEEDED`.
    """
    at = {JOINT_NAMES[joint]: rest[joint] for joint in NEEDED}
    hips = (at["left_hip"] + at["right_hip"]) / 2
    shoulders = (at["left_shoulder"] + at["right_shoulder"]) / 2
    frame = _frame(at["left_hip"] - at["right_hip"], shoulders - hips)
    if frame is None:
        return None
    left, up = frame[:, 0], frame[:, 1]
    expected = [
        *(
            (at[f"{s}_{a}"] - at[f"{s}_{b}"], up)
            for s in _SIDES
            for a, b in (("hip", "knee"), ("knee", "ankle"))
        ),
        (shoulders - hips, up),
        (at["left_shoulder"] - at["right_shoulder"], left),
    ]
    for way, axis in expected:
        direction = _unit(way)
        if direction is None or direction @ axis < _STANDING:
            return None
    # Arms may point to the side, down or forward, not across the body or up.
    for side, sign in zip(_SIDES, (1.0, -1.0), strict=True):
        arm = _unit(at[f"{side}_elbow"] - at[f"{side}_shoulder"])
        if arm is None or sign * (arm @ left) < -0.3 or arm @ up > 0.7:
            return None
    return frame


def _unit(way: Array, least: float = 1e-9) -> Array | None:
    """A unit vector; None: `way` is not longer than `least`."""
    length = np.linalg.norm(way)
    return np.asarray(way / length) if length > least else None


def _unit_of(way: Array) -> Array:
    return np.asarray(way / max(float(np.linalg.norm(way)), 1e-12))


def _frame(first: Array, second: Array) -> Array | None:
    """Axes as columns: y along `second`, x along `first`, orthogonal to y; None: parallel."""
    y = _unit(second)
    if y is None:
        return None
    x = _unit(first - y * (y @ first), 0.1 * float(np.linalg.norm(first)) + 1e-12)
    return None if x is None else np.stack([x, y, np.cross(x, y)], axis=1)


def _snapped(frame: Array, along: float = _ALONG) -> Array:
    """The nearest axis-aligned frame if it is close, else `frame`."""
    axes = np.zeros((3, 3))
    for column in range(3):
        row = int(np.argmax(np.abs(frame[:, column])))
        axes[row, column] = np.sign(frame[row, column])
    near = (axes * frame).sum(axis=0).min() > along
    return axes if near and np.linalg.det(axes) > 0.5 else frame


def _shortest(a: Array, b: Array) -> Array:
    """The shortest rotation (4,) from direction `a` to `b`."""
    if a @ b < -1.0 + 1e-12:
        side = np.cross(a, np.eye(3)[int(np.argmin(np.abs(a)))])
        return np.array([0.0, *_unit_of(side)])
    return rot.normalize(np.array([1.0 + a @ b, *np.cross(a, b)]))


def _average(quaternions: Array) -> Array:
    """The mean of rotations (T, 4)."""
    return np.asarray(np.linalg.eigh(quaternions.T @ quaternions)[1][:, -1])
