"""A reused world equals the world that its scene would make, to the last bit."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import halfphysics as hp
from halfphysics import scenarios
from halfphysics.simulation.build_world import build_world
from halfphysics.simulation.compiled_model import model_arrays
from halfphysics.simulation.simulate import follow
from halfphysics.simulation.simulator import Simulator
from halfphysics.simulation.world_cache import use_again
from support.as_it_is import as_it_is
from support.results.bits import bits

SHAPES = {
    "ball": hp.Sphere(0.1),
    "box": hp.Box((0.2, 0.3, 0.1)),
    "tin": hp.Cylinder(0.05, 0.2),
}


def room(masses=(1.0, 2.0, 0.5), frictions=(0.8, 0.8, 0.8), places=None, pairs=()):
    """A floor, a bench and three objects in the way of a walk."""
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    scene.add_static("bench", hp.Box((0.4, 1.0, 0.4)), position=(1.6, 0.0, 0.2))
    places = places or [(0.5, 0.1, 0.1), (1.6, 0.0, 0.45), (0.7, -0.2, 0.1)]
    things = zip(SHAPES.items(), masses, frictions, places, strict=True)
    for (name, shape), mass, friction, place in things:
        scene.add_object(name, shape, mass=mass, friction=friction, position=place)
    for a, b, mu in pairs:
        scene.friction(a, b, mu)
    return scene


@pytest.fixture(scope="module")
def walk():
    return scenarios.load("walk_into_wall").motion[:25]


def anew(scene, motion, chosen=None):
    return bits(hp.simulate(motion, scene, settings=chosen or hp.Settings(contact="parts")))


positive = st.floats(0.05, 20.0)
SCENES = st.fixed_dictionaries(
    {
        "masses": st.tuples(positive, positive, positive),
        "frictions": st.tuples(*[st.floats(0.0, 1.2)] * 3),
        "places": st.lists(
            st.tuples(st.floats(0.3, 1.2), st.floats(-0.3, 0.3), st.floats(0.15, 0.5)),
            min_size=3,
            max_size=3,
        ),
        "pairs": st.sampled_from([(), (("ball", "floor", 0.1),), (("person", "box", 1.5),)]),
    }
)

SETTINGS = st.fixed_dictionaries(
    {},
    optional={
        "stiffness": st.sampled_from([0.0, 3.0, {"left_hand": 0.2}]),
        "drive_time": st.sampled_from([None, 0.05]),
        "substeps": st.sampled_from([4, 9]),
        "clearance": st.sampled_from([0.0005, 0.004]),
        "root": st.sampled_from(["recover", "stay"]),
        "tolerance": st.just(1e-5),
        "record": st.just("substeps"),
    },
)
CHOICES = st.fixed_dictionaries(
    {"scene": SCENES, "settings": SETTINGS, "fps": st.sampled_from([30.0, 40.0])}
)


@settings(max_examples=8, deadline=None)
@given(chosen=st.lists(CHOICES, min_size=2, max_size=4))
def test_scenes_one_after_the_other(walk, chosen):
    how = as_it_is(contact="parts")
    simulator = Simulator(room(), settings=how, fps=walk.fps)
    kept = []
    for said in chosen:
        scene, how = room(**said["scene"]), as_it_is(contact="parts", **said["settings"])
        motion = walk.resample(said["fps"])
        assert use_again(simulator.world, scene, how)
        result = follow(simulator.world, [motion])
        assert bits(result) == anew(scene, motion, how)
        assert result.settings is how
        assert result.scene is scene
        kept.append((result, bits(result)))
    for result, was in kept:
        assert bits(result) == was  # no caller writes into returned arrays


def test_the_model_is_the_compiled_one():
    simulator = Simulator(room())
    scene = room(masses=(0.013, 70.0, 1e-3), places=[(1.0, 2.0, 3.0)] * 3)
    limp = hp.Settings(stiffness={"right_hand": 0.3})
    assert use_again(simulator.world, scene, limp)
    theirs = Simulator(scene, settings=limp).world
    mine, other = model_arrays(simulator.world.model), model_arrays(theirs.model)
    assert all(np.array_equal(mine[name], other[name]) for name in mine)
    assert simulator.world.signature == theirs.signature


@pytest.mark.parametrize("name", ["lift_suitcase", "open_drawer", "shake_hands"])
def test_scenarios_twice(name):
    story = scenarios.load(name)
    motions = [motion[:20] for motion in story.motions]
    simulator = Simulator(
        story.scene, body=list(story.bodies), settings=story.settings, fps=motions[0].fps
    )
    first = bits(follow(simulator.world, motions))
    assert use_again(simulator.world, story.scene._copied(), story.settings)
    assert bits(follow(simulator.world, motions)) == first


def test_what_sleeps_sleeps_again(walk):
    def scene(mass):
        made = room()
        made.add_object(
            "asleep", hp.Sphere(0.1), mass=mass, position=(0.6, 0.0, 0.8), start="asleep"
        )
        return made

    simulator = Simulator(scene(1.0), settings=hp.Settings(contact="parts"), fps=walk.fps)
    follow(simulator.world, [walk])
    assert use_again(simulator.world, scene(3.0), simulator.settings)
    assert bits(follow(simulator.world, [walk])) == anew(scene(3.0), walk)


def other_shape(scene):
    return scene._with({"ball": replace(scene.objects["ball"], shape=hp.Sphere(0.11))}, {})


def other_static(scene):
    bench = scene.statics["bench"]
    return scene._with({"bench": replace(bench, position=bench.position + 0.1)}, {})


def one_more(scene):
    scene = scene._copied()
    scene.add_object("more", hp.Sphere(0.1), mass=1.0)
    return scene


def of_a_part(scene):
    scene = scene._copied()
    scene.friction("person/left_foot", "floor", 0.1)
    return scene


def other_centre(scene):
    box = scene.objects["box"]
    return scene._with({"box": replace(box, com=box.com + 0.01)}, {})


def asleep(scene):
    return scene._with({"box": replace(scene.objects["box"], start="asleep")}, {})


@pytest.mark.parametrize(
    "change", [other_shape, other_static, one_more, of_a_part, other_centre, asleep]
)
def test_what_needs_a_new_world_leaves_the_old_one_alone(walk, change):
    scene = room()
    simulator = Simulator(scene, settings=hp.Settings(contact="parts"), fps=walk.fps)
    before = bits(follow(simulator.world, [walk]))
    assert not use_again(simulator.world, change(scene), simulator.settings)
    assert simulator.world.scene is scene
    assert bits(follow(simulator.world, [walk])) == before


def test_trajectories_and_poses_that_are_set_need_a_new_world():
    scene, how = room(), hp.Settings()
    pose = hp.baselines.Kinematic()
    assert not use_again(Simulator(scene, settings=pose).world, scene, pose)
    scene.add_moving("cart", hp.Sphere(0.1), [(3.0, 0.0, 1.0)], fps=1.0)
    assert not use_again(Simulator(scene).world, scene, how)


@pytest.mark.parametrize(
    "other",
    [
        {"contact": "parts"},
        {"self_contact": True},
        {"strength": None},
        {"drive_time": None},
        {"weight": False},
        {"blocked": "continue"},
        {"joint_limits": False},
        {"mode": "torque"},
        {"internal_forces": True},
        {"joint_damping": 1.0},
    ],
)
def test_settings_that_need_a_new_world(other):
    scene = room()
    simulator = Simulator(scene)
    assert not use_again(simulator.world, scene, hp.baselines.from_options(other))
    assert simulator.settings == hp.Settings() == simulator.world.settings


def test_gravity(walk):
    moon = hp.Scene(gravity=1.62)
    moon.add_object("ball", hp.Sphere(0.1), mass=1.0, position=(0.5, 0.0, 1.0))
    earth = hp.Scene()
    earth.add_object("ball", hp.Sphere(0.1), mass=1.0, position=(0.5, 0.0, 1.0))
    how = hp.Settings(contact="parts")
    simulator = Simulator(earth, settings=how, fps=walk.fps)
    assert use_again(simulator.world, moon, how)
    assert bits(follow(simulator.world, [walk])) == anew(moon, walk)


def test_another_layer_or_soft_skin_needs_a_new_world():
    def scene(soft):
        made = hp.Scene()
        made.add_static("floor", hp.Plane(), soft=soft)
        return made

    world = Simulator(scene("mat"), body=[]).world
    assert use_again(world, scene("mat"), hp.Settings())
    assert not use_again(world, scene("sofa"), hp.Settings())
    assert not use_again(world, scene(None), hp.Settings())
    assert not use_again(world, scene("mat"), hp.Settings(soft_skin=True))


@pytest.mark.parametrize("ignored", [False, True])
def test_what_may_press_a_soft_layer_needs_a_world_of_its_own(ignored):
    def bed(ignore):
        scene = hp.Scene()
        scene.add_static("bed", hp.Box((2, 2, 0.4)), position=(0, 0, 0.2), soft="mattress")
        scene.add_object("ball", hp.Sphere(0.1), mass=5.0, position=(0, 0, 0.6))
        if ignore:
            scene.ignore("ball", "bed")
        return scene

    world = build_world([], bed(ignored), hp.Settings())
    assert not use_again(world, bed(not ignored), hp.Settings())
    assert use_again(world, bed(ignored), hp.Settings())
