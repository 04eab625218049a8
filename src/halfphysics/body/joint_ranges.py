"""Ranges of joints: how far each of the 55 SMPL-X joints turns, by axis, in the body's own frame.

At rest (a T-pose) x points left, y up, z forward, and every joint's frame is that. A joint's
rotation is a twist about its bone, then a swing of the bone with two components: flexion and
abduction.

The numbers are facts of anatomy, in degrees, those of passive motion where sources give both (what
contact pushes a joint to), rounded up to 5:
- AAOS: Joint Motion, Method of Measuring and Recording (1965); Norkin and White, Measurement of
  Joint Motion (5th ed. 2016): limbs, neck, trunk, fingers, toes.
- Kapandji, The Physiology of the Joints (vol. 1 to 3): passive ends, shoulder girdle, thumb,
  rotation of the knee, inversion and eversion of the foot.
- Hume et al. 1990, J Hand Surg 15A; Bain et al. 2015, J Hand Surg Eur 40: fingers and thumb.
- Roaas and Andersson 1982, Acta Orthop Scand 53; Bennell et al. 1998, Aust J Physiother 44: hip,
  knee, ankle (45 degrees under the body's weight).
Trunk and neck are shared out among SMPL-X's three and two joints, each of which may take more than
an equal share. Data files give part of the forearm's rotation to the wrist: it has a twist of its
own. The shoulder's ends are those of a box that holds arms raised, hanging and drawn back.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.base import rotations as rot
from halfphysics.motion.skeleton import JOINT_INDEX, JOINT_NAMES, N_JOINTS

if TYPE_CHECKING:
    from halfphysics.body.body import Body

Array = NDArray[np.float64]
_Range = tuple[float, float]
_Direction = tuple[float, float, float]


@dataclass(frozen=True)
class _Joint:
    """Of a left or middle joint: bone, axis of flexion, and (least, most) of each angle [degrees].

    The axis of abduction is `bone` x `flexes`; positive means what the comments say.
    """

    bone: _Direction
    flexes: _Direction
    twist: _Range
    flexion: _Range
    abduction: _Range


_X, _Y, _Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
_DOWN, _BACK, _RIGHT = (0.0, -1.0, 0.0), (0.0, 0.0, -1.0), (-1.0, 0.0, 0.0)

_VERTEBRAE = _Joint(_Y, _X, (-25.0, 25.0), (-20.0, 45.0), (-25.0, 25.0))
_NECK = _Joint(_Y, _X, (-45.0, 45.0), (-40.0, 35.0), (-30.0, 30.0))
_EYE = _Joint(_Z, _X, (-10.0, 10.0), (-40.0, 50.0), (-50.0, 50.0))

_JOINTS: dict[str, _Joint] = {
    # Twist: inwards; abduction: adduction.
    "hip": _Joint(_DOWN, _RIGHT, (-50.0, 45.0), (-30.0, 140.0), (-60.0, 30.0)),
    # Twist: toes inwards.
    "knee": _Joint(_DOWN, _X, (-40.0, 30.0), (-10.0, 160.0), (-10.0, 10.0)),
    # Twist: eversion; flexion: plantar; abduction: toes outwards.
    "ankle": _Joint(_Z, _X, (-40.0, 25.0), (-45.0, 55.0), (-25.0, 25.0)),
    # The toes. Flexion: plantar.
    "foot": _Joint(_Z, _X, (-15.0, 15.0), (-90.0, 45.0), (-15.0, 15.0)),
    "spine1": _VERTEBRAE,
    "spine2": _VERTEBRAE,
    "spine3": _VERTEBRAE,
    "neck": _NECK,
    "head": _NECK,
    # Flexion: the mouth opens.
    "jaw": _Joint(_Z, _X, (-10.0, 10.0), (-5.0, 40.0), (-15.0, 15.0)),
    "eye_smplhf": _EYE,
    # Twist: the front goes down; flexion: forwards; abduction: down, from the arm of a T-pose.
    "collar": _Joint(_X, _DOWN, (-45.0, 45.0), (-30.0, 30.0), (-45.0, 30.0)),
    # Twist: inwards; flexion: forwards, from a T-pose; abduction: down, 90 at the side.
    "shoulder": _Joint(_X, _DOWN, (-100.0, 100.0), (-60.0, 135.0), (-110.0, 120.0)),
    # Twist: pronation, from the middle (palms down in a T-pose).
    "elbow": _Joint(_X, _DOWN, (-90.0, 90.0), (-10.0, 155.0), (-15.0, 15.0)),
    # Abduction: towards the little finger.
    "wrist": _Joint(_X, _BACK, (-45.0, 45.0), (-85.0, 90.0), (-25.0, 40.0)),
}

#: Of the fingers, knuckle to tip: twist, flexion, abduction [degrees].
_FINGER = (
    ((-15.0, 15.0), (-45.0, 95.0), (-25.0, 25.0)),
    ((-10.0, 10.0), (-10.0, 115.0), (-10.0, 10.0)),
    ((-10.0, 10.0), (-20.0, 90.0), (-10.0, 10.0)),
)
#: Of the thumb, wrist to tip. It flexes towards the little finger's knuckle. All of its opposition
#: is its root's, from a rest pose that bodies choose differently: twice a thumb's 60 degrees.
_THUMB = (
    ((-45.0, 45.0), (-50.0, 60.0), (-115.0, 60.0)),
    ((-20.0, 20.0), (-20.0, 75.0), (-25.0, 25.0)),
    ((-15.0, 15.0), (-30.0, 90.0), (-15.0, 15.0)),
)


@dataclass(frozen=True)
class JointRanges:
    """Ranges of all joints; angles are (twist, flexion, abduction).

    Attributes:
        axes: Of the three angles, in the rest frame (55, 3, 3), orthonormal and right-handed.
        lower, upper: Ends (55, 3) [rad]; those of the pelvis hold everything.
    """

    axes: Array
    lower: Array
    upper: Array

    @staticmethod
    def of(body: Body) -> JointRanges:
        """The ranges of a person with this body, kept with it: they take 3 ms."""
        if body not in _MADE:
            _MADE[body] = JointRanges._found(body)
        return _MADE[body]

    @staticmethod
    def _found(body: Body) -> JointRanges:
        axes = np.tile(np.eye(3), (N_JOINTS, 1, 1))
        lower, upper = np.full((N_JOINTS, 3), -np.pi), np.full((N_JOINTS, 3), np.pi)
        for j, name in enumerate(JOINT_NAMES[1:], start=1):
            joint = _left_joint(name, np.asarray(body.rest_joints))
            bone, flexes = np.array(joint.bone), np.array(joint.flexes)
            axes[j] = np.stack([bone, flexes, np.cross(bone, flexes)])
            if name.startswith("right_"):  # the mirror image of a turn about (x, y, z)
                axes[j] *= np.array([1.0, -1.0, -1.0])
            ends = np.radians([joint.twist, joint.flexion, joint.abduction])
            lower[j], upper[j] = ends.T
        for array in (axes, lower, upper):
            array.flags.writeable = False
        return JointRanges(axes, lower, upper)

    def angles(self, rotations: ArrayLike) -> Array:
        """Angles (..., 55, 3) [rad] of axis-angle rotations (..., 55, 3) [rad]."""
        return swing_twist(rot.exp(rotations), self.axes)

    def excess(self, rotations: ArrayLike, reference: ArrayLike) -> Array:
        """How far angles are beyond their ranges, and beyond the reference's, (..., 55, 3) [rad].

        Nothing is beyond a range of a whole turn, as the pelvis has.

        Args:
            rotations, reference: Axis-angle (..., 55, 3) [rad] of the motion and of what was asked.
        """
        own, asked = self.angles(rotations), self.angles(reference)
        own[..., 0] += 2.0 * np.pi * np.round((asked - own)[..., 0] / (2.0 * np.pi))
        least, most = np.minimum(self.lower, asked), np.maximum(self.upper, asked)
        out: Array = np.maximum(np.maximum(least - own, own - most), 0.0)
        out[..., self.upper - self.lower >= 2.0 * np.pi] = 0.0
        return out


def swing_twist(quats: ArrayLike, axes: ArrayLike) -> Array:
    """Angles (..., 3) [rad] of rotations (..., 4), wxyz, about axes (..., 3, 3), see `JointRanges`.

    With q = swing * twist, the twist about axis 0: its angle in (-pi, pi], and the swing's rotation
    vector by component, each 4 atan of the quarter tangent.
    """
    q = np.asarray(quats, dtype=np.float64)
    q = np.where(q[..., :1] < 0.0, -q, q)
    w = q[..., 0]
    t, f, a = np.moveaxis(np.einsum("...ij,...j->...i", np.asarray(axes), q[..., 1:]), -1, 0)
    N = np.hypot(w, t)
    c, s = np.where(N > 0.0, [w, t] / np.maximum(N, 1e-300), np.stack([np.ones_like(w), 0.0 * w]))
    swing = np.stack([c * f - s * a, c * a + s * f], axis=-1) / (1.0 + N)[..., None]
    twist = 2.0 * np.arctan2(t, w)
    return np.concatenate([twist[..., None], 4.0 * np.arctan(swing)], axis=-1)


def from_swing_twist(angles: ArrayLike, axes: ArrayLike) -> Array:
    """Axis-angle rotations (..., 3) [rad] whose `swing_twist` about axes (..., 3, 3) these are."""
    given, about = np.asarray(angles, dtype=np.float64), np.asarray(axes, dtype=np.float64)
    quarter = np.tan(0.25 * given[..., 1:])
    size = np.linalg.norm(quarter, axis=-1, keepdims=True)
    swung = quarter * 4.0 * np.arctan(size) / np.where(size > 0.0, size, 1.0)
    swing = swung[..., :1] * about[..., 1, :] + swung[..., 1:] * about[..., 2, :]
    twist = given[..., :1] * about[..., 0, :]
    return rot.log(rot.multiply(rot.exp(swing), rot.exp(twist)))


_MADE: WeakKeyDictionary[Body, JointRanges] = WeakKeyDictionary()


def _left_joint(name: str, joints: Array) -> _Joint:
    """The joint of this name, or of its name on the left; `joints` (55, 3) at rest [m]."""
    name = name.removeprefix("left_").removeprefix("right_")
    if name in _JOINTS:
        return _JOINTS[name]
    finger, k = name[:-1], int(name[-1])
    at = [joints[JOINT_INDEX[f"left_{finger}{i}"]] for i in (1, 2, 3)]
    bone = at[min(k, 2)] - at[min(k, 2) - 1]
    absent = not bone.any()  # SMPL has no fingers: their joints are where the wrist is
    if absent:
        bone = np.array(_X)
    if finger == "thumb" and not absent:
        flexes = np.cross(bone, joints[JOINT_INDEX["left_pinky1"]] - at[k - 1])
    else:
        flexes = np.array(_BACK) - (np.array(_BACK) @ bone) / (bone @ bone) * bone
    bone, flexes = bone / np.linalg.norm(bone), flexes / np.linalg.norm(flexes)
    return _Joint(tuple(bone), tuple(flexes), *(_THUMB if finger == "thumb" else _FINGER)[k - 1])
