"""Daily motions made from a seed: walking, sitting down, reaching, lifting, carrying, waving.

Nothing comes from a data set; speeds, heights and sides are drawn from the seed and the number.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from halfphysics.scenarios.acting.acting import Act
from halfphysics.scenarios.acting.gait import walk
from halfphysics.scenarios.acting.walk_plan import Walk

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion

#: Number of clips, and frames per second.
CLIPS, FPS = 10, 30.0

#: Makes the motion of a body from random numbers, at a frame rate.
Maker = Callable[["Body", np.random.Generator, float], "Motion"]


def _side(rng: np.random.Generator) -> tuple[str, float]:
    """A side, and where it is along y."""
    return ("left", 1.0) if rng.random() < 0.5 else ("right", -1.0)


def _paced(slow: float, fast: float) -> Maker:
    def make(body: Body, rng: np.random.Generator, fps: float) -> Motion:
        speed = rng.uniform(slow, fast)
        first, _ = _side(rng)
        heading = rng.uniform(-np.pi, np.pi)
        return walk(
            body, Walk(distance=4.0 * speed, speed=speed, heading=heading, first=first), fps
        )

    return make


def sit(body: Body, rng: np.random.Generator, fps: float) -> Motion:
    """Sitting down at the height of a chair, looking around, getting up."""
    act, seat = Act(body), rng.uniform(0.50, 0.58)
    act.move(0.3, 1.0, turn=(0.0, 36.0, 0.0), bend=(18.0, 0.0, 0.0), nod=-15.0)
    act.move(0.3, 1.5, pelvis=(-0.42, 0.0, seat))
    act.move(0.2, 0.9, **act.both(arm=(0.36, 0.10, -0.28)))
    act.move(1.4, 1.0, turn=(0.0, -8.0, 0.0), bend=(6.0, 0.0, 0.0), nod=4.0)
    act.move(2.6, 0.8, bend=(6.0, 0.0, rng.uniform(-30.0, 30.0)))
    act.move(3.6, 0.9, turn=(0.0, 38.0, 0.0), bend=(20.0, 0.0, 0.0), nod=-12.0)
    act.move(4.0, 1.4, pelvis=(0.0, 0.0, act.standing))
    act.move(4.6, 1.2, turn=(0.0, 0.0, 0.0), bend=(0.0, 0.0, 0.0), nod=0.0)
    act.move(4.2, 1.2, **act.both(arm=(0.10, 0.12, -0.47)))
    return act.motion(6.2, fps)


def reach_up(body: Body, rng: np.random.Generator, fps: float) -> Motion:
    """A hand goes up to a high shelf and brings something down."""
    act, (side, y) = Act(body), _side(rng)
    high = (rng.uniform(0.22, 0.32), 0.08, rng.uniform(0.28, 0.40))
    act.move(0.3, 1.0, **{f"{side}_arm": high}, bend=(-6.0, 8.0 * y, 0.0), nod=-20.0)
    act.move(0.9, 0.5, curl=55.0)
    act.move(1.6, 1.1, **{f"{side}_arm": (0.40, -0.02, -0.15)}, bend=(4.0, 0.0, 0.0), nod=12.0)
    act.move(3.0, 0.9, **{f"{side}_arm": (0.10, 0.12, -0.47)}, nod=0.0, curl=18.0)
    return act.motion(4.4, fps)


def squat(body: Body, rng: np.random.Generator, fps: float) -> Motion:
    """Down to the floor with both hands, something lifted from it to the waist."""
    act, low = Act(body), rng.uniform(0.48, 0.56)
    act.begin(**act.both(toes=(18.0, 0.0, 0.0)))
    act.move(0.3, 1.2, pelvis=(-0.20, 0.0, low), turn=(0.0, 36.0, 0.0), bend=(30.0, 0.0, 0.0))
    act.move(0.3, 1.2, **act.both(arm=(0.42, 0.05, -0.26)), nod=-25.0)
    act.move(1.5, 0.4, curl=50.0)
    act.move(2.0, 1.4, pelvis=(0.0, 0.0, act.standing), turn=(0.0, 0.0, 0.0), bend=(0.0, 0.0, 0.0))
    act.move(2.0, 1.4, **act.both(arm=(0.34, 0.04, -0.22)), nod=8.0)
    act.move(4.0, 0.9, **act.both(arm=(0.10, 0.12, -0.47)), nod=0.0, curl=18.0)
    return act.motion(5.2, fps)


def wave(body: Body, rng: np.random.Generator, fps: float) -> Motion:
    """One hand is raised and waves."""
    act, (side, y) = Act(body), _side(rng)
    act.move(0.3, 0.8, **{f"{side}_arm": (0.20, 0.26, 0.30)}, bend=(0.0, 4.0 * y, 0.0), curl=5.0)
    half = rng.uniform(0.22, 0.32)
    for k in range(8):
        out = 0.38 if k % 2 == 0 else 0.12
        act.move(1.1 + k * half, half, **{f"{side}_arm": (0.20, out, 0.30)})
    end = 1.2 + 8 * half
    act.move(end, 0.8, **{f"{side}_arm": (0.10, 0.12, -0.47)}, bend=(0.0, 0.0, 0.0), curl=18.0)
    return act.motion(end + 1.1, fps)


def carry(body: Body, rng: np.random.Generator, fps: float) -> Motion:
    """Small steps forward with a tray in both hands."""
    act, stride = Act(body), rng.uniform(0.24, 0.34)
    act.move(0.0, 0.8, **act.both(arm=(0.36, 0.06, -0.20)), nod=10.0, curl=45.0)
    at, lasts = 0.6, rng.uniform(0.55, 0.7)
    for k in range(6):
        side, y = ("left", 1.0) if k % 2 == 0 else ("right", -1.0)
        x, _, z = act["pelvis"]
        foot = act[f"{side}_foot"]
        act.step(side, at, 0.8 * lasts, (x + 0.5 * stride, *foot[1:]))
        act.move(at, lasts, pelvis=(x + 0.5 * stride, -0.025 * y, z))
        at += lasts
    x, _, z = act["pelvis"]
    act.step("left", at, lasts, (x, *act["left_foot"][1:]))
    act.move(at, lasts, pelvis=(x, 0.0, z))
    return act.motion(at + lasts + 0.4, fps)


def bow(body: Body, rng: np.random.Generator, fps: float) -> Motion:
    """Bending down to the shoes with straight legs, and up with a look around."""
    act, deep = Act(body), rng.uniform(50.0, 68.0)
    act.move(0.3, 1.2, turn=(0.0, 0.55 * deep, 0.0), bend=(0.8 * deep, 0.0, 0.0), nod=15.0)
    act.move(0.3, 1.2, pelvis=(-0.10, 0.0, act.standing - 0.05))
    act.move(0.4, 1.1, **act.both(arm=(0.46, 0.0, -0.20)), curl=40.0)
    act.move(2.0, 1.2, turn=(0.0, 0.0, 0.0), bend=(0.0, 0.0, 0.0), nod=0.0)
    act.move(2.0, 1.2, pelvis=(0.0, 0.0, act.standing))
    act.move(2.0, 1.2, **act.both(arm=(0.10, 0.12, -0.47)), curl=18.0)
    act.move(3.3, 0.7, bend=(0.0, 0.0, rng.uniform(20.0, 40.0)))
    act.move(4.2, 0.9, bend=(0.0, 0.0, rng.uniform(-40.0, -20.0)))
    return act.motion(5.3, fps)


def tidy(body: Body, rng: np.random.Generator, fps: float) -> Motion:
    """Both hands sort things on a table, from one side to the other."""
    act = Act(body)
    act.move(0.1, 0.8, bend=(18.0, 0.0, 0.0), nod=15.0, **act.both(arm=(0.40, 0.05, -0.22)))
    at = 0.9
    for _ in range(5):
        side, _ = _side(rng)
        there = (rng.uniform(0.30, 0.48), rng.uniform(-0.15, 0.30), rng.uniform(-0.30, -0.05))
        lasts = rng.uniform(0.5, 0.8)
        act.move(at, lasts, **{f"{side}_arm": there}, curl=rng.uniform(15.0, 55.0))
        act.move(at, lasts, bend=(18.0, rng.uniform(-8.0, 8.0), rng.uniform(-25.0, 25.0)))
        at += 0.85 * lasts
    act.move(at + 0.2, 0.9, bend=(0.0, 0.0, 0.0), nod=0.0, **act.both(arm=(0.10, 0.12, -0.47)))
    return act.motion(at + 1.4, fps)


def kneel(body: Body, rng: np.random.Generator, fps: float) -> Motion:
    """Down onto one knee, leaning forward, and up again."""
    act, (side, _) = Act(body), _side(rng)
    other = "right" if side == "left" else "left"
    back = act[f"{side}_foot"] + np.array([-0.42, 0.0, 0.12])
    act.step(other, 0.2, 0.7, act[f"{other}_foot"] + np.array([0.22, 0.0, 0.0]))
    act.step(side, 0.6, 0.9, back)
    act.move(0.6, 0.9, **{f"{side}_toes": (act[f"{side}_toes"][0], -62.0, 45.0)})
    act.move(0.5, 1.5, pelvis=(-0.04, 0.0, rng.uniform(0.50, 0.54)), bend=(10.0, 0.0, 0.0))
    act.move(2.0, 0.9, bend=(42.0, 0.0, 0.0), nod=-10.0, **act.both(arm=(0.44, 0.04, -0.2)))
    act.move(3.2, 0.9, bend=(4.0, 0.0, 0.0), nod=0.0, **act.both(arm=(0.10, 0.12, -0.47)))
    act.move(3.6, 1.4, pelvis=(0.0, 0.0, act.standing), bend=(0.0, 0.0, 0.0))
    act.step(side, 3.9, 0.9, back + np.array([0.42, 0.0, -0.12]))
    act.move(3.9, 0.9, **{f"{side}_toes": (act[f"{side}_toes"][0], 0.0, 0.0)})
    act.step(other, 4.7, 0.7, act[f"{other}_foot"] - np.array([0.22, 0.0, 0.0]))
    return act.motion(5.8, fps)


#: What the clips do, in their order.
KINDS: dict[str, Maker] = {
    "walk": _paced(0.9, 1.2),
    "sit": sit,
    "reach up": reach_up,
    "squat and lift": squat,
    "wave": wave,
    "carry": carry,
    "bend down": bow,
    "sort things": tidy,
    "kneel": kneel,
    "hurry": _paced(1.5, 1.9),
}


def daily(
    number: int,
    *,
    seed: int = 0,
    seconds: float | None = None,
    fps: float = FPS,
    body: Body | None = None,
) -> Motion:
    """Daily clip `number` of a seed, on a floor at z = 0.

    Args:
        number: Number of the clip, from 0; kinds come in turn.
        seed: Seed of all clips.
        seconds: Duration from the beginning [s]; None: the whole clip.
        fps: Frames per second.
        body: The body that moves; None: the default body.
    """
    if body is None:
        from halfphysics.body.body import Body

        body = Body.default()
    make = tuple(KINDS.values())[number % len(KINDS)]
    motion = make(body, np.random.default_rng([seed, number]), fps)
    return motion if seconds is None else motion[: max(2, round(seconds * fps))]
