"""Two hands squeeze a box of 3 kg, lift it off its stand by standing up, and hold it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.bench.clips import body
from halfphysics.bench.pressing import Play, pressed
from halfphysics.bench.record import Options, Record
from halfphysics.bench.squatting import eased, squat
from halfphysics.geometry.shapes import Box, Plane
from halfphysics.motion.motion import Motion
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.results.result import Result
from halfphysics.scene.scene import Scene

#: Mass of the box [kg], its depth and height [m]; its width follows from the open hands.
MASS, _DEPTH, _HEIGHT = 3.0, 0.25, 0.3
#: Gap between each open hand and the box [m]; angle by which the shoulders close [rad].
_OPEN, _SQUEEZE = 0.012, np.radians(12.0)
#: Angles of the open arms [rad]: upper arms below horizontal and spread, forearms turned in.
_BELOW, _SPREAD, _FOLD = 0.5, 0.9, 0.8
#: Distance of the box centre in front of the centre of the hands [m].
_AHEAD = 0.05
#: Time at which the hands have closed, start and end of the lift [s]; height of the lift [m].
_CLOSED, _LIFT, _UP, RISE = 0.5, 0.7, 1.5, 0.22
_FPS, _SECONDS = 30.0, 2.5
#: Parts of each hand: the wrist and the fingers.
HANDS = {
    side: [
        i
        for name, i in JOINT_INDEX.items()
        if name.startswith(f"{side}_")
        and name.removeprefix(f"{side}_").rstrip("123")
        in ("wrist", "index", "middle", "pinky", "ring", "thumb")
    ]
    for side in ("left", "right")
}


def grasp(options: Options) -> Iterator[Record]:
    """Records of both drives."""
    play = lifting()
    if options.quick:
        play = replace(play, motion=play.motion[:60])
    for record, result, (_, theirs) in pressed("grasp", "3 kg", play, options):
        rise, peer_rise = (
            1000.0 * float(np.ptp(objects["box"].position[:, 2]))
            for objects in (result.objects, theirs)
        )
        held = {
            "lifted [mm]": (rise, peer_rise),
            "held [%]": (100.0 * held_by_both(result), None),
        }
        yield replace(record, checks={**held, **record.checks})


def held_by_both(result: Result) -> float:
    """Share of the frames from the start of the lift in which both hands touch the box."""
    first = round(_LIFT * _FPS)
    contacts = result.contacts
    on_box = contacts.other == result.names.index("box")
    frames = [
        set(contacts.frame[on_box & np.isin(contacts.part, hand)].tolist())
        for hand in HANDS.values()
    ]
    both = [t for t in range(first, len(result.motion)) if all(t in f for f in frames)]
    return len(both) / max(1, len(result.motion) - first)


def lifting() -> Play:
    """The motion, the floor, the stand and the box between the hands."""
    motion = _motion()
    left, right = (_hand(motion, side) for side in ("left", "right"))
    inner, outer = float(right[:, 1].max()), float(left[:, 1].min())
    middle = 0.25 * (left.min(axis=0) + left.max(axis=0) + right.min(axis=0) + right.max(axis=0))
    width = outer - inner - 2.0 * _OPEN
    at = np.array([middle[0] + _AHEAD, 0.5 * (inner + outer), middle[2]])
    scene = Scene()
    scene.add_static("floor", Plane())
    under = at[2] - 0.5 * _HEIGHT - 0.001
    stand = Box((_DEPTH, 0.8 * width, under))
    scene.add_static("stand", stand, position=(at[0], at[1], 0.5 * under))
    scene.add_object("box", Box((_DEPTH, width, _HEIGHT)), mass=MASS, position=at)
    return Play(motion=motion, scene=scene)


def _motion() -> Motion:
    """Knees bent, arms ahead, palms facing each other; the hands close, then the legs stretch."""
    t = np.arange(round(_SECONDS * _FPS) + 1) / _FPS
    squeeze = _SQUEEZE * eased(t, 0.1, _CLOSED - 0.1)
    down = 0.03 + RISE * (1.0 - eased(t, _LIFT, _UP - _LIFT))
    lean = 0.35 * (down - 0.03)
    motion = squat(body(), 0.4 * (down - 0.03), down, lean, 0.0 * t, _FPS)
    rotations = motion.rotations.copy()
    for side, sign in (("left", -1.0), ("right", 1.0)):
        # Upper arms ahead, spread and below horizontal; forearms turned in until they are parallel;
        # the turn of the palms is divided equally between elbow and wrist.
        shoulder = rot.multiply(rot.exp([_BELOW, 0.0, 0.0]), _in(sign, _SPREAD + squeeze))
        elbow = rot.multiply(_in(sign, _FOLD - 0.5 * squeeze), rot.exp([np.pi / 4.0, 0.0, 0.0]))
        rotations[:, JOINT_INDEX[f"{side}_shoulder"]] = rot.log(shoulder)
        rotations[:, JOINT_INDEX[f"{side}_elbow"]] = rot.log(elbow)
        rotations[:, JOINT_INDEX[f"{side}_wrist"], 0] = np.pi / 4.0
    return motion.with_frames(motion.translation, rotations)


def _in(sign: float, angle: np.ndarray) -> np.ndarray:
    """Quaternions (T, 4) that turn an arm ahead and inwards by `angle` (T,)."""
    return rot.exp(np.outer(angle, [0.0, sign, 0.0]))


def _hand(motion: Motion, side: str) -> np.ndarray:
    """Vertices (n, 3) of a hand's parts in the first pose, in the world [m]."""
    person = body()
    positions, quaternions = person.joint_frames(motion)
    turns = rot.to_matrix(quaternions[0])
    parts = (person.variant.parts[i] for i in HANDS[side])
    return np.concatenate([p.vertices @ turns[p.index].T + positions[0, p.index] for p in parts])
