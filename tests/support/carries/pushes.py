"""A foot that pushes a thing over the floor, while the person stands on the other.

The person stands before the thing, looks along +x, sets one foot against it (toes, or the sole with
the toes up) and pushes it ahead; the foot comes back, the thing stays.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass

import numpy as np

from halfphysics.motion.easing import ease
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.results.result import ObjectTrack
from halfphysics.scenarios.acting.acting import Act
from support.carries import takes
from support.carries.acting import parts_of
from support.carries.people import person
from support.carries.takes import Hold, Take
from support.carries.things import REST, Solid

FPS = 30.0
#: Time line [s]: weight goes to one foot, the other goes to the thing, pushes; after it.
SHIFT, REACH, PUSH, BACK, END = 0.8, 0.8, 1.4, 0.8, 1.2
#: All but the foot stays this far from the thing [m].
CLEAR = 0.012
#: As the foot comes it is no deeper in the thing than this [m].
DEEP = 0.003
#: Shifts of the thing against the foot [m].
NOISE = (0.010, 0.025)
#: Friction on the floor of what is pushed by a sole, high up: with more it would topple.
SLIDES = 0.35
#: Height of the ankle over that of a flat foot, and how far the toes are up [degrees], by way.
WAYS = {"toe": (0.05, 12.0), "sole": (0.12, 55.0), "far": (0.10, 48.0)}
#: Where the ankle is ahead of the other as the push begins [m], by way.
STARTS = {"toe": 0.10, "sole": 0.22, "far": 0.40}


def _legs(x, y, length, below, side=0.04):
    return tuple(
        Solid("box", (side, side, length), (i * x, j * y, below - 0.5 * length))
        for i in (-1, 1)
        for j in (-1, 1)
    )


#: What is pushed: solids and mass [kg]. A chair has bars between its legs.
PUSHED = {
    "box": ((Solid("box", (0.40, 0.44, 0.34)),), 7.0),
    "stool": ((Solid("box", (0.36, 0.36, 0.42)),), 4.0),
    "chair": (
        (
            Solid("box", (0.34, 0.40, 0.05), (0.03, 0.0, 0.0)),
            Solid("box", (0.05, 0.40, 0.42), (0.175, 0.0, 0.235)),
            *_legs(0.18, 0.18, 0.42, -0.025),
            *(Solid("box", (0.04, 0.32, 0.10), (x, 0.0, -0.325)) for x in (-0.18, 0.18)),
        ),
        5.0,
    ),
}


@dataclass(frozen=True)
class PushCase:
    """One push.

    Attributes:
        thing: A key of `PUSHED`.
        way: "toe", "sole", or "far": the sole, with a stretched leg.
        side: Of the foot.
        distance: How far it is pushed [m].
        noise: "none", "gap" (the thing ahead of the foot), "inside" or "aside".
        stature: Of the person [m].
        seed: Of the noise.
    """

    thing: str = "box"
    way: str = "toe"
    side: str = "right"
    distance: float = 0.3
    noise: str = "none"
    stature: float = 1.75
    seed: int = 0

    @property
    def id(self) -> str:
        return (
            f"push-{self.thing}-{self.way}-{self.side}-{self.distance:g}m-{self.noise}-"
            f"{self.stature:g}-{self.seed}"
        )


def push(case: PushCase) -> Take:
    """The take of a case."""
    body = person(case.stature)
    size = case.stature / 1.75
    solids, mass = PUSHED[case.thing]
    left = 1.0 if case.side == "left" else -1.0
    other = "right" if case.side == "left" else "left"
    up, toes = WAYS[case.way]
    act = Act(body)
    own, stands = act[f"{case.side}_foot"], act[f"{other}_foot"]
    hips = act.standing - 0.06 * size
    # The foot against the thing, and where it ends.
    begin = np.array([stands[0] + STARTS[case.way] * size, own[1] * 0.6, own[2] + up])
    end = begin + np.array([case.distance, 0.0, 0.0])
    first = SHIFT + REACH
    act.move(0.1, SHIFT, pelvis=(stands[0] - 0.02, 0.85 * stands[1], hips))
    act.move(SHIFT - 0.1, REACH, **{f"{case.side}_foot": begin, f"{case.side}_toes": (0, toes, 0)})
    act.move(first + 0.1, PUSH, **{f"{case.side}_foot": end},
             pelvis=(stands[0] + 0.4 * case.distance, 0.85 * stands[1], hips - 0.05))  # fmt: skip
    act.move(first + 0.1, PUSH, turn=(0.0, -6.0, 0.0))
    leaves = first + 0.2 + PUSH
    # Back first, then down.
    away = end - [0.16, 0.0, 0.0]
    act.move(leaves, 0.6, **{f"{case.side}_foot": away})
    foot = {f"{case.side}_foot": own, f"{case.side}_toes": (6.0 * left, 0.0, 0.0)}
    act.move(leaves + 0.5, BACK, **foot)
    act.move(leaves + 0.2, BACK, pelvis=(0.0, 0.0, act.standing), turn=(0.0, 0.0, 0.0))
    total = leaves + 0.5 + BACK + END
    motion = act.motion(total, FPS)
    times = np.arange(len(motion)) / FPS
    hold = round((first + 0.1) * FPS), round((leaves + 0.05) * FPS)
    # The thing is where the foot touches it, and goes with it.
    names = takes.PARTS[f"{case.side}_ankle"]
    skin = np.flatnonzero(np.isin(parts_of(body), names))
    points = body.vertices(motion, frames=[hold[0]], indices=skin)[0]
    low = min(solid.low for solid in solids)
    ankle = body.joints(motion)[:, JOINT_INDEX[f"{case.side}_ankle"]]
    at = np.array([0.0, points[:, 1].mean(), -low + REST])
    # From far ahead towards the foot until it touches.
    at[0], step = begin[0] + 1.2, 0.02
    while step > 1e-7:
        closer = at - [step, 0.0, 0.0]
        if takes.distance(solids, points - closer).min() < 0.0:
            step *= 0.5
        else:
            at = closer
    pushed = np.clip(ankle[:, 0] - ankle[hold[0], 0], 0.0, None)
    pushed[: hold[0]] = 0.0
    pushed[hold[1] :] = pushed[hold[1]]
    others = [n for n in set(parts_of(body)) if n not in names]
    skin = np.flatnonzero(np.isin(parts_of(body), others))
    where = at + pushed[:, None] * [1.0, 0.0, 0.0]
    gap = takes.distance(solids, body.vertices(motion, indices=skin) - where[:, None]).min()
    if gap < CLEAR:
        raise ValueError(f"{case.id}: the body {1000 * gap:.0f} mm from the thing")
    skin = np.flatnonzero(np.isin(parts_of(body), names))
    frames = slice(0, hold[0])
    gap = takes.distance(
        solids, body.vertices(motion[frames], indices=skin) - where[frames, None]
    ).min()
    if gap < -DEEP:
        raise ValueError(f"{case.id}: the foot comes through the thing, {-1000 * gap:.0f} mm deep")
    rng = np.random.default_rng([case.seed, zlib.crc32(case.id.encode())])
    amount = float(rng.uniform(*NOISE))
    shift = {
        "none": (0.0, 0.0, 0.0),
        "gap": (amount, 0.0, 0.0),
        "inside": (-amount, 0.0, 0.0),
        "aside": (0.0, 1.5 * amount * rng.choice([-1.0, 1.0]), 0.0),
    }[case.noise]
    position = at + np.array(shift) + pushed[:, None] * [1.0, 0.0, 0.0]
    if case.noise in ("inside", "aside"):  # a little shake of the sensor while it moves
        fade = ease((times - times[hold[0]]) / 0.4) * ease((times[hold[1]] - times) / 0.4)
        position[:, 1] += 0.3 * fade * takes.shake(rng, -amount, amount, times)
    return Take(
        id=case.id,
        kind="push",
        name=case.thing,
        solids=solids,
        mass=mass,
        bodies=(body,),
        motions=(motion,),
        track=ObjectTrack(
            position=position, quaternion=np.tile([1.0, 0.0, 0.0, 0.0], (len(times), 1))
        ),
        holds=(Hold(0, f"{case.side}_ankle", *hold),),
        frictions={(case.thing, "floor"): SLIDES} if case.way == "sole" else {},
        noise=case.noise,
    )
