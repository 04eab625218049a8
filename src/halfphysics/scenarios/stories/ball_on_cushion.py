"""Scenario: a ball that is dropped on a cushion."""

from __future__ import annotations

from typing import TYPE_CHECKING

from halfphysics.base.validation import number
from halfphysics.geometry.shapes import Box, Sphere
from halfphysics.scenarios.acting.acting import Act
from halfphysics.scenarios.props import stage
from halfphysics.scenarios.props.furniture import CLOTH
from halfphysics.simulation.sequence import Sequence

if TYPE_CHECKING:
    from halfphysics.body.body import Body

# Where the ball is let go, ahead of the person, the thickness of the cushion and its sides [m].
_AHEAD, _THICK, _SIDE = 0.50, 0.20, 0.60
# From a wrist to the palm's skin, along the fingers to its middle, and between palm and ball [m].
_PALM, _HAND, _OPEN = 0.022, 0.085, 0.012


def build(
    *,
    fps: float = 30.0,
    mass: float = 3.0,
    radius: float = 0.11,
    height: float = 1.0,
    soft: str | None = "sofa",
    body: Body | None = None,
) -> Sequence:
    """A person lets a ball go, which falls on a cushion and comes to rest in it.

    Args:
        fps: Frames per second.
        mass: Of the ball [kg].
        radius: Of the ball [m].
        height: Of the ball's centre over the floor at first [m].
        soft: Material of the cushion (`hp.Soft.named`); None: it is hard.
        body: The person's body; None: the default body, whose arms the ball is placed for.
    """
    radius = number(radius, "radius", least=0.05, most=0.15, unit="m")
    height = number(height, "height", least=0.75, most=1.2, unit="m")
    actor = stage.actor(body)
    scene = stage.floor()
    scene.add_static(
        "cushion",
        Box((_SIDE, _SIDE, _THICK)),
        position=(_AHEAD, 0.0, 0.5 * _THICK),
        friction=CLOTH,
        soft=soft,
    )
    scene.add_object("ball", Sphere(radius), mass=mass, position=(_AHEAD, 0.0, height))
    act = Act(actor)
    wide = radius + _PALM + _OPEN
    at = (_AHEAD - _HAND, wide, height)
    act.begin(
        curl=14.0,
        elbows=(-0.5, 0.8, -0.5),
        turn=(0.0, 4.0, 0.0),
        nod=24.0,
        **act.both(hold=1.0, hand=at, palm=(0.0, 1.0, 0.0), fingers=(1.0, 0.0, -0.4)),
    )
    act.move(0.0, 0.5, **act.both(hand=(at[0], wide + 0.09, height + 0.02)))
    act.move(0.9, 1.0, **act.both(hold=0.0))
    return Sequence(act.motion(3.0, fps), scene, actor)
