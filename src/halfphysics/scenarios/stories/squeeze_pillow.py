"""Scenario: a pillow squeezed between two flat palms, lifted and carried."""

from __future__ import annotations

from typing import TYPE_CHECKING

from halfphysics.base.validation import number
from halfphysics.scenarios.props import stage
from halfphysics.scenarios.stories.lift_suitcase import Carried, carried
from halfphysics.simulation.sequence import Sequence

if TYPE_CHECKING:
    from halfphysics.body.body import Body


#: A pillow of 36 by 50 cm [m]: along the walk, between the palms, upright.
SIZE = (0.36, 0.20, 0.50)


def build(
    *,
    fps: float = 30.0,
    mass: float = 1.0,
    squeeze: float = 0.05,
    soft: str | None = "pillow",
    carry: float = 1.5,
    body: Body | None = None,
) -> Sequence:
    """A person squeezes a pillow between both flat palms, lifts and carries it.

    Args:
        fps: Frames per second.
        mass: Of the pillow [kg].
        squeeze: How far inside its sides the palms want to be [m].
        soft: Its material (`hp.Soft.named`); None: it is hard.
        carry: How long it is walked about with [s].
        body: The person's body; None: the default body, which stool and pillow are sized for.
    """
    squeeze = number(squeeze, "squeeze", least=0.0, most=0.1, unit="m")
    carry = number(carry, "carry", least=1.0, most=60.0, unit="s")
    thing = Carried("pillow", mass, 0.8, soft, SIZE)
    return carried(thing, fps, squeeze, (carry, 0.0), stage.actor(body))
