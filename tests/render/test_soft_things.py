"""Soft things in pictures: their meshes dent, their edges go along, hard ones stay as they were."""

from __future__ import annotations

import dataclasses

import numpy as np

from halfphysics.render.contact_sheet import contact_sheet_png
from halfphysics.render.film.sampling import sampled
from halfphysics.render.outlines import border, edges
from halfphysics.render.result_meshes import Drawing
from support.results.soft_results import BED, FRAMES, TOP, soft_result

DIP = 1 + FRAMES // 4


def hard():
    return dataclasses.replace(soft_result(), soft_contacts=None)


def test_the_bed_of_a_drawing_dents_under_the_ball():
    drawing = Drawing(soft_result())
    (name,) = drawing.dented(DIP)
    surface = drawing.dented(DIP)[name]
    near = np.linalg.norm(surface.vertices[:, :2] - (0.7, 0.35), axis=1) < 0.02
    assert surface.vertices[near & (surface.vertices[:, 2] > 0.2), 2].max() < TOP - 0.04
    flat = drawing.still()[name]
    assert flat.vertices[:, 2].max() == TOP
    np.testing.assert_array_equal(drawing.surfaces(DIP)[name].vertices, surface.vertices)


def test_what_nothing_presses_is_drawn_as_before():
    drawing = Drawing(hard())
    assert drawing.dented(DIP) == {}
    surface = drawing.still()["static/bed"]
    assert len(surface.vertices) == 8
    assert len(surface.faces) == 12


def test_a_film_between_frames_shows_dents_between_theirs():
    drawing = Drawing(sampled(soft_result(), np.array([DIP - 1, DIP - 0.5, DIP])))
    low = [drawing.dented(k)["static/bed"].vertices[:, 2] for k in range(3)]
    np.testing.assert_allclose(low[1], 0.5 * (low[0] + low[2]), atol=1e-7)


def test_edges_of_a_bed_that_nothing_presses_are_those_of_a_box():
    (item, found) = Drawing(soft_result())._borders[0]
    lines = found.at(item.at(0).vertices)
    length = np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1).sum()
    assert np.isclose(length, 4 * sum(BED), rtol=1e-6)
    whole = edges(Drawing(hard()).statics["static/bed"].at(0))
    assert np.isclose(np.linalg.norm(whole[:, 1] - whole[:, 0], axis=1).sum(), length, rtol=1e-2)


def test_edges_go_along_where_a_side_gives():
    item = Drawing(soft_result()).statics["static/bed"]
    found = border(item.surface)
    up, vertices = np.array([0.0, 0.0, 1.0]), item.at(0).vertices
    np.testing.assert_allclose(found.at(vertices + up), found.at(vertices) + up)


def test_a_sheet_of_pictures_shows_the_dent():
    frames = [DIP]
    soft = contact_sheet_png(soft_result(), frames=frames, columns=1, size=(160, 120))
    assert soft != contact_sheet_png(hard(), frames=frames, columns=1, size=(160, 120))


def test_what_dents_is_never_glass():
    drawing = Drawing(soft_result())
    assert drawing.still(["static/bed"])["static/bed"].alpha == 1.0
    assert Drawing(hard()).still(["static/bed"])["static/bed"].alpha < 1.0
