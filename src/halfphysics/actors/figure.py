"""A person put together: pelvis and feet, trunk, arms and head as one pose."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from halfphysics.actors.limbs import ArmBones, vec
from halfphysics.actors.stride import SIGN, Stand, Stride
from halfphysics.actors.turns import (
    Quat,
    Vec,
    about_x,
    about_y,
    about_z,
    log,
    multiply,
    plus,
    rotate,
)
from halfphysics.actors.walker import SIDES, Walker
from halfphysics.motion.pose import Pose
from halfphysics.motion.skeleton import JOINT_INDEX, N_JOINTS
from halfphysics.scenarios.acting import posture

if TYPE_CHECKING:
    from halfphysics.body.body import Body

_SPINE = tuple(JOINT_INDEX[name] for name in ("spine1", "spine2", "spine3"))
_NECK, _HEAD = JOINT_INDEX["neck"], JOINT_INDEX["head"]
_FINGERS = {
    side: tuple(
        JOINT_INDEX[f"{side}_{finger}{k}"]
        for finger in ("index", "middle", "pinky", "ring")
        for k in (1, 2, 3)
    )
    for side in SIDES
}
_PELVIS_YAW, _PELVIS_LIST = float(posture.PELVIS_YAW), float(posture.PELVIS_LIST)
_LEAN, _CHEST_YAW = float(posture.LEAN), float(posture.CHEST_YAW)
_SWING, _ELBOW = float(posture.ARM_SWING), float(posture.ELBOW)
_ELBOW_SWING, _PRONATION = float(posture.ELBOW_SWING), float(posture.PRONATION)
_DOWN, _COLLAR = float(posture.ARM_DOWN), float(posture.COLLAR_DOWN)
CURL = float(posture.CURL)


class Trunk(NamedTuple):
    """Turns of the spine: to the left, to the right side, forwards [rad]."""

    twist: float
    tilt: float
    bend: float


class Gaze(NamedTuple):
    """Turns of neck and head together: to the left, downwards [rad]."""

    turn: float
    nod: float


class ArmTurns(NamedTuple):
    """Rotations of the joints of an arm, each in its parent's frame."""

    collar: Quat
    shoulder: Quat
    elbow: Quat
    wrist: Quat


class Chest(NamedTuple):
    """The third joint of the spine: rotation and position, world; and the spine's own turns."""

    turn: Quat
    at: Vec
    spine: Quat


def walking_trunk(stride: Stride) -> Trunk:
    """The chest turns against the pelvis, and stays upright."""
    going, ahead, swings = stride
    return Trunk(
        (_CHEST_YAW + _PELVIS_YAW) * going * ahead, -0.9 * _PELVIS_LIST * going * swings, 0.0
    )


def walking_gaze(stride: Stride) -> Gaze:
    """The head goes straight ahead."""
    going, ahead, _ = stride
    return Gaze(-_CHEST_YAW * going * ahead, -_LEAN * going)


def swinging_arm(left: float, stride: Stride) -> ArmTurns:
    """An arm that hangs and swings against the leg of its side.

    Args:
        left: 1 of the left arm, -1 of the right one.
        stride: Of the walk.
    """
    going, ahead, _ = stride
    swing = _SWING * (left * ahead * going + 0.12)
    bend = _ELBOW * (0.6 + 0.4 * min(going, 1.0)) - _ELBOW_SWING * left * ahead * going
    twist = about_x(0.5 * _PRONATION)
    return ArmTurns(
        about_z(-left * _COLLAR),
        multiply(about_x(swing), about_z(-left * (_DOWN - _COLLAR))),
        multiply(about_y(-left * max(bend, 0.05)), twist),
        twist,
    )


class Figure:
    """The skeleton of a body, posed.

    Args:
        body: The person's body.
        walker: Whose legs these are.
    """

    def __init__(self, body: Body, walker: Walker) -> None:
        joints = np.asarray(body.rest_joints)
        self.body, self._legs = body, walker.legs
        #: Length of a leg [m].
        self.leg = walker.legs["left"].length
        self.arms = {side: ArmBones.of(body, side) for side in SIDES}
        self._pelvis = vec(joints[0])
        self._up = tuple(
            vec(joints[b] - joints[a]) for a, b in zip((0, *_SPINE), _SPINE, strict=False)
        )
        self._collar = {
            side: vec(joints[self.arms[side].collar] - joints[_SPINE[2]]) for side in SIDES
        }
        self._shoulder = {
            side: vec(joints[self.arms[side].joints[0]] - joints[self.arms[side].collar])
            for side in SIDES
        }
        #: Elbow from shoulder, by side.
        self.upper = {
            side: vec(joints[self.arms[side].joints[1]] - joints[self.arms[side].joints[0]])
            for side in SIDES
        }
        #: Head from the third joint of the spine.
        self.eyes = vec(joints[_HEAD] - joints[_SPINE[2]])

    def chest(self, stand: Stand, trunk: Trunk) -> Chest:
        """Where the chest is."""
        third = multiply(
            multiply(about_y(trunk.twist / 3.0), about_z(trunk.tilt / -3.0)),
            about_x(trunk.bend / 3.0),
        )
        at, turn = stand.pelvis, stand.root
        for offset in self._up:
            at = plus(at, rotate(turn, offset))
            turn = multiply(turn, third)
        return Chest(turn, at, third)

    def shoulder(self, side: str, chest: Chest, collar: Quat) -> tuple[Quat, Vec]:
        """World rotation of a collar, and position of its shoulder."""
        turn = multiply(chest.turn, collar)
        at = plus(chest.at, rotate(chest.turn, self._collar[side]))
        return turn, plus(at, rotate(turn, self._shoulder[side]))

    def pose(
        self,
        stand: Stand,
        chest: Chest,
        gaze: Gaze,
        arms: tuple[ArmTurns, ArmTurns],
        curls: tuple[float, float] = (CURL, CURL),
    ) -> Pose:
        """All of it.

        Args:
            stand: Pelvis and feet.
            chest: Of `chest`.
            gaze: Of the head from the chest.
            arms: Left and right.
            curls: Flexion of the fingers of both hands [rad].
        """
        out: list[Vec] = [(0.0, 0.0, 0.0)] * N_JOINTS
        out[0] = log(stand.root)
        out[_SPINE[0]] = out[_SPINE[1]] = out[_SPINE[2]] = log(chest.spine)
        half = log(multiply(about_y(0.5 * gaze.turn), about_x(0.5 * gaze.nod)))
        out[_NECK] = out[_HEAD] = half
        for side, foot, arm, curl in zip(SIDES, stand.feet, arms, curls, strict=True):
            leg, left = self._legs[side], SIGN[side]
            hip = plus(stand.pelvis, rotate(stand.root, leg.hip))
            turns = leg.solve(stand.root, hip, foot.ankle, foot.turn)
            for joint, turn in zip(leg.joints, turns, strict=False):
                out[joint] = log(turn)
            out[leg.joints[3]] = (-foot.bend, 0.0, 0.0)
            bones = self.arms[side]
            for joint, turn in zip((bones.collar, *bones.joints), arm, strict=True):
                out[joint] = log(turn)
            bent = (0.0, 0.0, -left * curl)
            for joint in _FINGERS[side]:
                out[joint] = bent
        origin = plus(stand.pelvis, self._pelvis, -1.0)
        return Pose.trusted(np.array(origin), np.array(out), np.eye(3))
