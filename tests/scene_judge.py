"""What a scenario asks for and what comes of it: penetration, place of the pelvis, free joints."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from halfphysics import metrics
from halfphysics import rotations as rot
from halfphysics.result import SETTLE
from halfphysics.simulation import simulate
from halfphysics.skeleton import N_JOINTS, PARENTS


@dataclass(frozen=True)
class SceneVerdict:
    """Depths [mm], shares [%], lengths [m], angles [degrees].

    Attributes:
        asked, after: `metrics.penetration` of the reference and of the result.
        pelvis: Distance of the pelvis from the reference (T,).
        free: Largest angle to the reference of each joint over the frames it is free in (55,).
    """

    sequence: object
    result: object
    asked: metrics.PenetrationReport
    after: metrics.PenetrationReport
    pelvis: np.ndarray
    free: np.ndarray


def judge(sequence):
    """Simulates a `Sequence` and looks at what comes of it."""
    motion, scene, body = sequence.motion, sequence.scene, sequence.body
    result = simulate(motion, scene, body=body, settings=sequence.settings)
    there = metrics.penetration(motion, body, scene)
    after = metrics.penetration(result.motion, body, scene, objects=result.objects)
    pelvis = np.linalg.norm(body.joints(motion)[:, 0] - body.joints(result.motion)[:, 0], axis=1)
    angle = np.where(free_joints(result), joint_angles(motion, result.motion), 0.0)
    return SceneVerdict(sequence, result, there, after, pelvis, angle.max(axis=0))


def joint_angles(a, b):
    """Angles between the joints of two motions (T, 55) [degrees]."""
    p, q = rot.exp(a.rotations), rot.exp(b.rotations)
    return np.degrees(np.linalg.norm(rot.log(rot.multiply(rot.conjugate(p), q)), axis=-1))


def free_joints(result):
    """Whether a joint has nothing to do with any contact (T, 55).

    A joint that a contact turns is not free: one whose own part or any part beyond it touches,
    that is, one between a contact and the root. Nor is it until it has had the time to return,
    `SETTLE`. The pelvis, moved by all, never is. A part that is stopped does not excuse what
    hangs on it.
    """
    frames = len(result.motion)
    touches = np.zeros((frames, N_JOINTS), dtype=bool)
    contacts = result.contacts
    rows = (contacts.person == 0) & (contacts.part >= 0)
    touches[contacts.frame[rows], contacts.part[rows]] = True
    beyond = touches.copy()
    for joint in range(N_JOINTS - 1, 0, -1):
        beyond[:, PARENTS[joint]] |= beyond[:, joint]
    wait = round(SETTLE * result.fps)
    out = np.ones_like(beyond)
    for t in range(frames):
        out[t] = ~beyond[max(0, t - wait) : t + 1].any(axis=0)
    out[:, 0] = False
    return out
