"""A scenario's reference and its result: penetration, place of the pelvis, free joints."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from evidence.runs.playing import free_joints, joint_angles, pelvis_distance
from halfphysics import metrics
from halfphysics.metrics.asked import asked_motion
from halfphysics.simulation.simulate import simulate


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


def judge(sequence, settings=None):
    """Simulates a `Sequence`, by its own settings or others, and judges the result."""
    motion, scene, body = sequence.motion, sequence.scene, sequence.body
    settings = settings or sequence.settings
    result = simulate(motion, scene, body=body, settings=settings)
    there = metrics.penetration(motion, body, scene)
    after = metrics.penetration(result.motion, body, scene, objects=result.objects)
    # Who has waited is behind the motion, and follows what was asked of it then.
    then = asked_motion(result.people[0])
    angle = np.where(free_joints(result), joint_angles(then, result.motion), 0.0)
    return SceneVerdict(sequence, result, there, after, pelvis_distance(result), angle.max(axis=0))
