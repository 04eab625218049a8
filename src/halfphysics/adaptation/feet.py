"""Feet that push a thing: kept on its surface while it moves.

A foot was recorded within centimetres of a thing that moves over the floor. It is shifted along the
thing's way until its skin touches, and aside, towards where it pushes through the thing's middle:
elsewhere it turns the thing. While the thing moves the foot stays at that place of it; it comes and
goes as recorded, shifted. Its rotation is not changed. What friction of the floor takes is added as
press.py does: targets go beyond.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.adaptation import arm_pose, press
from halfphysics.adaptation.parts import SAMPLES, joints_of
from halfphysics.base import rotations as rot
from halfphysics.motion.easing import ease
from halfphysics.motion.skeleton import JOINT_INDEX

if TYPE_CHECKING:
    from halfphysics.adaptation.recorded_holds import RecordedHold
    from halfphysics.adaptation.thing import Thing
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion
    from halfphysics.scene.scene import Scene

Array = NDArray[np.float64]

#: A foot is shifted by no more than this along the way, and aside [m].
_ALONG, _ASIDE = 0.06, 0.03
#: A leg is stretched to at most this part of its length: a straight knee snaps.
_STRETCHED = 0.985
#: Skin nearer than this touches [m]; the search along the way is as fine as this.
_TOUCHES, _FINE = 0.004, 1e-4
#: A foot is on its shifted way so long before it is near, no earlier before the thing moves than
#: this, after a time of coming; it stays at its place on the thing so long after that begins to
#: move; and is on its recorded way so long after [s].
_BEFORE, _WAITS, _COMES, _FIXED, _GOES = 0.1, 0.4, 0.6, 0.3, 0.6
#: It lets go within this time [s].
_LETS_GO = 0.1
#: How willingly angles of hip, knee and ankle change: the knee bends about x of its frame.
_WILLING = np.array([1.0, 0.3, 1.0, 1.0, 0.02, 0.02, 0.6, 0.6, 0.6])


@dataclass(frozen=True, eq=False)
class Foot:
    """One foot of a body.

    Attributes:
        side: "left" or "right".
        limb: Indices of hip, knee and ankle.
        toe: Index of the joint of the toes.
        skin: Vertices of its skin: a foot can push with toes, sole and sides.
    """

    side: str
    limb: tuple[int, int, int]
    toe: int
    skin: NDArray[np.int32]

    @property
    def inner(self) -> NDArray[np.int32]:
        """Some of its skin, for distances over all frames."""
        return self.skin[:: max(1, len(self.skin) // SAMPLES)]

    @property
    def name(self) -> str:
        """The joint that stands for it."""
        return f"{self.side}_ankle"

    @property
    def pressing(self) -> tuple[int, ...]:
        """Hip, knee and ankle give way; it presses near the joint of the toes."""
        return (*self.limb, self.toe)

    @property
    def beyond(self) -> tuple[int, ...]:
        """Nothing is beyond the toes."""
        return ()

    @property
    def ahead(self) -> Array:
        """Toes do not turn as they press."""
        return np.zeros(3)

    @classmethod
    def of(cls, body: Body, side: str) -> Foot | None:
        """The `side` foot of a body; None: its skin has none."""
        hip, knee, ankle, toe = (
            JOINT_INDEX[f"{side}_{name}"] for name in ("hip", "knee", "ankle", "foot")
        )
        part = np.argmax(body.weights, axis=1)
        own = np.flatnonzero(np.isin(part, joints_of(f"{side}_ankle")))
        if not len(own):
            return None
        return cls(side, (hip, knee, ankle), toe, own.astype(np.int32))


def kept_all(
    motion: Motion, body: Body, which: Sequence[Foot], hold: RecordedHold
) -> tuple[Motion, dict[str, float]]:
    """`kept` of several feet of a hold; of those that are, how far they were moved [m], by name."""
    arrives = {part.name: frame for part, frame in zip(hold.parts, hold.arrives, strict=True)}
    moved = {}
    for foot in which:
        made = kept(motion, body, foot, hold, arrives[foot.name])
        if made is not None:
            motion, moved[foot.name] = made
    return motion, moved


def friction_below(scene: Scene, thing: Thing) -> float:
    """What friction with what a thing stands on takes at most [N], whichever static that is."""
    most = max((scene.friction_of(thing.name, name) for name in scene.statics), default=0.0)
    return most * thing.item.mass * float(np.linalg.norm(scene.gravity))


def kept(
    motion: Motion, body: Body, foot: Foot, hold: RecordedHold, arrives: int
) -> tuple[Motion, float] | None:
    """The motion with one foot kept on what it pushes; how far it was moved [m].

    Args:
        motion: The motion, T frames.
        body: The person's body.
        foot: Which foot.
        hold: What it pushes, and when.
        arrives: The frame from which on it is near.

    None: along the thing's way the foot meets nothing.
    """
    thing, during = hold.thing, slice(hold.first, hold.last + 1)
    way = direction(hold)
    position, quaternion = body.joint_frames(motion)
    ankle = thing.seen(position[:, foot.limb[2]][:, None])[:, 0]
    middle = np.median(ankle[during], axis=0)
    # The foot as it is at the thing, in the thing's frame.
    points = body.vertices(motion, frames=[hold.middle], indices=foot.skin)[0]
    points = (points - thing.position[hold.middle]) @ thing.turn[hold.middle]
    up = thing.turn[hold.first].T @ np.array([0.0, 0.0, 1.0])
    shift = _onto(thing, points + middle - ankle[hold.middle], way, up)
    if shift is None:
        return None
    share, fixed = _shares(hold, arrives, len(motion), motion.fps)
    frames = np.flatnonzero(share > 0.0)
    to = ankle + shift + fixed[:, None] * (middle - ankle)
    to = thing.position + np.einsum("tij,tj->ti", thing.turn, to)
    here = position[:, foot.limb[2]]
    away = float(np.median(np.linalg.norm(to - here, axis=1)[during]))
    goal = in_reach(body, foot, position, here + share[:, None] * (to - here))
    turn = rot.to_matrix(quaternion[frames, foot.limb[2]])
    rotations = np.array(motion.rotations)
    rotations[np.ix_(frames, np.array(foot.limb))] = arm_pose.moved(
        motion, body, foot, frames, goal[frames], turn, _WILLING
    )
    return motion.with_frames(motion.translation, rotations), away


def reach_of(body: Body, foot: Foot, position: Array) -> Array:
    """How far from the hip the ankle may be (T,) [m]: as a leg stretches, or as it was recorded."""
    rest = np.asarray(body.rest_joints)[list(foot.limb)]
    hip, ankle = position[:, foot.limb[0]], position[:, foot.limb[2]]
    long = float(np.linalg.norm(np.diff(rest, axis=0), axis=1).sum())
    result: Array = np.maximum(_STRETCHED * long, np.linalg.norm(ankle - hip, axis=1))
    return result


def in_reach(body: Body, foot: Foot, position: Array, goal: Array) -> Array:
    """Places of the ankle (T, 3) no farther from the hip than a leg or the recording reaches."""
    hip = position[:, foot.limb[0]]
    away = np.linalg.norm(goal - hip, axis=1)
    share = np.minimum(1.0, reach_of(body, foot, position) / away)
    result: Array = hip + (goal - hip) * share[:, None]
    return result


def direction(hold: RecordedHold) -> Array:
    """Where the thing goes while it is held, level, in its own frame as it begins (3,)."""
    gone = hold.thing.centre[hold.first : hold.last + 1] - hold.thing.centre[hold.first]
    far = gone[int(np.argmax(np.linalg.norm(gone[:, :2], axis=1)))] * [1.0, 1.0, 0.0]
    result: Array = hold.thing.turn[hold.first].T @ (far / max(float(np.linalg.norm(far)), 1e-9))
    return result


def pushed(
    motion: Motion,
    body: Body,
    foot: Foot,
    hold: RecordedHold,
    force: float,
    *,
    stiffness: float,
    time: float,
) -> Motion:
    """The motion whose foot pushes with what the floor's friction takes.

    Args:
        motion: The motion with the foot at the thing.
        body: The person's body.
        foot: Which foot.
        hold: What it pushes, and when.
        force: Along the thing's way [N].
        stiffness: lambda of the leg.
        time: tau of the drive [s].
    """
    at = np.arange(len(motion)) / motion.fps - hold.first / motion.fps
    share = ease(at / _FIXED) * (1.0 - ease((at - _length(hold, motion.fps)) / _LETS_GO))
    frames = np.flatnonzero(share > 0.0)
    push = share[frames, None] * force * (hold.thing.turn[frames] @ direction(hold))
    rotations = np.array(motion.rotations)
    rotations[np.ix_(frames, np.array(foot.pressing))] = press.pressed(
        motion, body, foot, frames, push, stiffness=stiffness, time=time
    )
    return motion.with_frames(motion.translation, rotations)


def _length(hold: RecordedHold, fps: float) -> float:
    return (hold.last - hold.first) / fps


def _shares(hold: RecordedHold, arrives: int, frames: int, fps: float) -> tuple[Array, Array]:
    """How far the foot is on its shifted way (T,), and at one place of the thing (T,)."""
    time = np.arange(frames) / fps
    first, last = hold.first / fps, hold.last / fps
    near = max(arrives / fps - _BEFORE, first - _WAITS)
    share = ease((time - near + _COMES) / _COMES) if near > _COMES else np.ones(frames)
    fixed = ease((time - first) / _FIXED)
    if not hold.kept:
        share = share * (1.0 - ease((time - last) / _GOES))
        fixed = fixed * (1.0 - ease((time - last + _FIXED) / _FIXED))
    return share, fixed


def _onto(thing: Thing, skin: Array, way: Array, up: Array) -> Array | None:
    """The shift (3,) that puts a foot's skin (n, 3) onto the surface [m]; None: it meets none.

    `way` and `up`: where the thing goes, and the vertical, in its frame (3,)."""
    shift = _met(thing, skin, way)
    if shift is None:
        return None
    touches = skin + shift
    at = touches[thing.gaps(touches) < _TOUCHES].mean(axis=0)
    across = np.cross(up, way)
    aside = -np.clip((at - thing.item.com) @ across, -_ASIDE, _ASIDE) * across
    again = _met(thing, skin + aside, way)
    return shift if again is None else aside + again


def _met(thing: Thing, skin: Array, way: Array) -> Array | None:
    """How far along the way (3,) [m] skin touches first, coming from behind; None: nowhere."""
    steps = np.arange(-_ALONG, _ALONG, _TOUCHES)
    gaps = thing.gaps(skin[None] + steps[:, None, None] * way).min(axis=1)
    inside = np.flatnonzero(gaps < 0.0)
    if not len(inside) or inside[0] == 0:
        return None
    near, far = steps[inside[0] - 1], steps[inside[0]]
    while far - near > _FINE:
        middle = 0.5 * (near + far)
        near, far = (near, middle) if thing.gaps(skin + middle * way).min() < 0.0 else (middle, far)
    result: Array = near * way
    return result
