"""Parts that the scenarios share: the person, the floor, the ball in front of the foot."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.errors import InputError
from halfphysics.geometry.shapes import Plane, Sphere
from halfphysics.motion.motion import MODELS, Motion
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.scenarios.acting.gait import DOUBLE, IMPACT, pose_at
from halfphysics.scenarios.acting.walk_plan import Walk
from halfphysics.scene.scene import Scene

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.pose import Pose

Array = NDArray[np.float64]

#: Radius of a football [m].
BALL_RADIUS = 0.11
#: Friction of painted wood against cloth: a person can slide past furniture.
WOOD = 0.3


def actor(body: Body | None) -> Body:
    """The given body, or the default body."""
    if body is not None:
        return body
    from halfphysics.body.body import Body

    return Body.default()


def partner(other: Body | None, stature: float) -> Body:
    """The given body of a second person, or the default body with a stature [m]."""
    if other is not None:
        return other
    from halfphysics.body.body import Body

    return Body.default(stature=stature)


def floor() -> Scene:
    """A scene with only a floor at z = 0."""
    scene = Scene()
    scene.add_static("floor", Plane())
    return scene


def held(body: Body, pose: Pose, count: int, fps: float) -> Motion:
    """A pose of a body for `count` frames.

    Raises:
        InputError: Fewer than two frames, or an `fps` that is not positive.
    """
    smpl = body.model in MODELS
    return Motion(
        np.repeat(pose.translation[None], count, axis=0),
        np.repeat(pose.rotations[None], count, axis=0),
        fps,
        betas=body.betas if smpl else None,
        gender=body.gender if smpl else "neutral",
        model=body.model if smpl else "smplx",
    )


def impact_time(plan: Walk) -> float:
    """Planned time of the kicking foot's contact with the ball [s].

    Raises:
        InputError: The walk has no kick.
    """
    if plan.kick is None:
        raise InputError("kick: found none, expected a walk with a kick")
    times, phases = plan.clock()
    phase = plan.kick.step + 0.5 * DOUBLE + IMPACT * (1.0 - DOUBLE)
    inside = slice(1, -1)  # the phase is constant while the walker stands
    return float(np.interp(phase, phases[inside], times[inside]))


def add_ball(
    scene: Scene,
    body: Body,
    plan: Walk,
    mass: float,
    friction: float,
    *,
    radius: float = BALL_RADIUS,
    fixed: bool = False,
) -> Array:
    """Add a ball at the impact of the kick; returns its centre (3,) [m].

    The ball lies in the line of the foot and touches the toes at the time of impact. A `fixed`
    ball is a static.
    """
    side = plan.swinging(plan.kick.step) if plan.kick else "right"
    part = np.argmax(body.weights, axis=1)
    shoe = np.isin(part, [JOINT_INDEX[f"{side}_ankle"], JOINT_INDEX[f"{side}_foot"]])
    skin = np.asarray(body.vertices(pose_at(body, plan, impact_time(plan))))[shoe]
    ahead = np.array([np.cos(plan.heading), np.sin(plan.heading)])
    # Distance from a point at height z to the centre of a touching sphere on the ground.
    rise = np.clip(skin[:, 2] - radius, -radius, radius)
    along = skin[:, :2] @ ahead + np.sqrt(radius**2 - rise**2)
    across = skin[:, :2] - np.outer(skin[:, :2] @ ahead, ahead)
    centre = np.array([*(along.max() * ahead + across.mean(axis=0)), radius])
    ball = Sphere(radius)
    if fixed:
        scene.add_static("ball", ball, friction=friction, position=centre)
    else:
        scene.add_object("ball", ball, mass=mass, friction=friction, position=centre)
    return centre
