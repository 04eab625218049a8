"""One laptop from two formats, and scissors whose handle a hand presses."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.motion.easing import ease
from halfphysics.motion.skeleton import RIGHT_HAND_JOINTS
from halfphysics.scenarios.acting import arms, reaching
from halfphysics.scenarios.acting.gait import pose_at
from halfphysics.scenarios.acting.walk_plan import Walk
from halfphysics.scenarios.props import laptop, stage
from halfphysics.scenarios.stories import close_laptop
from support.as_it_is import as_it_is
from support.joint_scenarios import done
from support.judges.jointed import Jointed

pytestmark = pytest.mark.slow

_BOX = """<collision><origin xyz="{at[0]} {at[1]} {at[2]}"/>
<geometry><box size="{size[0]} {size[1]} {size[2]}"/></geometry></collision>"""


def urdf(mass, damping):
    """The laptop of `scenarios.laptop`, written again in the other format."""
    rear = laptop.DEPTH - laptop.RECESS_DEEP
    beside = 0.5 * laptop.WIDTH - laptop.RECESS_HALF
    middle = laptop.FEET + 0.5 * laptop.BASE
    boxes = [((-0.5 * rear, 0.0, middle), (rear, laptop.WIDTH, laptop.BASE))]
    for side in (-1.0, 1.0):
        at = (-rear - 0.5 * laptop.RECESS_DEEP, side * (laptop.RECESS_HALF + 0.5 * beside), middle)
        boxes.append((at, (laptop.RECESS_DEEP, beside, laptop.BASE)))
    base = "".join(_BOX.format(at=at, size=size) for at, size in boxes)
    size = np.array([laptop.DEPTH, laptop.WIDTH, laptop.LID])
    at = (-0.5 * size[0], 0.0, 0.5 * size[2])
    inertia = mass / 12.0 * ((size**2).sum() - size**2)
    return f"""<robot name="laptop"><link name="base">{base}</link><link name="lid">
<inertial><origin xyz="{at[0]} {at[1]} {at[2]}"/><mass value="{mass}"/>
<inertia ixx="{inertia[0]}" iyy="{inertia[1]}" izz="{inertia[2]}" ixy="0" ixz="0" iyz="0"/>
</inertial>{_BOX.format(at=at, size=size)}</link>
<joint name="hinge" type="revolute"><parent link="base"/><child link="lid"/>
<origin xyz="0 0 {laptop.hinge_height()}"/><axis xyz="0 1 0"/>
<limit lower="0" upper="{laptop.OPEN}" effort="1" velocity="1"/>
<dynamics damping="{damping}"/></joint></robot>"""


@pytest.mark.parametrize("stiffness", [0.0, 1.0])
def test_a_laptop_from_urdf_closes_as_the_one_from_mjcf(stiffness):
    sequence, result, _, _, angle = done("close_laptop", stiffness=stiffness)
    scene = hp.Scene()
    for s in sequence.scene.statics.values():
        scene.add_static(
            s.name,
            s.shape,
            position=s.position,
            quaternion=s.quaternion,
            friction=s.friction,
        )
    scene.add_articulated(
        "laptop",
        urdf(*(hp.scenarios.options("close_laptop")[n] for n in ("mass", "damping"))),
        position=close_laptop.HINGE,
        friction=stage.WOOD,
        joints={"hinge": laptop.OPEN},
    )
    other = hp.simulate(
        sequence.motion, scene, body=sequence.body, settings=as_it_is(stiffness=stiffness)
    )
    # The numbers in the text agree up to their last digits; contact does not amplify that.
    np.testing.assert_allclose(other.joints["laptop/hinge"], angle, atol=1e-9)
    np.testing.assert_allclose(other.motion.rotations, result.motion.rotations, atol=1e-9)
    thing = Jointed(other, "laptop")
    assert max(thing.off()) < 1e-12
    assert thing.beyond() <= 0.0


#: Top of the table under the scissors, and the position of their rivet on it [m].
TABLE, RIVET = 1.05, (0.44, -0.06)
#: Blades cross at the rivet; handles stand on edge, so that a hand meets them.
OPEN, SHUT = np.radians([45.0, 12.0])
SCISSORS = """
<mujoco><worldbody><body name="one">{joint}
  <geom type="box" pos=".07 0 .012" size=".07 .008 .002" mass=".02"/>
  <geom type="box" pos="-.06 0 .02" size=".06 .006 .02" mass=".05"/>
  <body name="two" pos="0 0 .005">
    <joint name="rivet" axis="0 0 1" range="12 60" damping="5e-3"/>
    <geom type="box" pos=".07 0 .012" size=".07 .008 .002" mass=".02"/>
    <geom type="box" pos="-.06 0 .015" size=".06 .006 .02" mass=".05"/>
  </body>
</body></worldbody></mujoco>"""


def cut(free, stiffness=0.0, fps=30.0):
    """A right hand presses the second blade's handle toward the first one's, and leaves it."""
    body = stage.actor(None)
    base = stage.held(body, pose_at(body, Walk(distance=1.0), 0.0), round(2.6 * fps) + 1, fps)
    base = base.with_frames(
        base.translation - base.translation[0] * [1.0, 0.0, 0.0], base.rotations
    )
    times = np.arange(len(base)) / fps
    share = ease(times / 0.8) * ease((2.6 - times) / 0.6)
    palm = RIVET[1] - 0.17 + 0.15 * ease((times - 0.8) / 0.9) * ease((2.5 - times) / 0.5)
    wrist = np.zeros((len(base), 3))
    wrist[:] = (RIVET[0] - 0.18, 0.0, TABLE + 0.056)
    wrist[:, 1] = palm - reaching.palm_depth(body, "right")
    hand = np.repeat(arms.palm_frame("right", [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]), len(base), axis=0)
    flat = {j: np.zeros((len(base), 3)) for j in RIGHT_HAND_JOINTS}
    motion = reaching.reach(
        body, base, "right", wrist, hand, share, pole=(-0.3, -1.0, -0.3), fingers=flat
    )
    scene = stage.floor()
    scene.add_static("table", hp.Box((0.5, 0.5, 0.04)), position=(0.46, 0.05, TABLE - 0.02))
    joint = '<freejoint name="base"/>' if free else ""
    at = (*RIVET, TABLE + (0.001 if free else 0.002))
    # Polished: a handle that is pressed at its end at 45 degrees turns rather than jams.
    scene.add_articulated(
        "scissors",
        SCISSORS.format(joint=joint),
        position=at,
        friction=0.3,
        joints={"rivet": OPEN},
    )
    if free:  # the handle is pressed against this
        peg = hp.Box((0.10, 0.02, 0.04))
        scene.add_static("peg", peg, position=(RIVET[0] - 0.06, RIVET[1] + 0.017, TABLE + 0.02))
    settings = as_it_is(stiffness=stiffness)
    return motion, hp.simulate(motion, scene, body=body, settings=settings)


@pytest.mark.parametrize("free", [False, True], ids=["fixed", "lying"])
@pytest.mark.parametrize("stiffness", [0.0, 1.0])
def test_scissors_close_when_a_hand_presses_the_handle(free, stiffness):
    motion, result = cut(free, stiffness)
    thing, angle = Jointed(result, "scissors"), result.joints["scissors/rivet"]
    assert max(thing.off()) < 1e-12
    assert thing.beyond() <= 0.0
    # Shut to the stop and left there; before the hand came they were open.
    force = np.linalg.norm(thing.force("two"), axis=1)
    touched = np.flatnonzero(force > 0.0)
    assert np.abs(angle[: touched[0]] - OPEN).max() < (1e-3 if free else 1e-9)
    np.testing.assert_allclose(angle[-1], SHUT, atol=1e-3 if free else 1e-6)
    assert np.diff(angle).max() < 1e-3
    assert 5.0 < force.max() < 50.0
    assert result.lost_time.sum() == 0.0
    assert thing.gap(np.arange(touched[0], touched[-1] + 3, 2)).min() > 0.0
    # The reference goes on beyond the stop: through the handle, if it were in the way.
    asked, found = thing.penetration(motion), thing.penetration(result.motion)
    assert asked.by_name["scissors/two"].max() > 3.0  # of 6 mm, half the handle's thickness
    assert found.depth_max_mm == 0.0
    # They do not move: pressed against the peg, or held by a static part.
    place = result.objects["scissors/one"].position
    assert np.abs(place - place[0])[: touched[-1]].max() < (0.01 if free else 1e-12)


@pytest.mark.parametrize("fps", [60.0, 120.0])
def test_scissors_close_alike_at_other_frame_rates(fps):
    slow, fast = (cut(True, 0.0, f)[1].joints["scissors/rivet"] for f in (30.0, fps))
    assert np.abs(fast[:: round(fps / 30.0)] - slow).max() < 0.05 * (OPEN - SHUT)
