"""Scenario: a kick at a ball."""

from __future__ import annotations

from typing import TYPE_CHECKING

from halfphysics.scenarios import stage
from halfphysics.scenarios.gait import Kick, Walk, walk
from halfphysics.sequence import Sequence

if TYPE_CHECKING:
    from halfphysics.body import Body


def build(
    *,
    fps: float = 30.0,
    mass: float = 0.43,
    friction: float = 0.6,
    body: Body | None = None,
) -> Sequence:
    """A person takes a run of four steps and kicks a ball that lies on the floor.

    Args:
        fps: Frames per second.
        mass: Of the ball [kg].
        friction: Of the ball.
        body: Who kicks; None: the default body.
    """
    actor = stage.actor(body)
    plan = Walk(distance=4.0, speed=1.3, kick=Kick(step=4), after=1.0)
    motion = walk(actor, plan, fps)
    scene = stage.floor()
    stage.add_ball(scene, actor, plan, mass, friction)
    return Sequence(motion, scene, actor)
