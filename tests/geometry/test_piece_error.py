"""The reported errors of pieces are correct, on thin walls too: closed forms and other methods."""

from __future__ import annotations

import warnings

import coal
import numpy as np
import pytest
from scipy.spatial import Delaunay
from scipy.stats.qmc import Sobol

from halfphysics.errors import HalfPhysicsWarning
from halfphysics.geometry.convex_decomposition import THRESHOLD, WARN_MM, Cut, decompose
from halfphysics.geometry.piece_error import piece_error
from halfphysics.geometry.shapes import Mesh
from halfphysics.scene.scene import Scene
from support.judges.coal_shapes import coal_hull
from support.revolution import cup, pipe, wine_glass

#: Sections around a pipe, its radius and height [m].
COUNT, RADIUS, HEIGHT = 48, 0.035, 0.1
#: Samples miss the deepest point by this share of the depth.
SAMPLED = 0.01
#: Tolerance for depths measured here by other methods at random points [mm].
MEASURED = 0.15
#: Tolerance for shares of volume, counted by two sets of points [% of the mesh].
COUNTED = 1.5


def sagged(wall, span, radius=RADIUS):
    """Pieces of `span` sections: depth in the pipe [mm], added volume [%]."""
    inner, half = radius - wall, np.pi / COUNT
    chord = inner * np.cos(span * half)
    deep = (inner - chord) * np.cos(half) if span % 2 == 0 else inner * np.cos(half) - chord
    more = span * np.sin(2.0 * half) - np.sin(2.0 * span * half)
    more *= inner**2 * COUNT / span
    return 1000.0 * deep, 100.0 * more / (COUNT * np.sin(2.0 * half) * (radius**2 - inner**2))


@pytest.mark.parametrize("wall", [0.002, 0.003])
@pytest.mark.parametrize("span", [1, 3, 6, 12])
def test_the_error_of_a_thin_pipe_in_closed_form(wall, span):
    mesh, pieces = pipe(RADIUS, wall, HEIGHT, COUNT)
    assert mesh.closed
    error = piece_error(mesh, pieces(span))
    deep, more = sagged(wall, span)
    assert error.inside_mm == 0.0
    assert error.outside_mm == pytest.approx(deep, rel=SAMPLED, abs=1e-3)
    assert error.volume_percent == pytest.approx(more, rel=0.01, abs=COUNTED)


@pytest.mark.parametrize(("share", "said"), [(0.98, False), (1.02, True)])
def test_the_warning_comes_over_five_millimetres(share, said):
    """The same pipe in two sizes, pieces 4.9 and 5.1 mm off."""
    radius = RADIUS * share * WARN_MM / sagged(0.1 * RADIUS, 8)[0]
    mesh, pieces = pipe(radius, 0.1 * radius, HEIGHT, COUNT)
    assert sagged(0.1 * radius, 8, radius)[0] == pytest.approx(share * WARN_MM)
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        Scene().add_object("pipe", mesh, mass=0.1, pieces=pieces(8))
    texts = [str(w.message) for w in found if issubclass(w.category, HalfPhysicsWarning)]
    assert bool(texts) == said
    if said:
        assert f"stick out of the mesh by up to {share * WARN_MM:.1f} mm" in texts[0]


def measured(turned, mesh, pieces, rng):
    """Depths [mm] and volume [%] by points at random: formulas, simplices, coal."""
    solids = [Delaunay(piece.vertices) for piece in pieces]
    out = 0.0
    for solid in solids:
        # Points of the faces: a piece protrudes farthest with its surface.
        corners = solid.points[solid.convex_hull]
        for weights in rng.dirichlet(np.ones(3), size=100):
            found = turned.signed_distance(np.einsum("c,fci->fi", weights, corners))
            out = max(out, found.max())
    faces = mesh.vertices[mesh.faces]
    area = np.linalg.norm(np.cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0]), axis=1)
    which = rng.choice(len(faces), size=1000, p=area / area.sum())
    weights = rng.dirichlet(np.ones(3), size=len(which))
    surface = np.concatenate([mesh.vertices, np.einsum("nc,nci->ni", weights, faces[which])])
    covered = np.any([s.find_simplex(surface, tol=1e-9) >= 0 for s in solids], axis=0)
    hulls, bare, here = [coal_hull(p.vertices) for p in pieces], 0.0, coal.Transform3s()
    for point in surface[~covered]:
        at, ball = coal.Transform3s(np.eye(3), point), coal.Sphere(1e-9)
        ask = coal.DistanceRequest
        gaps = [coal.distance(h, here, ball, at, ask(), coal.DistanceResult()) for h in hulls]
        bare = max(bare, min(gaps))
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    points = low + (high - low) * Sobol(3, rng=rng).random_base2(17)
    filled = np.any([s.find_simplex(points) >= 0 for s in solids], axis=0)
    held = mesh.query.inside(points)
    more = 100.0 * (filled.sum() - held.sum()) / held.sum()
    return 1000.0 * out, 1000.0 * bare, more


def clusters(mesh, count, rng):
    """Hulls of the vertices nearest to each of some points: pieces of the worst quality."""
    middles = mesh.vertices[rng.choice(len(mesh.vertices), count, replace=False)]
    nearest = np.linalg.norm(mesh.vertices[:, None] - middles, axis=2).argmin(axis=1)
    pieces = []
    for k in range(count):
        corners = mesh.vertices[nearest == k]
        n = np.arange(len(corners))
        if len(corners) >= 8 and np.linalg.svd(corners - corners.mean(axis=0))[1][-1] > 1e-3:
            pieces.append(Mesh(corners, np.stack([n, np.roll(n, 1), np.roll(n, 2)], axis=1)).hull)
    return pieces


def test_the_error_of_a_wine_glass_by_other_means():
    rng = np.random.default_rng(0)
    glass = wine_glass()
    mesh = glass.mesh(48)
    assert mesh.closed
    pieces = clusters(mesh, 40, rng)
    error = piece_error(mesh, pieces)
    outside, inside, more = measured(glass, mesh, pieces, rng)
    assert error.outside_mm > WARN_MM
    assert error.inside_mm > WARN_MM
    assert error.outside_mm == pytest.approx(outside, rel=SAMPLED, abs=MEASURED)
    # Fewer surface points here: they miss more of it.
    assert inside < error.inside_mm + MEASURED
    assert error.inside_mm < 1.03 * inside
    assert error.volume_percent == pytest.approx(more, rel=0.01, abs=COUNTED)


@pytest.mark.slow
def test_what_coacd_makes_of_a_thin_cup_is_said_truly():
    pytest.importorskip("coacd")
    rng = np.random.default_rng(0)
    thin = cup()
    mesh = thin.mesh(32)
    made = decompose(mesh, Cut())
    outside, inside, more = measured(thin, mesh, made.pieces, rng)
    assert made.outside_mm == pytest.approx(outside, abs=MEASURED)
    assert made.inside_mm == pytest.approx(inside, abs=MEASURED)
    assert made.volume_percent == pytest.approx(more, rel=0.01, abs=COUNTED)
    assert 0.5 < made.outside_mm < 1000.0 * THRESHOLD + MEASURED
