"""Scenario: a hand pushes a door open and its owner walks through."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.errors import InputError
from halfphysics.geometry.shapes import Box
from halfphysics.motion.easing import ease
from halfphysics.motion.motion import Motion
from halfphysics.motion.skeleton import JOINT_NAMES, N_JOINTS
from halfphysics.scenarios.acting import arms
from halfphysics.scenarios.acting.gait import walk
from halfphysics.scenarios.acting.reaching import bent_between
from halfphysics.scenarios.acting.walk_plan import Walk
from halfphysics.scenarios.props import stage
from halfphysics.simulation.sequence import Sequence

if TYPE_CHECKING:
    from halfphysics.body.body import Body

Array = NDArray[np.float64]

#: Width and height of the panel, its thickness [m].
WIDTH, HEIGHT, THICKNESS = 0.90, 2.0, 0.04
#: Where the closed door stands, before a walk that starts at x = 0 [m].
DOOR_AT = 1.2
#: Gap under and beside the panel [m].
_GAP = 0.02
#: The pushing wrist from the pelvis: ahead, to the right, up [m].
_WRIST = np.array([0.47, -0.18, 0.36])
#: How much of the walk is over when the arm is raised, and when it is lowered again.
_RAISED, _LOWERED = (0.05, 0.25), (0.70, 0.95)

_PANEL = """
<mujoco model="door"><worldbody>
  <body name="panel">
    <joint name="hinge" axis="0 0 1" range="0 110" damping="{damping}"/>
    <geom type="box" pos="0 -{half} {middle}" size="{thick} {half} {tall}" mass="{mass}"/>
  </body>
</worldbody></mujoco>
"""


def build(
    *,
    fps: float = 30.0,
    mass: float = 20.0,
    damping: float = 2.0,
    speed: float = 1.0,
    body: Body | None = None,
) -> Sequence:
    """A person pushes a door open with one hand and walks through.

    Args:
        fps: Frames per second.
        mass: Of the door [kg].
        damping: Of its hinge [N m s].
        speed: Of the walk [m/s].
        body: The person's body; None: the default body, which the door is sized for.
    """
    for name, value, least in (("mass", mass, 1e-3), ("damping", damping, 0.0)):
        if not (np.isfinite(value) and value >= least):
            raise InputError(f"{name}: found {value!r}, expected a number >= {least:g}")
    actor = stage.actor(body)
    motion = _pushing(actor, walk(actor, Walk(distance=3.0, speed=speed), fps))
    scene = stage.floor()
    for side in (1.0, -1.0):
        post = Box((0.10, 0.60, HEIGHT + 0.1))
        y = side * (0.5 * WIDTH + _GAP + 0.30)
        scene.add_static(
            "left_wall" if side > 0.0 else "right_wall",
            post,
            position=(DOOR_AT, y, 0.5 * HEIGHT + 0.05),
            friction=stage.WOOD,
        )
    panel = _PANEL.format(
        damping=damping,
        half=0.5 * WIDTH,
        middle=_GAP + 0.5 * HEIGHT,
        thick=0.5 * THICKNESS,
        tall=0.5 * HEIGHT,
        mass=mass,
    )
    hinge = (DOOR_AT + 0.08, 0.5 * WIDTH, 0.0)
    scene.add_articulated("door", panel, position=hinge, friction=stage.WOOD)
    return Sequence(motion, scene, actor)


def _pushing(body: Body, base: Motion) -> Motion:
    """The walk with the right hand held out, palm ahead, until the door is passed."""
    positions, quaternions = body.joint_frames(base)
    turns = rot.to_matrix(quaternions)
    arm = arms.arm_of(body, "right")
    # Steady above the path: the pelvis sways, a hand that pushes does not.
    steady = np.array(positions[:, 0])
    steady[:, 1:] = steady[:, 1:].mean(axis=0)
    up = np.array([0.0, -0.2, 1.0])
    hand = np.broadcast_to(
        arms.palm_frame("right", up, np.array([1.0, 0.0, 0.0])), (len(base), 3, 3)
    )
    held = arms.solve(
        arm,
        turns[:, arm.collar],
        positions[:, arm.joints[0]],
        steady + _WRIST,
        hand,
        np.array([0.0, -0.6, -1.0]),
    )
    walked = (positions[:, 0, 0] - positions[0, 0, 0]) / np.ptp(positions[:, 0, 0])
    raised = ease((walked - _RAISED[0]) / (_RAISED[1] - _RAISED[0]))
    share = raised * (1.0 - ease((walked - _LOWERED[0]) / (_LOWERED[1] - _LOWERED[0])))
    rotations = np.array(base.rotations)
    for joint, turn in held.items():
        rotations[:, joint] = bent_between(body, joint, rotations[:, joint], turn, share)
    fingers = [j for j in range(25, N_JOINTS) if JOINT_NAMES[j].startswith("right_")]
    rotations[:, fingers] *= (1.0 - share)[:, None, None]
    return base.with_frames(base.translation, rotations)
