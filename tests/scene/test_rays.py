"""Rays: primitives against their distance functions, triangles against linear equations."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.errors import InputError
from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Mesh, Plane, Sphere
from halfphysics.scene.scene import Scene
from halfphysics.simulation.simulator import Simulator
from support.people import t_pose

EXACT = 1e-12
PRIMITIVES = (Box((0.4, 0.6, 1.0)), Sphere(0.4), Capsule(0.3, 0.7), Cylinder(0.35, 0.9))
PLACE, TURN = np.array([0.3, -0.2, 1.1]), rot.exp([0.4, 1.0, -0.3])


def rays(count, seed=0):
    """Towards the shape, past it, and from inside it."""
    rng = np.random.default_rng(seed)
    origin = PLACE + rng.normal(size=(count, 3)) * rng.choice([0.05, 2.0], size=(count, 1))
    aim = PLACE + 0.4 * rng.normal(size=(count, 3))
    return origin, aim - origin


def signed(shape, points):
    """Distance from the surface, negative inside: an independent copy of the formulas."""
    p = np.abs(points)
    if isinstance(shape, Sphere):
        return np.linalg.norm(p, axis=-1) - shape.radius
    if isinstance(shape, Capsule):
        z = np.maximum(p[..., 2] - shape.length / 2, 0.0)
        return np.sqrt(p[..., 0] ** 2 + p[..., 1] ** 2 + z**2) - shape.radius
    if isinstance(shape, Cylinder):
        q = np.stack([np.hypot(p[..., 0], p[..., 1]) - shape.radius, p[..., 2] - shape.length / 2])
    else:
        q = np.moveaxis(p - np.asarray(shape.size) / 2, -1, 0)
    outside = np.linalg.norm(np.maximum(q, 0.0), axis=0)
    return outside + np.minimum(q.max(axis=0), 0.0)


def first(vertices, faces, o, d):
    """Distance to the first triangle that the ray o + t d hits; inf: none."""
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    matrix = np.stack([b - a, c - a, np.broadcast_to(-d, a.shape)], axis=2)
    regular = np.abs(np.linalg.det(matrix)) > 1e-15
    matrix, a = matrix[regular], a[regular]
    s, r, t = np.linalg.solve(matrix, (o - a)[..., None])[..., 0].T
    inside = (s >= 0) & (r >= 0) & (s + r <= 1) & (t >= 0)
    return t[inside].min(initial=np.inf) * np.linalg.norm(d)


@pytest.mark.parametrize("shape", PRIMITIVES, ids=lambda s: type(s).__name__)
def test_a_hit_is_on_the_surface_and_nothing_is_before_it(shape):
    scene = Scene()
    scene.add_static("thing", shape, position=PLACE, quaternion=TURN)
    seen = 0
    for o, d in zip(*rays(400), strict=True):
        unit = d / np.linalg.norm(d)
        hit = scene.ray(o, 7.0 * d)
        to = 10.0 if hit is None else hit.distance
        way = o + np.linspace(0.0, to, 400)[:, None] * unit
        f = signed(shape, rot.rotate(rot.conjugate(TURN), way - PLACE))
        assert (f[:-1] > -EXACT).all() or (f[:-1] < EXACT).all()  # one side of it all the way
        if hit is None:
            assert (f > 0).all()
            continue
        seen += 1
        np.testing.assert_allclose(f[-1], 0.0, atol=EXACT)
        np.testing.assert_allclose(hit.position, way[-1], atol=EXACT)
        assert hit.normal @ unit <= 0
        e = 1e-6 * np.eye(3)
        local = rot.rotate(rot.conjugate(TURN), hit.position + e - PLACE)
        back = rot.rotate(rot.conjugate(TURN), hit.position - e - PLACE)
        slope = (signed(shape, local) - signed(shape, back)) / 2e-6
        np.testing.assert_allclose(abs(slope @ hit.normal), 1.0, atol=1e-5)
    assert 100 < seen < 400


@pytest.mark.parametrize("shape", PRIMITIVES, ids=lambda s: type(s).__name__)
def test_a_mesh_is_hit_where_a_triangle_is(shape):
    mesh = Mesh(*shape.triangles())
    scene = Scene()
    scene.add_static("thing", mesh, position=PLACE, quaternion=TURN)
    vertices = rot.rotate(TURN, mesh.vertices) + PLACE
    for o, d in zip(*rays(150, seed=1), strict=True):
        hit, nearest = scene.ray(o, d), first(vertices, mesh.faces, o, d)
        assert (hit is None) == np.isinf(nearest)
        if hit is not None:
            np.testing.assert_allclose(hit.distance, nearest, atol=1e-9)
            np.testing.assert_allclose(hit.position, o + nearest * d / np.linalg.norm(d), atol=1e-9)


def test_a_plane_from_above_from_below_and_along():
    scene = Scene()
    scene.add_static("floor", Plane((0, 0, 2), 0.5))
    hit = scene.ray((1, 2, 3), (0, 0, -4))
    assert (hit.name, hit.distance) == ("floor", 2.5)
    np.testing.assert_array_equal(hit.position, [1, 2, 0.5])
    np.testing.assert_array_equal(hit.normal, [0, 0, 1])
    assert hit.part is None
    np.testing.assert_array_equal(scene.ray((1, 2, 0), (0, 0, 1)).normal, [0, 0, -1])
    assert scene.ray((1, 2, 3), (0, 0, 1)) is None
    assert scene.ray((1, 2, 3), (1, 0, 0)) is None


def test_the_nearest_of_several_and_what_is_ignored():
    scene = Scene()
    scene.add_static("far", Sphere(0.5), position=(5, 0, 0))
    scene.add_object("near", Sphere(0.5), mass=1, position=(2, 0, 0))
    scene.add_moving("lift", Box((1, 1, 1)), [[3.5, 0, 0]], fps=30)
    o, d = (0, 0, 0), (1, 0, 0)
    assert scene.ray(o, d).name == "near"
    assert scene.ray(o, d).distance == pytest.approx(1.5, abs=EXACT)
    assert scene.ray(o, d, ignore=["near"]).name == "lift"
    assert scene.ray(o, d, ignore={"near", "lift"}).name == "far"
    assert scene.ray(o, d, ignore=("near", "lift", "far")) is None
    assert Scene().ray(o, d) is None


def test_of_a_simulation_things_are_where_they_are():
    scene = Scene(gravity=0.0)
    scene.add_object(
        "crate",
        Box((0.2, 0.2, 0.2)),
        mass=1,
        com=(0.05, 0, 0),
        velocity=(0, 0, 1),
        position=(2, 0, 0),
    )
    simulator = Simulator(scene, body=[])
    simulator.reset([])
    assert simulator.ray((0, 0, 0), (1, 0, 0)).distance == pytest.approx(1.9, abs=EXACT)
    for _ in range(30):
        simulator.step([])
    assert simulator.ray((0, 0, 0), (1, 0, 0)) is None
    assert simulator.ray((0, 0, 1), (1, 0, 0)).distance == pytest.approx(1.9, abs=1e-9)
    assert scene.ray((0, 0, 0), (1, 0, 0)).name == "crate"  # at its start


def test_the_skin_of_a_person():
    body, motion = Body.default(), t_pose(np.zeros((2, 3)))
    simulator = Simulator(body=body)
    simulator.reset(motion[0])
    skin = body.vertices(motion[0])
    joints = body.joints(motion)[0]
    for joint, part in ((15, "head"), (20, "left_wrist"), (7, "left_ankle"), (18, "left_elbow")):
        target = joints[joint]
        origin = target + np.array([2.0, 0.0, 0.0])
        hit = simulator.ray(origin, target - origin)
        nearest = first(skin, body.faces, origin, target - origin)
        np.testing.assert_allclose(hit.distance, nearest, atol=1e-9)
        assert hit.name == "person"
        if joint != 15:
            assert hit.part.startswith("left_")
        else:
            assert hit.part in (part, "jaw")
    assert simulator.ray(origin, target - origin, ignore=["person"]) is None


@pytest.mark.parametrize(
    ("given", "says"),
    [
        (((0, 0), (0, 0, 1)), "origin"),
        (((0, 0, 0), (0, 0, 0)), "no length"),
        (((0, 0, 0), (0, np.inf, 0)), "direction"),
    ],
)
def test_what_is_wrong_is_said(given, says):
    with pytest.raises(InputError, match=says):
        Scene().ray(*given)


def test_names_that_are_wrong():
    scene = Scene()
    scene.add_static("floor", Plane())
    with pytest.raises(InputError, match="did you mean 'floor'"):
        scene.ray((0, 0, 1), (0, 0, -1), ignore=["flor"])
    with pytest.raises(InputError, match=r"expected a list such as \['floor'\]"):
        scene.ray((0, 0, 1), (0, 0, -1), ignore="floor")
    for wrong in (None, 3):
        with pytest.raises(InputError, match=r"ignore: found .*expected a list of names"):
            scene.ray((0, 0, 1), (0, 0, -1), ignore=wrong)
    with pytest.raises(InputError, match="there is nothing called"):
        scene.ray((0, 0, 1), (0, 0, -1), ignore=[["floor"]])
    with pytest.raises(InputError, match="reset"):
        Simulator(scene, body=[]).ray((0, 0, 1), (0, 0, -1))


CHEST = """<mujoco><worldbody><geom name="case" type="box" size=".1 .3 .3"/>
<body name="drawer" pos="0 0 1"><joint name="rail" type="slide" axis="1 0 0" range="-1 1"/>
<geom type="box" pos="0.1 0 0" size=".1 .2 .1" mass="2"/></body></worldbody></mujoco>"""


def test_links_are_hit_where_they_are():
    scene = Scene(gravity=0.0)
    scene.add_articulated("chest", CHEST, position=(2, 0, 0), joints={"rail": -0.25})
    low, high = scene.ray((0, 0, 0), (1, 0, 0)), scene.ray((0, 0, 1), (1, 0, 0))
    assert (low.name, high.name) == ("chest/world", "chest/drawer")
    assert low.distance == pytest.approx(1.9, abs=EXACT)
    assert high.distance == pytest.approx(2.0 - 0.25, abs=EXACT)
    assert scene.ray((0, 0, 1), (1, 0, 0), ignore=["chest/drawer"]) is None
    simulator = Simulator(scene, body=[])
    simulator.reset([])
    found = simulator.ray((0, 0, 1), (1, 0, 0))
    assert (found.name, found.distance) == ("chest/drawer", pytest.approx(1.75, abs=1e-9))
    assert simulator.ray((0, 0, 1), (1, 0, 0), ignore=["chest/drawer"]) is None
