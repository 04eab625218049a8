"""A laptop on a desk and a seated person, for the scenarios in which a hand moves the lid."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from halfphysics.base.validation import number
from halfphysics.motion.motion import Motion
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.scenarios.acting import hands, reaching
from halfphysics.scenarios.acting.acting import LIFT, SIDES, Act
from halfphysics.scenarios.props import stage
from halfphysics.scenarios.props.furniture import CLOTH, block, table
from halfphysics.scene.scene import Scene

if TYPE_CHECKING:
    from halfphysics.body.body import Body

#: Size of the laptop [m]: width and depth of base and lid, thickness of base, of lid.
WIDTH, DEPTH, BASE, LID = 0.32, 0.225, 0.018, 0.008
#: Gap between the lid and the base when shut [m]; feet under the base [m].
GAP, FEET = 0.003, 0.004
#: Largest opening of the lid [rad].
OPEN = np.radians(110.0)
#: The recess in the base's front edge under the lid [m]: half its width, its depth.
RECESS_HALF, RECESS_DEEP = 0.075, 0.035

#: The desk [m]: depth, width, height of its top.
_DEEP, _WIDE, DESK = 0.63, 1.20, 0.74
#: Height of the seated person's pelvis [m].
_SITS = 0.56
#: Height of resting palms above the desk [m].
_OVER = 0.006

# Origin: on the desk, below the hinge's middle; the base lies toward -x. The joint's coordinate is
# the opening of the lid.
_LAPTOP = """
<mujoco model="laptop"><worldbody>
  <body name="base">
    <geom type="box" pos="-{rear_at} 0 {middle}" size="{rear} {half} {thick}"/>
    <geom type="box" pos="-{front_at} -{beside_at} {middle}" size="{front} {beside} {thick}"/>
    <geom type="box" pos="-{front_at} {beside_at} {middle}" size="{front} {beside} {thick}"/>
    <body name="lid" pos="0 0 {hinge}">
      <joint name="hinge" axis="0 1 0" range="0 {open}" damping="{damping}"/>
      <geom type="box" pos="-{long} 0 {thin}" size="{long} {half} {thin}" mass="{mass}"/>
    </body>
  </body>
</worldbody></mujoco>
"""


@dataclass(frozen=True, kw_only=True)
class Lean:
    """The trunk leans ahead by `degrees` from `start` on, and back from `back` on [s]."""

    start: float
    back: float
    seconds: float
    degrees: float


def hinge_height() -> float:
    """Height of the hinge above the desk [m], that of the shut lid's inner side."""
    return FEET + BASE + GAP


def xml(mass: float, damping: float) -> str:
    """The laptop as MJCF."""
    rear, front = 0.5 * (DEPTH - RECESS_DEEP), 0.5 * RECESS_DEEP
    beside = 0.5 * (0.5 * WIDTH - RECESS_HALF)
    return _LAPTOP.format(
        rear_at=rear,
        rear=rear,
        front_at=2.0 * rear + front,
        front=front,
        beside_at=RECESS_HALF + beside,
        beside=beside,
        middle=FEET + 0.5 * BASE,
        thick=0.5 * BASE,
        half=0.5 * WIDTH,
        hinge=hinge_height(),
        open=np.degrees(OPEN),
        damping=damping,
        long=0.5 * DEPTH,
        thin=0.5 * LID,
        mass=mass,
    )


def add_laptop(
    scene: Scene, hinge: tuple[float, float, float], *, mass: float, damping: float, angle: float
) -> None:
    """Add an articulated "laptop" on a desk.

    Args:
        scene: The scene to extend.
        hinge: Point of the desk's top below the middle of the hinge (3,) [m].
        mass: Mass of the lid [kg].
        damping: Damping of the hinge [N m s].
        angle: Opening of the lid [rad].

    Raises:
        InputError: A mass not above 0, or a negative damping.
    """
    mass = number(mass, "mass", above=0.0, unit="kg")
    damping = number(damping, "damping", least=0.0, unit="N m s")
    scene.add_articulated(
        "laptop",
        xml(mass, damping),
        position=hinge,
        friction=stage.WOOD,
        joints={"hinge": angle},
    )


def seated(
    body: Body,
    scene: Scene,
    seconds: float,
    fps: float,
    *,
    edge: float,
    lean: Lean,
    right: tuple[float, float, float] | None = None,
) -> Motion:
    """Motion of a person seated at a desk, hands above it; adds "table", its legs and "chair".

    Args:
        body: The person's body, pelvis above the origin, facing +x.
        scene: The scene to extend with the furniture.
        seconds: Duration of the motion [s].
        fps: Frames per second.
        edge: Distance of the desk's near edge ahead of the person [m].
        lean: The lean of the trunk.
        right: Position of the right wrist (3,) [m]; None: on the desk, as the left wrist.
    """
    table(scene, (edge, -0.5 * _WIDE), (edge + _DEEP, 0.5 * _WIDE), DESK)
    act = Act(body)
    ankle = act["left_foot"][2]
    act.begin(pelvis=(0.0, 0.0, _SITS), bend=(4.0, 0.0, 0.0), knees=(1.0, 0.0, 0.4), nod=8.0)
    act.begin(elbows=(-0.5, 0.7, -0.8))
    level = DESK + reaching.palm_depth(body, "left") + _OVER
    act.begin(**act.both(foot=(0.38, 0.11, ankle), hand=(edge + 0.03, 0.37, level), hold=1.0))
    if right is not None:
        act.begin(right_hand=right)
    act.move(lean.start, lean.seconds, bend=(lean.degrees, 0.0, 0.0))
    act.move(lean.back, lean.seconds, bend=(4.0, 0.0, 0.0))
    motion = act.motion(seconds, fps)
    for side in SIDES:
        motion = hands.shaped(body, motion, side, 1.0, curls=(4.0, 4.0, 4.0))
    part = np.argmax(body.weights, axis=1)
    sits = np.isin(part, [JOINT_INDEX[n] for n in ("pelvis", "left_hip", "right_hip")])
    seat = float(np.asarray(body.vertices(motion[0]))[sits, 2].min()) - LIFT
    block(scene, "chair", (-0.22, -0.22, 0.0), (0.20, 0.22, seat), CLOTH)
    return motion
