"""Penetration against closed forms and brute force."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from halfphysics import metrics
from halfphysics.base import rotations
from halfphysics.errors import InputError
from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Mesh, Plane, Sphere
from halfphysics.scene.scene import Scene
from support.point_bodies import Ball, Cloud, Drift, Track
from support.references.mesh_queries import closest_reference, winding_reference


@pytest.fixture
def cloud() -> Cloud:
    return Cloud(np.random.default_rng(0).uniform(-0.5, 0.5, (200, 3)))


def _line(frames: int) -> Drift:
    return Drift(np.linspace([-1.0, 0.0, 0.0], [1.0, 0.2, 0.1], frames))


def test_definitions_by_hand() -> None:
    """Four points over a floor: one dips 30 mm, another 10 mm, in one of two frames."""
    body = Cloud(np.array([[0, 0, 0.5], [0, 0, 1.0], [0, 0, 0.52], [0, 0, 2.0]]))
    motion = Drift(np.array([[0, 0, 0.0], [0, 0, -0.53]]))
    scene = Scene()
    scene.add_static("floor", Plane())
    report = metrics.penetration(motion, body, scene)
    np.testing.assert_allclose(report.share, [0.0, 50.0])
    np.testing.assert_allclose(report.deepest, [0.0, 30.0])
    assert report.rate_percent == pytest.approx(25.0)
    assert report.depth_mean_mm == pytest.approx(15.0)
    assert report.depth_max_mm == pytest.approx(30.0)
    assert report.depth_penetrating_mm == pytest.approx(20.0)
    np.testing.assert_allclose(report.by_name["floor"], [0.0, 30.0])
    clear = metrics.penetration(motion, body, Scene())
    assert (clear.rate_percent, clear.depth_max_mm, clear.depth_penetrating_mm) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("holes", [0, 1])
def test_depth_in_other_people(cloud: Cloud, holes: int) -> None:
    """Points of a cloud in another person, a ball: as in a static mesh that follows."""
    vertices, faces = Sphere(0.4).triangles()
    other, theirs = Ball(np.asarray(vertices), np.asarray(faces)[holes:]), _line(40)
    still = Drift(np.tile([0.1, 0.0, 0.0], (40, 1)))
    report = metrics.penetration(still, cloud, Scene(), people={"anna": (theirs, other)})
    assert report.deepest.max() > 100.0
    np.testing.assert_array_equal(report.deepest, report.by_name["anna"])
    for frame in (0, 13, 39):
        scene = Scene()
        mesh = Mesh(other.points, other.faces)
        scene.add_static("anna", mesh, position=theirs.translation[frame])
        same = metrics.penetration(still, cloud, scene)
        assert report.deepest[frame] == pytest.approx(same.deepest[frame], abs=1e-6)
        assert report.share[frame] == pytest.approx(same.share[frame])


@pytest.mark.parametrize(
    ("people", "message"),
    [
        ([1], r"people: expected names and pairs"),
        ({"floor": None}, r"people\['floor'\]: the scene has a thing of this name"),
        ({"anna": 3}, r"people\['anna'\]: expected a pair \(motion, body\)"),
        ({"anna": (3, 4)}, r"people\['anna'\]: expected a halfphysics\.Motion or Pose"),
    ],
)
def test_impossible_people(people: Any, message: str, cloud: Cloud) -> None:
    scene = Scene()
    scene.add_static("floor", Plane())
    with pytest.raises(InputError, match=message):
        metrics.penetration(_line(3), cloud, scene, people=people)
    with pytest.raises(InputError, match=r"expected 3 frames as of motion, found 4"):
        metrics.penetration(_line(3), cloud, scene, people={"anna": (_line(4), cloud)})


@pytest.mark.parametrize("frames", [1, 2, 32, 33, 65, 100])
def test_batches_change_nothing(frames: int, cloud: Cloud) -> None:
    motion = Drift(np.random.default_rng(1).uniform(-0.5, 0.5, (frames, 3)))
    scene = Scene()
    scene.add_static("ball", Sphere(0.4), position=(0.1, 0.0, 0.0))
    report = metrics.penetration(motion, cloud, scene)
    depth = 0.4 - np.linalg.norm(cloud.vertices(motion) - [0.1, 0.0, 0.0], axis=-1)
    np.testing.assert_allclose(report.share, 100.0 * (depth > 0).mean(axis=1))
    np.testing.assert_allclose(report.deepest, 1000.0 * np.maximum(depth.max(axis=1), 0.0))


@pytest.mark.parametrize(
    "shape",
    [Box((0.5, 0.8, 0.6)), Sphere(0.4), Capsule(0.2, 0.5), Cylinder(0.3, 0.6)],
    ids=lambda s: type(s).__name__,
)
def test_primitives_and_their_triangles_agree_anywhere(
    shape: Any, cloud: Cloud, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("halfphysics.geometry.shapes._SEGMENTS", 128)
    pose = {"position": (0.2, -0.1, 0.05), "quaternion": (0.4, -0.8, 0.3, 0.2)}
    exact, triangles = Scene(), Scene()
    exact.add_static("x", shape, **pose)
    triangles.add_static("x", Mesh(*shape.triangles()), **pose)
    a = metrics.penetration(_line(20), cloud, exact)
    b = metrics.penetration(_line(20), cloud, triangles)
    assert a.rate_percent > 1.0
    # 128 segments remove under 0.25 mm from these shapes (twice: around and along).
    np.testing.assert_allclose(a.deepest, b.deepest, atol=0.5)
    assert a.rate_percent == pytest.approx(b.rate_percent, abs=0.1)


def test_brute_force_on_a_real_mesh(shared_data: Path, cloud: Cloud) -> None:
    scene = Scene()
    path = shared_data / "meshes" / "kaykit_furniture" / "bed_single_A.obj"
    quaternion = rotations.exp([0.3, -0.2, 1.0])
    static = scene.add_static("bed", path, scale=0.7, up="y", quaternion=quaternion)
    report = metrics.penetration(_line(9), cloud, scene)
    vertices, faces = static.mesh()
    points = rotations.rotate(rotations.conjugate(quaternion), cloud.vertices(_line(9)))
    flat = points.reshape(-1, 3)
    inside = winding_reference(flat, vertices, faces) > 0.5
    inside &= ((flat >= vertices.min(axis=0)) & (flat <= vertices.max(axis=0))).all(axis=1)
    depth = np.where(inside, closest_reference(flat, vertices, faces)[0], 0.0).reshape(9, -1)
    assert inside.any()
    np.testing.assert_allclose(report.share, 100 * inside.reshape(9, -1).mean(axis=1))
    np.testing.assert_allclose(report.deepest, 1000 * depth.max(axis=1), atol=1e-9)


def test_moving_objects_and_unions(cloud: Cloud) -> None:
    frames = 40
    motion = Drift(np.zeros((frames, 3)))
    scene = Scene()
    scene.add_static("floor", Plane(offset=-0.3))
    scene.add_object("bar", Box((0.2, 0.4, 3.0)), mass=1)
    scene.add_object("far", Sphere(0.1), mass=1)
    turn = rotations.exp(np.linspace([0, 0, 0], [0, 0, 2.0], frames))
    track = Track(np.linspace([-1, 0, 0], [1, 0, 0], frames), turn)
    report = metrics.penetration(motion, cloud, scene, objects={"bar": track})
    expected = np.zeros((frames, 200))
    for i in range(frames):
        local = rotations.rotate(rotations.conjugate(turn[i]), cloud.points - track.position[i])
        gap = np.array([0.1, 0.2, 1.5]) - np.abs(local)
        floor = -0.3 - cloud.points[:, 2]
        expected[i] = np.maximum(np.maximum(gap.min(axis=1), floor), 0.0)
    np.testing.assert_allclose(report.deepest, 1000 * expected.max(axis=1), atol=1e-9)
    np.testing.assert_allclose(report.share, 100 * (expected > 0).mean(axis=1))
    assert report.depth_penetrating_mm == pytest.approx(1000 * expected[expected > 0].mean())
    assert sorted(report.by_name) == ["bar", "floor"]
    without = metrics.penetration(motion, cloud, scene)
    assert without.rate_percent < report.rate_percent
    scene.ignore("floor", "person")
    ignored = metrics.penetration(motion, cloud, scene, objects={"bar": track})
    assert sorted(ignored.by_name) == ["bar"]


def test_bad_tracks_and_threads(cloud: Cloud) -> None:
    scene = Scene()
    scene.add_object("ball", Sphere(0.1), mass=1)
    short = Track(np.zeros((3, 3)), np.tile([1.0, 0, 0, 0], (3, 1)))
    with pytest.raises(InputError, match=r"'ball': expected position \(5, 3\)"):
        metrics.penetration(_line(5), cloud, scene, objects={"ball": short})
    with pytest.raises(InputError, match="no object 'bell'; it has: ball"):
        metrics.penetration(_line(3), cloud, scene, objects={"bell": short})
    for threads in (0, 1.5, "2"):
        with pytest.raises(InputError, match="threads"):
            metrics.penetration(_line(3), cloud, scene, threads=threads)


NO_BODIES = [None, "body.npz", 3, Cloud, lambda motion: motion]


@pytest.mark.parametrize("wrong", NO_BODIES, ids=["None", "str", "int", "class", "function"])
def test_what_is_no_body_is_said(wrong: Any) -> None:
    for measure in (
        lambda: metrics.mpjpe(_line(3), _line(3), wrong),
        lambda: metrics.mpjpe_global(_line(3), _line(3), wrong),
        lambda: metrics.penetration(_line(3), wrong, Scene()),
    ):
        with pytest.raises(InputError, match=r"body: expected a halfphysics\.Body.*found "):
            measure()


def test_what_is_no_motion_scene_or_track_is_said(cloud: Cloud) -> None:
    for wrong in (None, "walk.npz", np.zeros((3, 3)), Drift):
        with pytest.raises(InputError, match=r"b: expected a halfphysics\.Motion, found"):
            metrics.mpjpe(_line(3), wrong, cloud)
        with pytest.raises(InputError, match=r"motion: expected a .*Motion or Pose, found"):
            metrics.penetration(wrong, cloud, Scene())
    for wrong in (None, "room.yaml", {}, Scene):
        with pytest.raises(InputError, match=r"scene: expected a halfphysics\.Scene, found"):
            metrics.penetration(_line(3), cloud, wrong)  # type: ignore[arg-type]
    scene = Scene()
    scene.add_object("ball", Sphere(0.1), mass=1)
    with pytest.raises(InputError, match="objects: expected names and tracks"):
        metrics.penetration(_line(3), cloud, scene, objects=["ball"])  # type: ignore[arg-type]
    with pytest.raises(InputError, match="objects: 'ball': expected a track with position"):
        metrics.penetration(_line(3), cloud, scene, objects={"ball": np.zeros((3, 3))})


def _subdivided(path: Path, least: int) -> Scene:
    trimesh = pytest.importorskip("trimesh")
    mesh = trimesh.load(path, force="mesh")
    while len(mesh.faces) < least:
        mesh = mesh.subdivide()
    scene = Scene()
    scene.add_static("furniture", mesh, scale=0.7, up="y")
    return scene


@pytest.mark.slow
@pytest.mark.parametrize("name", ["couch", "cabinet_medium"])
def test_the_same_with_threads(shared_data: Path, name: str) -> None:
    """10,000 vertices against 10k triangles for 30 frames; a closed and an open mesh."""
    scene = _subdivided(shared_data / "meshes" / "kaykit_furniture" / f"{name}.obj", 10_000)
    low, high = scene.statics["furniture"].shape.query.bounds  # type: ignore[attr-defined]
    points = np.random.default_rng(0).uniform(low, high, (10_000, 3))
    # Neighbours in a skin's list are neighbours in space: sorted by cells of 5 cm.
    points = points[np.lexsort(np.floor(points / 0.05).T)]
    motion = Drift(np.linspace(-0.3, 0.3, 30)[:, None] * [1.0, 0.0, 0.0])
    one = metrics.penetration(motion, Cloud(points), scene)
    two = metrics.penetration(motion, Cloud(points), scene, threads=2)
    assert one.rate_percent > 20.0
    assert (one.rate_percent, one.depth_mean_mm) == (two.rate_percent, two.depth_mean_mm)
    np.testing.assert_array_equal(one.deepest, two.deepest)


def test_frames_beside_a_solid_are_passed_over_and_change_no_bit() -> None:
    """Things that people pass, and moving ones that pass them, as if every point were looked at."""
    rng = np.random.default_rng(5)
    body, frames = Cloud(rng.uniform(-0.5, 0.5, (300, 3))), 60
    motion = _line(frames)
    turn = rotations.exp(np.array([0.3, -0.5, 0.7]))
    scene = Scene()
    shapes = [Box((0.2, 0.3, 0.4)), Sphere(0.2), Capsule(0.1, 0.3), Cylinder(0.1, 0.4)]
    vertices, faces = Box((0.3, 0.2, 0.2)).triangles()
    shapes += [Mesh(vertices, faces), Mesh(vertices, faces[:-2]), Plane((0.0, 0.6, 0.8), -0.6)]
    places = rng.uniform(-1.4, 1.4, (len(shapes), 3)) * [1.0, 0.3, 0.3]
    for k, (shape, place) in enumerate(zip(shapes, places, strict=True)):
        scene.add_static(f"static{k}", shape, position=place, quaternion=turn)
    scene.add_object("ball", Sphere(0.15), mass=1.0)
    path = np.linspace([0.2, 2.0, 0.0], [0.2, -2.0, 0.1], frames)
    tracks = {"ball": Track(path, np.tile(turn, (frames, 1)))}
    report = metrics.penetration(motion, body, scene, objects=tracks)
    points = body.vertices(motion)
    for k, (shape, place) in enumerate(zip(shapes, places, strict=True)):
        local = (points - place) @ rotations.to_matrix(turn)
        depth = shape.depth(local.reshape(-1, 3)).reshape(local.shape[:2])
        np.testing.assert_array_equal(report.by_name[f"static{k}"], 1000.0 * depth.max(axis=1))
    ball = (points - path[:, None]) @ rotations.to_matrix(np.tile(turn, (frames, 1)))
    depth = Sphere(0.15).depth(ball.reshape(-1, 3)).reshape(ball.shape[:2])
    np.testing.assert_array_equal(report.by_name["ball"], 1000.0 * depth.max(axis=1))
    touched = [(values > 0.0).mean() for values in report.by_name.values()]
    assert sum(0.0 < share < 1.0 for share in touched) >= 4, "they are passed"
