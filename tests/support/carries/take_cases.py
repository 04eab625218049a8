"""The cases of `campaigns.holds_more`: two people, feet, seats, a drawer, things put down."""

from __future__ import annotations

from support.carries.drawer import DrawerCase, drawer
from support.carries.pushes import PushCase, push
from support.carries.put_down import left
from support.carries.recordings import Case
from support.carries.seats import SeatCase, seat
from support.carries.shared_carry import LOADS, SharedCase, shared

NOISES = ("gap", "aside", "inside", "none")
#: Statures of the two people, in turn [m].
PAIRS = ((1.75, 1.75), (1.62, 1.88), (1.80, 1.66), (1.88, 1.70))
STATURES = (1.75, 1.62, 1.88, 1.70)
#: What is put down and left: what one person lifts by friction alone.
LEFT = ("suitcase", "smallbox", "bowl", "mug", "bottle")


def take_of(case):
    """The take of any case."""
    makers = {
        SharedCase: shared, PushCase: push, SeatCase: seat, DrawerCase: drawer, Case: left,
    }  # fmt: skip
    return makers[type(case)](case)


def name_of(case) -> str:
    """The id of its take."""
    return f"left-{case.id}" if isinstance(case, Case) else case.id


def all_cases() -> list:
    """All, by kind."""
    out: list = []
    for number, load in enumerate(LOADS):
        for k in range(4):
            out.append(
                SharedCase(
                    load, (0.5, 1.0, 1.5, 0.8)[(number + k) % 4], NOISES[(number + k) % 4],
                    (number + k) // 2 % 2 == 0, PAIRS[k], k,
                )
            )  # fmt: skip
    pushed = (("box", "toe"), ("box", "sole"), ("stool", "sole"), ("chair", "far"))
    for number, (thing, way) in enumerate(pushed):
        for k in range(3):
            far = (0.2, 0.3, 0.25) if way == "far" else (0.3, 0.2, 0.5)
            out.append(
                PushCase(
                    thing, way, ("right", "left")[(number + k) % 2], far[k],
                    NOISES[(number + k) % 4], STATURES[(number + k) % 4], k,
                )
            )  # fmt: skip
    rides = ((0.3, 0.0), (-0.25, 0.0), (0.0, 40.0), (0.2, -30.0), (0.4, 0.0))
    for k, (distance, turn) in enumerate(rides):
        out.append(SeatCase(distance, turn, NOISES[k % 4], STATURES[k % 4], k))
    for k in range(6):
        out.append(
            DrawerCase(
                (0.25, 0.2, 0.3)[k % 3], k % 3 != 2, NOISES[k % 4], k % 2 == 0, STATURES[k % 4], k
            )
        )
    for k, thing in enumerate(LEFT):
        out.append(Case(thing, "turn", "down", NOISES[k % 4], k % 2 == 0, STATURES[k % 4], seed=k))
    return out
