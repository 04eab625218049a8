"""People on mats: who walks over one or stands on one, and what came of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.scenarios.acting.gait import walk
from halfphysics.scenarios.acting.walk_plan import Walk
from support.standing import raised, standing

#: Where the mat begins and ends along the path, how wide it is, and the path [m].
BEGINS, ENDS, WIDE, PATH = 1.0, 3.0, 2.0, 5.0
#: A box is this many thicknesses high, so that its frame is over nothing but itself.
_HEIGHTS = 2.6
#: Speed of a walk [m/s].
_SPEED = 1.2
#: A foot whose ankle goes slower than this stands [m/s].
_STANDS = 0.15


@dataclass(frozen=True)
class Crossing:
    """Figures of a walk over a mat.

    Args:
        off_path: Most that the root was off its path along the ground [m].
        end: The same at the end [m].
        tilt: Angle between the pelvis and its reference at the end [degrees].
        force: Largest sum of all contact forces [body weights].
        heavy: The longest time that it was over two body weights [s].
        sunk, raised: How far the root was below and above its reference over the mat [m].
        feet_off: Most that a foot was off its reference along the ground, beside the root [m].
        slide: Most that a foot in stance moved along the ground [m].
        clear: Least height of a swinging sole over the mat, in the upper half of its swings [m].
        unsupported: Share of the frames in which nothing holds the person up [%].
    """

    off_path: float
    end: float
    tilt: float
    force: float
    heavy: float
    sunk: float
    raised: float
    feet_off: float
    slide: float
    clear: float
    unsupported: float


def mat(material: str | hp.Soft | None, thickness: float) -> hp.Scene:
    """A mat of a thickness [m] that lies on a floor; None: a hard one."""
    soft = hp.Soft.named(material, thickness=thickness) if isinstance(material, str) else material
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    high = _HEIGHTS * thickness
    place = (0.5 * (BEGINS + ENDS), 0.0, thickness - 0.5 * high)
    scene.add_static("mat", hp.Box((ENDS - BEGINS, WIDE, high)), position=place, soft=soft)
    return scene


def crossed(
    body: hp.Body,
    material: str | hp.Soft | None,
    thickness: float,
    fps: float = 30.0,
    substeps: int | None = None,
) -> hp.Result:
    """A walk on the floor's height whose path leads over a mat."""
    motion = walk(body, Walk(distance=PATH, speed=_SPEED), fps)
    settings = hp.Settings(substeps=substeps)
    return hp.simulate(motion, mat(material, thickness), body=body, settings=settings)


def stood(
    body: hp.Body, material: str, thickness: float, fps: float, substeps: int, seconds: float = 2.5
) -> hp.Result:
    """Somebody who stands on the unloaded surface of a mat, in balance."""
    motion = standing(body, frames=round(seconds * fps) + 1, fps=fps)
    middle = np.array([0.5 * (BEGINS + ENDS), 0.0, 0.0])
    motion = raised(motion.with_frames(motion.translation + middle, motion.rotations), thickness)
    settings = hp.Settings(substeps=substeps)
    return hp.simulate(motion, mat(material, thickness), body=body, settings=settings)


def forces(result: hp.Result) -> np.ndarray:
    """Sum of all contact forces on the person (T, 3) [body weights]."""
    contacts = result.contacts
    total = np.zeros((len(result), 3))
    np.add.at(total, contacts.frame, contacts.impulse * result.fps)
    return total / (9.81 * result.people[0].body.mass)


def soles(result: hp.Result, motion: hp.Motion | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Middle along the ground (T, 2, 2) and lowest point (T, 2) of the left and right foot [m]."""
    body = result.people[0].body
    skin = body.vertices(result.motion if motion is None else motion)
    part = body.weights.argmax(axis=1)
    middle, low = [], []
    for side in ("left", "right"):
        foot = np.isin(part, [JOINT_INDEX[f"{side}_ankle"], JOINT_INDEX[f"{side}_foot"]])
        middle.append(skin[:, foot, :2].mean(axis=1))
        low.append(skin[:, foot, 2].min(axis=1))
    return np.stack(middle, axis=1), np.stack(low, axis=1)


def crossing(result: hp.Result, thickness: float) -> Crossing:
    """The figures of a walk over a mat of a thickness [m]."""
    off = result.motion.translation - result.reference.translation
    along = np.linalg.norm(off[:, :2], axis=1)
    turns = [rot.exp(np.asarray(m.rotations[-1, 0])) for m in (result.motion, result.reference)]
    up = [rot.rotate(q, np.array([0.0, 1.0, 0.0])) for q in turns]
    force = np.linalg.norm(forces(result), axis=1)
    middle, low = soles(result)
    asked, asked_low = soles(result, result.reference)
    over = (middle[:, :, 0] > BEGINS + 0.2) & (middle[:, :, 0] < ENDS - 0.2)
    speed = np.linalg.norm(np.gradient(asked, axis=0), axis=2) * result.fps
    stands = speed < _STANDS
    moved = np.linalg.norm(np.gradient(middle, axis=0), axis=2)
    on = over.any(axis=1)
    # Where the motion has a swinging sole highest.
    top = over & ~stands & (asked_low > 0.5 * asked_low.max())
    return Crossing(
        off_path=along.max(),
        end=along[-1],
        tilt=float(np.degrees(np.arccos(min(1.0, float(up[0] @ up[1]))))),
        force=force.max(),
        heavy=_longest(force > 2.0) / result.fps,
        sunk=-off[on, 2].min(),
        raised=off[on, 2].max(),
        feet_off=np.linalg.norm(middle - asked - off[:, None, :2], axis=2)[over].max(),
        slide=moved[over & stands].max(),
        clear=(low[top] - thickness).min(),
        unsupported=result.people[0].support.unsupported_percent,
    )


def _longest(flags: np.ndarray) -> int:
    """Length of the longest run of True."""
    longest = run = 0
    for flag in flags:
        run = run + 1 if flag else 0
        longest = max(longest, run)
    return longest
