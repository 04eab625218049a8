"""How far targets go inwards, so that the drive presses with a force.

With the drive's time constant tau and stiffness lambda (docs/physics.md, "The drive") an arm that
is held where it is pulls towards its target xi away with

    (M + lambda diag(I)) xi = tau^2 J^T F

M is the inertia of the arm about collar, shoulder and elbow with its hand stiff, J moves the wrist,
F is the force that this balances. So the target of a hand that is to press with F is xi beyond. Its
rotation in the world stays, but for a turn of the fingers inwards: it lies flat on what it presses.

Who carries tenses the arms: lambda of the arm is ten times, of the wrist thirty times that of the
settings while a hand presses. Targets then go a third as far inwards, and a wrist, whose own
inertia is small, bears what hangs beside the hand.
"""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.adaptation.arm_pose import chain, jacobians
from halfphysics.base import rotations as rot
from halfphysics.motion.joint_groups import JointValues
from halfphysics.motion.skeleton import N_JOINTS, PARENTS

if TYPE_CHECKING:
    from halfphysics.adaptation.hands import Hand
    from halfphysics.adaptation.parts import Limb
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion
    from halfphysics.settings import Settings

Array = NDArray[np.float64]

#: A hand that presses turns its fingers inwards until its wrist could bear this share of the force
#: at the last joints of the fingers: what is held does not turn between two heels of hands. 0 lets
#: a suitcase of 6 kg swing by 25 degrees; from 1.5 on fingers reach around a bowl and push it out.
_TIPS_BEAR = 0.5
#: Who holds something makes collar, shoulder and elbow so much firmer than by the settings, the
#: wrist, and the fingers. Without it a tray tips by 25 degrees, a small table by 38.
ARM, _WRIST, _FINGERS = 10.0, 30.0, 3.0
#: Fingers that pull a drawer by its bar: a pull opens them.
_PULLING = 6.0


def pressed(
    motion: Motion,
    body: Body,
    hand: Limb,
    frames: NDArray[np.int64],
    force: Array,
    *,
    stiffness: float,
    time: float,
) -> Array:
    """Rotations of an arm whose palm presses.

    Args:
        motion: The motion whose palm touches, T frames.
        body: The person's body.
        hand: Which hand.
        frames: Of which frames (n,).
        force: What the palm is to press with, in the world (n, 3) [N].
        stiffness: lambda of the arm as it presses: that of the settings, `ARM` times.
        time: tau [s].

    Returns:
        Axis-angles (n, 4, 3) of collar, shoulder, elbow and wrist.
    """
    positions, quaternions = (x[frames] for x in body.joint_frames(motion))
    rest = np.asarray(body.rest_joints)
    joints = hand.pressing
    parent = int(PARENTS[joints[0]])
    local = [rot.to_matrix(rot.exp(motion.rotations[frames][:, j])) for j in joints]
    bones = [rest[b] - rest[a] for a, b in pairwise(joints)]
    turns, places = chain(
        rot.to_matrix(quaternions[:, parent]), positions[:, joints[0]], local, bones
    )
    matrix = _inertia(body, hand, turns, places, positions, quaternions)
    mean = np.diagonal(matrix, axis1=1, axis2=2).reshape(len(matrix), -1, 3).mean(axis=2)
    at = np.arange(matrix.shape[1])
    matrix[:, at, at] += stiffness * np.repeat(mean, 3, axis=1)
    pull = np.einsum("nij,ni->nj", jacobians(turns[:-1], places[:-1], places[-1])[:, :3], force)
    beyond = time**2 * np.linalg.solve(matrix, pull[..., None])[..., 0]
    for k in range(len(joints) - 1):
        local[k] = local[k] @ rot.rotvec_to_matrix(beyond[:, 3 * k : 3 * k + 3])
    after, _ = chain(rot.to_matrix(quaternions[:, parent]), positions[:, joints[0]], local, bones)
    flat = turns[-1]
    if hand.ahead.any():
        way = np.cross(turns[-1] @ hand.ahead, force)
        way /= np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-9)
        wrist = _WRIST / ARM * stiffness
        curl = _curl(body, hand, np.linalg.norm(force, axis=1), wrist, time)
        flat = rot.rotvec_to_matrix(curl[:, None] * way) @ flat
    local[-1] = local[-1] @ np.swapaxes(after[-1], 1, 2) @ flat
    return np.stack([rot.matrix_to_rotvec(m) for m in local], axis=1)


def _curl(body: Body, hand: Limb, force: Array, stiffness: float, time: float) -> Array:
    """Turns of a wrist (n,) [rad] whose fingers then bear their share of a force (n,) [N].

    Against (1 + lambda) I / tau^2 of the wrist, lambda its `stiffness`, I the inertia of the hand.
    """
    rest, parts = np.asarray(body.rest_joints), body.variant.parts
    wrist, fingers = hand.pressing[-1], list(hand.beyond)
    inertia = 0.0
    for joint in (wrist, *fingers):
        away = rest[joint] + parts[joint].com - rest[wrist]
        about = parts[joint].inertia + parts[joint].mass * (
            away @ away * np.eye(3) - np.outer(away, away)
        )
        inertia += float(np.trace(about)) / 3.0
    lever = float(np.linalg.norm(rest[fingers] - rest[wrist], axis=1).max())
    out: Array = _TIPS_BEAR * force * lever * time**2 / ((1.0 + stiffness) * inertia)
    return out


def firmer(hand: Hand, presses: Array, *, pulls: bool = False) -> Array:
    """How much stiffer a hand that holds makes all joints (T, 55).

    Args:
        hand: Which hand.
        presses: Shares of its force (T,).
        pulls: It pulls with its fingers.
    """
    out = np.ones((len(presses), N_JOINTS))
    *arm, wrist = hand.pressing
    out[:, arm] += (ARM - 1.0) * presses[:, None]
    out[:, wrist] += (_WRIST - 1.0) * presses
    fingers = _PULLING if pulls else _FINGERS
    out[:, list(hand.fingers)] += (fingers - 1.0) * presses[:, None]
    return out


def stiffness_of(settings: Settings, hand: Limb) -> float:
    """lambda of a limb: that of its shoulder or hip."""
    value = settings.stiffness
    if isinstance(value, JointValues):
        return float(value.resolve(1.0)[hand.limb[0]])
    return float(value)  # type: ignore[arg-type]


def _inertia(
    body: Body,
    hand: Limb,
    turns: list[Array],
    places: list[Array],
    positions: Array,
    quaternions: Array,
) -> Array:
    """Joint-space inertia (n, 9, 9) about collar, shoulder and elbow; the hand moves with these."""
    joints = hand.pressing[:-1]
    total = np.zeros((len(positions), 9, 9))
    parts = body.variant.parts
    for k, joint in enumerate(joints):
        last = k == len(joints) - 1
        for index in (joint, *((hand.pressing[-1], *hand.beyond) if last else ())):
            part = parts[index]
            turn = rot.to_matrix(quaternions[:, index])
            centre = positions[:, index] + turn @ part.com
            moves = jacobians(turns[: k + 1], places[: k + 1], centre)
            spin = turn @ part.inertia @ np.swapaxes(turn, 1, 2)
            n = 3 * (k + 1)
            linear, angular = moves[:, :3], moves[:, 3:]
            total[:, :n, :n] += part.mass * np.swapaxes(linear, 1, 2) @ linear
            total[:, :n, :n] += np.swapaxes(angular, 1, 2) @ spin @ angular
    return total
