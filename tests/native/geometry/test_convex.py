"""Distances of convex shapes and separating planes of triangles, against an independent library."""

from __future__ import annotations

import coal
import numpy as np
import pytest

from halfphysics import _native
from halfphysics.base import rotations as rot
from halfphysics.geometry.colliders import convex_collider, hull_collider
from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Sphere
from support.judges.coal_shapes import coal_hull, coal_shape

MICROMETRE = 1e-6
#: At termination, GJK's bounds of a distance between two round shapes differ by this much [m].
BOUNDS = 1e-8
#: Rounding of a distance along a direction [m].
ALONG = 1e-12
#: The nearest points are separated along the normal; where several sides are equally near,
#: GJK on thin triangles is less exact [m].
WITNESS = 5e-5


def random_turn(rng):
    return rot.to_matrix(rot.normalize(rng.normal(size=4)))


def distance(a, b):
    sides = ((c.vertices, c.normals, c.radius, c.rim) for c in (a, b))
    return _native.convex_distance(*(x for side in sides for x in side))


def lowest(collider, normal):
    """Smallest n.x of a collider, from its definition: hull, disc, rounding."""
    disc = np.linalg.norm(np.cross(collider.rim, normal))
    return (collider.vertices @ normal).min() - disc - collider.radius


def test_distance_of_hulls_agrees_with_coal():
    rng = np.random.default_rng(1)
    request = coal.DistanceRequest()
    checked = 0
    for _ in range(300):
        a = rng.normal(size=(rng.integers(4, 40), 3)) * rng.uniform(0.01, 0.3)
        b = rng.normal(size=(rng.integers(4, 40), 3)) * rng.uniform(0.01, 0.3)
        shift = rng.normal(size=3)
        shift *= rng.uniform(0.0, 2.0) / np.linalg.norm(shift)
        expected = coal.distance(
            coal_hull(a),
            coal.Transform3s.Identity(),
            coal_hull(b),
            coal.Transform3s(np.eye(3), shift),
            request,
            coal.DistanceResult(),
        )
        dist, normal, pa, pb = distance(hull_collider(a), hull_collider(b + shift))
        if expected > 1e-6:
            checked += 1
            assert dist == pytest.approx(expected, abs=MICROMETRE)
            # The witness: nearest points at that distance, and a plane that separates the shapes.
            np.testing.assert_allclose(pa - pb, dist * normal, atol=1e-9)
            gap = (a @ normal).min() - ((b + shift) @ normal).max()
            assert gap == pytest.approx(expected, abs=MICROMETRE)
        elif expected < -1e-6:
            assert dist < 0.0
            # An upper bound of the depth: moving by it along the normal separates the shapes.
            gap = (a @ normal).min() - ((b + shift) @ normal).max()
            assert gap == pytest.approx(dist, abs=1e-9)
            assert -dist >= -expected - MICROMETRE
    assert checked > 150


def some_shape(kind, rng):
    """A collider of random size, and the same shape as a coal geometry."""
    if kind == "hull":
        points = 0.15 * rng.normal(size=(rng.integers(4, 30), 3))
        return hull_collider(points), coal_hull(points)
    a, b = rng.uniform(0.02, 0.3, size=2)
    shape = {
        "box": Box((a, b, rng.uniform(0.02, 0.5))),
        "sphere": Sphere(a),
        "capsule": Capsule(a, b),
        "cylinder": Cylinder(a, b),
    }[kind]
    return convex_collider(shape), coal_shape(shape, solid=True)


@pytest.mark.parametrize("kind", ["box", "sphere", "capsule", "cylinder", "hull"])
def test_primitives_are_exact(kind):
    """1,000 placements per kind against all kinds: bounded from both sides, and equal to coal."""
    rng = np.random.default_rng([2, len(kind)])
    request = coal.DistanceRequest()
    request.gjk_tolerance, request.gjk_max_iterations = 1e-10, 1000
    apart = 0
    for n in range(1000):
        other = ("box", "sphere", "capsule", "cylinder", "hull")[n % 5]
        (a, first), (b, second) = some_shape(kind, rng), some_shape(other, rng)
        turns = random_turn(rng), random_turn(rng)
        shift = rng.normal(size=3)
        shift *= rng.uniform(0.2, 1.0) / np.linalg.norm(shift)
        here = coal.Transform3s(turns[0], np.zeros(3))
        there = coal.Transform3s(turns[1], shift)
        expected = coal.distance(first, here, second, there, request, coal.DistanceResult())
        a, b = a.moved(turns[0], np.zeros(3)), b.moved(turns[1], shift)
        dist, normal, pa, pb = distance(a, b)
        if expected <= MICROMETRE:
            assert dist <= 2 * MICROMETRE
            continue
        apart += 1
        assert dist == pytest.approx(expected, abs=MICROMETRE)
        # Lower bound: a plane separates them by this. Upper bound: these two points are on them.
        assert lowest(a, normal) + lowest(b, -normal) >= dist - BOUNDS
        assert normal @ (pa - pb) == pytest.approx(dist, abs=1e-7)  # may be a face's own normal
        for collider, point in ((a, pa), (b, pb)):
            at = hull_collider(point[None])
            assert distance(collider, at)[0] <= WITNESS
    assert apart > 600


def test_cylinders_side_by_side_and_end_to_end():
    """Parallel axes: whole lines and faces are equally near."""
    a, b = convex_collider(Cylinder(0.1, 0.4)), convex_collider(Cylinder(0.05, 0.3))
    for gap in (1.0, 1e-2, 1e-4, 1e-6):
        for turn in (np.eye(3), random_turn(np.random.default_rng(4))):
            for shift in ([0.15 + gap, 0.0, 0.1], [0.02, 0.01, 0.35 + gap]):
                dist, normal, *_ = distance(
                    a.moved(turn, np.zeros(3)), b.moved(turn, turn @ np.array(shift))
                )
                assert dist == pytest.approx(gap, abs=1e-12)
                side = [1.0, 0.0, 0.0] if shift[0] > 0.1 else [0.0, 0.0, 1.0]
                np.testing.assert_allclose(normal, -turn @ np.array(side), atol=1e-6)


@pytest.mark.parametrize("deep", [1e-7, 1e-4, 0.02])
def test_the_way_out_of_an_overlap_leads_out(deep):
    """Cylinders on their sides, crossed and parallel, and on an end, in a box and in each other."""
    cylinder, box = convex_collider(Cylinder(0.1, 0.4)), convex_collider(Box((0.3, 0.3, 0.3)))
    on_side = rot.to_matrix(rot.exp([0.0, np.pi / 2, 0.0]))
    across = rot.to_matrix(rot.exp([np.pi / 2, 0.0, 0.0]))
    for turn, other, height in (
        (np.eye(3), box, 0.35),
        (on_side, box, 0.25),
        (on_side, cylinder.moved(on_side, np.zeros(3)), 0.2),
        (on_side, cylinder.moved(across, np.zeros(3)), 0.2),
    ):
        up = np.array([0.0, 0.0, height - deep])
        moved = cylinder.moved(turn, up)
        dist, normal, *_ = distance(moved, other)
        assert dist == pytest.approx(-deep, abs=1e-9)
        np.testing.assert_allclose(normal, [0.0, 0.0, 1.0], atol=1e-9)


def test_the_way_out_of_an_overlap_is_the_shortest_along_all_normals():
    """Directions that points of others rule out are not measured: none of them is the best."""
    rng = np.random.default_rng(9)
    overlaps = 0
    for _ in range(200):
        size = rng.uniform(0.01, 0.3, size=(2, 3))
        a, b = (hull_collider(rng.normal(size=(rng.integers(4, 200), 3)) * s) for s in size)
        b = b.moved(np.eye(3), rng.normal(size=3) * rng.choice([0.0, 0.02, 0.1]))
        dist, normal, *_ = distance(a, b)
        if dist > 0.0:
            continue
        overlaps += 1
        normals = np.concatenate([-a.normals, b.normals, normal[None]])
        apart = (a.vertices @ normals.T).min(axis=0) - (b.vertices @ normals.T).max(axis=0)
        assert dist == pytest.approx(apart.max(), abs=ALONG)
        assert dist == pytest.approx(apart[-1], abs=ALONG)
    assert overlaps > 100


def test_rounding_makes_no_overlap():
    """A separating plane implies a gap, however flat GJK's tetrahedron is.

    Pairs from piles, 1 to 2 mm apart; about 1 % of them seemed to overlap.
    """
    rng = np.random.default_rng(5)
    pairs = [
        (
            Cylinder(0.10669168388793651, 0.1861488290980371),
            [-0.1581306077227384, 0.09763125948933274, 0.0940744145473318],
            [0.12197753688862342, 1.512715956796425e-11, -1.2559005925325557e-11, -0.99253286116],
            Box((0.11159307409391313, 0.2397186839944224, 0.2263183915000657)),
            [-0.24879762341797193, 0.221821331056932, 0.30971689031273525],
            [-0.06766860708353067, -0.3224365837924266, 0.730869629755508, 0.5977333798180348],
        ),
        (
            Cylinder(0.1456001709628975, 0.14153636201582936),
            [-0.03570279764733265, 0.039538227338412536, 0.07176815321603083],
            [0.7939858722155567, -4.9204430575299366e-11, -3.7654498334263575e-11, -0.6079362094],
            Cylinder(0.10316016891970811, 0.10260748641900526),
            [0.19426539924110944, 0.047447779104930456, 0.21709968132321944],
            [-0.1174376404529725, -0.5745799841034146, -0.6051932841514259, -0.5383375625855673],
        ),
    ]
    for a, xa, qa, b, xb, qb in pairs:
        found = []
        for size in 10 ** rng.uniform(-16.0, -6.0, size=2000):
            moved = [
                convex_collider(shape).moved(
                    rot.to_matrix(rot.normalize(q + size * rng.normal(size=4))),
                    x + size * rng.normal(size=3),
                )
                for shape, x, q in ((a, xa, qa), (b, xb, qb))
            ]
            found.append(distance(*moved)[0])
        assert np.ptp(found) < 2e-5  # as far as the shapes are moved
        assert min(found) > 9e-4


@pytest.mark.parametrize("gap", [1e-2, 1e-3, 1e-5])
def test_what_a_plane_separates_is_that_far_apart(gap):
    """Random and parallel faces, sides and rims, placed `gap` apart along a normal."""
    rng = np.random.default_rng(6)
    turns = [[0.0, 0.0, 0.0], [np.pi / 2, 0.0, 0.0], [0.0, np.pi / 2, 0.0], [0.0, 0.0, 0.3]]
    for case in range(1000):
        (a, _), (b, _) = (some_shape(rng.choice(["box", "cylinder"]), rng) for _ in "ab")
        turn, normal = random_turn(rng), np.eye(3)[rng.integers(3)]
        around = [rot.to_matrix(rot.exp(turns[rng.integers(4)])) for _ in "ab"]
        if case % 2:
            around = [random_turn(rng) for _ in "ab"]
        normal = turn @ normal
        a = a.moved(turn @ around[0], np.zeros(3))
        b = b.moved(turn @ around[1], 0.05 * np.cross(normal, rng.normal(size=3)))
        b = b.moved(np.eye(3), (lowest(a, normal) + lowest(b, -normal) - gap) * normal)
        assert distance(a, b)[0] >= gap - 2 * BOUNDS


def soup(rng, triangles):
    corners = rng.uniform(-1.0, 1.0, size=(triangles, 1, 3))
    corners = corners + rng.normal(size=(triangles, 3, 3)) * 0.15
    corners[0] = corners[0, 0]  # a triangle without extent
    corners[1, 2] = corners[1, 1]  # a triangle without area
    vertices = corners.reshape(-1, 3)
    return vertices, np.arange(len(vertices), dtype=np.int32).reshape(-1, 3)


@pytest.mark.parametrize("kind", ["hull", "cylinder"])
def test_planes_separate_from_every_triangle_in_reach(kind):
    """The planes are complete: beyond all of them no triangle is within reach."""
    rng = np.random.default_rng(3)
    vertices, faces = soup(rng, 300)
    corners = vertices[faces]
    seen = 0
    for _ in range(100):
        if kind == "hull":
            shape = hull_collider(rng.normal(size=(20, 3)) * 0.08)
        else:
            shape = convex_collider(Cylinder(*rng.uniform(0.02, 0.2, size=2)))
        hull = shape.moved(random_turn(rng), rng.uniform(-1.2, 1.2, size=3))
        reach = 0.3
        planes, nearest, _ = _native.triangle_planes(
            vertices, faces, hull.vertices, hull.radius, hull.rim, reach
        )
        exact = np.array([distance(hull, hull_collider(t))[0] for t in corners])
        if exact.min() <= 1e-6:
            assert nearest <= 1e-6
            continue
        seen += len(planes) > 0
        assert nearest == pytest.approx(min(exact.min(), reach), abs=MICROMETRE)
        for normal, offset, dist in ((p[:3], p[3], p[4]) for p in planes):
            assert lowest(hull, normal) - offset == pytest.approx(dist, abs=BOUNDS)
        for triangle, dist in zip(corners, exact, strict=True):
            if dist < reach - 1e-6:
                heights = triangle @ planes[:, :3].T - planes[:, 3]
                assert (heights.max(axis=0) <= 1.1e-7).any()  # wholly behind one plane
    assert seen > 30


def test_a_finely_divided_floor_gives_one_plane():
    n = 40
    x, y = np.meshgrid(np.linspace(-1, 1, n), np.linspace(-1, 1, n), indexing="ij")
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(n * n)], axis=1)
    i, j = np.meshgrid(np.arange(n - 1), np.arange(n - 1), indexing="ij")
    corner = (i * n + j).ravel()
    faces = np.concatenate(
        [
            np.stack([corner, corner + n, corner + 1], 1),
            np.stack([corner + n, corner + n + 1, corner + 1], 1),
        ]
    ).astype(np.int32)
    foot = hull_collider(Box((0.1, 0.25, 0.06)).convex_vertices() + np.array([0.013, 0.027, 0.035]))
    planes, nearest, _ = _native.triangle_planes(
        vertices, faces, foot.vertices, foot.radius, foot.rim, 0.05
    )
    assert len(planes) == 1
    np.testing.assert_allclose(planes[0, :3], [0, 0, 1], atol=1e-12)
    assert nearest == pytest.approx(0.005, abs=1e-12)
