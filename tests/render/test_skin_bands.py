"""Surfaces in bands of colour: the same surface, cut on lines of equal value."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from halfphysics.geometry.shapes import Sphere
from halfphysics.render.film import FilmOptions
from halfphysics.render.film.filming import Shoot
from halfphysics.render.pressure_colors import RAMP
from halfphysics.render.rasterizer import Surface
from halfphysics.render.result_meshes import Drawing
from halfphysics.render.skin_bands import BANDS, SkinPressures, banded
from halfphysics.results.skin_pressure import skin_pressure
from support.results.soft_results import soft_result

GREY = (0.5, 0.5, 0.5)


def ball():
    vertices, faces = Sphere(1.0).triangles()
    return Surface(vertices=vertices, faces=faces, color=GREY, crease=180.0)


def area(surface):
    a, b, c = np.moveaxis(surface.vertices[surface.faces], 1, 0)
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()


def test_the_bands_are_the_surface():
    surface = ball()
    pieces = banded(surface, 1000.0 * (surface.vertices[:, 2] + 1.0), 2000.0)
    assert len(pieces) == BANDS
    assert sum(map(area, pieces)) == pytest.approx(area(surface), rel=1e-9)
    assert len({piece.color for piece in pieces}) == BANDS
    for k, piece in enumerate(pieces):
        value = 1000.0 * (piece.vertices[:, 2] + 1.0)
        assert value.min() > 2000.0 * k / BANDS - 1e-6
        assert value.max() < 2000.0 * (k + 1) / BANDS + 1e-6


def test_without_pressure_it_keeps_its_colour():
    (piece,) = banded(ball(), np.zeros(len(ball().vertices)), 1000.0)
    assert piece.color == GREY
    assert len(piece.faces) == len(ball().faces)


def test_above_the_end_it_has_the_last_colour():
    pieces = banded(ball(), np.full(len(ball().vertices), 9e9), 1000.0)
    dark = np.array(pieces[-1].color)
    assert len(pieces) == 1
    assert np.linalg.norm(dark - RAMP[-1]) < np.linalg.norm(dark - RAMP[-2])


def test_a_film_colours_who_is_pressed():
    """At fractional frames the pressures are between theirs; the film has its own colours."""
    result = soft_result()
    own = skin_pressure(result)
    at = SkinPressures.of(result, np.array([3.0, 3.5, 15.0]))
    np.testing.assert_allclose(at.values[0][1], 0.5 * (own[3] + own[4]), atol=1e-3)
    np.testing.assert_array_equal(at.values[0][2], own[15])
    drawing = Drawing(result)
    every = SkinPressures.of(result, np.arange(16.0))
    plain = {surface.color for surface in drawing.moving(15)}
    colored = {surface.color for surface in drawing.moving(15, pressures=every)}
    assert len(colored) > len(plain) + 3
    # Who is not pressed yet looks as ever.
    assert {s.color for s in drawing.moving(0, pressures=every)} == {
        s.color for s in drawing.moving(0)
    }


def test_results_beside_each_other_have_one_scale():
    """One key stands for all: under a tenth of the pressure, colours are those of a tenth."""
    low = soft_result()
    rows = low.soft_contacts
    high = replace(
        low,
        scene=low.scene,
        people=low.people,
        soft_contacts=replace(rows, pressure=10.0 * rows.pressure),
    )
    frames = np.array([15.0])
    ends = [SkinPressures.of(result, frames).end for result in (low, high)]
    assert ends[0] < ends[1]
    options = FilmOptions(
        pressure=True, camera=("top",), size=(240, 120), samples=1, text=False, ghost=False
    )

    def scales(results):
        shoot = Shoot(results, options, [frames] * len(results), rate=30.0)
        return [pressures.end for pressures in shoot._pressures]

    assert scales([low, high]) == scales([high, low]) == [ends[1]] * 2
    assert scales([low]) == ends[:1]
