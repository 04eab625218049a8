"""Scenario: one hand grasps a glass, lifts it, shakes it, carries it, turns it over and lets go."""

from __future__ import annotations

from collections.abc import Sequence as Many
from typing import TYPE_CHECKING

import numpy as np

from halfphysics.base.validation import number
from halfphysics.errors import InputError
from halfphysics.scenarios.acting.walk_plan import Walk
from halfphysics.scenarios.props import glass, stage
from halfphysics.scenarios.props.vessels import vessel
from halfphysics.simulation.sequence import Sequence

if TYPE_CHECKING:
    from halfphysics.body.body import Body

#: What can be asked for, in the order in which it happens.
STAGES = ("lift", "shake", "walk", "turn", "open")
#: How long stages take, and how long the glass stays upside down [s].
_SHAKING, _TURNING, _OVER, _FALLING = 4.0, 1.5, 0.7, 0.6


def build(
    *,
    shape: str = "tumbler",
    mass: float = 0.3,
    friction: float = 0.8,
    fps: float = 30.0,
    stages: Many[str] = STAGES,
    hold: float = 1.0,
    squeeze: float = 0.2,
    body: Body | None = None,
) -> Sequence:
    """One hand grasps a glass, lifts it, shakes it, carries it, turns it over and lets go.

    Args:
        shape: "tumbler", a closed cylinder, or "wine", a glass with stem, foot and hollow bowl.
        mass: Of the glass [kg].
        friction: Of the glass.
        fps: Frames per second.
        stages: Which of "lift", "shake", "walk", "turn" and "open" happen, after the grasp and
            in this order.
        hold: How long the glass is held still after the lift [s]: at most 60.
        squeeze: How far the fingers' targets are beyond contact [rad]; a warning over 0.5.
        body: The person's body; None: the default body. Hand, arm and table follow the body given.
    """
    return planned(
        shape=shape,
        mass=mass,
        friction=friction,
        fps=fps,
        stages=stages,
        hold=hold,
        squeeze=squeeze,
        body=body,
    )[0]


def planned(
    *,
    shape: str = "tumbler",
    mass: float = 0.3,
    friction: float = 0.8,
    fps: float = 30.0,
    stages: Many[str] = STAGES,
    hold: float = 1.0,
    squeeze: float = 0.2,
    body: Body | None = None,
) -> tuple[Sequence, dict[str, tuple[float, float]]]:
    """As `build`, and when every stage begins and ends [s]; "grasp" and "hold" are stages too."""
    for name in stages:
        if isinstance(stages, str) or name not in STAGES:
            found = stages if isinstance(stages, str) else name
            raise InputError(f"stages: found {found!r}, expected some of {', '.join(STAGES)}")
    hold = number(hold, "hold", least=0.0, most=60.0, unit="s")
    actor = stage.actor(body)
    held = vessel(shape)
    plan, steps, shake = _plan(stages, hold)
    motion = glass.perform(actor, plan, fps, squeeze, held=held, steps=steps, shake=shake)
    scene = stage.floor()
    at = glass.start(actor)
    glass.add_stand(scene, "stand", at, held)
    glass.add_glass(scene, at, held, mass, friction)
    return Sequence(motion, scene, actor), plan.times


def _plan(stages: Many[str], hold: float) -> tuple[glass.Plan, Walk | None, glass.Shake | None]:
    """The stages one after the other, the walk and the shake, where they are among them."""
    plan = glass.Plan()
    plan.grasp()
    if "lift" in stages:
        plan.lift()
    begin = plan.time
    if hold > 0.0:
        plan.then(hold)
        plan.stage("hold", begin)
    shake = steps = None
    begin = plan.time
    if "shake" in stages:
        shake = glass.Shake(begin=begin, seconds=_SHAKING)
        plan.then(_SHAKING)
        plan.stage("shake", begin)
    begin = plan.time
    if "walk" in stages:
        steps = Walk(distance=2.0, speed=1.0, before=begin)
        plan.then(float(steps.clock()[0][-2]) - begin)
        plan.stage("walk", begin)
    begin = plan.time
    if "turn" in stages:
        plan.then(_TURNING, turn=np.pi)
        plan.then(_OVER)
        plan.then(_TURNING, turn=0.0)
        plan.then(0.3)
        plan.stage("turn", begin)
    if "open" in stages:
        plan.open(_FALLING)
    return plan, steps, shake
