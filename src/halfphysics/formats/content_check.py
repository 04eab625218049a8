"""What a file's content says about its axes, its sides and its floor, whatever its format's rule.

Each file is looked at after it was read by the rule of its format. People say where up is: who
stands has the head above the feet, and what bears them is below. For a direction that could be up,
the part of the frames is counted in which a person is *borne* along it: the lowest skin is at its
usual level (the median over the frames), some of it stays where it is, and the middle of the body
is above what stays.

- Who is straight along another axis most of the clip, and is borne along it more often than along
  the format's up axis, stands there: the file is read again with that axis up.
- Who is borne along the format's axis more often lies on the ground. Nothing is said.
- Else it is not clear: the rule stays, and the warning says how to choose.

Knees and elbows bend one way: the other way, rotations are mirrored or inverse. A planted foot
stays where it is: where it goes twice as far instead, the translation is mirrored.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.axes import name_along
from halfphysics.base.reader_warnings import held, warn
from halfphysics.formats.format import Options
from halfphysics.formats.glance import Glance, glance, owners
from halfphysics.formats.units_check import PLANTED
from halfphysics.motion.motion import Motion
from halfphysics.motion.skeleton import JOINT_INDEX, LEFT_HAND_JOINTS, RIGHT_HAND_JOINTS

Array = NDArray[np.float64]
T = TypeVar("T")

#: A body is along an axis where the direction from feet to head has this component along it (32
#: degrees), most of the clip in this part of the frames.
_ALONG, _MOST = 0.85, 0.6
#: A body is straight from this length on, head to feet as a part of that at rest.
_STRAIGHT = 0.8
#: A shorter clip says nothing for sure [s].
_SHORT = 1.0
#: Skin that is so close to the lowest bears, if it is slower than this [m], [m/s]; the lowest is so
#: close to its usual level, and the middle of the body within this of what bears.
_TOUCHES, _STAYS, _LEVEL, _BALANCED = 0.04, 0.2, 0.06, 0.15
#: Who stands along another axis is borne along it more often than along the rule's by at least this
#: part of the frames, and along a third by at most so much more.
_MORE, _THIRD = 0.3, 0.15
#: Who does not stand is borne along another axis so often, and so much more often, if it is up.
_OFTEN, _RATHER = 0.7, 0.4
#: A hinge bends the wrong way beyond this [rad], or this in a clip under two seconds, in this
#: part of the frames and so many times as often as the right way; one alone in so many of them.
_BENT, _FAR_BENT, _WRONG, _RIGHT, _SURELY = 0.3, 0.8, 0.1, 5.0, 0.3
#: Root and planted feet move against each other: correlation, the least way [m], in so many pairs.
_AGAINST, _WAY, _PLANTED_PAIRS = -0.8, 0.1, 12
#: People may be so far off z = 0 because the default body has another size than they [m].
_FLOOR = 0.15

_UP = np.array([0.0, 0.0, 1.0])
#: Joints that bend about one axis: name, joint, component of the axis-angle, sign of bending.
_HINGES = (
    ("left knee", JOINT_INDEX["left_knee"], 0, 1.0),
    ("right knee", JOINT_INDEX["right_knee"], 0, 1.0),
    ("left elbow", JOINT_INDEX["left_elbow"], 1, -1.0),
    ("right elbow", JOINT_INDEX["right_elbow"], 1, 1.0),
)
#: What a person stands on upside down.
_ARMS = (
    *LEFT_HAND_JOINTS,
    *RIGHT_HAND_JOINTS,
    *(JOINT_INDEX[f"{side}_{part}"] for side in ("left", "right") for part in ("wrist", "elbow")),
)


def checked(
    where: str,
    options: Options,
    read: Callable[[Options], T],
    people: Callable[[T], Sequence[Motion]],
    explained: Callable[[T], bool],
) -> T:
    """What `read` makes of a file; read again with another axis up where the content says so.

    Args:
        where: Name of the file in messages.
        options: Options of the caller.
        read: Reads the file with these options.
        people: The motions in what was read.
        explained: Whether what was read has something to stand on besides a floor at z = 0.

    Warns:
        HalfPhysicsWarning: What `read` warns of, what was found and done, and what is in doubt.
    """
    with held() as texts:
        found = read(options)
    unit = _unit_of(people(found))
    with np.errstate(over="ignore", invalid="ignore"):  # damaged numbers are no answer here
        looks = [_glance(motion) for motion in people(found)]
        sides = _sides(people(found))  # whose joints are wrong may stand anywhere
    up, told = _axis(looks, people(found), options.up, sure=not sides)
    if up is not None or unit != options.unit:
        options = replace(options, up=up or options.up, unit=unit)
        if unit != 1.0:  # told by the first reading only
            told = [*(text for text in texts if "translations are in" in text), *told]
        with held() as texts:
            found = read(options)
        if up is not None:
            looks = [_glance(motion) for motion in people(found)]
    for text in texts:
        warn(text)
    for line in dict.fromkeys([*told, *sides, *_feet(looks)]):
        warn(line if line.startswith(where) else f"{where}: {line}")
    if options.floor is None and not sides and not explained(found):
        _warn_of_floor(where, looks)
    return found


def _unit_of(motions: Sequence[Motion]) -> float:
    """Metres per unit of the file's translations."""
    origins = [motion.origin for motion in motions if motion.origin is not None]
    return next((float(o.fields["unit"]) for o in origins if "unit" in o.fields), 1.0)


def _glance(motion: Motion) -> Glance:
    return glance(motion.translation, motion.rotations, motion.fps, motion.axes)


def _axis(
    looks: Sequence[Glance], motions: Sequence[Motion], said: str | None, *, sure: bool
) -> tuple[str | None, list[str]]:
    """The axis with which the file is to be read again, if any (only if `sure`), and a line."""
    axes = _axes_of(motions[0])
    rule = name_along(axes, _UP)
    stands, straight = _stands_along(looks)
    short = max(look.duration for look in looks) < _SHORT
    if stands is None or stands[2] > 0.0:
        return None, [] if short or said else _borne_elsewhere(looks, axes)
    other = name_along(axes, stands)
    often = _borne(looks, stands)
    more = often - _borne(looks, _UP, hands=stands[2] < 0.0)
    # Who lies in a file of a third axis up is borne along that one.
    third = max(_borne(looks, up) for up in _across(stands) if up[2] != 1.0)
    clear = sure and more >= _MORE and third < often + _THIRD and straight and not short
    if clear and said is None:
        return other, [
            f"read with {other} up: the person stands along {other}, and by the format {rule} is "
            f"up (up={rule!r}: it is)"
        ]
    doubtful = more > -_MORE and (straight or not short)
    if (said is None and doubtful) or clear:
        how = "upside down" if stands[2] < 0.0 else "lying"
        return None, [
            f"read with {rule} up, and the person is along {other} most of the time: {how}, or is "
            f"another axis up? Then say up={other!r} (up={rule!r}: it is right)"
        ]
    return None, [] if short or said else _borne_elsewhere(looks, axes)


def _axes_of(motion: Motion) -> Array:
    """World from the axes in which the file's rule says what is up: of its frame, or of the data
    set's world around it."""
    fields = motion.origin.fields if motion.origin is not None else {}
    world = fields.get("world")
    return motion.axes if world is None else np.asarray(motion.axes @ world.T)


def _stands_along(looks: Sequence[Glance]) -> tuple[Array | None, bool]:
    """The axis of the world that people are along most of the clip, and whether straight."""
    along = np.concatenate([look.along for look in looks])
    length = np.concatenate([look.length for look in looks])
    for axis in range(3):
        for sign in (1.0, -1.0):
            there = sign * along[:, axis] > _ALONG
            if there.mean() >= _MOST:
                return sign * np.eye(3)[axis], bool(np.median(length[there]) >= _STRAIGHT)
    return None, False


def _borne(looks: Sequence[Glance], up: Array, *, hands: bool = False) -> float:
    """Part of the frames in which people are borne along a direction; `hands`: by arms, too."""
    return float(np.mean([_borne_one(look, up, hands) for look in looks]))


def _borne_one(look: Glance, up: Array, hands: bool) -> float:
    height = look.skin @ up
    low = height.min(axis=1)
    usual = np.abs(low - np.median(low)) < _LEVEL
    bears = (height < low[:, None] + _TOUCHES) & (look.speed < _STAYS) & usual[:, None]
    side = [axis for axis in range(3) if not up[axis]]
    places = look.skin[..., side]
    first = np.where(bears[..., None], places, np.inf).min(axis=1)
    last = np.where(bears[..., None], places, -np.inf).max(axis=1)
    middle = places.mean(axis=1)
    above = (middle > first - _BALANCED) & (middle < last + _BALANCED)
    held_up = above.all(axis=1)
    if hands:
        held_up &= bears[:, np.isin(owners(), _ARMS)].any(axis=1)
    return float(held_up.mean())


def _across(direction: Array) -> list[Array]:
    """The directions along the other axes (4, 3)."""
    both = np.concatenate([np.eye(3), -np.eye(3)])
    return [other for other in both if not other @ direction]


def _borne_elsewhere(looks: Sequence[Glance], axes: Array) -> list[str]:
    """A line where people are seldom borne along the rule's axis, and often along another."""
    others = [*_across(_UP), -_UP]
    often, other = max(((_borne(looks, up), up) for up in others), key=lambda pair: pair[0])
    if often < _OFTEN or often < _borne(looks, _UP) + _RATHER:
        return []
    rule, name = name_along(axes, _UP), name_along(axes, other)
    return [
        f"read with {rule} up, and something bears the person along {name} rather than along it: "
        f"is another axis up? Then say up={name!r} (up={rule!r}: it is right)"
    ]


def _sides(motions: Sequence[Motion]) -> list[str]:
    """A line where knees or elbows bend the wrong way."""
    joints = [joint for _, joint, _, _ in _HINGES]
    turns = [rot.log(rot.exp(motion.rotations[_spread(motion)][:, joints])) for motion in motions]
    values = np.concatenate(turns)
    short = max(motion.duration for motion in motions) < 2.0 * _SHORT
    bent, wrong = _FAR_BENT if short else _BENT, []
    for k, (name, _, axis, sign) in enumerate(_HINGES):
        bend = sign * values[:, k, axis]
        back, right = float((bend < -bent).mean()), float((bend > bent).mean())
        if back > max(_WRONG, _RIGHT * right):
            wrong.append((name, back))
    if len(wrong) < 2 and (short or not any(back > _SURELY for _, back in wrong)):
        return []  # one joint may be a fault of the record
    which = ", ".join(f"{name} ({100.0 * part:.0f} % of the frames)" for name, part in wrong)
    return [
        f"joints bend the wrong way: {which}. Are the rotations mirrored, inverse (transposed "
        "matrices) or of other joints than the format says?"
    ]


def _spread(motion: Motion) -> NDArray[np.intp]:
    return np.unique(np.linspace(0, len(motion) - 1, 64).astype(np.intp))


def _feet(looks: Sequence[Glance]) -> list[str]:
    """A line where the root goes against planted feet along an axis of the ground."""
    looks, against = [look for look in looks if look.duration >= _SHORT], []
    if not looks:
        return []
    planted = [look.turned < PLANTED for look in looks]
    pairs = list(zip(looks, planted, strict=True))
    every_foot = np.concatenate([look.feet[still] for look, still in pairs])
    every_root = np.concatenate(
        [np.repeat(look.moved[:, None], 2, axis=1)[still] for look, still in pairs]
    )
    if len(every_foot) < _PLANTED_PAIRS:
        return []
    for axis, name in ((0, "x"), (1, "y")):
        feet, root = every_foot[:, axis], every_root[:, axis]
        size = float(np.sqrt((feet * feet).sum() * (root * root).sum()))
        together = -float((feet * root).sum())
        if float(np.abs(feet).sum()) > _WAY and together < _AGAINST * size:
            against.append(name)
    if not against:
        return []
    return [
        f"planted feet go along {' and '.join(against)} (z up) as if the translation was mirrored "
        "there: was it, or the rotations, turned to other axes alone?"
    ]


def _warn_of_floor(where: str, looks: Sequence[Glance]) -> None:
    """Warn of people who stand on a level other than z = 0 all the time."""
    stands, _ = _stands_along(looks)
    if stands is None or stands[2] <= 0.0 or max(look.duration for look in looks) < _SHORT:
        return
    if _borne(looks, _UP) < 0.5:
        return
    levels = [float(np.median(look.skin[..., 2].min(axis=1))) for look in looks]
    level = min(levels, key=abs)
    if abs(level) > _FLOOR:
        how = "above" if level > 0.0 else "below"
        warn(
            f"{where}: soles are {abs(level):.2f} m {how} z = 0 all the time (of the default "
            "body). floor='lowest' puts them on it, floor=HEIGHT what is at that height"
        )
