"""Variants of clips and scenarios: what is simulated, and that it is nobody else's business."""

import gc
import hashlib
import tracemalloc
import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import halfphysics as hp
from halfphysics import scenarios
from halfphysics.errors import InputError
from halfphysics.sweep.plan.choices import BodyChoice, SceneChoice
from support.sweeps.sweep_variants import clip, scenario, workshop


@pytest.fixture(scope="module")
def walk(tmp_path_factory):
    """A motion file of a walk: 31 frames at 30 fps."""
    path = tmp_path_factory.mktemp("clips") / "walk.npz"
    hp.scenarios.load("walk_into_wall").motion[:31].save(path)
    return path


def bits(ready):
    """All numbers of what is simulated, as one digest."""
    digest = hashlib.sha256(repr((ready.settings, ready.sources)).encode())
    for motion in ready.motions:
        for array in (motion.translation, motion.rotations, np.array(motion.fps)):
            digest.update(np.ascontiguousarray(array).tobytes())
    for body in ready.bodies:
        digest.update(body.rest_vertices.tobytes())
    for thing in (*ready.scene.statics.values(), *ready.scene.objects.values()):
        digest.update(repr((thing.name, thing.friction, thing.restitution)).encode())
        for array in (thing.position, thing.quaternion, thing.mesh()[0]):
            digest.update(np.ascontiguousarray(array).tobytes())
    for thing in ready.scene.objects.values():
        for array in (np.array(thing.mass), thing.inertia, thing.com, thing.velocity):
            digest.update(np.ascontiguousarray(array).tobytes())
    digest.update(repr((ready.scene.friction_pairs, ready.scene.ignored_pairs)).encode())
    return digest.hexdigest()


def same(a, b):
    """Whether two results have the same numbers, bit for bit."""
    tracks = zip(a.objects.values(), b.objects.values(), strict=True)
    return (
        np.array_equal(a.motion.translation, b.motion.translation)
        and np.array_equal(a.motion.rotations, b.motion.rotations)
        and all(
            np.array_equal(x.position, y.position) and np.array_equal(x.quaternion, y.quaternion)
            for x, y in tracks
        )
        and np.array_equal(a.contacts.impulse, b.contacts.impulse)
    )


# -- what a factor does to what happens -----------------------------------------------------


def test_friction_decides_whether_the_suitcase_is_lifted():
    shop = workshop()
    heights = []
    for friction in (0.1, 0.8):
        said = {"object.suitcase.friction": friction}
        mine = shop.make(scenario("lift_suitcase", carry=1.0, shake=0.0, factors=said))
        theirs = shop.make(scenario("lift_suitcase", carry=1.0, shake=0.0, friction=friction))
        assert bits(mine) == bits(theirs)
        result = shop.run(mine)
        z = result.objects["suitcase"].position[:, 2]
        heights.append(z[75] - z[0])  # the lift ends at 2 s
        if friction == 0.1:
            assert same(result, shop.run(theirs))
    assert heights[0] < 0.02 < 0.2 < heights[1]


def test_mass_is_the_scenarios_own():
    shop = workshop()
    by_option = shop.make(scenario("kick_ball", factors={"scenario.mass": 2.0}))
    by_thing = shop.make(scenario("kick_ball", factors={"object.ball.mass": 2.0}))
    by_input = shop.make(scenario("kick_ball", mass=2.0))
    assert bits(by_option) == bits(by_thing) == bits(by_input)
    assert by_thing.scene.objects["ball"].mass == 2.0
    assert same(shop.run(by_option), shop.run(by_thing))


def test_settings_over_the_plans_over_the_scenarios():
    shop = workshop(settings={"stiffness": 0.5, "root": "recover"})
    ready = shop.make(scenario("kick_ball", factors={"settings.clearance": 0.002}))
    story = scenarios.load("kick_ball").settings
    assert (ready.settings.stiffness, ready.settings.root) == (0.5, "recover")
    assert ready.settings.clearance == 0.002
    assert ready.settings.drive_time == story.drive_time


SCALED = [
    ("kick_ball", "ball", {}),
    ("grasp_glass", "glass", {"stages": ()}),
    ("place_glass", "glass", {}),
]


def starts_inside(ready):
    simulator = hp.Simulator(
        ready.scene, body=list(ready.bodies), settings=ready.settings, fps=ready.motions[0].fps
    )
    return simulator.reset([motion[0] for motion in ready.motions]).inside


@pytest.mark.slow
@pytest.mark.parametrize(("name", "thing", "options"), SCALED)
def test_scaled_things_start_clear(name, thing, options):
    shop = workshop()
    for factor in (0.8, 1.25):
        said = {f"object.{thing}.scale": factor}
        ready = shop.make(scenario(name, factors=said, **options))
        assert len(starts_inside(ready).depth) == 0


def test_a_suitcase_larger_than_the_room_before_the_knees_starts_in_them():
    shop = workshop()
    for factor, clear in ((0.8, True), (1.0, True), (1.1, False), (1.25, False)):
        said = {"object.suitcase.scale": factor}
        ready = shop.make(scenario("lift_suitcase", carry=1.0, shake=0.0, factors=said))
        inside = starts_inside(ready)
        assert (len(inside.depth) == 0) == clear
        # On its stool it stands as it did: only the person is met.
        assert (inside.person >= 0).all()


# -- bodies ---------------------------------------------------------------------------------


def test_stature_and_betas_of_the_default_body(walk):
    shop = workshop()
    by_factor = shop.make(clip(walk, factors={"body.stature": 1.6}))
    by_choice = shop.make(clip(walk, body=BodyChoice(stature=1.6)))
    assert by_factor.bodies[0].stature == pytest.approx(1.6)
    assert by_factor.bodies[0] is by_choice.bodies[0]
    shaped = shop.make(clip(walk, factors={"body.betas.2": 1.5})).bodies[0]
    assert shaped.betas.tolist() == [0.0, 0.0, 1.5, *[0.0] * 7]
    with pytest.raises(InputError, match=r"betas\.10: the default body has 10 shape numbers"):
        shop.make(clip(walk, factors={"body.betas.10": 1.0}))


def test_a_scenario_follows_its_body():
    ready = workshop().make(scenario("kick_ball", factors={"body.stature": 1.5}))
    body = hp.Body.default(stature=1.5)
    story = scenarios.load("kick_ball", body=body)
    assert np.array_equal(ready.bodies[0].rest_vertices, body.rest_vertices)
    assert np.array_equal(ready.motions[0].translation, story.motion.translation)


def test_the_default_body_is_one(walk):
    shop = workshop()
    assert shop.make(clip(walk)).bodies[0] is hp.Body.default()
    assert shop.make(scenario("kick_ball")).bodies[0] is hp.Body.default()


def test_two_people_in_a_scenario():
    shop = workshop()
    plain = shop.make(scenario("shake_hands"))
    moved = shop.make(scenario("shake_hands", factors={"motion.yaw": 90.0}))
    assert len(plain.motions) == len(plain.bodies) == 2
    way = [
        hp_motion.translation[0] + body.rest_joints[0] @ hp_motion.axes.T
        for ready in (plain, moved)
        for hp_motion, body in zip(ready.motions, ready.bodies, strict=True)
    ]
    assert way[2] == pytest.approx(way[0])  # turned about the first person
    x, y, z = way[1] - way[0]
    assert way[3] - way[2] == pytest.approx([-y, x, z])


# -- files ----------------------------------------------------------------------------------


def test_a_file_in_its_own_scene_and_in_a_file_s(walk, tmp_path):
    scene = hp.Scene()
    scene.add_static("wall", hp.Box((0.1, 4.0, 2.5)), position=(1.0, 0.0, 1.25))
    scene.save(tmp_path / "room.yaml")
    shop = workshop()
    bare = shop.make(clip(walk, ground=False))
    assert not bare.scene.statics
    assert list(shop.make(clip(walk)).scene.statics) == ["ground"]
    room = SceneChoice(file="room.yaml", path=tmp_path / "room.yaml")
    ready = shop.make(clip(walk, scene=room, factors={"static.wall.friction": 0.1}))
    assert list(ready.scene.statics) == ["wall", "ground"]
    assert ready.scene.statics["wall"].friction == 0.1
    assert ready.sources == (
        {"path": str(walk), "sha256": hashlib.sha256(walk.read_bytes()).hexdigest()},
        {
            "path": str(tmp_path / "room.yaml"),
            "sha256": hashlib.sha256((tmp_path / "room.yaml").read_bytes()).hexdigest(),
        },
    )


def test_a_scenario_brings_its_own_scene(tmp_path):
    hp.Scene().save(tmp_path / "room.yaml")
    room = SceneChoice(file="room.yaml", path=tmp_path / "room.yaml")
    with pytest.raises(InputError, match=r"room.yaml.*brings a scene of its own"):
        workshop().make(scenario("kick_ball", scene=room))


def test_grounded_is_as_the_command_line_has_it(walk):
    ready = workshop(grounded=True).make(clip(walk, body=BodyChoice(stature=1.5)))
    motion = hp.Motion.load(walk).grounded(hp.Body.default(stature=1.5))
    assert np.array_equal(ready.motions[0].translation, motion.translation)


def test_a_variant_is_simulate_itself(walk):
    shop = workshop()
    scene = hp.Scene()
    scene.add_static("ground", hp.Plane())
    theirs = hp.simulate(hp.Motion.load(walk), scene)
    assert same(shop.run(shop.make(clip(walk))), theirs)


# -- what cannot be -------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("factors", "said"),
    [
        ({"scenario.weight": 1.0}, r"kick_ball has no such option, expected one of fps, mass"),
        ({"scenario.body": 1.0}, "no such option"),
        ({"object.suitcase.mass": 1.0}, r"no object called 'suitcase'.*objects: ball"),
        ({"settings.stiffnes": 1.0}, "did you mean stiffness"),
        ({"settings.stiffness": -1.0}, "Settings.stiffness is -1.0"),
        ({"motion.speed": 0.0}, "motion.speed: found 0.0"),
    ],
)
def test_a_factor_that_a_variant_has_nothing_for(factors, said):
    with pytest.raises(InputError, match=said):
        workshop().make(scenario("kick_ball", factors=factors))


def test_options_are_of_scenarios(walk):
    with pytest.raises(InputError, match=r"scenario.mass: .*walk.npz is a file"):
        workshop().make(clip(walk, factors={"scenario.mass": 1.0}))


# -- nothing depends on what was made before ------------------------------------------------

ROOM = """\
version: 1
statics:
  shelf: {shape: box, size: [0.4, 0.4, 0.8], position: [2.0, 1.0, 0.4]}
objects:
  vase: {shape: cylinder, radius: 0.05, length: 0.3, mass: 1.0, position: [2.0, 1.0, 0.95]}
friction: [[vase, shelf, 0.4]]
"""

THINGS = st.fixed_dictionaries(
    {},
    optional={
        "motion.speed": st.sampled_from([0.5, 1.0, 1.5]),
        "motion.fps": st.sampled_from([30.0, 40.0]),
        "motion.yaw": st.sampled_from([0.0, 30.0]),
        "motion.offset_z": st.sampled_from([0.0, 0.1]),
        "body.stature": st.sampled_from([1.5, 1.7]),
        "settings.stiffness": st.sampled_from([0.0, 2.0]),
        "objects.mass": st.sampled_from([0.5, 2.0]),
        "objects.scale": st.sampled_from([0.9, 1.1]),
        "objects.friction": st.sampled_from([0.2, 0.9]),
        "statics.yaw": st.sampled_from([0.0, 45.0]),
    },
)


@pytest.fixture(scope="module")
def variants(walk, tmp_path_factory):
    path = tmp_path_factory.mktemp("rooms") / "room.yaml"
    path.write_text(ROOM)
    room = SceneChoice(file="room.yaml", path=path)
    other = walk.with_name("other.npz")
    hp.Motion.load(walk)[5:25].save(other)
    return {
        "walk": lambda factors: clip(walk, scene=room, factors=factors),
        "other": lambda factors: clip(other, scene=room, factors=factors),
        "kick": lambda factors: scenario("kick_ball", factors=factors),
        "light": lambda factors: scenario("kick_ball", mass=0.2, factors=factors),
    }


@pytest.mark.slow
@settings(max_examples=6, deadline=None)
@given(
    chosen=st.lists(
        st.tuples(st.sampled_from(["walk", "other", "kick", "light"]), THINGS),
        min_size=2,
        max_size=6,
    ),
    data=st.data(),
)
def test_the_order_of_making_changes_nothing(variants, chosen, data):
    shop = workshop(grounded=True)
    alone = [bits(workshop(grounded=True).make(variants[name](said))) for name, said in chosen]
    order = data.draw(st.permutations(range(len(chosen))))
    for k in (*order, *reversed(order)):
        name, said = chosen[k]
        assert bits(shop.make(variants[name](said))) == alone[k]


def test_a_run_changes_nothing_for_the_next():
    shop = workshop()
    heavy = scenario("kick_ball", factors={"object.ball.mass": 5.0})
    light = scenario("kick_ball", factors={"object.ball.mass": 0.1})
    first = shop.run(shop.make(heavy))
    world = shop._world
    shop.run(shop.make(light))
    assert shop._world is world  # it was used again
    assert same(shop.run(shop.make(heavy)), first)
    assert same(workshop().run(shop.make(heavy)), first)
    limitless = scenario("kick_ball", factors={"settings.strength": None})
    shop.run(shop.make(limitless))
    assert shop._world is not world


def test_what_is_kept_stays_little(walk, tmp_path):
    shop = workshop()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for k in range(20):
            shop.make(
                clip(walk, factors={"body.stature": 1.5 + 0.01 * k, "motion.speed": 1.0 + 0.01 * k})
            )
            shop.make(scenario("kick_ball", factors={"object.ball.scale": 1.0 + 0.01 * k}))
    kept = [*vars(shop._stock).values(), *vars(shop._items).values()]
    assert sum(len(one) for one in kept) < 60


@pytest.mark.slow
def test_memory_is_flat(walk):
    shop = workshop(grounded=True)

    def made(first, count):
        for k in range(first, first + count):
            said = {"object.ball.scale": 1.0 + 0.001 * k, "motion.speed": 1.0 + 0.001 * k}
            shop.make(scenario("kick_ball", factors=said))
            shop.make(clip(walk, factors={"motion.yaw": float(k)}))
        gc.collect()
        return tracemalloc.get_traced_memory()[0]

    tracemalloc.start()
    try:
        before = made(0, 34)  # more than are kept
        assert made(34, 30) - before < 100_000
    finally:
        tracemalloc.stop()
