"""Scenes: their contents, refused values, and material pairs."""

from __future__ import annotations

import copy
import pickle
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

import halfphysics as hp
from halfphysics.errors import FileError, HalfPhysicsWarning, InputError
from halfphysics.geometry.shapes import Box, Mesh, Plane, Sphere
from halfphysics.results.overview import scene_lines
from halfphysics.scene.scene import Scene


def test_a_small_scene() -> None:
    scene = Scene()
    floor = scene.add_static("floor", Plane())
    ball = scene.add_object(
        "ball", Sphere(0.11), mass=0.43, friction=0.6, position=(1, 0, 0.11), velocity=(0, 2, 0)
    )
    np.testing.assert_array_equal(scene.gravity, [0.0, 0.0, -9.81])
    assert (list(scene.statics), list(scene.objects)) == (["floor"], ["ball"])
    assert scene.statics["floor"] is floor
    assert scene.objects["ball"] is ball
    assert (floor.friction, floor.restitution, floor.source) == (1.0, 0.0, None)
    assert ball.mass == 0.43
    np.testing.assert_allclose(ball.inertia, 0.4 * 0.43 * 0.11**2 * np.eye(3))
    np.testing.assert_array_equal(ball.velocity, [0.0, 2.0, 0.0])
    np.testing.assert_array_equal(ball.quaternion, [1.0, 0.0, 0.0, 0.0])
    for array in (ball.position, ball.com, ball.inertia, floor.position, scene.gravity):
        assert not array.flags.writeable
    with pytest.raises(TypeError):
        scene.objects["other"] = ball  # type: ignore[index]
    vertices, faces = ball.mesh()
    np.testing.assert_allclose(np.linalg.norm(vertices, axis=1), 0.11)
    assert faces.max() < len(vertices)


class Shared:
    """An array of another library that has `__dlpack__` alone."""

    def __init__(self, numbers: list[float]) -> None:
        self._array = np.array(numbers)

    def __dlpack__(self, **options: object) -> object:
        return self._array.__dlpack__(**options)

    def __dlpack_device__(self) -> object:
        return self._array.__dlpack_device__()


def test_gravity() -> None:
    np.testing.assert_array_equal(Scene(gravity=0).gravity, np.zeros(3))
    np.testing.assert_array_equal(Scene(gravity=(0, -9.81, 0)).gravity, [0, -9.81, 0])
    np.testing.assert_array_equal(Scene(gravity=np.array([1.0, 2, 3])).gravity, [1, 2, 3])
    np.testing.assert_array_equal(Scene(gravity=Shared([0.0, 0.0, -1.6])).gravity, [0, 0, -1.6])
    for bad in (-9.81, np.nan, "9.81", (1, 2), (0, 0, np.nan), None, [[1], [1, 2]]):
        with pytest.raises(InputError, match="Scene: gravity"):
            Scene(gravity=bad)  # type: ignore[arg-type]


def test_copies_stand_alone() -> None:
    scene = Scene()
    scene.add_object("ball", Sphere(0.1), mass=1)
    scene.ignore("ball", "person")
    for other in (copy.deepcopy(scene), pickle.loads(pickle.dumps(scene))):
        other.add_static("floor", Plane())
        assert other.ignores("ball", "person")
    assert "floor" not in scene.statics


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"mass": -1}, r"object 'x': mass: expected a number above 0 \[kg\], found -1"),
        ({"mass": 0}, "mass"),
        ({"mass": float("nan")}, "mass: .* found nan"),
        ({"mass": "5"}, "mass: .* found '5'"),
        ({}, "mass= .* or density= .*neither"),
        ({"mass": 1, "density": 2}, "both, 1 and 2"),
        ({"density": -2}, "density"),
        ({"mass": 1, "friction": -0.1}, "friction"),
        ({"mass": 1, "restitution": 1.5}, "restitution: expected a number from 0 to 1"),
        ({"mass": 1, "position": (0, 0)}, "position: expected 3 finite numbers"),
        ({"mass": 1, "position": (0, 0, np.inf)}, "position"),
        ({"mass": 1, "quaternion": (0, 0, 0, 0)}, "quaternion: .*zero length"),
        ({"mass": 1, "quaternion": (1, 0, 0)}, "quaternion: expected 4"),
        ({"mass": 1, "velocity": "fast"}, "velocity"),
        ({"mass": 1, "angular_velocity": (1, 2)}, "angular_velocity"),
        ({"mass": 1, "com": (1, 2, np.nan)}, "com"),
        ({"mass": 1, "scale": 2.0}, "scale and up are for meshes"),
        ({"mass": 1, "up": "y"}, "scale and up are for meshes"),
        ({"mass": 1, "up": "x"}, "up: expected 'y', 'z'"),
        ({"mass": 1, "scale": 0}, "scale"),
    ],
)
def test_impossible_objects_leave_no_trace(options: dict[str, Any], message: str) -> None:
    scene = Scene()
    with pytest.raises(InputError, match=message):
        scene.add_object("x", Sphere(0.1), **options)
    assert not scene.objects
    scene.add_object("x", Sphere(0.1), mass=1)


@pytest.mark.parametrize("name", ["", "  ", 3, None, "a/b", "a\nb", "person"])
def test_names_refused(name: Any) -> None:
    with pytest.raises(InputError, match="name"):
        Scene().add_static(name, Plane())


def test_names_are_unique() -> None:
    scene = Scene()
    scene.add_static("a", Plane())
    scene.add_object("b", Sphere(1), mass=1)
    for name, kind in (("a", "a static"), ("b", "an object")):
        with pytest.raises(InputError, match=f"{kind} of this name already"):
            scene.add_object(name, Sphere(1), mass=1)
        with pytest.raises(InputError, match=f"{kind} of this name already"):
            scene.add_static(name, Plane())


@pytest.mark.parametrize("shape", [None, 3.0, (1, 2, 3), object(), Sphere])
def test_unknown_shapes(shape: Any) -> None:
    with pytest.raises(InputError, match="as shape, expected Plane, Box, Sphere"):
        Scene().add_static("x", shape)


def test_planes_do_not_move_and_flat_meshes_neither() -> None:
    with pytest.raises(InputError, match="Plane has no volume"):
        Scene().add_object("x", Plane(), mass=1)
    with pytest.raises(InputError, match=r"object 'x': .* no volume"):
        Scene().add_object("x", Mesh(np.eye(3), np.array([[0, 1, 2]])), mass=1)
    with pytest.raises(FileError, match="no such file"):
        Scene().add_object("x", "nowhere.obj", mass=1)


def test_pose_is_normalised_and_com_can_be_given() -> None:
    box = Scene().add_object(
        "x", Box((1, 1, 1)), density=100, quaternion=(0, 0, 0, 2), com=(0.1, 0, 0)
    )
    np.testing.assert_array_equal(box.quaternion, [0, 0, 0, 1])
    np.testing.assert_array_equal(box.com, [0.1, 0, 0])
    np.testing.assert_allclose(box.inertia, 100 / 6 * np.eye(3))


def test_convex_mesh_moves_as_it_is() -> None:
    vertices, faces = Box((0.2, 0.4, 0.6)).triangles()
    thing = Scene().add_object("x", Mesh(vertices + 1.0, faces), density=1000)
    assert thing.mass == pytest.approx(48.0)
    np.testing.assert_allclose(thing.com, 1.0)
    expected = 48 * Box((0.2, 0.4, 0.6)).unit_inertia()
    np.testing.assert_allclose(thing.inertia, expected, atol=1e-14)
    assert isinstance(thing.shape, Mesh)
    assert len(thing.shape.vertices) == 8


def test_solids_that_share_an_edge_move_as_two_pieces() -> None:
    v, f = Box((2.0, 1.0, 1.0)).triangles()
    w, g = Box((1.0, 1.0, 1.0)).triangles()
    step = Mesh(np.vstack([v, w + np.array([-0.5, 0.0, 1.0])]), np.vstack([f, g + len(v)]))
    thing = Scene().add_object("x", step, density=10)
    assert thing.mass == pytest.approx(30.0)
    assert thing.visual is step
    assert thing.decomposition is not None
    assert sorted(p.volume for p in thing.pieces) == pytest.approx([1.0, 2.0])
    assert thing.decomposition.outside_mm == thing.decomposition.inside_mm == 0.0
    hull = Scene().add_object("x", step, density=10, pieces="hull")
    assert hull.mass == pytest.approx(30.0)  # the mesh's own, not its hull's
    assert hull.shape.volume == pytest.approx(3.5)


def test_an_open_mesh_needs_a_mass() -> None:
    v, f = Box((2.0, 1.0, 1.0)).triangles()
    with pytest.raises(InputError, match=r"object 'x': the mesh is not a closed.*expected mass="):
        Scene().add_object("x", Mesh(v, f[1:]), density=10)
    with pytest.warns(
        HalfPhysicsWarning, match="not a closed surface.*spread over its hull"
    ) as got:
        open_ = Scene().add_object("x", Mesh(v, f[1:]), mass=20)
    assert [warning.filename for warning in got] == [__file__]
    np.testing.assert_allclose(
        open_.inertia, 20.0 * Box((2.0, 1.0, 1.0)).unit_inertia(), atol=1e-12
    )


def test_trimesh_objects() -> None:
    trimesh = pytest.importorskip("trimesh")
    box = trimesh.creation.box((1, 2, 3))
    static = Scene().add_static("x", box, scale=0.1, up="y")
    np.testing.assert_allclose(np.ptp(static.mesh()[0], axis=0), [0.1, 0.3, 0.2])
    scene = trimesh.Scene([box])
    scene.add_geometry(box, transform=trimesh.transformations.translation_matrix([5, 0, 0]))
    both = Scene().add_static("x", scene)
    np.testing.assert_allclose(both.mesh()[0].max(axis=0), [5.5, 1.0, 1.5])
    with pytest.raises(InputError, match="static 'x': Mesh: found no triangles"):
        Scene().add_static("x", trimesh.Trimesh())


def test_real_mesh_stands_upright(shared_data: Path) -> None:
    path = shared_data / "meshes" / "kaykit_furniture" / "chair_A.obj"
    chair = Scene().add_static("chair", path, scale=0.7, up="y")
    vertices, _ = chair.mesh()
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    assert low[2] == pytest.approx(0.0, abs=0.02)
    assert 0.6 < high[2] < 1.5
    assert high[2] > high[:2].max()
    assert chair.source is not None
    assert (chair.source.path, chair.source.up) == (str(path.resolve()), "y")


def test_friction_restitution_and_ignoring() -> None:
    scene = Scene()
    scene.add_static("floor", Plane(), friction=0.9, restitution=0.3)
    scene.add_object("ball", Sphere(0.1), mass=1, restitution=0.5)
    assert scene.friction_of("ball", "floor") == 0.8
    assert scene.friction_of("floor", "person") == 0.9
    assert scene.friction_of("person", "person") == 1.0
    scene.friction("ball", "person", 0.1)
    assert scene.friction_of("person", "ball") == 0.1
    scene.friction("person", "ball", 1.7)
    assert scene.friction_pairs == (("ball", "person", 1.7),)
    assert scene.restitution_of("floor", "ball") == 0.5
    assert scene.restitution_of("person", "floor") == 0.3
    scene.ignore("floor", "ball")
    assert scene.ignores("ball", "floor")
    assert not scene.ignores("ball", "person")
    assert scene.ignored_pairs == (("ball", "floor"),)


def test_pairs_name_what_is_there() -> None:
    scene = Scene()
    scene.add_object("ball", Sphere(0.1), mass=1)
    with pytest.raises(InputError, match=r"'bal'; did you mean 'ball'.*It has: ball, person"):
        scene.friction("bal", "person", 0.5)
    with pytest.raises(InputError, match="nothing called 'floor'"):
        scene.ignore("ball", "floor")
    with pytest.raises(InputError, match="twice"):
        scene.friction("ball", "ball", 0.5)
    with pytest.raises(InputError, match="friction between 'ball' and 'person'"):
        scene.friction("ball", "person", -0.5)


def test_what_is_soft_keeps_its_surface_and_has_a_frame():
    scene = hp.Scene()
    bed = scene.add_static("bed", hp.Box((2.0, 1.0, 0.4)), soft=hp.Soft(0.1, 1e5))
    assert bed.shape == hp.Box((2.0, 1.0, 0.4))
    assert bed.frame.size == pytest.approx((1.8, 0.8, 0.2))
    thin = scene.add_static("pad", hp.Box((1.0, 1.0, 0.1)), soft="sofa")
    assert thin.soft.thickness == pytest.approx(0.045)  # as much as fits
    hard = scene.add_static("floor", hp.Plane())
    assert hard.soft is hard.soft_frame is None
    assert hard.frame is hard.shape


def test_the_pieces_of_a_soft_object_are_those_of_its_frame():
    scene = hp.Scene()
    ball = scene.add_object("ball", hp.Sphere(0.11), mass=0.4, soft=hp.Soft(0.05, 1e5))
    assert ball.pieces == (hp.Sphere(0.06),)
    assert ball.inertia == pytest.approx(0.4 * 0.4 * 0.11**2 * np.eye(3))  # of all of it
    cushion = scene.add_object(
        "cushion", trimesh.creation.box((0.5, 0.4, 0.2)), mass=1, soft="sofa"
    )
    (piece,) = cushion.pieces
    # A box of 12 triangles is as thin as 20 cm: 45 % of it is soft on either side.
    assert np.ptp(piece.triangles()[0], axis=0)[2] == pytest.approx(0.02, abs=0.01)


def test_a_soft_mesh_cannot_be_open_or_bring_its_own_pieces():
    scene, box = hp.Scene(), trimesh.creation.box((1.0, 1.0, 1.0))
    with pytest.raises(InputError, match="found pieces= and soft="):
        scene.add_object("a", box, mass=1.0, pieces=[box], soft="sofa")
    sheet = trimesh.Trimesh(box.vertices, box.faces[:-2])
    with pytest.raises(InputError, match="not a closed surface, so no frame can be put inside"):
        scene.add_object("b", sheet, mass=1.0, soft="sofa")
    with pytest.raises(InputError, match="object 'c': soft: found 5"):
        scene.add_object("c", hp.Sphere(0.1), mass=1.0, soft=5)
    assert not scene.objects


def test_the_lines_of_a_scene_say_what_is_soft():
    scene = hp.Scene()
    scene.add_static("mat", hp.Plane(), soft="mat")
    scene.add_object("ball", hp.Sphere(0.1), mass=1.0, soft=hp.Soft(0.03, 1e5))
    mat, ball, _ = scene_lines(scene)
    assert mat.endswith(", soft for 100 mm")
    assert "soft for 30 mm at (0.00, 0.00, 0.00) m" in ball


@pytest.mark.parametrize("kind", ["overlapping", "inside out", "hollow", "apart"])
def test_parts_whose_mass_is_not_that_of_what_is_inside_are_warned_of(kind):
    box = trimesh.creation.box((1.0, 1.0, 1.0))
    size, away, turned = {
        "overlapping": (1.0, 0.5, False),
        "inside out": (0.9, 3.0, True),
        "hollow": (0.5, 0.0, True),
        "apart": (0.9, 3.0, False),
    }[kind]
    other = trimesh.creation.box((size, size, size))
    other.apply_translation((away, 0.0, 0.0))
    if turned:
        other.invert()
    mesh = trimesh.util.concatenate([box, other])
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        Scene().add_object("odd", mesh, density=100.0, pieces=[box])
    odd = any("parts of the mesh overlap or are inside out" in str(one.message) for one in said)
    assert odd == (kind in ("overlapping", "inside out"))
