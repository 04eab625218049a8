"""Start poses, and the motions after them. All face +x; rotations (55, 3) [rad]."""

from __future__ import annotations

import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.motion.skeleton import JOINT_INDEX as J
from support.people import FACING_X
from support.starts.groups import paths_of


def _mirrored(turn):
    return np.array(turn) * (1.0, -1.0, -1.0)


def _set(rotations, side, name, turn):
    rotations[J[f"{side}_{name}"]] = turn if side == "left" else _mirrored(turn)


def _arm(rotations, side, forward, down, elbow=0.0):
    """An arm turned forward from the T-pose, then down [rad]."""
    turn = rot.log(rot.multiply(rot.exp([0.0, -forward, 0.0]), rot.exp([0.0, 0.0, -down])))
    if forward > 1.0:  # ahead of the body down is about the body's x
        turn = rot.log(rot.multiply(rot.exp([down, 0.0, 0.0]), rot.exp([0.0, -forward, 0.0])))
    _set(rotations, side, "shoulder", turn)
    _set(rotations, side, "elbow", (0.0, -elbow, 0.0))


def _upright(rng, noise=0.06):
    """Hanging arms, every joint a little off."""
    rotations = np.zeros((55, 3))
    rotations[1:22] = noise * rng.normal(size=(21, 3))
    rotations[25:] = 0.1 * rng.normal(size=(30, 3))
    rotations[0] = rot.log(rot.multiply(rot.exp([0.0, 0.0, 0.3 * rng.normal()]), rot.exp(FACING_X)))
    for side in ("left", "right"):
        _arm(rotations, side, rng.uniform(-0.2, 0.4), rng.uniform(0.9, 1.3), rng.uniform(0.0, 0.5))
    return rotations


def _bent(rng, least, most):
    """Equal bends in the three joints of the spine [rad]."""
    rotations = _upright(rng, 0.04)
    bent = rng.uniform(least, most)
    for name in ("spine1", "spine2", "spine3"):
        rotations[J[name]] += (bent, 0.0, 0.0)
    return rotations


def _ahead(rng, rotations, down, elbow):
    """With one arm or both ahead: how far down, and the most of an elbow [rad]."""
    sides = [["left"], ["right"], ["left", "right"]][rng.integers(3)]
    for side in sides:
        _arm(rotations, side, rng.uniform(1.2, 1.6), rng.uniform(*down), rng.uniform(0.0, elbow))
    return rotations


def stand(rng):
    rotations = _upright(rng)
    if rng.random() < 0.5:
        return step(rng, rotations)
    return rotations


def step(rng, rotations=None):
    """One leg ahead, its knee bent or not."""
    rotations = _upright(rng) if rotations is None else rotations
    side = rng.choice(["left", "right"])
    up, bent = rng.uniform(0.2, 0.9), rng.uniform(0.0, 0.8)
    _set(rotations, side, "hip", (-up, 0.0, 0.0))
    _set(rotations, side, "knee", (bent, 0.0, 0.0))
    return rotations


def reach(rng):
    """One hand or both ahead."""
    return _ahead(rng, _upright(rng), (-0.3, 0.5), 0.4)


def lean(rng):
    """Bent a little, forearms ahead and down, as over a table."""
    return _ahead(rng, _bent(rng, 0.05, 0.3), (0.5, 0.9), 0.6)


def bend(rng):
    """Bent forward from the hips, arms back."""
    rotations = _bent(rng, 0.2, 0.5)
    for side in ("left", "right"):
        _arm(rotations, side, rng.uniform(-0.5, 0.0), rng.uniform(0.9, 1.2), 0.2)
    return rotations


def sit(rng):
    rotations = _upright(rng, 0.05)
    for side in ("left", "right"):
        _set(rotations, side, "hip", (-rng.uniform(1.2, 1.55), 0.05, rng.uniform(0.0, 0.15)))
        _set(rotations, side, "knee", (rng.uniform(1.1, 1.5), 0.0, 0.0))
    return rotations


def lie(rng):
    """On the back, the head towards -x."""
    rotations = _upright(rng, 0.05)
    flat = rot.exp([0.0, -np.pi / 2 + 0.05 * rng.normal(), 0.0])
    rotations[0] = rot.log(rot.multiply(flat, rot.exp(rotations[0])))
    return rotations


def sit_or_lie(rng):
    return sit(rng) if rng.random() < 0.5 else lie(rng)


POSES = {
    "sit_or_lie": sit_or_lie,
    "stand": stand,
    "step": step,
    "reach": reach,
    "lean": lean,
    "bend": bend,
    "sit": sit,
    "lie": lie,
}

#: Waving limbs, outermost joint of each: an elbow, the neck, a knee.
_LIMBS = {
    "left_arm": ("left_elbow", "left_shoulder"),
    "right_arm": ("right_elbow", "right_shoulder"),
    "head": ("neck",),
    "left_leg": ("left_knee",),
    "right_leg": ("right_knee",),
}


def wave(turns, held, rng, own=False):
    """Turns (T, 55, 3) at 30 fps with a limb that waves by 0.3 rad: a limb that is not held, or
    (`own`) one that is held."""
    blocked = paths_of(held)
    # No joint below the limb may be held either.
    free = [names for names in _LIMBS.values() if not any(blocked[J[n]] for n in names)]
    caught = [names for names in _LIMBS.values() if any(blocked[J[n]] for n in names)]
    choice = caught or free if own else free or caught
    t = np.arange(len(turns)) / 30.0
    out = turns.copy()
    swing = 0.3 * np.sin(2.0 * np.pi * rng.uniform(0.6, 1.2) * t)
    for name in choice[rng.integers(len(choice))]:
        axis = rng.normal(size=3) * (1.0, 0.3, 1.0)
        axis /= np.linalg.norm(axis)
        out[:, J[name]] = rot.log(
            rot.multiply(rot.exp(turns[:, J[name]]), rot.exp(swing[:, None] * axis))
        )
    return out


def path_of(frames, rng):
    """A root that walks off at 0.3 to 1.2 m/s, level, any way (T, 3)."""
    angle, speed = rng.uniform(-np.pi, np.pi), rng.uniform(0.3, 1.2)
    t = np.arange(frames) / 30.0
    way = speed * (t - 0.2 * (1.0 - np.exp(-t / 0.2)))  # a smooth start
    return np.outer(way, [np.cos(angle), np.sin(angle), 0.0])
