"""Scenario: a glass is carried to a table that has been taken away, and set down there."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from halfphysics.scenarios.acting.walk_plan import Walk
from halfphysics.scenarios.props import glass, stage
from halfphysics.scenarios.props.vessels import vessel
from halfphysics.simulation.sequence import Sequence

if TYPE_CHECKING:
    from halfphysics.body.body import Body

#: How far the table is from the stand [m].
_DISTANCE = 2.0
#: Time to lower the glass, to stay there, and to watch it [s].
_LOWERING, _STAYING, _WATCHING = 1.2, 0.3, 0.8


def build(
    *,
    shape: str = "tumbler",
    mass: float = 0.3,
    friction: float = 0.8,
    fps: float = 30.0,
    table: bool = False,
    squeeze: float = 0.2,
    body: Body | None = None,
) -> Sequence:
    """A glass is carried to a table that has been taken away, set down there, and falls.

    Args:
        shape: "tumbler", a closed cylinder, or "wine", a glass with stem, foot and hollow bowl.
        mass: Of the glass [kg].
        friction: Of the glass.
        fps: Frames per second.
        table: Whether the table is there after all: then the glass stands on it.
        squeeze: How far the fingers' targets are beyond contact [rad]; a warning over 0.5.
        body: The person's body; None: the default body. Hand, arm and tables follow the body given.
    """
    return planned(
        shape=shape,
        mass=mass,
        friction=friction,
        fps=fps,
        table=table,
        squeeze=squeeze,
        body=body,
    )[0]


def planned(
    *,
    shape: str = "tumbler",
    mass: float = 0.3,
    friction: float = 0.8,
    fps: float = 30.0,
    table: bool = False,
    squeeze: float = 0.2,
    body: Body | None = None,
) -> tuple[Sequence, dict[str, tuple[float, float]]]:
    """As `build`, and when every stage begins and ends [s]: grasp, lift, walk, lower, open."""
    actor = stage.actor(body)
    held = vessel(shape)
    plan = glass.Plan()
    plan.grasp()
    plan.lift()
    begin = plan.time
    steps = Walk(distance=_DISTANCE, speed=1.0, before=begin)
    plan.then(float(steps.clock()[0][-2]) - begin)
    plan.stage("walk", begin)
    begin = plan.time
    plan.then(_LOWERING, place=np.zeros(3), yaw=float(glass.AT_STAND))
    plan.then(_STAYING)
    plan.stage("lower", begin)
    plan.open(_WATCHING)
    motion = glass.perform(actor, plan, fps, squeeze, held=held, steps=steps)
    scene = stage.floor()
    at = glass.start(actor)
    glass.add_stand(scene, "stand", at, held)
    if table:
        glass.add_stand(scene, "table", at + np.array([_DISTANCE, 0.0, 0.0]), held)
    glass.add_glass(scene, at, held, mass, friction)
    return Sequence(motion, scene, actor), plan.times
