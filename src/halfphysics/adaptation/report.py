"""What hands, feet and seats that were to hold a thing did: forces reached, what friction left."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from halfphysics.adaptation.parts import joints_of
from halfphysics.scene.material_pairs import PERSON

if TYPE_CHECKING:
    from halfphysics.adaptation.adapt import Adaptation, AdaptedHold
    from halfphysics.results.result import Result


@dataclass(frozen=True)
class HeldReport:
    """One part of one hold, after the simulation.

    Attributes:
        object: Name of the thing.
        part: The joint that stands for it: a wrist for hand and fingers, an ankle for a foot, the
            pelvis for the seat.
        start, end: When it was to hold [s].
        asked: The force that it was to press with [N].
        reached: The sum of its normal forces, the median over the hold [N].
        margin: Largest friction that its contacts could bear over what they bore, the median; above
            1: nothing slips, 0: it did not touch.
        touched: Share of the frames in which it touched the thing.
    """

    object: str
    part: str
    start: float
    end: float
    asked: float
    reached: float
    margin: float
    touched: float


def held(result: Result, adaptation: Adaptation, person: int = 0) -> list[HeldReport]:
    """What became of every hold of an adapted motion, one entry a hand, foot or seat.

    Args:
        result: The simulation of `adaptation.motion`.
        adaptation: What `adapt` returned.
        person: Whose motion it is.
    """
    return [_one(result, hold, part, person) for hold in adaptation.holds for part in hold.parts]


def _one(result: Result, hold: AdaptedHold, part: str, person: int) -> HeldReport:
    c = result.contacts
    thing = result.names.index(hold.object)
    own = (c.person == person) & np.isin(c.part, joints_of(part))
    own &= (c.other == thing) & (c.frame >= hold.first) & (c.frame <= hold.last)
    impulse, normal = c.impulse[own], c.normal[own]
    along = np.einsum("ij,ij->i", impulse, normal)
    across = np.linalg.norm(impulse - np.einsum("i,ij->ij", along, normal), axis=1)
    frames = hold.last - hold.first + 1
    at = c.frame[own] - hold.first
    presses = np.bincount(at, along, minlength=frames) * result.fps
    rubs = np.bincount(at, across, minlength=frames) * result.fps
    friction = result.scene.friction_of(PERSON, hold.object)
    touched = presses > 0.0
    margin = friction * presses[touched] / np.maximum(rubs[touched], 1e-9)
    return HeldReport(
        object=hold.object,
        part=part,
        start=hold.first / result.fps,
        end=hold.last / result.fps,
        asked=hold.force,
        reached=float(np.median(presses)),
        margin=float(np.median(margin)) if touched.any() else 0.0,
        touched=float(touched.mean()),
    )
