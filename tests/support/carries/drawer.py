"""A drawer that is pulled out of a chest by its bar with one hand, and pushed back.

As data sets have it: the drawer is a free thing between the sides of a chest that stands still.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass

import numpy as np

from halfphysics.motion.easing import ease
from halfphysics.results.result import ObjectTrack
from halfphysics.scenarios.acting.gait import walk
from halfphysics.scenarios.acting.walk_plan import Walk
from support.carries import takes
from support.carries.acting import Way, acted, parts_of, without_gaps
from support.carries.people import person
from support.carries.recordings import is_hand
from support.carries.takes import Hold, Take, without_fingers
from support.carries.things import REST, Grasp, Solid, Thing

FPS = 30.0
#: Time line [s]: the hand comes, is near, reaches, closes; pull, rest, push; opens, leaves, after.
COME, REACH, TOUCH, CLOSE = 0.6, 0.8, 0.4, 0.3
PAUSE, PULL, REST_OUT, PUSH = 0.2, 1.4, 0.4, 1.4
AWAY, END = 0.4, 1.4
#: The drawer [m]: depth behind the front, width and height of the front, thickness of its boards.
DEEP, WIDE, HIGH, THIN = 0.40, 0.44, 0.18, 0.016
#: Its bar [m]: radius, distance before the front, half length between its posts.
BAR, OUT, HALF = 0.012, 0.062, 0.07
#: Height of the drawer's middle over the floor for a stature of 1.75 [m].
HEIGHT = 0.92
#: The hand is closed as around a bar of this radius [m]: loosely.
LOOSE = 0.025
#: How far a hand that comes is closed.
HALF_CLOSED = 0.7
#: The chest's sides leave this much [m].
PLAY = 0.002
#: Friction of its runners, and its mass [kg].
RUNS, MASS = 0.2, 3.0
NOISE, SLOW = (0.010, 0.020), 0.3
CLEAR, WRIST = 0.010, np.radians(80.0)
_AHEADS = np.arange(0.36, 0.80, 0.03)


def drawer_thing() -> Thing:
    """The drawer: its frame is at the middle of the front's outer side, x into the chest."""
    half = 0.5 * WIDE - 0.02
    solids = (
        Solid("box", (THIN, WIDE, HIGH), (0.5 * THIN, 0.0, 0.0)),
        Solid("box", (DEEP - THIN, 2.0 * half, THIN), (0.5 * (DEEP + THIN), 0.0, -0.07)),
        *(Solid("box", (DEEP - THIN, THIN, 0.12), (0.5 * (DEEP + THIN), y, -0.002))
          for y in (half - 0.5 * THIN, 0.5 * THIN - half)),
        Solid("box", (THIN, 2.0 * (half - THIN), 0.12), (DEEP - 0.5 * THIN, 0.0, -0.002)),
        Solid("cylinder", (BAR, 2.0 * HALF + 0.03), (-OUT, 0.0, 0.0), 1),
        *(Solid("box", (OUT - 0.8 * BAR, 0.014, 0.012), (-0.5 * (OUT - 0.8 * BAR), y, 0.0))
          for y in (-HALF - 0.008, HALF + 0.008)),
    )  # fmt: skip
    # From above, the fingers over the bar and down behind it.
    turns = np.radians([20.0, 35.0, 5.0, 50.0])
    grasp = Grasp(
        (-OUT, 0.0, 0.0),
        (0.25, 0.0, -0.97),
        tuple((float(np.cos(a)), 0.0, float(-np.sin(a))) for a in turns),
        (-0.10, -0.02, 0.08),
        LOOSE,
    )
    return Thing("drawer", solids, {"right": grasp})


@dataclass(frozen=True)
class DrawerCase:
    """One drawer.

    Attributes:
        distance: How far it is pulled [m].
        back: It is pushed back; else it is left open.
        noise: "none", "gap" (the bar farther away), "inside" or "aside" (across).
        fingers: Whether the fingers are recorded.
        stature: Of the person [m].
        seed: Of the noise.
    """

    distance: float = 0.25
    back: bool = True
    noise: str = "none"
    fingers: bool = True
    stature: float = 1.75
    seed: int = 0

    @property
    def id(self) -> str:
        hands, way = "fingers" if self.fingers else "flat", "back" if self.back else "open"
        return f"drawer-{way}-{self.distance:g}m-{self.noise}-{hands}-{self.stature:g}-{self.seed}"


def drawer(case: DrawerCase) -> Take:
    """The take of a case, the chest as near as is clear of the body."""
    body, thing = person(case.stature), drawer_thing()
    height = HEIGHT * case.stature / 1.75
    first = COME + REACH + TOUCH + CLOSE
    out = first + PAUSE
    back = out + PULL + REST_OUT
    last = (back + PUSH if case.back else out + PULL) + PAUSE
    times = np.arange(int(np.floor((last + CLOSE + AWAY + END) * FPS + 1e-9)) + 1) / FPS
    pulled = ease((times - out) / PULL)
    if case.back:
        pulled = pulled - ease((times - back) / PUSH)
    pulled = case.distance * pulled
    hold = int(np.ceil(first * FPS - 1e-6)), int(np.floor(last * FPS + 1e-6))
    near, touch = ease((times - COME) / REACH), ease((times - COME - REACH) / TOUCH)
    # Half closed on the way: straight fingers would pass through the front.
    shut = ease((times - first + CLOSE) / CLOSE) * (1.0 - ease((times - last) / CLOSE))
    half = near * (1.0 - ease((times - last - CLOSE - AWAY) / 0.8))
    closed = HALF_CLOSED * half + (1.0 - HALF_CLOSED) * shut
    touch = touch * (1.0 - ease((times - last - CLOSE) / AWAY))
    near = near * (1.0 - ease((times - last - CLOSE - AWAY) / 0.8))
    grasp = thing.grasps["right"]
    waits = np.array([0.0, 0.0, 0.09])
    open_ = (1.0 - near)[:, None] * np.asarray(grasp.ready) + near[:, None] * waits
    rng = np.random.default_rng([case.seed, zlib.crc32(case.id.encode())])
    low, high = NOISE
    constant = rng.uniform(low / (1.0 - SLOW), high / (1.0 + SLOW))
    amount = takes.shake(rng, constant * (1.0 - SLOW), constant * (1.0 + SLOW), times)
    way = {"none": (0, 0, 0), "gap": (-1.0, 0, 0), "inside": (1.0, 0, 0),
           "aside": (0, rng.choice([-1.0, 1.0]), 0)}[case.noise]  # fmt: skip
    offsets = {"right": (1.0 - touch)[:, None] * open_ + amount[:, None] * np.array(way, float)}
    base = walk(body, Walk(distance=0.5, before=times[-1] + 1.0), FPS)[: len(times)]
    faults = {}
    for ahead in _AHEADS:
        position = np.stack([ahead - pulled, 0.0 * pulled - 0.12, 0.0 * pulled + height], axis=1)
        frames = len(base)
        way = Way(position, np.broadcast_to(np.eye(3), (frames, 3, 3)), np.zeros(frames))
        motion = without_gaps(acted(body, base, thing, way, offsets, closed, hold, WRIST))
        if motion is None:
            faults[round(float(ahead), 2)] = "out of reach"
            continue
        names = [n for n in set(parts_of(body)) if not is_hand(n) and n != "right_elbow"]
        skin = np.flatnonzero(np.isin(parts_of(body), names))
        points = body.vertices(motion, frames=np.arange(0, len(times), 4), indices=skin)
        gap = takes.distance(thing.solids, points - position[::4, None]).min()
        if gap > CLEAR:
            break
        faults[round(float(ahead), 2)] = f"the body {1000 * gap:.0f} mm from it"
    else:
        raise ValueError(f"{case.id}: no place is right: {faults}")
    return Take(
        id=case.id,
        kind="drawer",
        name="drawer",
        solids=thing.solids,
        mass=MASS,
        bodies=(body,),
        motions=(motion if case.fingers else without_fingers(motion),),
        track=ObjectTrack(
            position=position, quaternion=np.tile([1.0, 0.0, 0.0, 0.0], (len(times), 1))
        ),
        holds=(Hold(0, "right_wrist", *hold),),
        statics=_chest(float(ahead), height),
        frictions={("drawer", name): RUNS for name in _chest(float(ahead), height)},
        noise=case.noise,
    )


def _chest(ahead, height):
    """Boxes around the drawer: a runner below, sides, a top and a back."""
    half = 0.5 * WIDE - 0.02 + PLAY
    middle, turn = ahead + THIN + PLAY + 0.5 * DEEP, (1.0, 0.0, 0.0, 0.0)
    low = height - 0.078 - REST
    return {
        "runner": ((DEEP, WIDE, 0.02), (middle, -0.12, low - 0.01), turn),
        "top": ((DEEP, WIDE, 0.02), (middle, -0.12, height + 0.058 + PLAY + 0.01), turn),
        **{
            f"side{k}": ((DEEP, 0.02, 0.14), (middle, -0.12 + y, height - 0.01), turn)
            for k, y in enumerate((half + 0.01, -half - 0.01))
        },
        "back": ((0.02, WIDE, 0.14), (middle + 0.5 * DEEP, -0.12, height - 0.01), turn),
    }
