"""Scenario: a kick at a ball."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from halfphysics.errors import InputError
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.scenarios.acting.gait import pose_at, walk
from halfphysics.scenarios.acting.walk_plan import Kick, Walk
from halfphysics.scenarios.props import stage
from halfphysics.simulation.sequence import Sequence

if TYPE_CHECKING:
    from halfphysics.body.body import Body

#: Speeds of the foot that the kick is authored for [m/s].
SPEEDS = (0.5, 15.0)
# Half of the time over which the speed of the foot is taken [s].
_AROUND = 1e-3


def build(
    *,
    fps: float = 30.0,
    mass: float = 0.43,
    friction: float = 0.6,
    speed: float | None = None,
    radius: float = stage.BALL_RADIUS,
    fixed: bool = False,
    body: Body | None = None,
) -> Sequence:
    """A person takes a run of four steps and kicks a ball that lies on the floor.

    Args:
        fps: Frames per second.
        mass: Of the ball [kg].
        friction: Of the ball.
        speed: Of the foot as it meets the ball [m/s]; None: of an easy kick, about 5.5.
        radius: Of the ball [m].
        fixed: The ball is part of the floor: the foot can only bend past it.
        body: The person's body; None: the default body.
    """
    actor = stage.actor(body)
    plan = Walk(distance=4.0, speed=1.3, kick=Kick(step=4), after=1.0)
    if speed is not None:
        plan = _at_speed(actor, plan, speed)
    motion = walk(actor, plan, fps)
    scene = stage.floor()
    stage.add_ball(scene, actor, plan, mass, friction, radius=radius, fixed=fixed)
    return Sequence(motion, scene, actor)


def foot_speed(body: Body, plan: Walk) -> float:
    """Of the kicking foot's toe joint at the moment of impact [m/s]."""
    side = plan.swinging(plan.kick.step) if plan.kick else "right"
    time = stage.impact_time(plan)
    toe = JOINT_INDEX[f"{side}_foot"]
    before, after = (
        np.asarray(body.joints(pose_at(body, plan, t)))[toe]
        for t in (time - _AROUND, time + _AROUND)
    )
    return float(np.linalg.norm(after - before) / (2.0 * _AROUND))


def _at_speed(body: Body, plan: Walk, speed: float) -> Walk:
    """The same kick faster or slower: what the foot does is a function of the phase alone."""
    low, high = SPEEDS
    if not low <= speed <= high:
        raise InputError(f"speed: found {speed!r}, expected {low} to {high} m/s of the foot")
    kick = plan.kick or Kick(step=4)
    pace = (1.0 + kick.slow) * foot_speed(body, plan) / speed
    return replace(plan, kick=replace(kick, slow=pace - 1.0))
