"""Scenario: flying while holding a ball."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from halfphysics.base.validation import number
from halfphysics.geometry.shapes import Cylinder, Sphere
from halfphysics.scenarios.acting.acting import Act
from halfphysics.scenarios.props import stage
from halfphysics.settings import Settings
from halfphysics.simulation.sequence import Sequence

if TYPE_CHECKING:
    from halfphysics.body.body import Body

# The ball [m]: radius, where it lies on its stand.
_RADIUS, _AHEAD, _HEIGHT = 0.12, 0.46, 1.14
# From a wrist to the palm's skin and along the fingers to its middle [m].
_PALM, _HAND = 0.022, 0.085
# Between each palm and the ball while open [m]; how far into it they press.
_OPEN = 0.03


def build(
    *,
    fps: float = 30.0,
    mass: float = 0.5,
    friction: float = 0.8,
    squeeze: float = 0.02,
    body: Body | None = None,
) -> Sequence:
    """A person takes a ball between the palms and flies off with it, held by friction alone.

    Args:
        fps: Frames per second.
        mass: Of the ball [kg].
        friction: Of the ball.
        squeeze: How far into the ball each palm goes [m]: 0 to 0.08.
        body: The person's body; None: the default body, for which the ball is placed.
    """
    squeeze = number(squeeze, "squeeze", least=0.0, most=0.08, unit="m")
    actor = stage.actor(body)
    scene = stage.floor()
    under = _HEIGHT - _RADIUS - 0.001
    scene.add_static("stand", Cylinder(0.06, under), position=(_AHEAD, 0.0, 0.5 * under))
    scene.add_object(
        "ball", Sphere(_RADIUS), mass=mass, friction=friction, position=(_AHEAD, 0.0, _HEIGHT)
    )

    act = Act(actor)
    wide = _RADIUS + _PALM + _OPEN
    wrist = (_AHEAD - _HAND, wide, _HEIGHT)
    act.begin(
        curl=28.0,  # fingers around it: between flat palms it would swing
        elbows=(-0.5, 0.8, -0.5),
        **act.both(hold=1.0, hand=wrist, palm=(0.0, 1.0, 0.0), fingers=(1.0, 0.0, 0.0)),
    )
    wide = _RADIUS + _PALM - squeeze
    act.move(0.2, 0.6, **act.both(hand=(wrist[0], wide, _HEIGHT)))
    # Up, over the stand, then ahead, prone, the ball before the head; feet trail behind.
    up = act["pelvis"] + np.array([0.15, 0.0, 0.85])
    act.move(1.0, 1.4, pelvis=up, turn=(0.0, 15.0, 0.0))
    act.move(1.0, 1.4, **act.both(hand=(wrist[0] + 0.15, wide, _HEIGHT + 0.95)))
    act.move(1.0, 1.4, **act.both(foot=(-0.15, 0.11, 1.15), toes=(6.0, -70.0, 0.0)))
    far = up + np.array([2.4, 0.0, 0.15])
    act.move(2.2, 2.4, pelvis=far, turn=(0.0, 72.0, 0.0), nod=-30.0)
    act.move(2.2, 2.4, **act.both(hand=(far[0] + 0.82, wide, far[2] + 0.17)))
    act.move(
        2.2, 2.4, **act.both(foot=(far[0] - 0.78, 0.10, far[2] - 0.25), toes=(4.0, -125.0, 0.0))
    )
    return Sequence(act.motion(4.8, fps), scene, actor, settings=Settings(weight=False))  # it flies
