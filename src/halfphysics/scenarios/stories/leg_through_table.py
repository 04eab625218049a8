"""Scenario: a walk along a coffee table, one leg through its top."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from halfphysics.geometry.shapes import Box
from halfphysics.scenarios.acting.gait import walk
from halfphysics.scenarios.acting.walk_plan import Walk
from halfphysics.scenarios.props import stage
from halfphysics.simulation.sequence import Sequence

if TYPE_CHECKING:
    from halfphysics.body.body import Body

# The coffee table [m]: how long, wide and thick its top is, and how high.
_TOP, _HEIGHT, _LEG = (1.0, 0.6, 0.12), 0.44, 0.05
# Where the right corner at its far end is, and how its long edge is turned [rad].
_CORNER, _ANGLE = (2.35, 0.075), np.radians(-8.0)


def build(*, fps: float = 30.0, body: Body | None = None) -> Sequence:
    """A person walks along a coffee table so near that the left leg goes through its top.

    Args:
        fps: Frames per second.
        body: The person's body; None: the default body, for which the table is placed.
    """
    actor = stage.actor(body)
    scene = stage.floor()
    along = np.array([np.cos(_ANGLE), np.sin(_ANGLE)])
    left = np.array([-along[1], along[0]])
    turn = (np.cos(0.5 * _ANGLE), 0.0, 0.0, np.sin(0.5 * _ANGLE))
    length, width, thick = _TOP
    middle = np.array(_CORNER) - 0.5 * length * along + 0.5 * width * left

    def put(name: str, size: tuple[float, float, float], at: np.ndarray, z: float) -> None:
        scene.add_static(name, Box(size), position=(*at, z), quaternion=turn, friction=stage.WOOD)

    put("table", _TOP, middle, _HEIGHT - 0.5 * thick)
    for name, a, b in (
        ("near_right", -1, -1),
        ("near_left", -1, 1),
        ("far_right", 1, -1),
        ("far_left", 1, 1),
    ):
        at = middle + a * (0.5 * length - 0.1) * along + b * (0.5 * width - 0.18) * left
        under = _HEIGHT - thick
        put(f"table_leg_{name}", (_LEG, _LEG, under), at, 0.5 * under)
    return Sequence(walk(actor, Walk(distance=3.0, speed=0.9), fps), scene, actor)
