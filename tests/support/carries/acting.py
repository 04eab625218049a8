"""Acts a carry: a person who walks or stands, bends as far as the hands need, hands at the thing.

The person walks along +x from or to the origin. Hands are placed by inverse kinematics at a thing
whose pose is given, so they move with it exactly.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import convolve1d, maximum_filter1d

from halfphysics.base import rotations as rot
from halfphysics.motion.skeleton import JOINT_INDEX, JOINT_NAMES, N_JOINTS
from halfphysics.scenarios.acting import arms
from halfphysics.scenarios.acting.grip import grip
from halfphysics.scenarios.acting.legs import about, leg_of
from halfphysics.scenarios.acting.legs import solve as solve_leg

#: Bent as far as a person bends here: pelvis lower and farther back [m], trunk leaning [rad].
CROUCH, BACK, LEAN = 0.34, 0.20, np.radians(70.0)
#: Parts of a lean, and of a turn to the side, that the pelvis takes; the spine takes the rest.
PELVIS_LEAN, PELVIS_TURN = 0.35, 0.45
#: An arm is stretched to at most this part of its length.
STRETCHED = 0.94
#: Distance between the skin and a round part that a hand is closed around [m].
CLOSED_GAP = 0.0005
#: The bend is smooth over so many frames before and after.
_SMOOTH = 9
_BENDS = np.linspace(0.0, 1.0, 21)
_ELBOWS = {"flat": (-0.4, 0.6, -1.0), "round": (-0.8, 0.25, -1.0)}


@dataclass(frozen=True)
class Held:
    """One hand at the thing: pose of the hand in the thing's frame, and how it comes and goes.

    Attributes:
        side: "left" or "right".
        turn: Hand from thing (3, 3).
        wrist: Of the hold, in the thing's frame (3,) [m].
        offset: From there, by frame (T, 3) [m].
        fingers: Rotations of the hand's 15 joints by frame (T, 15, 3).
        round: Whether the fingers are closed around it.
    """

    side: str
    turn: np.ndarray
    wrist: np.ndarray
    offset: np.ndarray
    fingers: np.ndarray
    round: bool

    def rows(self, rows):
        return Held(
            self.side, self.turn, self.wrist, self.offset[rows], self.fingers[rows], self.round
        )


def parts_of(body):
    """Name of the joint that moves each vertex most (V,)."""
    return np.array(JOINT_NAMES)[np.argmax(body.weights, axis=1)]


def hand_joints(side):
    """Indices of the 15 joints of the fingers."""
    return [j for j in range(25, N_JOINTS) if JOINT_NAMES[j].startswith(f"{side}_")]


def hand_skin(body, side, fingers):
    """Skin of a hand about its wrist, rest axes (n, 3) [m]; `fingers` (15, 3)."""
    from halfphysics.motion.pose import Pose

    own = np.isin(parts_of(body), ["", *(JOINT_NAMES[j] for j in hand_joints(side))])
    own |= parts_of(body) == f"{side}_wrist"
    rotations = np.zeros((N_JOINTS, 3))
    rotations[hand_joints(side)] = fingers
    skin = body.vertices(Pose(np.zeros(3), rotations), indices=np.flatnonzero(own))
    return skin - np.asarray(body.rest_joints)[JOINT_INDEX[f"{side}_wrist"]]


def flat(body, thing, side, grasp, fingers, turn):
    """Place of the wrist in the thing's frame (3,) with which a flat palm just touches."""
    joints = np.asarray(body.rest_joints)
    wrist, knuckle = JOINT_INDEX[f"{side}_wrist"], JOINT_INDEX[f"{side}_middle1"]
    palm = 0.55 * (joints[knuckle] - joints[wrist])
    palm[1] = 0.0
    facing = np.asarray(grasp.facing)
    skin = hand_skin(body, side, fingers) @ turn.T
    start = np.asarray(grasp.point) - turn @ palm
    # From far away toward the thing until the first point of the skin touches it.
    far, near = 0.12, -0.03
    for _ in range(40):
        middle = 0.5 * (far + near)
        inside = thing.distance(skin + start - middle * facing).min() < 0.0
        far, near = (far, middle) if inside else (middle, near)
    return start - far * facing


def holds_of(body, thing, pick, offsets, closed, frames):
    """The hands at the thing, each with its `pick` of the directions of its fingers."""
    out = []
    for side, grasp in thing.grasps.items():
        direction = np.asarray(grasp.fingers[pick])
        turn = arms.palm_frame(side, direction, np.asarray(grasp.facing))[0]
        if grasp.radius is None:
            still = _straight(side)
            wrist = flat(body, thing, side, grasp, still, turn)
            fingers = np.repeat(still[None], frames, axis=0)
        else:
            own = _grip(body, grasp.radius)
            fingers = own.fingers(closed, 0.0)
            wrist = np.asarray(grasp.point) - turn @ own.centre
        out.append(Held(side, turn, wrist, offsets[side], fingers, grasp.radius is not None))
    return out


_GRIPS: dict = {}


def _grip(body, radius):
    key = (id(body), radius)
    if key not in _GRIPS:
        _GRIPS[key] = (
            body,
            grip(body, radius, CLOSED_GAP),
        )  # the body is kept: its id stays its own
    return _GRIPS[key][1]


def _straight(side):
    """A flat hand, its thumb beside the palm."""
    out = np.zeros((15, 3))
    out[hand_joints(side).index(JOINT_INDEX[f"{side}_thumb1"])] = (np.radians(-25.0), 0.0, 0.0)
    return out


@dataclass(frozen=True)
class Way:
    """The thing by frame: `position` (T, 3), `matrix` (T, 3, 3); `turn` of the trunk (T,)."""

    position: np.ndarray
    matrix: np.ndarray
    turn: np.ndarray

    def rows(self, rows):
        return Way(self.position[rows], self.matrix[rows], self.turn[rows])


def act(body, base, way, holds, shoulders, smooth=True):
    """The motion with the hands at the thing, and how far the body bends (T,); nan: no reach.

    `shoulders`: of these frames, from `shoulders_of`.
    """
    bend = _bend(body, way, holds, shoulders)
    reached = np.where(np.isnan(bend), 1.0, bend)
    if smooth:
        window = np.hanning(2 * _SMOOTH + 3)[1:-1]
        reached = maximum_filter1d(reached, 2 * _SMOOTH + 1, mode="nearest")
        reached = convolve1d(reached, window / window.sum(), mode="nearest")
    motion = _bent(body, base, way.turn, reached)
    return _with_hands(body, motion, way, holds), bend


def acted(body, base, thing, way, offsets, closed, hold, limit):
    """`act` with that direction of the fingers which bends the wrists least; None: none is right.

    Args:
        body, base, way: As of `act`.
        thing: What is held, with one direction of the fingers or several for each grasp.
        offsets: Of each hand from its place (T, 3) [m].
        closed: How far fingers are closed (T,).
        hold: First and last frame of the hold.
        limit: Wrists bend by no more than this [rad].
    """
    few, best = np.arange(hold[0], hold[1] + 1, 8), None
    shoulders = shoulders_of(body, base, way.turn)
    for pick in range(min(len(grasp.fingers) for grasp in thing.grasps.values())):
        holds = holds_of(body, thing, pick, offsets, closed, len(base))
        some = [held.rows(few) for held in holds]
        standing = base.with_frames(base.translation[few], base.rotations[few])
        motion, bend = act(body, standing, way.rows(few), some, shoulders[:, few], smooth=False)
        if np.isnan(bend).any():
            continue
        worst = wrist_bend(motion, some)
        if worst <= limit and (best is None or worst < best[0]):
            best = worst, holds
    return None if best is None else act(body, base, way, best[1], shoulders)


def without_gaps(made):
    """The motion of what `acted` returns; None: there is none, or hands cannot reach throughout."""
    return None if made is None or np.isnan(made[1]).any() else made[0]


def _wrist(way, held):
    place = held.wrist + held.offset
    return way.position + np.einsum("tij,tj->ti", way.matrix, place)


def shoulders_of(body, base, turn):
    """Both shoulders at every bend that is tried (bends, T, 2, 3) [m]."""
    own = [JOINT_INDEX["left_shoulder"], JOINT_INDEX["right_shoulder"]]
    bent = (_bent(body, base, turn, np.full(len(base), share), legs=False) for share in _BENDS)
    return np.stack([body.joints(motion)[:, own] for motion in bent])


def _bend(body, way, holds, shoulders):
    """The least bend with which the wrists are within reach (T,), nan: none is."""
    fits = np.ones(shoulders.shape[:2], bool)
    for held in holds:
        arm = arms.arm_of(body, held.side)
        length = np.linalg.norm(arm.upper) + np.linalg.norm(arm.fore)
        shoulder = shoulders[:, :, 0 if held.side == "left" else 1]
        away = np.linalg.norm(_wrist(way, held) - shoulder, axis=-1)
        fits &= away < STRETCHED * length
    return np.where(fits.any(axis=0), _BENDS[np.argmax(fits, axis=0)], np.nan)


def _bent(body, base, turn, bend, legs=True):
    """The walk with the pelvis lower, farther back and turned, the trunk leaning; same feet."""
    positions, quaternions = body.joint_frames(base)
    turns = rot.to_matrix(quaternions)
    size = body.stature / 1.75
    yaw = about(2, PELVIS_TURN * turn)
    root = yaw @ about(1, PELVIS_LEAN * LEAN * bend) @ turns[:, 0]
    lower = bend[:, None] * np.array([-BACK, 0.0, -CROUCH]) * size
    pelvis = positions[:, 0] + np.einsum("tij,tj->ti", yaw, lower)
    rotations = np.array(base.rotations)
    rotations[:, 0] = rot.matrix_to_rotvec(root)
    for side in ("left", "right") if legs else ():
        leg = leg_of(body, side)
        ankle, toe = leg.joints[2:]
        straight = np.zeros(len(base))
        hip = pelvis + root @ leg.hip
        solved = solve_leg(leg, root, hip, positions[:, ankle], turns[:, ankle], straight)
        for joint in leg.joints[:3]:
            rotations[:, joint] = solved[joint]
        rotations[:, toe] = base.rotations[:, toe]
    for name in ("spine1", "spine2", "spine3"):
        joint = JOINT_INDEX[name]
        local = rot.rotvec_to_matrix(rotations[:, joint])
        local = local @ about(1, (1.0 - PELVIS_TURN) * turn / 3.0)
        local = local @ about(0, (1.0 - PELVIS_LEAN) * LEAN * bend / 3.0)
        rotations[:, joint] = rot.matrix_to_rotvec(local)
    for name in ("neck", "head"):  # looks at the thing, not at the feet
        joint = JOINT_INDEX[name]
        local = rot.rotvec_to_matrix(rotations[:, joint]) @ about(0, -0.25 * LEAN * bend)
        rotations[:, joint] = rot.matrix_to_rotvec(local)
    return base.with_frames(base.translation + pelvis - positions[:, 0], rotations)


def _with_hands(body, motion, way, holds):
    positions, quaternions = body.joint_frames(motion)
    turns = rot.to_matrix(quaternions)
    rotations = np.array(motion.rotations)
    for held in holds:
        arm = arms.arm_of(body, held.side)
        hand = way.matrix @ held.turn
        left = 1.0 if held.side == "left" else -1.0
        elbow = np.array(_ELBOWS["round" if held.round else "flat"]) * (1.0, left, 1.0)
        pole = np.einsum("tij,j->ti", about(2, way.turn), elbow)
        shoulder = positions[:, arm.joints[0]]
        solved = arms.solve(arm, turns[:, arm.collar], shoulder, _wrist(way, held), hand, pole)
        for joint, turn in solved.items():
            rotations[:, joint] = turn
        rotations[:, hand_joints(held.side)] = held.fingers
    return motion.with_frames(motion.translation, rotations)


def wrist_bend(motion, holds):
    """Largest angle of the wrists [rad]."""
    own = [JOINT_INDEX[f"{held.side}_wrist"] for held in holds]
    return float(np.linalg.norm(motion.rotations[:, own], axis=-1).max())
