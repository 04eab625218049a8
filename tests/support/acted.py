"""What actors do without a simulator, and how it is judged."""

from __future__ import annotations

from functools import cache

import numpy as np

import halfphysics as hp
from halfphysics.actors.play import as_motion
from halfphysics.body.joint_ranges import JointRanges

FPS = 30.0
#: Accelerations of joints that people's motion has [m/s^2]: of the trunk, of hands, and of knees
#: and feet, which swing and land in 0.1 s.
TRUNK, HANDS, FEET = 25.0, 40.0, 80.0


@cache
def body() -> hp.Body:
    return hp.Body.default()


def frames(actor, count, seed=0, each=None):
    """The first `count` frames of an actor as a motion; `each` is called with their number."""
    poses = [actor.reset(seed)]
    for i in range(count - 1):
        if each is not None:
            each(i)
        poses.append(actor.next(1.0 / FPS, hp.actors.Seen()))
    return as_motion(poses, actor.body if hasattr(actor, "body") else body(), FPS)


def until_done(person, most=900, seed=0, rest=5):
    """The frames of a person until its goals are done, and some more."""
    poses = [person.reset(seed)]
    while not person.done and len(poses) < most:
        poses.append(person.next(1.0 / FPS, hp.actors.Seen()))
    assert person.done, f"not done after {most} frames: {person.goals}"
    poses += [person.next(1.0 / FPS, hp.actors.Seen()) for _ in range(rest)]
    return as_motion(poses, person.body, FPS)


def accelerations(motion, joints, own=None):
    """Largest acceleration of some joints, by name [m/s^2]."""
    own = own or body()
    places = own.joints(motion)[:, [hp.JOINT_NAMES.index(name) for name in joints]]
    return float(np.linalg.norm(np.diff(places, n=2, axis=0), axis=2).max()) * motion.fps**2


def smooth(motion, own=None):
    """Whether no joint moves more abruptly than people's do."""
    trunk = accelerations(motion, ("pelvis", "spine3", "head"), own)
    hands = accelerations(motion, ("left_wrist", "right_wrist"), own)
    feet = accelerations(motion, ("left_ankle", "right_ankle", "left_knee", "right_knee"), own)
    assert trunk < TRUNK, f"trunk {trunk:.0f}"
    assert hands < HANDS, f"hands {hands:.0f}"
    assert feet < FEET, f"feet {feet:.0f}"
    return True


def range_excess(motion, own=None):
    """How far joints are beyond people's ranges [rad]."""
    ranges = JointRanges.of(own or body())
    return float(ranges.excess(motion.rotations, np.zeros_like(motion.rotations)).max())


def slide(motion, own=None, low=0.008):
    """Of every frame and foot that is down: how far its point of contact moves by the next [m].

    A foot that rolls turns about what touches: the least displacement of the skin that is under
    `low` in both frames.
    """
    own = own or body()
    part = own.weights.argmax(axis=1)
    found = []
    for side in ("left", "right"):
        parts = [hp.JOINT_NAMES.index(f"{side}_{name}") for name in ("ankle", "foot")]
        skin = own.vertices(motion, indices=np.flatnonzero(np.isin(part, parts)))
        down = skin[..., 2] < low
        both = down[1:] & down[:-1]
        moved = np.linalg.norm(np.diff(skin[..., :2], axis=0), axis=2)
        least = np.where(both, moved, np.inf).min(axis=1)
        found.append(least[np.isfinite(least)])
    return np.concatenate(found)
