"""A person who sits down on a chair, which then slides and turns with the person on it.

A chair of wheels (low friction on the floor): the feet walk it ahead, or turn it.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass

import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.motion.easing import ease
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.results.result import ObjectTrack
from halfphysics.scenarios.acting.acting import Act
from halfphysics.scenarios.acting.legs import about
from support.carries.acting import parts_of
from support.carries.people import person
from support.carries.takes import Hold, Take
from support.carries.things import REST, Solid

FPS = 30.0
#: Time line [s]: sits down, waits, the chair moves with the person, what is after.
SIT, WAIT, MOVE, END = 1.8, 0.6, 1.6, 1.2
#: The seat's height [m] for a stature of 1.75, its depth and width, thickness; of the back rest.
SEAT, DEEP, WIDE, THICK, REST_HIGH = 0.44, 0.42, 0.44, 0.05, 0.40
#: On wheels; the mass [kg].
ROLLS, MASS = 0.05, 9.0
NOISE = (0.010, 0.025)


@dataclass(frozen=True)
class SeatCase:
    """One ride.

    Attributes:
        distance: How far ahead the chair slides [m]; negative: back.
        turn: How far it turns to the left [degrees].
        noise: "none", "gap" (the person above the seat), "inside" (in it) or "aside".
        stature: Of the person [m].
        seed: Of the noise.
    """

    distance: float = 0.3
    turn: float = 0.0
    noise: str = "none"
    stature: float = 1.75
    seed: int = 0

    @property
    def id(self) -> str:
        return f"seat-{self.distance:g}m-{self.turn:g}deg-{self.noise}-{self.stature:g}-{self.seed}"


def seat(case: SeatCase) -> Take:
    """The take of a case."""
    body = person(case.stature)
    size = case.stature / 1.75
    high = SEAT * size
    act = Act(body)
    rng = np.random.default_rng([case.seed, zlib.crc32(case.id.encode())])
    amount = float(rng.uniform(*NOISE))
    sat = _sat(body, high) + {"gap": amount, "inside": -amount}.get(case.noise, 0.0)
    shift = np.array([0.0, amount if case.noise == "aside" else 0.0, 0.0])
    begin = SIT + WAIT
    act.move(0.2, 0.9, turn=(0.0, 40.0, 0.0), bend=(24.0, 0.0, 0.0), nod=-14.0)
    act.move(0.2, SIT - 0.3, pelvis=(-0.40 * size, 0.0, sat))
    act.move(0.2, 0.9, **act.both(arm=(0.30, 0.14, -0.30)))
    act.move(1.1, 1.0, turn=(0.0, -4.0, 0.0), bend=(4.0, 0.0, 0.0), nod=4.0)
    go = np.radians(case.turn)
    act.move(begin, MOVE, pelvis=(-0.40 * size + case.distance, 0.0, sat))
    act.move(begin, MOVE, turn=(case.turn, -4.0, 0.0))
    act.move(begin, MOVE, knees=(np.cos(go), np.sin(go), 0.0))
    # The feet step, one after the other, to where they stood before the seat.
    for k, side in enumerate(("left", "right")):
        foot = act[f"{side}_foot"]
        from_seat = foot - [-0.40 * size, 0.0, 0.0]
        to = about(2, go) @ from_seat + [-0.40 * size + case.distance, 0.0, 0.0]
        start = begin + k * 0.5 * MOVE
        act.step(side, start, 0.5 * MOVE, to)
        heading = act[f"{side}_toes"][0] + case.turn
        act.move(start, 0.5 * MOVE, **{f"{side}_toes": (heading, 0.0, 0.0)})
    motion = act.motion(begin + MOVE + END, FPS)
    times = np.arange(len(motion)) / FPS
    pelvis = body.joints(motion)[:, JOINT_INDEX["pelvis"]]
    share = ease((times - begin) / MOVE)
    turn = about(2, go * share)
    # The seat's middle below the pelvis; it rides with the pelvis.
    at = np.array([pelvis[-1, 0] - case.distance + 0.05 * size, 0.0, high - 0.5 * THICK + REST])
    ride = pelvis[round(begin * FPS), :2]
    position = np.zeros((len(times), 3))
    position[:, 2] = at[2]
    offset = np.append(at[:2] - ride, 0.0)
    centre = np.append(ride, 0.0) + share[:, None] * [case.distance, 0.0, 0.0]
    position[:, :2] = (centre + np.einsum("tij,j->ti", turn, offset))[:, :2]
    return Take(
        id=case.id,
        kind="seat",
        name="chair",
        solids=_chair(size, high),
        mass=MASS,
        bodies=(body,),
        motions=(motion,),
        track=ObjectTrack(
            position=position + shift, quaternion=rot.continuous(rot.from_matrix(turn))
        ),
        holds=(Hold(0, "pelvis", round(begin * FPS), round((begin + MOVE) * FPS)),),
        frictions={("chair", "floor"): ROLLS},
        noise=case.noise,
    )


def _sat(body, high):
    """Height of the pelvis at which a sitting person's skin is just on a seat so high [m]."""
    act = Act(body)
    act.begin(pelvis=(-0.40 * body.stature / 1.75, 0.0, 1.0), turn=(0.0, -4.0, 0.0))
    low, up = high, high + 0.4
    names = ["pelvis", "left_hip", "right_hip"]
    skin = np.flatnonzero(np.isin(parts_of(body), names))
    for _ in range(20):
        middle = 0.5 * (low + up)
        act.begin(pelvis=(-0.40 * body.stature / 1.75, 0.0, middle))
        points = body.vertices(act.motion(0.2, FPS), frames=[0], indices=skin)
        low, up = (middle, up) if points[..., 2].min() < high else (low, middle)
    return up


def _chair(size, high):
    """Seat, back rest, a column and a foot of two beams."""
    column = high - THICK - 0.04
    deep, wide = DEEP * size, WIDE * size
    return (
        Solid("box", (deep, wide, THICK)),
        Solid("box", (0.04, wide, REST_HIGH), (-0.5 * deep - 0.02, 0.0, 0.5 * (REST_HIGH - THICK))),
        Solid("box", (0.06, 0.06, column), (0.0, 0.0, -0.5 * (THICK + column))),
        Solid("box", (0.50, 0.06, 0.04), (0.0, 0.0, -0.5 * THICK - column - 0.02)),
        *(Solid("box", (0.06, 0.22, 0.04), (0.0, y, -0.5 * THICK - column - 0.02))
          for y in (-0.14, 0.14)),
    )  # fmt: skip
