"""Soft things in pictures: their meshes dent, their edges go along, hard ones stay as they were."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.render.contact_sheet import contact_sheet_png
from halfphysics.render.film.sampling import sampled
from halfphysics.render.outlines import border, edges
from halfphysics.render.rasterizer import Camera
from halfphysics.render.result_meshes import Drawing
from support.results.soft_results import BED, FRAMES, TOP, soft_result

DIP = 1 + FRAMES // 4
#: A plane's mesh ends 10 m from its origin [m].
AWAY = 30.0


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


@pytest.fixture(scope="module")
def on_a_plane():
    """A ball on a soft floor 60 cm below the origin, `AWAY` from the point where the plane is."""
    scene = hp.Scene()
    soft = hp.Soft(thickness=0.1, stiffness=2e5)
    scene.add_static("mat", hp.Plane(), position=(0.0, 0.0, -0.6), soft=soft)
    near = (AWAY - 22.0, 0.0, -0.51)
    scene.add_object("ball", hp.Sphere(0.1), mass=8.0, position=near)
    motion = hp.Motion(np.tile([AWAY, 0.0, 1.0], (8, 1)), np.zeros((8, 55, 3)), 30.0)
    return hp.simulate(motion, scene, settings=hp.Settings(weight=False))


def test_the_grid_of_a_soft_floor_lies_on_it(on_a_plane):
    drawing = Drawing(on_a_plane)
    middle = drawing.middle
    camera = Camera(position=np.add(middle, [3.0, 3.0, 2.0]), target=middle)
    (lines,) = drawing.edges(camera, 480, 7)
    # Strips face the camera: they have a width of centimetres far away.
    assert np.abs(lines.vertices[:, 2] + 0.6).max() < 0.05
    below = Camera(position=np.add(middle, [3.0, 3.0, -1.0 - middle[2] - 0.6]), target=middle)
    assert drawing.edges(below, 480, 7) == []


def test_a_soft_floor_reaches_as_far_as_the_story(on_a_plane):
    """Around the middle of the story as far as a hard floor, without holes and overlaps."""
    hard = dataclasses.replace(
        on_a_plane, scene=on_a_plane.scene, people=on_a_plane.people, soft_contacts=None
    )
    surface, flat = (
        drawing.still()["static/mat"] for drawing in (Drawing(on_a_plane), Drawing(hard))
    )
    low, high = flat.vertices.min(axis=0), flat.vertices.max(axis=0)
    assert (surface.vertices.min(axis=0)[:2] <= low[:2] + 1e-9).all()
    assert (surface.vertices.max(axis=0)[:2] >= high[:2] - 1e-9).all()
    size = np.ptp(surface.vertices[:, :2], axis=0)
    a, b, c = np.moveaxis(surface.vertices[surface.faces], 1, 0)
    across = np.cross(b - a, c - a)[:, 2]
    assert (across > 0.0).all()
    assert 0.5 * across.sum() == pytest.approx(size.prod(), rel=1e-6)
    dented = Drawing(on_a_plane).dented(7)["static/mat"]
    assert dented.vertices[:, 2].min() < -0.601
