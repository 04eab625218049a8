"""Scenes in many variants: the effect of each factor, and no other effect."""

import numpy as np
import pytest
import trimesh

import halfphysics as hp
from halfphysics import scenarios
from halfphysics.base.rotations import rotate
from halfphysics.errors import InputError
from halfphysics.sweep.make.scene_factors import SceneFactors

QUARTER = (np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5))


def varied(scene, **factors):
    """With "__" for "." in the names of factors."""
    return SceneFactors().varied(scene, {k.replace("__", "."): v for k, v in factors.items()})


@pytest.fixture
def scene():
    made = hp.Scene(gravity=9.0)
    made.add_static("floor", hp.Plane())
    made.add_static("table", hp.Box((1.0, 0.8, 0.7)), position=(1.0, 0.0, 0.35))
    made.add_object("cup", hp.Cylinder(0.04, 0.1), mass=0.2, position=(1.2, 0.1, 0.75))
    made.add_object(
        "ball", hp.Sphere(0.1), mass=1.0, friction=0.3, position=(3.0, 0.0, 0.1), velocity=(1, 0, 0)
    )
    made.friction("ball", "floor", 0.25)
    made.ignore("cup", "person/head")
    return made


def test_the_scene_given_is_left_alone(scene):
    before = scene.objects["ball"], scene.statics["table"], scene.friction_pairs
    made = varied(scene, objects__mass=3.0, statics__friction=0.1, objects__friction=0.7)
    assert (scene.objects["ball"], scene.statics["table"], scene.friction_pairs) == before
    assert made is not scene
    made.add_object("new", hp.Sphere(0.1), mass=1.0)
    assert "new" not in scene.objects


def test_what_no_factor_names_is_shared(scene):
    made = varied(scene, object__ball__mass=3.0)
    assert made.objects["cup"] is scene.objects["cup"]
    assert made.statics["table"] is scene.statics["table"]
    assert made.gravity.tolist() == scene.gravity.tolist()
    assert made.friction_pairs == scene.friction_pairs
    assert made.ignored_pairs == scene.ignored_pairs
    assert list(made.objects) == list(scene.objects)


def test_mass_scales_inertia_as_a_scene_made_with_that_mass_has_it(scene):
    made = varied(scene, objects__mass=2.5).objects["cup"]
    other = hp.Scene()
    other.add_object("cup", hp.Cylinder(0.04, 0.1), mass=2.5)
    assert made.mass == 2.5
    assert made.inertia.tolist() == other.objects["cup"].inertia.tolist()
    half = varied(scene, objects__mass_factor=0.5).objects["ball"]
    assert half.mass == 0.5
    assert np.allclose(half.inertia, 0.5 * scene.objects["ball"].inertia, rtol=1e-15)


def test_what_is_said_of_one_comes_before_what_is_said_of_all(scene):
    for order in (1, -1):
        said = {"objects.mass": 2.0, "object.cup.mass": 0.1}
        made = SceneFactors().varied(scene, dict(list(said.items())[::order]))
        assert (made.objects["cup"].mass, made.objects["ball"].mass) == (0.1, 2.0)


def test_scale_keeps_mass_and_the_foot(scene):
    made = varied(scene, object__cup__scale=1.5).objects["cup"]
    was = scene.objects["cup"]
    assert (made.shape.radius, made.shape.length) == pytest.approx((0.06, 0.15))
    assert made.mass == was.mass
    assert np.allclose(made.inertia, 1.5**2 * was.inertia, rtol=1e-14)
    assert made.position == pytest.approx([1.2, 0.1, 0.775])  # its foot at 0.7, as before


@pytest.mark.parametrize("factor", [0.8, 1.25])
@pytest.mark.parametrize(
    "shape", [hp.Sphere(0.1), hp.Capsule(0.1, 0.4), hp.Cylinder(0.1, 0.4), hp.Box((0.1, 0.3, 0.5))]
)
def test_the_lowest_point_stays_however_a_thing_lies(shape, factor):
    scene = hp.Scene()
    turn = np.array([0.3, -0.5, 0.7, 0.4]) / np.linalg.norm([0.3, -0.5, 0.7, 0.4])
    scene.add_object("thing", shape, mass=1.0, position=(0.0, 0.0, 2.0), quaternion=turn)
    thing = varied(scene, object__thing__scale=factor).objects["thing"]

    def lowest(one):
        return (rotate(one.quaternion, one.mesh()[0]) + one.position)[:, 2].min()

    # A triangulated round shape is up to 1 - cos(pi / 32) = 0.5 % of a radius smaller.
    assert lowest(thing) == pytest.approx(lowest(scene.objects["thing"]), abs=2e-3)


def test_what_stands_on_something_larger_stands_on_it_still(scene):
    made = varied(scene, static__table__scale=1.2)
    assert made.statics["table"].position[2] == pytest.approx(0.42)  # its feet on the floor
    assert made.objects["cup"].position == pytest.approx([1.2, 0.1, 0.84 + 0.05])
    assert made.objects["ball"] is scene.objects["ball"]
    both = varied(scene, static__table__scale=1.2, object__cup__scale=2.0)
    assert both.objects["cup"].position[2] == pytest.approx(0.84 + 0.1)


def test_what_stands_on_something_raised_is_raised(scene):
    scene.add_object("coin", hp.Cylinder(0.01, 0.002), mass=0.01, position=(1.2, 0.1, 0.801))
    made = varied(scene, static__table__offset_z=0.1, object__cup__scale=0.5)
    assert made.objects["cup"].position[2] == pytest.approx(0.8 + 0.025)
    assert made.objects["coin"].position[2] == pytest.approx(0.8 + 0.05 + 0.001)
    floor = varied(scene, static__floor__offset_z=-0.2)
    for name in ("cup", "ball", "coin"):
        below = scene.objects[name].position[2] - 0.2
        assert floor.objects[name].position[2] == pytest.approx(below)
    assert floor.statics["table"].position[2] == pytest.approx(0.15)


def test_sideways_nothing_is_carried(scene):
    made = varied(scene, static__table__offset_x=0.3, static__table__yaw=30.0)
    assert made.objects["cup"] is scene.objects["cup"]
    assert made.statics["table"].position == pytest.approx([1.3, 0.0, 0.35])


def test_yaw_turns_about_the_own_origin(scene):
    made = varied(scene, object__ball__yaw=90.0).objects["ball"]
    assert made.quaternion == pytest.approx(QUARTER)
    assert made.position.tolist() == scene.objects["ball"].position.tolist()
    assert made.velocity.tolist() == [1.0, 0.0, 0.0]


def test_all_statics_but_planes_are_scaled(scene):
    made = varied(scene, statics__scale=2.0)
    assert made.statics["floor"] is scene.statics["floor"]
    assert made.statics["table"].shape.size == (2.0, 1.6, 1.4)


def test_friction_reaches_pairs_of_which_the_scene_says_one(scene):
    assert varied(scene, object__ball__friction=0.9).friction_of("ball", "floor") == 0.9
    assert varied(scene, object__cup__friction=0.9).friction_of("ball", "floor") == 0.25
    both = varied(scene, objects__friction=0.9, statics__friction=0.4)
    assert both.friction_of("ball", "floor") == 0.4
    assert both.friction_of("cup", "person") == 0.9


def test_restitution(scene):
    assert varied(scene, objects__restitution=0.4).restitution_of("ball", "floor") == 0.4


def test_a_moving_thing_keeps_its_trajectory_in_its_own_frame():
    scene = hp.Scene()
    path = [(1.0, 0.0, 1.0), (2.0, 0.0, 1.0)]
    scene.add_moving("cart", hp.Box((0.2, 0.2, 0.2)), path, fps=10.0)
    made = varied(scene, object__cart__yaw=90.0, object__cart__offset_y=1.0).objects["cart"]
    assert made.positions == pytest.approx(np.array([(1.0, 1.0, 1.0), (1.0, 2.0, 1.0)]))
    assert made.velocity == pytest.approx([0.0, 10.0, 0.0])
    assert made.position == pytest.approx(made.positions[0])
    larger = varied(scene, objects__scale=2.0).objects["cart"]
    assert larger.positions[:, 2] == pytest.approx([1.1, 1.1])
    assert np.isinf(larger.mass)


def test_pieces_are_scaled_not_cut_again(monkeypatch):
    post, beam = trimesh.creation.box((0.1, 0.1, 0.4)), trimesh.creation.box((0.5, 0.1, 0.1))
    beam.apply_translation((0.1, 0.0, 0.3))
    scene = hp.Scene()
    shape = trimesh.util.concatenate([post, beam])
    scene.add_object("gibbet", shape, mass=2.0, position=(0.0, 0.0, 0.2))
    was = scene.objects["gibbet"]

    def never(*args):
        raise AssertionError("pieces were cut again")

    for name in ("decompose", "judged", "touching"):
        monkeypatch.setattr(f"halfphysics.geometry.contact_pieces.{name}", never)
    made = varied(scene, objects__scale=1.25).objects["gibbet"]
    assert len(made.pieces) == len(was.pieces) == 2
    for small, large in zip(was.pieces, made.pieces, strict=True):
        assert np.array_equal(large.vertices, 1.25 * small.vertices)
    assert made.decomposition.outside_mm == 1.25 * was.decomposition.outside_mm
    assert made.cut.threshold == 1.25 * was.cut.threshold
    assert np.allclose(made.inertia, 1.25**2 * was.inertia, rtol=1e-12)
    assert np.allclose(made.com, 1.25 * was.com, rtol=1e-12, atol=1e-15)
    assert made.position == pytest.approx([0.0, 0.0, 0.25])


def test_meshes_are_named_by_file_hash_and_scale(tmp_path):
    path = tmp_path / "stone.ply"
    trimesh.creation.icosphere(subdivisions=1, radius=0.1).export(path)
    scene = hp.Scene()
    scene.add_object("stone", path, mass=1.0, scale=2.0, position=(0.0, 0.0, 0.2))
    made = varied(scene, objects__scale=1.5)
    assert made.objects["stone"].source.scale == 3.0
    assert made.objects["stone"].source.sha256 == scene.objects["stone"].source.sha256
    made.save(tmp_path / "made.yaml")
    again = hp.Scene.load(tmp_path / "made.yaml").objects["stone"]
    assert again.mesh()[0] == pytest.approx(made.objects["stone"].mesh()[0])
    assert again.inertia == pytest.approx(made.objects["stone"].inertia)


def test_articulated_things_stay_and_are_carried():
    scene = scenarios.load("open_laptop").scene
    (name,) = scene.articulated
    table = next(n for n, s in scene.statics.items() if not isinstance(s.shape, hp.Plane))
    made = varied(scene, statics__friction=0.2)
    assert made.articulated[name] is scene.articulated[name]
    raised = varied(scene, **{f"static__{table}__offset_z": 0.1})
    lift = raised.articulated[name].position - scene.articulated[name].position
    assert lift == pytest.approx([0.0, 0.0, 0.1])


def test_a_size_is_made_once(scene):
    factors = SceneFactors()
    first = factors.varied(scene, {"object.cup.scale": 1.1}).objects["cup"].shape
    assert factors.varied(scene, {"object.cup.scale": 1.1}).objects["cup"].shape is first


@pytest.mark.parametrize(
    ("factor", "value", "said"),
    [
        ("object.bal.mass", 1.0, r"no object called 'bal'; did you mean 'ball'.*cup, ball"),
        ("static.cup.yaw", 1.0, r"no static called 'cup'.*statics: floor, table"),
        ("static.floor.scale", 2.0, r"'floor' is a plane, which has no size"),
        ("object.ball.mas", 1.0, r"did you mean mass"),
        ("objects.mass", -1.0, r"objects.mass: found -1.0, expected a number above 0"),
        ("objects.friction", "rough", r"found 'rough', expected a number"),
        ("statics.restitution", 1.5, r"of at most 1"),
    ],
)
def test_a_factor_that_cannot_be_is_an_error_that_says_what_can(scene, factor, value, said):
    with pytest.raises(InputError, match=said):
        SceneFactors().varied(scene, {factor: value})


def test_a_factor_of_nothing_is_an_error():
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    with pytest.raises(InputError, match=r"has no object.*statics: floor"):
        varied(scene, objects__mass=1.0)
    with pytest.raises(InputError, match="has no static of which that can be said"):
        varied(scene, statics__scale=2.0)
    scene.add_moving("cart", hp.Sphere(0.1), [(0.0, 0.0, 1.0)], fps=1.0)
    with pytest.raises(InputError, match="is kinematic"):
        varied(scene, object__cart__mass=1.0)


def test_a_table_of_a_top_and_legs_stays_one():
    scene = scenarios.load("close_laptop").scene
    made = varied(scene, statics__scale=1.2)
    leg = made.statics["table_leg_near_left"]
    top = made.statics["table"]
    height = leg.position[2] + 0.5 * leg.shape.size[2]
    assert top.position[2] - 0.5 * top.shape.size[2] == pytest.approx(height)
    surface = top.position[2] + 0.5 * top.shape.size[2]
    was = scene.statics["table"]
    gap = scene.articulated["laptop"].position[2] - was.position[2] - 0.5 * was.shape.size[2]
    assert made.articulated["laptop"].position[2] - surface == pytest.approx(gap)
