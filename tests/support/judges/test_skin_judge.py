"""The judge of the skin detects overlaps, cuts and crossings, and nothing else."""

from __future__ import annotations

from dataclasses import replace

import coal
import numpy as np
import pytest

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Mesh, Plane, Sphere
from halfphysics.motion.motion import Motion
from halfphysics.scene.scene import Scene
from support.barriers import BARRIERS, barrier, sheet
from support.judges.posed_skin import Skinner
from support.judges.skin_judge import SkinJudge
from support.judges.skin_obstacles import Primitive, hull_of, obstacles_of, signed_distance
from support.judges.triangle_soup import Soup
from support.people import FACING_X, t_pose, violent
from support.references.mesh_queries import closest_reference, winding_reference

trimesh = pytest.importorskip("trimesh")

#: Rounding of some dozens of products of numbers around one [m].
EXACT = 1e-12
#: coal's distances [m].
COAL = 1e-6
SHAPES = {
    "plane": Plane((0.1, -0.3, 1.0), 0.07),
    "box": Box((0.4, 0.2, 0.9)),
    "sphere": Sphere(0.3),
    "capsule": Capsule(0.15, 0.6),
    "cylinder": Cylinder(0.2, 0.5),
}


@pytest.fixture(scope="module")
def body():
    return Body.default()


@pytest.fixture
def rng():
    return np.random.default_rng(0)


def mesh_of(shape, times=0):
    mesh = trimesh.Trimesh(*shape.triangles(), process=False)
    for _ in range(times):
        mesh = mesh.subdivide()
    return mesh


def with_it(shape, **pose):
    scene = Scene()
    scene.add_static("it", shape, **pose)
    return scene


# -- the pieces ----------------------------------------------------------------------------


def test_skinning_is_that_of_the_body(body, rng):
    moved = violent(frames=5)
    blend = replace(body, posedirs=1e-3 * rng.normal(size=(len(body.rest_vertices), 3, 486)))
    for who in (body, blend):
        skin = Skinner(who)
        mine = skin.vertices(moved.translation, moved.rotations, moved.axes)
        assert np.abs(mine - who.vertices(moved)).max() < EXACT


def test_samples_cover_the_skin_by_area(body):
    skin = Skinner(body)
    assert len(skin.bary) >= 20_000
    assert np.allclose(skin.bary.sum(axis=1), 1.0)
    assert (skin.bary >= 0.0).all()
    corners = np.asarray(body.rest_vertices)[np.asarray(body.faces)]
    area = 0.5 * np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    part = skin.part[np.asarray(body.faces)[:, 0]]
    expected = np.bincount(part, weights=area, minlength=55) / area.sum() * len(skin.bary)
    found = np.bincount(skin.points_part[len(body.rest_vertices) :], minlength=55)
    # A count's standard deviation is its square root; six of them never happen.
    assert (np.abs(found - expected) < 6.0 * np.sqrt(expected + 1.0)).all()
    assert np.array_equal(skin.bary, Skinner(body).bary)


@pytest.mark.parametrize("name", SHAPES)
def test_formulas_are_distances(name, rng):
    shape = SHAPES[name]
    points = rng.uniform(-1.0, 1.0, size=(400, 3))
    found = signed_distance(shape, points)
    assert np.abs(np.maximum(-found, 0.0) - shape.depth(points)).max() < EXACT
    it, here = Primitive(shape).coal, coal.Transform3s()
    for p, d in zip(points, found, strict=True):
        result = coal.DistanceResult()
        ball = coal.Sphere(1e-9)
        by_coal = coal.distance(
            ball, coal.Transform3s(np.eye(3), p), it, here, coal.DistanceRequest(), result
        )
        if d > COAL:
            assert by_coal == pytest.approx(d, abs=COAL)
        elif d < -COAL:
            assert by_coal < 0.0


def test_soups_measure_what_sums_over_all_triangles_do(rng):
    mesh = trimesh.util.concatenate(
        [trimesh.creation.icosphere(2, 0.5), trimesh.creation.annulus(0.6, 1.0, 0.4)]
    )
    soup, points = Soup(mesh.triangles), rng.uniform(-1.1, 1.1, size=(500, 3))
    d = closest_reference(points, mesh.vertices, mesh.faces)[0]
    assert np.abs(soup.distances(points) - d).max() < EXACT
    winding = winding_reference(points, mesh.vertices, mesh.faces)
    assert np.abs(soup.winding(points) - winding).max() < EXACT
    assert soup.smallest(points) == (pytest.approx(d.min(), abs=EXACT), d.argmin())
    assert soup.smallest(points, 0.5 * d.min()) == (np.inf, -1)


@pytest.mark.parametrize("name", ["mesh", "box", "sphere", "capsule", "cylinder"])
@pytest.mark.parametrize("corners", [3, 6])
def test_hulls_of_triangles_meet_what_coal_says(name, corners, rng):
    """Random triangles and ways of triangles around each shape: the same ones meet it."""
    shape = mesh_of(SHAPES["box"]) if name == "mesh" else SHAPES[name]
    if name == "mesh":
        shape = Mesh(shape.vertices, shape.faces)
    (it,) = obstacles_of(shape)
    at = rng.uniform(-0.5, 0.5, size=(600, 1, 3))
    hulls = at + 0.1 * rng.normal(size=(600, corners, 3))
    here = coal.Transform3s()

    def hit(points):
        # coal has trees meet hulls, not single triangles.
        hull = hull_of(points if corners == 6 else np.concatenate([points, points]))
        request, result = coal.CollisionRequest(), coal.CollisionResult()
        return coal.collide(hull, here, it.coal, here, request, result) > 0

    expected = [i for i, points in enumerate(hulls) if hit(points)]
    assert 50 < len(expected) < 550
    assert it.met_by(hulls).tolist() == expected


def test_closed_and_open_pieces_are_told_apart():
    ball = trimesh.creation.icosphere(1, 0.5)
    bowl = trimesh.creation.icosphere(1, 0.5).apply_translation([2.0, 0.0, 0.0])
    bowl.update_faces(np.arange(len(bowl.faces)) > 4)
    both = trimesh.util.concatenate([ball, bowl])
    closed, open_ = obstacles_of(Mesh(both.vertices, both.faces))
    assert (closed.solid, open_.solid) == (True, False)
    assert len(closed.soup.triangles) == len(ball.faces)
    assert closed.depths(np.zeros((1, 3))) == pytest.approx(
        [(ball.triangles_center * ball.face_normals).sum(axis=1).min()]
    )
    assert open_.depths(np.array([[2.0, 0.0, 0.0]])) == [0.0]


# -- detected ------------------------------------------------------------------------------


def test_being_inside_is_seen_and_how_deep(body):
    motion = t_pose(np.outer([0.3, 0.29, 0.28], [0.0, 0.0, 1.0]))
    skin = body.vertices(motion)
    judge = SkinJudge(body, with_it(Plane()))
    verdict = judge.judge_motion(motion)
    lowest = skin[..., 2].min(axis=1)
    assert verdict.depths == pytest.approx(-lowest, abs=EXACT)
    assert verdict.gaps == pytest.approx(lowest, abs=EXACT)
    assert verdict.start == pytest.approx(lowest[0], abs=EXACT)
    assert verdict.shares == pytest.approx((skin[..., 2] < 0.0).mean(axis=1))
    assert verdict.cut == verdict.coal == {0, 1, 2}
    assert not verdict.clear
    rate, depth = judge.penetration(motion)
    assert rate == pytest.approx(100.0 * verdict.shares.mean())
    assert depth == pytest.approx(1e3 * verdict.depth)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["box", "sphere", "capsule", "cylinder"])
@pytest.mark.parametrize("kind", ["primitive", "mesh", "finer mesh"])
def test_things_of_any_kind_are_seen(body, name, kind):
    """An item at the belly, then 8 cm in it, then out again."""
    motion = t_pose(np.outer([0.0, 0.08, 0.0], [1.0, 0.0, 0.0]))
    skin = body.vertices(motion)
    shape = SHAPES[name]
    if kind != "primitive":
        shape = mesh_of(shape, 0 if kind == "mesh" else 2)
    belly = body.joints(motion)[0, 3]
    beside = np.abs(skin[0] - belly)
    reach = skin[0][(beside[:, 1] < 0.3) & (beside[:, 2] < 0.45), 0].max()
    half = {"box": 0.2, "sphere": 0.3, "capsule": 0.15, "cylinder": 0.2}[name]
    gap = 0.004
    pose = {"position": (reach + gap + half, *belly[1:])}
    judge = SkinJudge(body, with_it(shape, **pose))
    verdict = judge.judge_motion(motion, continuous=True)
    assert verdict.cut == verdict.coal == {1}
    assert np.count_nonzero(verdict.depths) == 1
    assert verdict.depth > 0.03
    assert judge.penetration(motion)[1] > 30.0
    # Facets are within the round shape.
    assert gap - EXACT < verdict.gaps[0] < 0.02


def test_what_goes_between_the_vertices_is_seen(body):
    """A needle through the middle of one triangle: no vertex and hardly a sample is in it."""
    motion = t_pose(np.zeros((2, 3)))
    skin = body.vertices(motion)[0]
    corners = skin[np.asarray(body.faces)]
    area = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    a, b, c = corners[area.argmax()]
    normal = np.cross(b - a, c - a) / area.max()
    turn = rot.from_matrix(trimesh.geometry.align_vectors([0, 0, 1], normal)[:3, :3])
    length = 0.05
    where = {"position": (a + b + c) / 3.0 + (0.5 * length - 0.001) * normal, "quaternion": turn}
    for shape in (
        Cylinder(5e-5, length),
        Box((1e-4, 1e-4, length)),
        mesh_of(Box((1e-4, 1e-4, length))),
    ):
        verdict = SkinJudge(body, with_it(shape, **where), samples=100).judge_motion(motion)
        assert verdict.depth == 0.0
        assert verdict.cut == verdict.coal == {0, 1}
        assert not verdict.clear


@pytest.mark.slow
@pytest.mark.parametrize("kind", BARRIERS)
def test_a_jump_over_it_is_a_crossing(body, kind):
    shape = barrier(kind)
    motion = t_pose([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]], fps=20.0)
    middle = (0.0, body.joints(motion)[0, 0, 1], 0.0)
    judge = SkinJudge(body, with_it(shape, position=middle))
    assert judge.judge_motion(motion).clear
    verdict = judge.judge_motion(motion, continuous=True)
    assert not verdict.cut
    assert not verdict.clear
    crossed = {part for _, part, pose in verdict.crossed if pose == 1}
    assert {"pelvis", "spine1", "spine2", "spine3", "neck", "head"} <= crossed
    assert ("left_wrist" in crossed) == ("pole" not in kind)


def test_small_things_within_the_body_are_seen(body):
    motion = t_pose(np.zeros((2, 3)))
    at = body.joints(motion)[0, 3]
    for shape in (Sphere(0.01), trimesh.creation.icosphere(1, 0.01), sheet(0.01)):
        verdict = SkinJudge(body, with_it(shape, position=at)).judge_motion(motion, continuous=True)
        assert verdict.swallowed == ["it"]
        assert not verdict.clear


def test_a_moving_thing_is_judged_where_it_is(body):
    motion = t_pose(np.zeros((3, 3)))
    skin = body.vertices(motion)[0]
    scene = Scene()
    scene.add_object("ball", Sphere(0.1), mass=1.0)
    x = skin[:, 0].max() + np.array([0.15, 0.105, 0.09])
    z = skin[skin[:, 0].argmax(), 2]
    y = skin[skin[:, 0].argmax(), 1]
    track = {"ball": (np.stack([x, 0 * x + y, 0 * x + z], axis=1), np.tile([1.0, 0, 0, 0], (3, 1)))}
    verdict = SkinJudge(body, scene).judge_motion(motion, track, continuous=True)
    assert verdict.gaps[1] == pytest.approx(0.005, abs=1e-9)
    assert verdict.depth == pytest.approx(0.010, abs=1e-3)
    assert verdict.cut == verdict.coal == {2}


# -- not detected --------------------------------------------------------------------------


@pytest.mark.parametrize("steps", [2, 5, 20])
def test_passing_by_is_nothing(body, steps):
    """A person between two sheets and two poles, 5 mm from its finger tips, soles and head."""
    path = np.outer(np.linspace(-1.0, 1.0, steps + 1), [1.0, 0.0, 0.0])
    motion = t_pose(path, fps=10.0)
    everywhere = body.vertices(motion).reshape(-1, 3)
    low, high = everywhere.min(axis=0), everywhere.max(axis=0)
    gap, thick = 0.005, 0.01
    scene, flat = Scene(), rot.exp([0.0, np.pi / 2, 0.0])
    scene.add_static("over", sheet(), position=(0.0, 0.0, high[2] + gap), quaternion=flat)
    scene.add_static("under", Plane(), position=(0.0, 0.0, low[2] - gap))
    scene.add_static("left", Cylinder(thick, 4.0), position=(0.0, high[1] + gap + thick, 0.0))
    pole = trimesh.creation.cylinder(thick, height=4.0)
    scene.add_static("right", pole, position=(0.0, low[1] - gap - thick, 0.0))
    verdict = SkinJudge(body, scene).judge_motion(motion, continuous=True)
    assert verdict.clear
    assert verdict.gap == pytest.approx(gap, abs=1e-4)
    assert verdict.gaps[0] == pytest.approx(gap, abs=1e-4)


def test_around_an_edge_is_no_crossing(body):
    """Up in front of a sheet's edge, over it and down behind it: three steps, one each way."""
    scene = with_it(sheet(), position=(0.0, 0.0, -2.5))  # its edge at z = -0.5
    path = [[-0.6, 0.0, -0.8], [-0.6, 0.0, 1.5], [0.6, 0.0, 1.5], [0.6, 0.0, -0.8]]
    judge = SkinJudge(body, scene)
    assert judge.judge_motion(t_pose(path, fps=10.0), continuous=True).clear
    assert not judge.judge_motion(t_pose(path[::3], fps=10.0), continuous=True).clear


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["box", "mesh", "cylinder"])
def test_own_answers_are_those_of_coal(body, kind, rng):
    """Random poses about an item: cut where coal finds a cut, and inside only where cut."""
    shape = {"box": Box((0.3, 0.5, 0.3)), "cylinder": Cylinder(0.02, 3.0)}.get(kind)
    if kind == "mesh":
        shape = trimesh.creation.annulus(0.15, 0.3, 0.4)
    count = 40
    rotations = 0.4 * rng.normal(size=(count, 55, 3))
    rotations[:, 0] = FACING_X
    motion = Motion(0.3 * rng.normal(size=(count, 3)), rotations, 5.0)
    middle = (0.0, body.joints(motion)[:, 0, 1].mean(), 0.0)
    verdict = SkinJudge(body, with_it(shape, position=middle)).judge_motion(motion)
    assert verdict.cut == verdict.coal
    assert 5 < len(verdict.cut) < 35
    assert set(np.flatnonzero(verdict.depths)) <= verdict.cut
