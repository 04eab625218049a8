"""Parts of a mesh: their area is that of the cut figure, and parts meet without a gap."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.render.cutting import cut


def sheet(n=13):
    """A square of side 2 around the origin."""
    x = np.linspace(-1.0, 1.0, n)
    vertices = np.stack([*np.meshgrid(x, x, indexing="ij"), np.zeros((n, n))], axis=2).reshape(
        -1, 3
    )
    k = np.arange(n * n).reshape(n, n)
    a, b, c, d = k[:-1, :-1], k[1:, :-1], k[1:, 1:], k[:-1, 1:]
    faces = np.concatenate([np.stack(t, axis=2).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    return vertices, faces


def area(vertices, faces):
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return 0.5 * np.cross(b - a, c - a)[:, 2]


def test_a_straight_line_cuts_off_its_polygon():
    vertices, faces = sheet()
    field = 0.37 - vertices[:, 0] - 2.0 * vertices[:, 1]
    part = cut(field, faces)
    inside = area(part.of(vertices), part.faces)
    assert (inside > -1e-15).all()  # no face is turned over
    # The line meets y = -1 beyond x = 1, and y = 1 left of x = -1: a trapezoid.
    left, right = (0.37 + 1.0) / 2.0, (0.37 - 1.0) / 2.0
    assert inside.sum() == pytest.approx(2.0 * (0.5 * (left + right) + 1.0), abs=1e-12)
    # Linear values are exact, on the line too.
    np.testing.assert_allclose(
        part.of(field), 0.37 - part.of(vertices) @ [1.0, 2.0, 0.0], atol=1e-12
    )
    assert part.of(field).min() == pytest.approx(0.0, abs=1e-12)


def test_a_field_and_its_negative_share_the_border():
    vertices, faces = sheet()
    field = 0.61 - np.linalg.norm(vertices, axis=1)
    parts = [cut(f, faces) for f in (field, -field)]
    places = [part.of(vertices) for part in parts]
    total = sum(area(p, part.faces).sum() for p, part in zip(places, parts, strict=True))
    assert total == pytest.approx(4.0, abs=1e-12)
    borders = [
        {tuple(np.round(x, 12)) for x in p[abs(part.of(field)) < 1e-12]}
        for p, part in zip(places, parts, strict=True)
    ]
    assert borders[0] == borders[1]
    assert len(borders[0]) > 20
    # Nearly a disc.
    assert area(places[0], parts[0].faces).sum() == pytest.approx(np.pi * 0.61**2, rel=0.02)


def test_all_and_nothing():
    vertices, faces = sheet(4)
    whole = cut(np.ones(len(vertices)), faces)
    np.testing.assert_array_equal(whole.of(vertices)[whole.faces], vertices[faces])
    assert len(cut(-np.ones(len(vertices)), faces).faces) == 0
