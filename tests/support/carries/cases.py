"""The cases of `campaigns.holds`: things, ways to carry them, people, noise, fingers."""

from __future__ import annotations

from support.carries.recordings import Case
from support.carries.things import THINGS

#: Noise of a thing's cases, in turn; cases without fingers are every second one.
NOISES = ("gap", "aside", "inside", "none")
#: Statures [m] and arms of the people, in turn.
PEOPLE = (
    (1.75, 1.0), (1.62, 1.0), (1.88, 1.0), (1.70, 0.95), (1.80, 1.06),
    (1.55, 1.0), (1.95, 1.0), (1.72, 0.9), (1.78, 1.1),
)  # fmt: skip


def ways(thing) -> tuple[tuple[str, str], ...]:
    """How a thing can be carried: one that stands on the floor leaves the way ahead free."""
    if thing.stand == 0.0:
        return (("walk", "down"), ("turn", "down"), ("walk", "air"))
    if thing.name == "tray":  # turned, a forearm below it would pass through the stand
        return (("up", "down"), ("back", "air"), ("up", "air"))
    return (("turn", "down"), ("back", "air"), ("turn", "air"))


def all_cases() -> list[Case]:
    """Four of every thing carried by two hands, three of every other; those of two hands first."""
    cases = []
    for number, thing in enumerate(THINGS.values()):
        two = len(thing.grasps) == 2
        for k in range(4 if two else 3):
            way, ends = ways(thing)[k % 3]
            stature, arms = PEOPLE[(number + 2 * k) % len(PEOPLE)]
            cases.append(
                Case(
                    thing.name, way, ends, NOISES[(number + k) % 4], (number // 4 + k) % 2 == 0,
                    stature, arms, seed=k,
                )
            )  # fmt: skip
    return cases
