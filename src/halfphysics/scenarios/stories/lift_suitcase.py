"""Scenario: a suitcase between two flat palms, lifted, carried and shaken."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.errors import InputError
from halfphysics.geometry.shapes import Box
from halfphysics.motion.easing import ease
from halfphysics.motion.skeleton import JOINT_INDEX, JOINT_NAMES, N_JOINTS
from halfphysics.scenarios.acting import arms
from halfphysics.scenarios.acting.gait import walk
from halfphysics.scenarios.acting.legs import about, leg_of
from halfphysics.scenarios.acting.legs import solve as solve_leg
from halfphysics.scenarios.acting.walk_plan import WALK_RATIO, Walk
from halfphysics.scenarios.props import stage
from halfphysics.simulation.sequence import Sequence

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion

Array = NDArray[np.float64]

#: The suitcase [m]: along the walk, between the palms, upright; and what it stands on.
SIZE = (0.36, 0.25, 0.50)
STOOL = (0.30, 0.25, 0.55)
# How high its middle is as it stands [m].
_MIDDLE = STOOL[2] + 0.5 * SIZE[2]
#: When the palms close, the lift begins and ends, and the walk begins [s].
CLOSE, LIFT, UP, WALK = 0.2, 1.0, 2.0, 2.4
#: How far the suitcase is lifted [m]; how high its sides are pressed above its middle [m].
RISE, _ABOVE = 0.35, 0.05
#: Shaken up and down: amplitude [m] and rate [Hz], after this pause [s].
AMPLITUDE, RATE, _PAUSE = 0.10, 1.0, 0.5
# The palms while open: this far from the sides [m]; closed: their targets this far inside.
_OPEN, _CLOSING = 0.03, 0.5
# The wrists before the pelvis as the suitcase is taken and as it is carried [m].
_TAKEN, _CARRIED = 0.30, 0.36
# While it stands: the pelvis this much lower and farther back [m], the trunk leaning [rad].
_CROUCH, _BACK, _LEAN = 0.08, 0.06, np.radians(24.0)
# Of the hands: fingers below horizontal as it is taken and as it is carried, each knuckle bent,
# thumbs out of the way [rad].
_TAKING, _CARRYING, _BEND, _THUMB = np.radians([28.0, 8.0, 10.0, 25.0])
# Where the left elbow points, down and out; the right one mirrored.
_ELBOW = (-0.5, 0.5, -1.0)
_SPEED = 0.9
# Part of the way from the wrist to the knuckles at which the palm presses.
_PRESSED = 0.5


def build(
    *,
    fps: float = 30.0,
    mass: float = 5.0,
    friction: float = 0.8,
    squeeze: float = 0.05,
    carry: float = 5.0,
    shake: float = 5.0,
    body: Body | None = None,
) -> Sequence:
    """A person lifts a suitcase off a stool between both flat palms, carries and shakes it.

    Args:
        fps: Frames per second.
        mass: Of the suitcase [kg].
        friction: Of its sides: about 0.8 holds it, 0.1 lets it slip.
        squeeze: How far inside the sides the palms want to be [m].
        carry: How long it is walked about with [s], at least 1.
        shake: How long it is then shaken up and down [s], 0 for not at all.
        body: The person's body; None: the default body, which stool and suitcase are sized for.
    """
    for name, value, least, most in (("carry", carry, 1.0, 60.0), ("shake", shake, 0.0, 60.0)):
        if not least <= value <= most:
            raise InputError(f"{name}: found {value!r}, expected {least:g} to {most:g} s")
    if not 0.0 <= squeeze <= 0.1:
        raise InputError(f"squeeze: found {squeeze!r}, expected 0 to 0.1 m")
    return carried(
        Carried("suitcase", mass, friction), fps, squeeze, (carry, shake), stage.actor(body)
    )


@dataclass(frozen=True)
class Carried:
    """What is carried.

    Attributes:
        name: Its name.
        mass: [kg].
        friction: Of its sides.
        soft: The material of its sides; None: hard.
        size: Along the walk, between the palms, upright [m].
    """

    name: str
    mass: float
    friction: float
    soft: str | None = None
    size: tuple[float, float, float] = SIZE


def carried(
    thing: Carried, fps: float, squeeze: float, times: tuple[float, float], actor: Body
) -> Sequence:
    """A person who lifts, carries and shakes a thing, whose middle is as high as the suitcase's.

    Args:
        thing: What it is.
        fps: Frames per second.
        squeeze: How far inside the sides the palms want to be [m].
        times: How long it is carried, at least 1, and shaken [s].
        actor: The person.
    """
    carry, shake = times
    after = 2.0 * _PAUSE + shake
    # The first and the last of the steps are short ones: of n steps n - 1 go the distance.
    strides = max(2.0, carry * np.sqrt(_SPEED / WALK_RATIO) - 1.0)
    distance = float(strides * np.sqrt(WALK_RATIO * _SPEED))
    # The stool is in front: the walk away from it is a walk toward it, played backwards.
    start = (-distance, 0.0)
    plan = Walk(distance=distance, speed=_SPEED, start=start, before=after, after=WALK)
    base = walk(actor, plan, fps)
    base = base.with_frames(base.translation[::-1], base.rotations[::-1])
    clock = np.arange(len(base)) / base.fps
    stands = base.duration - after
    motion = _carrying(actor, base, Wrists(clock, stands, shake, squeeze, thing.size[1]))
    scene = stage.floor()
    pelvis = actor.joints(base[0])[0]
    at = np.array([pelvis[0] + _TAKEN + _palm(actor)[0], 0.0, _MIDDLE])
    stool = (*STOOL[:2], _MIDDLE - 0.5 * thing.size[2])
    scene.add_static("stool", Box(stool), position=(at[0], at[1], 0.5 * stool[2]))
    scene.add_object(
        thing.name,
        Box(thing.size),
        mass=thing.mass,
        friction=thing.friction,
        position=at,
        soft=thing.soft,
    )
    return Sequence(motion, scene, actor)


@dataclass(frozen=True)
class Wrists:
    """Where the wrists should be, as functions of time.

    Attributes:
        times: Of the frames (T,) [s].
        stands: When the walk is over [s].
        shake: How long it is shaken [s].
        squeeze: How far inside the sides the palms want to be [m].
        width: From side to side [m].
    """

    times: Array
    stands: float
    shake: float
    squeeze: float
    width: float

    @property
    def lifted(self) -> Array:
        """0 while the suitcase stands, 1 once it is carried, (T,)."""
        return ease((self.times - LIFT) / (UP - LIFT))

    @property
    def apart(self) -> Array:
        """Of a palm from the side of the suitcase, negative inside, (T,) [m]."""
        return _OPEN - (_OPEN + self.squeeze) * ease((self.times - CLOSE) / _CLOSING)

    @property
    def height(self) -> Array:
        """Over the floor (T,) [m]."""
        start = self.stands + _PAUSE
        since = np.clip(self.times - start, 0.0, self.shake)
        # In and out within half a period each, so that nothing jerks.
        share = ease(2.0 * RATE * since) * ease(2.0 * RATE * (self.shake - since))
        shaken = AMPLITUDE * share * np.sin(2.0 * np.pi * RATE * since)
        return _MIDDLE + _ABOVE + RISE * self.lifted + shaken


def _palm(body: Body) -> Array:
    """From the wrist joint: how far ahead the palm presses, and its surface [m], (2,)."""
    part = np.argmax(body.weights, axis=1)
    wrist, knuckle = JOINT_INDEX["left_wrist"], JOINT_INDEX["left_middle1"]
    joints = np.asarray(body.rest_joints)
    skin = np.asarray(body.rest_vertices)[part == wrist]
    return np.array(
        [_PRESSED * (joints[knuckle, 0] - joints[wrist, 0]), joints[wrist, 1] - skin[:, 1].min()]
    )


def _carrying(body: Body, base: Motion, wrists: Wrists) -> Motion:
    """The walk `base` with bent knees at its start and the hands at the suitcase."""
    positions, quaternions = body.joint_frames(base)
    turns = rot.to_matrix(quaternions)
    crouch = 1.0 - wrists.lifted
    rotations = np.array(base.rotations)
    pelvis = positions[:, 0] - crouch[:, None] * np.array([_BACK, 0.0, _CROUCH])
    for side in ("left", "right"):
        leg = leg_of(body, side)
        hip = pelvis + turns[:, 0] @ leg.hip
        ankle = leg.joints[2]
        bent = solve_leg(
            leg, turns[:, 0], hip, positions[:, ankle], turns[:, ankle], np.zeros(len(base))
        )
        for joint in leg.joints[:3]:
            rotations[:, joint] = bent[joint]
    for name in ("spine1", "spine2", "spine3"):
        joint = JOINT_INDEX[name]
        lean = rot.rotvec_to_matrix(rotations[:, joint]) @ about(0, crouch * _LEAN / 3.0)
        rotations[:, joint] = rot.matrix_to_rotvec(lean)
    translation = base.translation + pelvis - positions[:, 0]
    motion = base.with_frames(translation, rotations)
    return motion.with_frames(translation, _with_hands(body, motion, wrists))


def _with_hands(body: Body, motion: Motion, wrists: Wrists) -> Array:
    """Rotations (T, 55, 3) of `motion` with the arms at the suitcase, palms flat."""
    positions, quaternions = body.joint_frames(motion)
    turns = rot.to_matrix(quaternions)
    rotations = np.array(motion.rotations)
    surface = _palm(body)[1]
    lifted = wrists.lifted
    for side, left in (("left", 1.0), ("right", -1.0)):
        arm = arms.arm_of(body, side)
        wrist = np.empty((len(motion), 3))
        wrist[:, 0] = positions[:, 0, 0] + _TAKEN + (_CARRIED - _TAKEN) * lifted
        wrist[:, 0] += (1.0 - lifted) * _BACK
        wrist[:, 1] = left * (0.5 * wrists.width + surface + wrists.apart)
        wrist[:, 2] = wrists.height
        below = _TAKING + lifted * (_CARRYING - _TAKING)
        fingers = np.stack([np.cos(below), 0.0 * below, -np.sin(below)], axis=-1)
        hand = arms.palm_frame(side, fingers, np.array([0.0, -left, 0.0]))
        collar, shoulder = turns[:, arm.collar], positions[:, arm.joints[0]]
        elbow = np.array(_ELBOW) * (1.0, left, 1.0)
        for joint, turn in arms.solve(arm, collar, shoulder, wrist, hand, elbow).items():
            rotations[:, joint] = turn
        own = [j for j in range(25, N_JOINTS) if JOINT_NAMES[j].startswith(f"{side}_")]
        rotations[:, own] = (0.0, 0.0, -left * _BEND)
        rotations[:, JOINT_INDEX[f"{side}_thumb1"]] = (-_THUMB, 0.0, 0.0)
    return rotations
