"""Scenario: jumping on a bed."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.validation import is_whole, number, shown
from halfphysics.errors import InputError
from halfphysics.scenarios.acting.acting import Act
from halfphysics.scenarios.acting.legs import leg_of
from halfphysics.scenarios.acting.legs import solve as solve_leg
from halfphysics.scenarios.props import stage
from halfphysics.scenarios.props.furniture import CLOTH, block
from halfphysics.simulation.sequence import Sequence

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion

Array = NDArray[np.float64]

# The bed [m]: half of its sides, its top, the underside of its mattress.
_HALF, _TOP, _UNDER = (0.7, 1.0), 0.45, 0.2
#: How deep the knees bend before and after a jump [m]; stillness before and after [s]; gravity
#: [m/s^2].
_CROUCH, _STILL, _G = 0.22, 0.6, 9.81


def build(
    *,
    fps: float = 30.0,
    jumps: int = 2,
    height: float = 0.15,
    soft: str | None = "mattress",
    body: Body | None = None,
) -> Sequence:
    """A person stands on a bed, jumps on its mattress and comes to rest on it.

    Args:
        fps: Frames per second.
        jumps: How often.
        height: Of the feet above the mattress in a jump [m].
        soft: Material of the mattress (`hp.Soft.named`); None: it is hard.
        body: The person's body; None: the default body.
    """
    if not is_whole(jumps, least=1, plain=False) or jumps > 20:
        raise InputError(f"jumps: found {shown(jumps)}, expected 1 to 20, a whole number")
    height = number(height, "height", least=0.02, most=0.4, unit="m")
    actor = stage.actor(body)
    scene = stage.floor()
    x, y = _HALF
    block(scene, "mattress", (-x, -y, _UNDER), (x, y, _TOP), CLOTH, soft)
    act = Act(actor)
    act.begin(**act.both(arm=(0.16, 0.16, -0.44)))
    start, air, seconds = _clock(jumps, height)
    standing = act.motion(seconds, fps)
    times = np.arange(len(standing)) / standing.fps
    pelvis, feet = _heights(times, jumps, height, start, air)
    return Sequence(_jumping(actor, standing, pelvis, feet), scene, actor)


def _clock(jumps: int, height: float) -> tuple[float, float, float]:
    """When the first jump's crouch begins, how long a flight lasts, and the whole [s]."""
    speed = np.sqrt(2.0 * _G * height)
    down = 4.0 * _CROUCH / speed  # bends and stretches, at rest in between
    air = 2.0 * speed / _G
    return _STILL, float(air), float(2.0 * _STILL + jumps * air + (jumps + 1) * down + 0.6)


def _heights(
    times: Array, jumps: int, height: float, start: float, air: float
) -> tuple[Array, Array]:
    """Pelvis and feet above where they stand (T,), (T,) [m].

    On the mattress the pelvis has a constant acceleration up, from the speed of landing to that of
    taking off; in the air both fall.
    """
    speed = np.sqrt(2.0 * _G * height)
    bend = 2.0 * _CROUCH / speed
    pelvis, feet = np.zeros(len(times)), np.zeros(len(times))
    # First down from rest, slowly; then a half of bounces.
    first = np.clip((times - start) / 0.6, 0.0, 1.0)
    pelvis -= _CROUCH * first**2 * (3.0 - 2.0 * first)
    begin = start + 0.6
    push = 0.5 * speed / bend
    for jump in range(jumps):
        since = times - begin
        pelvis += np.where((since >= 0) & (since < bend), push * since**2, 0.0)
        fall = since - bend
        flying = (fall >= 0) & (fall < air)
        up = speed * fall - 0.5 * _G * fall**2
        pelvis = np.where(flying, up, pelvis)
        feet = np.where(flying, up, feet)
        land = fall - air
        down = (land >= 0) & (land < bend)
        pelvis = np.where(down, push * (bend - land) ** 2 - _CROUCH, pelvis)
        pelvis = np.where(land >= bend, -_CROUCH, pelvis)
        begin += 2.0 * bend + air
        if jump == jumps - 1:
            rise = np.clip((times - begin) / 0.6, 0.0, 1.0)
            pelvis += _CROUCH * rise**2 * (3.0 - 2.0 * rise)
    return pelvis, feet


def _jumping(body: Body, standing: Motion, pelvis: Array, feet: Array) -> Motion:
    """Somebody who stands, with the pelvis and the feet moved up by so much, on the bed."""
    positions, quaternions = body.joint_frames(standing)
    turns = rot.to_matrix(quaternions)
    rotations = np.array(standing.rotations)
    up = np.array([0.0, 0.0, 1.0])
    root = positions[:, 0] + (pelvis + _TOP)[:, None] * up
    for side in ("left", "right"):
        leg = leg_of(body, side)
        ankle = leg.joints[2]
        goal = positions[:, ankle] + (feet + _TOP)[:, None] * up
        bent = solve_leg(
            leg,
            turns[:, 0],
            root + turns[:, 0] @ leg.hip,
            goal,
            turns[:, ankle],
            np.zeros(len(standing)),
        )
        for joint in leg.joints[:3]:
            rotations[:, joint] = bent[joint]
    return standing.with_frames(standing.translation + root - positions[:, 0], rotations)
