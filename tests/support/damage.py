"""What estimators and generators do to a motion, one damage at a time, by arithmetic of its own."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import Rotation

#: Sunk, floating, drift down [m], [m], [m/s]; tilt [deg]; noise of a joint [m]; slide [m/s].
SUNK, FLOATING, DRIFT, TILT, NOISE, SLIDE = 0.03, 0.05, 0.02, 2.0, 0.005, 0.1
#: A joint's noise comes from its own turn and those above it, over bones of about this length [m].
_BONE = 0.4
_JOINTS = 22


def _moved(motion, way):
    return motion.with_frames(motion.translation + way, motion.rotations)


def _time(motion):
    return np.arange(len(motion)) / motion.fps


def sunk(motion, body):
    return _moved(motion, [0.0, 0.0, -SUNK])


def floating(motion, body):
    return _moved(motion, [0.0, 0.0, FLOATING])


def drifting(motion, body):
    return _moved(motion, np.outer(_time(motion), [0.0, 0.0, -DRIFT]))


def sliding(motion, body):
    return _moved(motion, np.outer(_time(motion), [0.8 * SLIDE, 0.6 * SLIDE, 0.0]))


def tilted(motion, body, degrees=TILT):
    """Turned about a level axis through the origin of the world."""
    turn = Rotation.from_rotvec(np.deg2rad(degrees) * np.array([0.8, 0.6, 0.0]))
    rotations = np.array(motion.rotations)
    rotations[:, 0] = (turn * Rotation.from_rotvec(rotations[:, 0])).as_rotvec()
    pelvis = motion.axes @ np.asarray(body.rest_joints)[0]
    return motion.with_frames(turn.apply(motion.translation + pelvis) - pelvis, rotations)


def noisy(motion, body):
    random = np.random.default_rng(11)
    rotations = np.array(motion.rotations)
    size = NOISE / _BONE / np.sqrt(2.0)
    rotations[:, :_JOINTS] += random.normal(0.0, size, rotations[:, :_JOINTS].shape)
    return motion.with_frames(
        motion.translation + random.normal(0.0, NOISE / np.sqrt(3.0), (len(motion), 3)), rotations
    )


DAMAGES: dict[str, Callable] = {
    "sunk": sunk,
    "floating": floating,
    "drifting": drifting,
    "tilted": tilted,
    "noisy": noisy,
    "sliding": sliding,
}
