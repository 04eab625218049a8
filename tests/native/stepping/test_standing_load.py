"""Who stands, sits or lies on a movable thing weighs on it."""

import numpy as np
import pytest

import halfphysics as hp
from support.as_it_is import as_it_is
from support.bent_knees import BODY, WEIGHT, G, mass, standing


def scale(stiffness=2e5, platform=5.0):
    """A plate of 0.6 m on a spring, its top at z = 0 without a load."""
    return f"""<mujoco><worldbody><body name="plate" pos="0 0 -0.025">
    <joint name="spring" type="slide" axis="0 0 1" stiffness="{stiffness}" damping="2000"/>
    <geom type="box" size=".3 .3 .025" mass="{platform}"/></body></worldbody></mujoco>"""


def seesaw(damping=40.0):
    return f"""<mujoco><worldbody><body name="plank" pos="0 0 -0.025">
    <joint name="hinge" type="hinge" axis="0 1 0" range="-20 20" damping="{damping}"/>
    <geom type="box" size="1.5 .3 .025" mass="20"/></body></worldbody></mujoco>"""


def plank(*people, frames=90, damping=40.0, friction=0.0):
    """The angle of a seesaw over time; `people`: where along it they stand [m]."""
    scene = hp.Scene()
    scene.add_articulated("seesaw", seesaw(damping))
    scene.friction("person", "seesaw", friction)
    motions = [standing(frames, at=(x, 0.0)) for x in people]
    return hp.simulate(motions, scene, body=[BODY] * len(people), settings=WEIGHT).joints[
        "seesaw/hinge"
    ]


@pytest.mark.parametrize("stiffness", [5e4, 2e5])
@pytest.mark.parametrize("fps", [30.0, 120.0])
def test_a_scale_reads_the_weight(stiffness, fps):
    scene = hp.Scene()
    scene.add_articulated("scale", scale(stiffness))
    result = hp.simulate(standing(int(2 * fps), fps), scene, body=BODY, settings=WEIGHT)
    empty = hp.Scene()
    empty.add_articulated("scale", scale(stiffness))
    rest = hp.simulate(
        standing(int(2 * fps), fps, at=(5.0, 0.0)), empty, body=BODY, settings=WEIGHT
    )
    sinks = rest.joints["scale/spring"] - result.joints["scale/spring"]
    read = stiffness * sinks[-int(fps) :]
    assert np.abs(read / (mass() * G) - 1.0).max() < 0.01
    # Over time too: the sum of the load is the weight.
    assert abs(read.mean() / (mass() * G) - 1.0) < 0.01
    # And the person has come down with it.
    z = result.motion.translation[:, 2] - standing(2).translation[0, 2]
    assert abs(z[-1] - result.joints["scale/spring"][-1]) < 0.006


def test_without_weight_nothing_weighs():
    scene = hp.Scene()
    scene.add_articulated("scale", scale())
    settings = as_it_is()
    alone = hp.simulate(standing(at=(5.0, 0.0)), scene, body=BODY, settings=settings)
    stood = hp.simulate(standing(top=0.01), scene, body=BODY, settings=settings)
    assert np.array_equal(alone.joints["scale/spring"], stood.joints["scale/spring"])


def test_a_seesaw_tilts_to_the_heavier_moment_and_balances_at_equal_ones():
    assert plank(0.5)[-1] > 0.1
    assert plank(-0.5)[-1] < -0.1
    assert plank(-0.5, 1.0)[-1] > 0.1
    assert plank(-1.0, 0.5)[-1] < -0.1
    assert np.abs(plank(-0.6, 0.6)).max() < 0.01


@pytest.mark.parametrize("friction", [0.0, 0.6])
def test_the_moment_is_that_of_the_centre_of_mass(friction):
    """How a hinge with much damping starts to turn, soles that stay where they are 25 mm above it:
    m g (x - 0.025 mu) / damping.
    """
    damping, x = 4e4, 0.6
    angle = plank(x, damping=damping, frames=60, friction=friction)
    speed = np.diff(angle)[20:].mean() * 60.0
    assert speed == pytest.approx(mass() * G * (x - 0.025 * friction) / damping, rel=0.02)


def slide(person, speed=2.0, box_mass=20.0):
    """Deceleration of a box that is set off over the floor [m/s^2]."""
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane(), friction=0.5)
    scene.add_object(
        "box", hp.Box((1.6, 1.6, 0.1)), mass=box_mass, position=(0, 0, 0.0501), friction=0.5
    )
    scene.friction("floor", "box", 0.5)
    scene.friction("person", "box", 0.0)
    fps = 240.0
    motion = standing(100, fps, at=(0.0 if person else 5.0, 0.0), top=0.1)
    sim = hp.Simulator(scene, body=BODY, fps=fps, settings=WEIGHT)
    sim.reset(motion[0])
    for t in range(1, 80):
        sim.step(motion[t])
    sim.set_velocity("box", (speed, 0.0, 0.0))
    x = [sim.step(motion[80 + k]).objects["box"][0][0] for k in range(10)]
    v = np.diff(x) * fps
    return -np.polyfit(np.arange(len(v)) / fps, v, 1)[0]


def test_a_box_that_is_stood_on_is_pressed_on_the_floor():
    """The force that slides it is mu (m_box + m_person) g: what slows it down."""
    assert slide(False) == pytest.approx(0.5 * G, rel=0.05)
    assert 20.0 * slide(True) == pytest.approx(0.5 * (20.0 + mass()) * G, rel=0.05)


def test_static_floor_beside_a_movable_thing_changes_no_bit():
    motion = standing()
    floor, both = hp.Scene(), hp.Scene()
    for scene in (floor, both):
        scene.add_static("floor", hp.Plane())
    both.add_object("box", hp.Box((0.2, 0.2, 0.2)), mass=3.0, position=(3.0, 0.0, 0.1005))
    a, b = (hp.simulate(motion, s, body=BODY, settings=WEIGHT) for s in (floor, both))
    assert np.array_equal(a.motion.translation, b.motion.translation)
    off = hp.simulate(motion, both, body=BODY, settings=as_it_is())
    assert np.array_equal(b.objects["box"].position, off.objects["box"].position)


def test_who_jumps_off_is_no_load_within_a_tenth_of_a_second():
    fps, leaves = 60.0, 60
    motion = standing(90, fps)
    t = np.maximum(0.0, np.arange(90) - leaves) / fps
    up = np.maximum(0.0, 3.0 * t - 0.5 * G * t**2)
    jump = motion.with_frames(motion.translation + up[:, None] * [0.0, 0.0, 1.0], motion.rotations)
    scene = hp.Scene()
    scene.add_articulated("scale", scale(2e5))
    read = -2e5 * hp.simulate(jump, scene, body=BODY, settings=WEIGHT).joints["scale/spring"]
    plate = 5.0 * G
    assert read[leaves] - plate == pytest.approx(mass() * G, rel=0.02)
    assert np.abs(read[leaves + 6 : leaves + 20] - plate).max() < 0.02 * mass() * G


def test_a_load_comes_without_a_jump():
    """In 60 ms, and no more than the weight on the way: on a stiff scale."""
    scene = hp.Scene()
    scene.add_articulated("scale", scale(2e6, 1.0))
    result = hp.simulate(standing(60, 240.0), scene, body=BODY, settings=WEIGHT)
    read = -2e6 * result.joints["scale/spring"] / (mass() * G)
    assert read[2] < 0.4
    assert read[18] > 0.9
    assert read.max() < 1.03
    assert np.diff(read).max() < 0.25


def test_a_sleeping_box_wakes_and_carries():
    scene = hp.Scene()
    scene.add_object(
        "box", hp.Box((1.0, 1.0, 0.1)), mass=5.0, position=(0.0, 0.0, 1.0), start="asleep"
    )
    scene.add_static("floor", hp.Plane())
    result = hp.simulate(standing(top=1.05), scene, body=BODY, settings=WEIGHT)
    assert result.objects["box"].position[-1, 2] < 0.2
    away = hp.simulate(standing(at=(5.0, 0.0)), scene, body=BODY, settings=WEIGHT)
    assert (away.objects["box"].position[:, 2] == 1.0).all()


def test_a_saved_state_goes_on_to_the_bit():
    scene = hp.Scene()
    scene.add_articulated("scale", scale(2e4))
    motion = standing(40)
    sim = hp.Simulator(scene, body=BODY, settings=WEIGHT)
    ends = []
    for stop in (40, 3):
        sim.reset(motion[0])
        for t in range(1, 40):
            if t == stop:
                state = sim.get_state()
                sim.step(motion[0])
                sim.set_state(state)
            frame = sim.step(motion[t])
        ends.append((frame.joints["scale/spring"], frame.pose.translation))
    assert np.array_equal(ends[0][0], ends[1][0])
    assert np.array_equal(ends[0][1], ends[1][1])


@pytest.mark.parametrize("box_mass", [0.5, 50.0])
def test_the_floor_under_a_box_carries_the_box_and_the_person(box_mass):
    fps, g = 60.0, G
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    box = hp.Box((1.0, 1.0, 0.3))
    scene.add_object("box", box, mass=box_mass, position=(0.0, 0.0, 0.1512))
    motion = standing(120, fps, top=0.3012)
    result = hp.simulate(motion, scene, body=BODY, settings=WEIGHT)
    touches = result.contacts
    up = np.zeros(120)
    np.add.at(up, touches.frame, touches.impulse[:, 2])
    force = np.abs(up[30:]) * fps
    assert force.mean() == pytest.approx((box_mass + mass()) * g, rel=0.02)
    assert np.ptp(result.objects["box"].position[30:], axis=0).max() < 1e-5
    assert not len(result.breaches)


def test_static_ground_takes_its_share():
    """One foot on a scale, one on the floor, the centre of mass in the middle."""
    scene = hp.Scene()
    scene.add_articulated("scale", scale())
    scene.add_static("floor", hp.Box((1.0, 1.0, 0.05)), position=(0.81, 0.0, -0.025))
    result = hp.simulate(standing(at=(0.3, 0.0)), scene, body=BODY, settings=WEIGHT)
    read = -2e5 * result.joints["scale/spring"][-1] - 5.0 * G
    # 2 %: the body's left is not quite its right.
    assert read == pytest.approx(0.5 * mass() * G, rel=0.02)


def test_what_a_trajectory_moves_has_no_load_and_goes_on():
    rise = np.linspace(0.0, 0.05, 90)[:, None] * [0.0, 0.0, 1.0] - [0.0, 0.0, 0.05]
    scene = hp.Scene()
    lift = scene.add_moving("lift", hp.Box((1.0, 1.0, 0.1)), rise, fps=60.0)
    result = hp.simulate(standing(), scene, body=BODY, settings=WEIGHT)
    place = lift.at(np.arange(90) / 60.0)[0]
    assert np.abs(result.objects["lift"].position - place).max() < 1e-9
