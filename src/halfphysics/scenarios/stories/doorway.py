"""Scenario: through a narrow doorway, past a table, a kick at a ball (the demo's story)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from halfphysics.base.validation import number
from halfphysics.geometry.shapes import Box, Cylinder
from halfphysics.scenarios.acting.gait import walk
from halfphysics.scenarios.acting.walk_plan import Kick, Walk
from halfphysics.scenarios.props import stage
from halfphysics.scene.scene import Scene
from halfphysics.simulation.sequence import Sequence

if TYPE_CHECKING:
    from halfphysics.body.body import Body

# The wall the doorway is in [m]: where along the walk, how thick and how high.
_WALL_X, _WALL, _WALL_HEIGHT = 2.0, 0.12, 2.4
_DOOR_HEIGHT = 2.05
# The opening runs from the right jamb, which is in the way of the right arm, to the left one.
_RIGHT_JAMB, _LEFT_JAMB = -0.235, 0.60
_ROOM = 1.1
# The table top [m]: its right edge runs into the path at an angle, so that it pushes aside.
_TOP, _TOP_HEIGHT, _LEG = (1.1, 0.7, 0.04), 0.74, 0.06
_EDGE_END = (4.1, 0.18)
_EDGE_ANGLE = np.radians(-8.0)


def build(
    *,
    fps: float = 30.0,
    mass: float = 0.43,
    friction: float = 0.6,
    right_jamb: float = _RIGHT_JAMB,
    body: Body | None = None,
) -> Sequence:
    """A person walks through a doorway too narrow on one side, bumps a table and kicks a ball.

    Args:
        fps: Frames per second.
        mass: Of the ball [kg].
        friction: Of the ball.
        right_jamb: Where the opening begins, across the way [m], to the right negative: at -0.1
            half of the reference is in the wall.
        body: The person's body; None: the default body. Doorway and table are sized for the default
            body; the walk and the place of the ball follow the body given.
    """
    actor = stage.actor(body)
    plan = Walk(distance=8.0, speed=1.2, kick=Kick(step=8), after=1.0)
    motion = walk(actor, plan, fps)
    scene = stage.floor()
    _add_doorway(scene, number(right_jamb, "right_jamb", least=-0.9, most=0.0))
    _add_table(scene)
    stage.add_ball(scene, actor, plan, mass, friction)
    return Sequence(motion, scene, actor)


def _add_doorway(scene: Scene, right: float) -> None:
    """Two walls with rounded jambs and a lintel."""
    radius = 0.5 * _WALL
    for side, jamb, out in (("right", right, -1.0), ("left", _LEFT_JAMB, 1.0)):
        middle = jamb + out * radius
        scene.add_static(
            f"{side}_jamb",
            Cylinder(radius, _WALL_HEIGHT),
            position=(_WALL_X, middle, 0.5 * _WALL_HEIGHT),
            friction=stage.WOOD,
        )
        width = _ROOM - abs(middle)
        scene.add_static(
            f"{side}_wall",
            Box((_WALL, width, _WALL_HEIGHT)),
            position=(_WALL_X, middle + 0.5 * out * width, 0.5 * _WALL_HEIGHT),
            friction=stage.WOOD,
        )
    above = _WALL_HEIGHT - _DOOR_HEIGHT
    scene.add_static(
        "lintel",
        Box((_WALL, _LEFT_JAMB - right + _WALL, above)),
        position=(_WALL_X, 0.5 * (_LEFT_JAMB + right), _WALL_HEIGHT - 0.5 * above),
        friction=stage.WOOD,
    )


def _add_table(scene: Scene) -> None:
    """A table top on four legs, its right edge ending at `_EDGE_END`."""
    along = np.array([np.cos(_EDGE_ANGLE), np.sin(_EDGE_ANGLE)])
    left = np.array([-along[1], along[0]])
    length, depth, thickness = _TOP
    middle = np.array(_EDGE_END) - 0.5 * length * along + 0.5 * depth * left
    turn = (np.cos(0.5 * _EDGE_ANGLE), 0.0, 0.0, np.sin(0.5 * _EDGE_ANGLE))
    height = _TOP_HEIGHT - thickness
    scene.add_static(
        "table",
        Box(_TOP),
        position=(*middle, _TOP_HEIGHT - 0.5 * thickness),
        quaternion=turn,
        friction=stage.WOOD,
    )
    for name, a, b in (
        ("front_right", -1, -1),
        ("front_left", -1, 1),
        ("back_right", 1, -1),
        ("back_left", 1, 1),
    ):
        inset = 0.05 + 0.5 * _LEG
        foot = middle + a * (0.5 * length - inset) * along + b * (0.5 * depth - inset) * left
        scene.add_static(
            f"table_leg_{name}",
            Box((_LEG, _LEG, height)),
            position=(*foot, 0.5 * height),
            quaternion=turn,
            friction=stage.WOOD,
        )
