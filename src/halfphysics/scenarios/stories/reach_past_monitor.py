"""Scenario: a hand that reaches past a monitor and touches nothing."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.validation import frame_rate
from halfphysics.errors import InputError
from halfphysics.geometry.shapes import Box
from halfphysics.motion.easing import ease
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.scenarios.acting import arms
from halfphysics.scenarios.acting.gait import pose_at
from halfphysics.scenarios.acting.legs import about
from halfphysics.scenarios.acting.walk_plan import Walk
from halfphysics.scenarios.props import stage
from halfphysics.simulation.sequence import Sequence

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion
    from halfphysics.scene.scene import Scene

Array = NDArray[np.float64]

#: The table [m]: along the reach, across, height of its top, thickness of the top.
TABLE = (0.60, 1.20, 0.74, 0.04)
#: Screen and foot of the monitor [m]: along the reach, across, upright.
SCREEN, FOOT = (0.03, 0.50, 0.32), (0.20, 0.24, 0.02)
# The table's near edge and the monitor's middle before the person [m]; the mouse beside it.
_EDGE, _MONITOR, _MOUSE = 0.26, 0.52, (0.40, -0.42)
# Where the fingers point beside the body, and past the screen; where the elbow does.
_FINGERS = np.array([[0.6, 0.0, -0.8], [1.0, -0.08, -0.2]])
_ELBOW = np.array([-0.6, -0.2, -1.0])
# Times [s]: the hand leaves, is there, leaves again, is back.
_LEAVES, _THERE, _AWAY, _BACK = 0.3, 1.3, 1.8, 2.8


def build(
    *,
    fps: float = 30.0,
    mass: float = 4.0,
    friction: float = 0.8,
    beside: float = 0.10,
    body: Body | None = None,
) -> Sequence:
    """A person reaches past a monitor on a table without touching it, and draws the hand back.

    Args:
        fps: Frames per second.
        mass: Of the monitor [kg].
        friction: Of the monitor.
        beside: From the middle of the hand to the edge of the screen [m]; under about 0.05 it
            is touched.
        body: The person's body; None: the default body, which the table is sized for.
    """
    if not -0.5 <= beside <= 0.3:
        raise InputError(f"beside: found {beside!r}, expected -0.5 to 0.3 m")
    actor = stage.actor(body)
    motion, middle = _reach(actor, fps, beside)
    scene = stage.floor()
    _add_desk(scene, middle, mass, friction)
    return Sequence(motion, scene, actor)


def _reach(actor: Body, fps: float, beside: float) -> tuple[Motion, float]:
    """The motion of the person, and where the person's middle is along the reach [m]."""
    fps = frame_rate(fps)
    stands = pose_at(actor, Walk(distance=1.0), 0.0)
    count = round((_BACK + 0.3) * fps) + 1
    base = stage.held(actor, stands, count, fps)
    times = np.arange(count) / base.fps
    share = ease((times - _LEAVES) / (_THERE - _LEAVES)) * (
        1.0 - ease((times - _AWAY) / (_BACK - _AWAY))
    )
    rotations = np.array(base.rotations)
    for name in ("spine1", "spine2", "spine3"):
        joint = JOINT_INDEX[name]
        lean = rot.rotvec_to_matrix(rotations[:, joint]) @ about(0, share * np.radians(6.0))
        rotations[:, joint] = rot.matrix_to_rotvec(lean)
    leaning = base.with_frames(base.translation, rotations)
    positions, quaternions = actor.joint_frames(leaning)
    turns = rot.to_matrix(quaternions)
    arm = arms.arm_of(actor, "right")
    middle = float(positions[0, 0, 0])
    # Up beside the body first, then ahead: over the table's edge, past the screen.
    edge = -0.5 * SCREEN[1] - beside
    start = np.array([middle + 0.05, -0.36, TABLE[2] + 0.16])
    end = np.array([middle + _MONITOR - 0.02, edge, TABLE[2] + 0.24])
    wrist = start + share[:, None] * (end - start)
    # Fingers go on along the forearm, which hangs first.
    fingers = _FINGERS[0] + share[:, None] * (_FINGERS[1] - _FINGERS[0])
    hand = arms.palm_frame("right", fingers, np.array([0.0, 1.0, -0.3]))
    elbow = _ELBOW
    collar, shoulder = turns[:, arm.collar], positions[:, arm.joints[0]]
    for joint, turn in arms.solve(arm, collar, shoulder, wrist, hand, elbow).items():
        rotations[:, joint] = turn
    return base.with_frames(base.translation, rotations), middle


def _add_desk(scene: Scene, middle: float, mass: float, friction: float) -> None:
    """Add the table with the monitor and the mouse before a person who stands at `middle` [m]."""
    length, width, height, thickness = TABLE
    centre = middle + _EDGE + 0.5 * length
    scene.add_static(
        "table", Box((length, width, thickness)), position=(centre, 0.0, height - 0.5 * thickness)
    )
    at = middle + _MONITOR
    scene.add_object(
        "foot",
        Box(FOOT),
        mass=0.3 * mass,
        friction=friction,
        position=(at, 0.0, height + 0.5 * FOOT[2]),
    )
    scene.add_object(
        "screen",
        Box(SCREEN),
        mass=0.7 * mass,
        friction=friction,
        position=(at, 0.0, height + FOOT[2] + 0.5 * SCREEN[2]),
    )
    mouse = Box((0.11, 0.06, 0.035))
    scene.add_object(
        "mouse",
        mouse,
        mass=0.1,
        position=(middle + _MOUSE[0], _MOUSE[1], height + 0.5 * mouse.size[2]),
    )
