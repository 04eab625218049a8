"""Hulls of the skin: whole faces, reproducible, any topology, tight where contacts occur."""

from __future__ import annotations

import dataclasses
import hashlib
import os
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from halfphysics.body.body import Body
from halfphysics.body.skin_corners import without_inner
from halfphysics.body.skin_cut import PIECES, cut_faces, parts_of_faces
from halfphysics.body.skin_hulls import REMEMBERED, SkinHulls, _known, baked, skin_hulls
from halfphysics.body.symmetry import symmetry_of
from halfphysics.errors import InputError
from halfphysics.motion.pose import Pose
from halfphysics.motion.skeleton import FACE_JOINTS, LEFT_HAND_JOINTS, N_JOINTS, RIGHT_HAND_JOINTS
from support.files.model_files import LAYOUTS, fields, write_npz
from support.judges import hull_gap

#: Skinned coordinates of order 1 m and hull planes through them: 1e-15, with room.
ROUNDING = 1e-12
#: Visible gap at first contact [m]: 1.5 and 6 mm, less 1 mm of clearance.
MEDIAN, P95 = 0.5e-3, 5e-3


@pytest.fixture(scope="module")
def body() -> Body:
    return Body.default()


@pytest.fixture(scope="module", params=LAYOUTS)
def loaded(request, tmp_path_factory) -> Body:
    folder = tmp_path_factory.mktemp("models")
    file = write_npz(folder / f"{request.param.upper()}_NEUTRAL.npz", fields(request.param))
    return Body.load(file, model=request.param, gender="neutral")


def check(hulls: SkinHulls, faces: np.ndarray, weights: np.ndarray) -> None:
    """All guaranteed properties of a skin's vertex sets."""
    sets = hull_gap.split(hulls) if len(hulls.part) else []
    assert len(hulls.part) + 1 == len(hulls.first)
    assert hulls.first[0] == 0
    assert hulls.first[-1] == len(hulls.vertex)
    assert hulls.vertex.dtype == np.int32
    inside = np.zeros((len(sets), len(weights)), dtype=bool)
    for row, some in zip(inside, sets, strict=True):
        assert len(some) > 0
        assert len(np.unique(some)) == len(some)
        row[some] = True
    whole = inside[:, faces].all(axis=2)  # (H, F)
    assert whole.any(axis=0).all(), "a face that is in no set"
    parts = parts_of_faces(faces, weights)
    for row, some, part in zip(whole, sets, hulls.part, strict=True):
        np.testing.assert_array_equal(np.unique(faces[row]), np.sort(some))
        own = row & (parts == part)
        assert own.any()
        assert weights[faces[own]].sum(axis=(0, 1)).argmax() == part


def test_every_face_is_whole_in_a_set(body):
    hulls = body.skin_hulls
    check(hulls, body.faces, body.weights)
    assert len(hulls.part) == PIECES
    # Duplicates along the cuts cost time in every contact.
    assert len(hulls.vertex) < 1.2 * len(body.rest_vertices)
    assert set(hulls.part) == set(parts_of_faces(body.faces, body.weights))


def test_of_every_model(loaded):
    check(loaded.skin_hulls, loaded.faces, loaded.weights)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**31), st.integers(0, 60), st.integers(3, 40), st.integers(0, 4))
def test_of_any_topology(seed, count, vertices, kind):
    """Few or no faces, degenerate and repeated ones, flat skins, single points and joints."""
    rng = np.random.default_rng(seed)
    faces = rng.integers(0, vertices, (count, 3))
    weights = rng.random((vertices, N_JOINTS)) ** 8
    rest = rng.normal(size=(vertices, 3))
    if kind == 1:
        rest[:, 2] = 0.0
    elif kind == 2:
        rest[:] = rest[0]
    elif kind == 3:
        weights = np.eye(N_JOINTS)[np.full(vertices, 20)]
    elif kind == 4:
        faces = np.repeat(faces[:1], count, axis=0)
    weights /= weights.sum(axis=1, keepdims=True)
    check(skin_hulls(faces, weights, rest, np.zeros((N_JOINTS, 3))), faces, weights)


@pytest.mark.parametrize("mirrored", [True, False])
@pytest.mark.parametrize("pieces", [1, 55, 56, 70])
def test_pieces_part_the_faces(body, pieces, mirrored):
    skin = body.faces.astype(np.int64), body.weights, body.rest_vertices, body.rest_joints
    cut = cut_faces(*skin, pieces, body.symmetry.face if mirrored else None)
    assert len(cut) == max(pieces, 55)
    np.testing.assert_array_equal(np.sort(np.concatenate(cut)), np.arange(len(body.faces)))
    part = parts_of_faces(body.faces.astype(np.int64), body.weights)
    assert all(len(np.unique(part[piece])) == 1 for piece in cut)


def test_refuses_what_does_not_fit(body):
    with pytest.raises(InputError, match="weights"):
        skin_hulls(body.faces, body.weights[1:], body.rest_vertices, body.rest_joints)
    with pytest.raises(InputError, match="faces name vertices"):
        skin_hulls(body.faces + 1, body.weights, body.rest_vertices, body.rest_joints)


def test_the_same_for_all_shapes():
    """One object in a process."""
    other, plain = Body.default([3.0, -3.0, 2.0], stature=1.5).skin_hulls, Body.default().skin_hulls
    for name in ("part", "first", "vertex"):
        np.testing.assert_array_equal(getattr(other, name), getattr(plain, name))


@pytest.mark.slow
@pytest.mark.parametrize("threads", ["1", "4"])
def test_cut_beforehand_is_cut_now(body, threads):
    """The packaged cut, byte by byte, for any number of threads: else run tools/cut_body.py."""
    code = (
        "import hashlib; from halfphysics import Body; "
        "from halfphysics.body.skin_hulls import bake; "
        "b = Body.default(); f = bake(b.faces, b.weights, b.mean_vertices, b.mean_joints); "
        "print(f['skin'], hashlib.sha256(f['piece'].tobytes()).hexdigest())"
    )
    names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
    env = os.environ | dict.fromkeys(names, threads) | {"PYTHONHASHSEED": threads}
    env["PYTHONPATH"] = os.pathsep.join(p for p in sys.path if p)
    out = subprocess.run([sys.executable, "-c", code], env=env, capture_output=True, check=True)
    skin, digest = out.stdout.decode().split()
    whose, pieces = baked()
    piece = np.full(len(body.faces), 255, dtype=np.uint8)
    for number, some in enumerate(pieces):
        piece[some] = number
    assert whose == skin
    assert hashlib.sha256(piece.tobytes()).hexdigest() == digest


@pytest.mark.parametrize("noise", [1e-14, 1e-10])
def test_rounding_does_not_choose_a_cut(body, noise):
    """A body's sides mirror each other, and other machines sum in another order."""
    faces, rest = body.faces.astype(np.int64), body.mean_vertices
    moved = rest + noise * np.random.default_rng(0).normal(size=rest.shape)
    image = symmetry_of(faces, moved).face
    cut = cut_faces(faces, body.weights, moved, body.mean_joints, image=image)
    assert {c.tobytes() for c in cut} == {c.tobytes() for c in baked()[1]}


def halves(hulls: SkinHulls, image: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Of each hull its vertices, and those of the hull that is its mirror image."""
    sets = hull_gap.split(hulls)
    named = {tuple(np.sort(some)): some for some in sets}
    return [(some, named[tuple(np.sort(image[some]))]) for some in sets]


@pytest.mark.parametrize("betas", [None, [2.0, -1.0, 0.5, 1.0, 0.0, -2.0]])
@pytest.mark.parametrize("which", ["skin_hulls", "skin_corners"])
def test_hulls_mirror_each_other_vertex_by_vertex(which, betas):
    """Of any shape; those in the middle mirror themselves, in some order."""
    body = Body.default(betas)
    pairs = halves(getattr(body, which), body.symmetry.vertex)
    apart = [(a, b) for a, b in pairs if not np.array_equal(np.sort(a), np.sort(b))]
    assert len(apart) == 80
    for some, other in apart:
        np.testing.assert_array_equal(body.symmetry.vertex[some], other)


def test_a_skin_that_mirrors_itself_nearly_is_cut_evenly(body):
    """As models of people are: vertices are off by micrometres."""
    moved = body.mean_vertices + 1e-6 * np.random.default_rng(0).normal(size=(13718, 3))
    hulls = skin_hulls(body.faces, body.weights, moved, body.mean_joints)
    check(hulls, body.faces, body.weights)
    assert len(hulls.part) == PIECES
    for some, other in halves(hulls, body.symmetry.vertex):
        assert len(some) == len(other)


def test_an_uneven_skin_is_cut_as_it_is(body):
    moved = body.mean_vertices.copy()
    moved[np.argmax(moved[:, 0]), 0] += 0.01
    assert symmetry_of(body.faces, moved) is None
    hulls = skin_hulls(body.faces, body.weights, moved, body.mean_joints)
    check(hulls, body.faces, body.weights)
    assert len(hulls.part) == PIECES


def test_another_skin_is_cut_anew(body):
    """The precomputed cut is for that skin only."""
    faces = body.faces[:-1]
    hulls = skin_hulls(faces, body.weights, body.mean_vertices, body.mean_joints)
    check(hulls, faces, body.weights)
    assert hulls is not body.skin_hulls


def test_no_one_changes_them(body):
    for array in (body.skin_hulls.part, body.skin_hulls.first, body.skin_hulls.vertex):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


def test_few_skins_are_remembered():
    rest = np.eye(3)
    for k in range(REMEMBERED + 5):
        skin_hulls([[0, 1, 2]], np.eye(N_JOINTS)[[k, k, k]], rest, np.zeros((N_JOINTS, 3)))
    assert len(_known) <= REMEMBERED


def any_pose(rng) -> Pose:
    rotations = rng.normal(size=(N_JOINTS, 3)) * rng.uniform(0.0, 1.5)
    return Pose(rng.normal(size=3), rotations)


def outside(hull: ConvexHull, points: np.ndarray) -> np.ndarray:
    """Distance [m] of points (n, 3) above the hull's highest plane; negative inside."""
    normals, offsets = hull.equations[:, :3], hull.equations[:, 3]
    return (points @ normals.T + offsets).max(axis=1)


@pytest.mark.parametrize("which", ["skin_hulls", "skin_corners"])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_hulls_hold_all_skin_at_any_pose(body, which, seed):
    rng = np.random.default_rng(seed)
    shaped = body if seed == 0 else Body.default(rng.uniform(-3.0, 3.0, 10))
    skin = shaped.vertices(any_pose(rng))
    some = rng.integers(0, len(body.faces), 1000)
    points = np.einsum("nc,nci->ni", rng.dirichlet(np.ones(3), 1000), skin[body.faces[some]])
    points = np.concatenate([skin, points])
    left = np.full(len(points), np.inf)
    for vertices in hull_gap.split(getattr(shaped, which)):
        corners = skin[vertices]
        low, high = corners.min(axis=0) - ROUNDING, corners.max(axis=0) + ROUNDING
        near = ((points >= low) & (points <= high)).all(axis=1)
        left[near] = np.minimum(left[near], outside(ConvexHull(corners), points[near]))
    assert left.max() <= ROUNDING


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 2**31), st.sampled_from([0.0, 1e-4, 1e-3]))
def test_left_out_vertices_are_inside_at_every_pose(seed, size):
    """A cloud of points with a few shared weights, and pose blend shapes as strong as `size`."""
    rng = np.random.default_rng(seed)
    vertices = 120
    rest = rng.normal(scale=0.1, size=(vertices, 3))
    weights = np.zeros((vertices, N_JOINTS))
    kinds = rng.random((3, 4))
    weights[:, 12:16] = kinds[rng.integers(0, 3, vertices)]
    weights /= weights.sum(axis=1, keepdims=True)
    posedirs = np.zeros((vertices, 3, 486))
    posedirs[:, :, 90:120] = rng.normal(scale=size, size=(vertices, 3, 30))
    everything = SkinHulls(
        part=np.array([12]),
        first=np.array([0, vertices]),
        vertex=np.arange(vertices, dtype=np.int32),
    )
    fewer = without_inner(everything, weights, rest, posedirs if size else None)
    if size < 1e-3:
        assert len(fewer.vertex) < vertices, "nothing was left out: nothing is tested"
    shaped = Body(
        betas=np.zeros(0),
        gender="neutral",
        model="free",
        faces=np.zeros((0, 3), dtype=np.int32),
        weights=weights,
        rest_vertices=rest,
        rest_joints=rng.normal(scale=0.2, size=(N_JOINTS, 3)),
        posedirs=posedirs,
    )
    for _ in range(5):
        skin = shaped.vertices(any_pose(rng))
        assert outside(ConvexHull(skin[fewer.vertex]), skin).max() <= ROUNDING


def test_many_vertices_are_left_out(body):
    """Feet and head are mostly rigid: contacts skip the vertices inside them."""
    assert len(body.skin_corners.vertex) < 0.8 * len(body.skin_hulls.vertex)
    np.testing.assert_array_equal(body.skin_corners.part, body.skin_hulls.part)


def within(found: hull_gap.Gaps) -> tuple[float, float]:
    """The larger of pole and edge: median and 95th percentile [m]."""
    gaps = [found.gap[found.pole == kind] for kind in (True, False)]
    assert min(map(len, gaps)) > 100
    assert min(g.min() for g in gaps) > -ROUNDING, "skin that sticks out of the hulls"
    return max(np.median(g) for g in gaps), max(np.percentile(g, 95) for g in gaps)


@pytest.mark.slow
def test_the_gap_that_is_seen(body):
    """Deep squat, sitting, fists, bent elbows, raised arms, bowed and arched."""
    poses = list(hull_gap.bends().values())
    median, p95 = within(hull_gap.gaps(body, hull_gap.split(body.skin_hulls), poses, 25))
    assert median <= MEDIAN
    assert p95 <= P95
    uncut = within(hull_gap.gaps(body, hull_gap.joint_sets(body), poses, 25))
    assert p95 < 0.5 * uncut[1], "cutting is worth its hulls"


@pytest.mark.slow
def test_the_gap_that_is_seen_in_motions(body, shared_data):
    poses = list(hull_gap.motion_poses(shared_data / "motion", 2))
    median, p95 = within(hull_gap.gaps(body, hull_gap.split(body.skin_hulls), poses, 20))
    assert median <= MEDIAN
    assert p95 <= P95


@pytest.mark.slow
def test_the_gap_of_another_shape(body):
    """The cut is the mean shape's: it fits other shapes nearly as well."""
    poses = list(hull_gap.bends().values())
    for betas in np.array([[3.0, 0.0], [-3.0, 0.0], [0.0, 3.0], [0.0, -3.0]]):
        other = Body.default(betas)
        median, p95 = within(hull_gap.gaps(other, hull_gap.split(other.skin_hulls), poses, 15))
        assert median <= MEDIAN
        assert p95 <= P95


@pytest.mark.slow
def test_the_gap_of_a_body_without_fingers_and_face(body):
    """As in SMPL: each hand is one part, and so is the head."""
    weights = body.weights.copy()
    for joint, gone in ((20, LEFT_HAND_JOINTS), (21, RIGHT_HAND_JOINTS), (15, FACE_JOINTS)):
        weights[:, joint] += weights[:, gone].sum(axis=1)
        weights[:, gone] = 0.0
    smpl = dataclasses.replace(body, weights=weights)
    check(smpl.skin_hulls, smpl.faces, weights)
    assert len(smpl.skin_hulls.part) == PIECES
    poses = list(hull_gap.bends().values())
    found = hull_gap.gaps(smpl, hull_gap.split(smpl.skin_hulls), poses, 25)
    median, p95 = within(found)
    assert median <= MEDIAN
    assert p95 <= P95
    hands = np.isin(found.vertex, np.flatnonzero(weights[:, [20, 21]].sum(axis=1) > 0.5))
    assert np.percentile(found.gap[hands], 95) <= P95


def test_contacts_of_pole_and_edge_in_closed_form():
    """Against one segment, and across a gutter between two blocks."""
    flat = np.array([[[1.0, -1.0]], [[1.0, 1.0]]])
    assert hull_gap.pole_contact(*flat, 0.3, 0.02) == pytest.approx(0.98, abs=1e-15)
    assert hull_gap.pole_contact(*flat, 1.01, 0.02) == pytest.approx(
        1.0 - np.sqrt(0.02**2 - 0.01**2), abs=1e-15
    )
    assert hull_gap.pole_contact(*flat, 1.03, 0.02) == np.inf
    slope = np.array([[[0.0, 0.0]], [[1.0, 1.0]]])
    assert hull_gap.pole_contact(*slope, 0.5, 0.02) == pytest.approx(0.5 - 0.02 * np.sqrt(2))
    # {u >= s, v >= s} comes down onto the segment from (0, 1) to (1, 0) at its middle.
    assert hull_gap.edge_contact(np.array([[0.0, 1.0]]), np.array([[1.0, 0.0]])) == 0.5
    assert hull_gap.edge_contact(np.array([[2.0, 1.0]]), np.array([[3.0, 0.0]])) == 1.0


def test_the_gap_over_a_gutter_in_closed_form():
    """A V-shaped trough 90 degrees wide: one hull puts a lid on it, two leave it open."""
    section = [[-0.1, 0.1], [0.0, 0.0], [0.1, 0.1], [0.1, -0.1], [-0.1, -0.1]]
    skin = np.array([[x, y, z] for z in (-2.0, 2.0) for x, y in section])
    ridges = np.array([[0, 1], [1, 2], [2, 3], [3, 4], [4, 0]])
    plane = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0]])  # the pole comes down the middle
    lid = [np.arange(10)]
    halves = [np.array([0, 1, 4, 5, 6, 9]), np.array([1, 2, 3, 6, 7, 8])]
    for sets, height in (
        (lid, 0.1 + hull_gap.RADIUS),
        (halves, np.sqrt(2.0) * hull_gap.RADIUS),
    ):
        start, end = hull_gap.union_edges([skin[some] for some in sets])
        x = hull_gap.pole_contact(start @ plane.T, end @ plane.T, 0.0)
        assert -x == pytest.approx(height, abs=ROUNDING)
        distance, _ = hull_gap._nearest(skin @ plane.T, ridges, np.array([x, 0.0]))
        assert distance == pytest.approx(height / np.sqrt(2.0), abs=ROUNDING)
