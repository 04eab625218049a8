"""Scenario: a walk into a thin wall."""

from __future__ import annotations

from typing import TYPE_CHECKING

from halfphysics.geometry.shapes import Box
from halfphysics.scenarios.acting.gait import walk
from halfphysics.scenarios.acting.walk_plan import Walk
from halfphysics.scenarios.props import stage
from halfphysics.simulation.sequence import Sequence

if TYPE_CHECKING:
    from halfphysics.body.body import Body


def build(
    *,
    fps: float = 30.0,
    speed: float = 1.5,
    thickness: float = 0.01,
    body: Body | None = None,
) -> Sequence:
    """A person walks straight into a thin wall, which the motion alone would walk through.

    Args:
        fps: Frames per second.
        speed: Of the walk [m/s].
        thickness: Of the wall [m].
        body: The person's body; None: the default body.
    """
    actor = stage.actor(body)
    plan = Walk(distance=4.0, speed=speed)
    scene = stage.floor()
    scene.add_static("wall", Box((thickness, 3.0, 2.4)), position=(2.0, 0.0, 1.2))
    return Sequence(walk(actor, plan, fps), scene, actor)
