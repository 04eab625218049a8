"""Things at rest on a layer: how deep they sink, the pressures, and what carries them."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import fsolve

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.geometry.shapes import Box, Cylinder, Mesh, Plane, Sphere
from halfphysics.scene.scene import Scene
from support.soft import closed_forms as forms
from support.soft import winkler
from support.soft.scenes import LYING, load, on_floor, pressures, run, soft

MASS, G = 10.0, forms.G
WEIGHT = MASS * G
#: Shape, its turn, height of its origin over its lowest point [m], stiffness [Pa/m] and the force
#: at a depth [N].
THINGS = {
    "box": (Box((0.4, 0.4, 0.2)), None, 0.1, 2e4, lambda d: forms.box_force(2e4, 0.16, d)),
    "ball": (Sphere(0.15), None, 0.15, 2e5, lambda d: forms.ball_force(2e5, 0.15, d)),
    "cylinder": (
        Cylinder(0.1, 0.4),
        LYING,
        0.1,
        1e5,
        lambda d: forms.cylinder_force(1e5, 0.1, 0.4, d),
    ),
    "standing cylinder": (
        Cylinder(0.15, 0.2),
        None,
        0.1,
        5e4,
        lambda d: forms.box_force(5e4, np.pi * 0.15**2, d),
    ),
}
#: How long a heavily damped thing takes to settle [s].
SETTLED = 2.0


def settled(shape, turn, height, stiffness, damping, seconds=SETTLED, mass=MASS, **more):
    turned = {} if turn is None else {"quaternion": turn}
    layer = soft(stiffness, damping)
    return run(on_floor(layer, shape, height, mass, **turned, **more), seconds)


@pytest.fixture(scope="module")
def at_rest():
    """Runs of the four things, each until it rests."""
    return {
        name: settled(shape, turn, height, k, 0.05 * k)
        for name, (shape, turn, height, k, _) in THINGS.items()
    }


@pytest.mark.parametrize("name", THINGS)
def test_the_depth_of_the_sink(at_rest, name):
    _, _, height, _, force = THINGS[name]
    expected = forms.sink(force, WEIGHT, 0.095)
    assert height - at_rest[name].height[-1] == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize("name", THINGS)
def test_the_layer_carries_the_weight(at_rest, name):
    result = at_rest[name]
    force = load(result.frames[-10:], result.simulator.dt)
    assert force[2] == pytest.approx(WEIGHT, rel=1e-3)
    np.testing.assert_allclose(force[:2], 0.0, atol=1e-3 * WEIGHT)
    rows = pressures(result)
    assert rows.pressure @ rows.area == pytest.approx(WEIGHT, rel=1e-3)


@pytest.mark.parametrize("name", THINGS)
def test_the_profile_of_the_pressure(at_rest, name):
    """At every sample k times its depth, which is how far its hard point is under the surface."""
    shape, _, _, stiffness, _ = THINGS[name]
    result = at_rest[name]
    rows = pressures(result)
    most = rows.pressure.max()
    np.testing.assert_allclose(rows.pressure, stiffness * rows.depth, atol=0.01 * most)
    whole = rows.depth > 0.006  # not cut by the surface, which samples that stand askew may be
    np.testing.assert_allclose(rows.depth[whole], -rows.position[whole, 2], atol=1e-5)
    np.testing.assert_allclose(
        rows.normal, np.tile([0.0, 0.0, 1.0], (len(rows.depth), 1)), atol=1e-9
    )
    deepest = -(result.height[-1] - THINGS[name][2])
    centre = result.poses[-1, :3]
    away = rows.position - centre
    if isinstance(shape, Sphere):
        r = np.hypot(away[:, 0], away[:, 1])
        expected = deepest - shape.radius + np.sqrt(shape.radius**2 - r**2)
    elif name == "cylinder":
        expected = deepest - shape.radius + np.sqrt(shape.radius**2 - away[:, 0] ** 2)
    else:
        expected = np.full(len(away), deepest)
    whole &= expected > 0.006
    assert whole.sum() > 0.3 * len(whole)
    np.testing.assert_allclose(rows.pressure[whole], stiffness * expected[whole], atol=0.01 * most)


def test_the_area_under_pressure(at_rest):
    """That of the footprint, as far as samples 2 cm apart can say it."""
    area = {name: pressures(result).area.sum() for name, result in at_rest.items()}
    assert area["box"] == pytest.approx(0.16, rel=0.01)
    assert area["standing cylinder"] == pytest.approx(np.pi * 0.15**2, rel=0.02)
    depth = 0.15 - at_rest["ball"].height[-1]
    assert area["ball"] == pytest.approx(np.pi * (0.3 * depth - depth**2), rel=0.1)


@pytest.mark.parametrize("aside", [0.02, 0.05])
def test_a_weight_off_centre_tilts_the_box(aside):
    """By M / (k I_A) while the whole face is pressed."""
    size = (0.4, 0.3, 0.2)
    result = settled(Box(size), None, 0.1, 4e4, 3e3, com=(aside, 0.0, 0.0))
    turn = rot.log(result.quaternions[-1, 0])
    body, layer, still = winkler.box(MASS, size, 80), winkler.Layer(4e4), np.zeros(3)

    def out_of_balance(at):
        """Force and moment about the centre of mass, which the side that goes under adds to."""
        place = winkler.State(
            np.array([0.0, 0.0, at[0]]), rot.exp(np.array([0.0, at[1], 0.0])), still, still
        )
        force, moment, _ = winkler.pressed(body, layer, place)
        arm = aside * np.cos(at[1])
        return [force[2] - WEIGHT, moment[1] + force[2] * arm]

    angle = fsolve(out_of_balance, [0.08, 0.03])[1]
    assert turn[1] == pytest.approx(angle, rel=0.01)
    np.testing.assert_allclose(turn[[0, 2]], 0.0, atol=1e-4)
    small = forms.tilt(WEIGHT * aside, 4e4, 0.4, 0.3)
    assert turn[1] == pytest.approx(small, rel=0.2)  # as it would be if the box were flat


def test_a_load_beyond_the_thickness_ends_on_the_frame():
    """A ton on 3 cm of foam that would have to be 6 m thick: it stops within the clearance."""
    shape = Box((0.4, 0.4, 0.2))
    layer = soft(1e4, 100.0, thickness=0.03)
    for height in (0.1, 1.1):
        result = run(on_floor(layer, shape, height, 1000.0), 1.5)
        lowest = result.height - 0.1
        assert lowest.min() >= -0.03
        assert lowest[-1] == pytest.approx(-0.03, abs=0.0011)
        force = load(result.frames[-10:], result.simulator.dt)
        assert force[2] == pytest.approx(1000.0 * G, rel=1e-3)


def test_a_stiffer_layer_converges_to_the_rigid_floor():
    """A box slides and stops: the stiffer the layer, the nearer to where it ends on a hard floor.

    Without spin, which friction under the whole face stops later than friction at four corners.
    """
    start = {
        "position": (0.0, 0.0, 0.101),
        "velocity": (1.5, 0.3, 0.0),
        "friction": 0.4,
    }
    shape = Box((0.3, 0.3, 0.2))
    scene = Scene()
    scene.add_static("floor", Plane(), friction=0.4)
    scene.add_object("thing", shape, mass=MASS, **start)
    rigid = run(scene, 1.5, fps=120)
    off = []
    for stiffness in (5e4, 5e6):
        more = {k: v for k, v in start.items() if k != "friction"}
        more["position"] = (0.0, 0.0, 0.1)
        scene = on_floor(soft(stiffness, 0.02 * stiffness), shape, 0.1, friction=0.4, **more)
        end = run(scene, 1.5, fps=120).poses[-1]
        off.append(np.linalg.norm(end[:3] - rigid.poses[-1, :3]))
    way = np.linalg.norm(rigid.poses[-1, :2])
    assert off[1] < 0.01 * way
    assert off[1] < 0.35 * off[0]


#: Heights of the same block over time, foam on the floor or under itself [m].
ALIKE = 1e-6


@pytest.mark.parametrize("mass", [1.0, 50.0])
@pytest.mark.parametrize("material", ["sofa", "mattress", "pillow", "mat"])
def test_foam_carries_alike_on_the_floor_and_under_the_thing(material, mass):
    """A block of foam on a hard floor sinks as a hard one into the same foam, without a hop."""
    size, layer = (0.5, 0.5, 0.4), hp.Soft.named(material, thickness=0.1)
    under = run(on_floor(layer, Box(size), 0.2, mass), 1.0)
    thing = run(on_floor(None, Box(size), 0.2, mass, soft=layer), 1.0)
    np.testing.assert_allclose(thing.height, under.height, atol=ALIKE)
    assert thing.height.max() <= 0.2
    np.testing.assert_allclose(thing.positions[:, 0, :2], 0.0, atol=ALIKE)


@pytest.mark.parametrize("bed", ["plane", "box", "mesh"])
def test_a_wedge_whose_middle_is_beside_it_is_carried(bed):
    """The middle of the box around its corners is below the slanted face that it lies on: within
    the hard frame, and no point of it."""
    corners = 0.4 * np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    wedge = Mesh(corners, np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]))
    axis = np.cross(np.ones(3), (0.0, 0.0, -1.0)) / np.sqrt(2.0)
    turn = rot.exp(np.arccos(-1.0 / np.sqrt(3.0)) * axis)
    scene, layer = Scene(), hp.Soft(thickness=0.08, stiffness=2e5)
    block = Box((2.0, 2.0, 0.5))
    if bed == "plane":
        scene.add_static("bed", Plane(), soft=layer)
    else:
        shape = block if bed == "box" else Mesh(*block.triangles())
        scene.add_static("bed", shape, position=(0, 0, -0.25), soft=layer)
    place = -rot.rotate(turn, wedge.centre)
    place[2] = 0.005 - rot.rotate(turn, corners)[:, 2].min()
    scene.add_object("wedge", wedge, mass=MASS, position=place, quaternion=turn)
    simulator = hp.Simulator(scene, body=[], fps=30.0)
    simulator.reset([])
    for _ in range(40):
        frame = simulator.step([])
    at, turned = frame.objects["wedge"]
    lowest = (rot.rotate(turned, corners) + at)[:, 2].min()
    area = 0.5 * np.sqrt(3.0) * 0.4**2
    assert lowest == pytest.approx(-WEIGHT / (2e5 * area), rel=0.1)
