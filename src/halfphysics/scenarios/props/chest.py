"""A chest of drawers, for the scenarios in which a hand moves a drawer."""

from __future__ import annotations

import numpy as np

from halfphysics.base.validation import number
from halfphysics.scenarios.props import stage
from halfphysics.scene.scene import Scene

#: The drawers from top to bottom, and the height of the middle of each front [m].
DRAWERS = {"top": 1.06, "middle": 0.79, "bottom": 0.52}
#: Travel of a drawer [m].
TRAVEL = 0.30
#: A front's width, height, thickness [m].
WIDTH, HEIGHT, THICKNESS = 0.50, 0.24, 0.02
#: Depth of the case behind the fronts [m], its height, thickness of its panels.
DEPTH, TOP, _PANEL = 0.42, 1.22, 0.02
#: The bar across the middle of a front [m]: half length, radius, distance from the front.
BAR_HALF, BAR_RADIUS, BAR_OUT = 0.060, 0.006, 0.050

# Origin: on the floor, at the middle of the outer side of the shut fronts; drawers open toward -x.
# Coordinates of the rails: 0 shut, `TRAVEL` open.
_CASE = """
<mujoco model="chest"><worldbody>
  <geom type="box" pos="{middle} -{side} {half}" size="{deep} {thin} {half}"/>
  <geom type="box" pos="{middle} {side} {half}" size="{deep} {thin} {half}"/>
  <geom type="box" pos="{back} 0 {half}" size="{thin} {side} {half}"/>
  <geom type="box" pos="{middle} 0 {top}" size="{deep} {wide} {thin}"/>
  <geom type="box" pos="{middle} 0 0.18" size="{deep} {side} 0.18"/>
  {drawers}
</worldbody></mujoco>
"""
# Masses of front, bottom, sides, back and bar are fractions of the drawer's mass.
_DRAWER = """
  <body name="{name}" pos="0 0 {height}">
    <joint name="{name}_rail" type="slide" axis="-1 0 0" range="0 {travel}" damping="{damping}"/>
    <geom type="box" pos="{front} 0 0" size="{front} {half} {tall}" mass="{m[0]}"/>
    <geom type="box" pos="{middle} 0 -0.07" size="{deep} {in_} 0.006" mass="{m[1]}"/>
    <geom type="box" pos="{middle} -{in_} -0.01" size="{deep} 0.006 0.06" mass="{m[2]}"/>
    <geom type="box" pos="{middle} {in_} -0.01" size="{deep} 0.006 0.06" mass="{m[2]}"/>
    <geom type="box" pos="{back} 0 -0.01" size="0.006 {in_} 0.06" mass="{m[2]}"/>
    <geom type="capsule" fromto="-{out} -{bar} 0 -{out} {bar} 0" size="{r}" mass="{m[3]}"/>
    <geom type="capsule" fromto="-{out} -{bar} 0 0 -{bar} 0" size="{r}" mass="{m[3]}"/>
    <geom type="capsule" fromto="-{out} {bar} 0 0 {bar} 0" size="{r}" mass="{m[3]}"/>
  </body>"""


def add_chest(
    scene: Scene, at: float, *, mass: float, damping: float, out: dict[str, float]
) -> None:
    """Add an articulated "chest" whose shut fronts are at x = `at` [m], facing -x.

    Args:
        scene: The scene to extend.
        at: Position x of the outer side of the fronts [m].
        mass: Mass of each drawer with its contents [kg].
        damping: Damping of the rails [N s/m].
        out: Drawer -> its opening [m].

    Raises:
        InputError: A mass not above 0, or a negative damping.
    """
    mass = number(mass, "mass", above=0.0, unit="kg")
    damping = number(damping, "damping", least=0.0, unit="N s/m")
    inside = DEPTH - 0.04
    drawers = "".join(
        _DRAWER.format(
            name=name,
            height=height,
            travel=TRAVEL,
            damping=damping,
            front=0.5 * THICKNESS,
            half=0.5 * WIDTH,
            tall=0.5 * HEIGHT,
            middle=THICKNESS + 0.5 * inside,
            deep=0.5 * inside,
            in_=0.5 * WIDTH - 0.04,
            back=THICKNESS + inside - 0.006,
            out=BAR_OUT,
            bar=BAR_HALF,
            r=BAR_RADIUS,
            m=mass * np.array([0.34, 0.30, 0.11, 0.01]),
        )
        for name, height in DRAWERS.items()
    )
    thin = 0.5 * _PANEL
    case = _CASE.format(
        middle=THICKNESS + 0.5 * DEPTH + 0.002,
        side=0.5 * WIDTH - thin,
        half=0.5 * TOP - thin,
        deep=0.5 * DEPTH,
        thin=thin,
        back=THICKNESS + DEPTH - thin,
        top=TOP - thin,
        wide=0.5 * WIDTH,
        drawers=drawers,
    )
    scene.add_articulated(
        "chest",
        case,
        position=(at, 0.0, 0.0),
        friction=stage.WOOD,
        joints={f"{name}_rail": value for name, value in out.items()},
    )
