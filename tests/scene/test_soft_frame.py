"""SoftFrame: what is hard under a layer, of every kind of shape."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

import halfphysics as hp
from halfphysics.errors import InputError
from halfphysics.geometry.mesh import Mesh
from halfphysics.geometry.subdivision import subdivided
from halfphysics.scene.soft import checked_soft
from halfphysics.scene.soft_frame import fitting, most_thickness, soft_frame

#: Frames of one solid that is meshed differently lie within this share of the thickness. Where a
#: solid is thin, its middle is found to that share.
SAME = 0.05


def layer(thickness):
    return hp.Soft(thickness, 1e5)


def mesh_of(made, edge=None):
    vertices, faces = np.asarray(made.vertices), np.asarray(made.faces, dtype=np.int32)
    if edge:
        vertices, faces = subdivided(vertices, faces, edge, 100_000)
    return Mesh(vertices, faces.astype(np.int32))


@pytest.mark.parametrize(
    ("shape", "frame"),
    [
        (hp.Plane((0, 0, 2), 0.5), hp.Plane((0, 0, 1), 0.45)),
        (hp.Box((1.0, 0.5, 0.3)), hp.Box((0.9, 0.4, 0.2))),
        (hp.Sphere(0.11), hp.Sphere(0.06)),
        (hp.Capsule(0.1, 0.4), hp.Capsule(0.05, 0.4)),
        (hp.Cylinder(0.2, 0.3), hp.Cylinder(0.15, 0.2)),
    ],
    ids=lambda shape: type(shape).__name__,
)
def test_a_primitive_stays_of_its_kind_and_is_smaller_by_the_thickness(shape, frame):
    made = soft_frame(shape, layer(0.05))
    assert type(made.frame) is type(frame)
    for name, value in vars(frame).items():
        assert getattr(made.frame, name) == pytest.approx(value)
    assert made.surface.shape == made.inner.shape
    assert made.thickness == pytest.approx(0.05)


def test_surface_and_frame_of_a_mesh_correspond_vertex_by_vertex():
    made = soft_frame(mesh_of(trimesh.creation.box((1.0, 1.0, 0.5))), layer(0.1))
    assert len(made.surface) == 8  # as coarse as it was given
    assert len(made.frame.faces) == 12
    assert np.abs(made.surface - made.inner) == pytest.approx(0.1)
    corners = made.corner_thickness()
    assert corners.shape == (12, 3)
    assert corners == pytest.approx(0.1)


@pytest.mark.parametrize("edge", [0.02, 0.03, 0.05])
def test_a_solid_has_one_frame_however_it_is_meshed(edge):
    coarse = mesh_of(trimesh.creation.box((0.3, 0.2, 0.15)))
    t = 0.05
    want, found = soft_frame(coarse, layer(t)), soft_frame(mesh_of(coarse, edge), layer(t))
    far = want.frame.query.closest(found.inner)[0]
    assert far.max() < SAME * t
    assert found.thickness == pytest.approx(t, rel=SAME)


@pytest.mark.parametrize("edge", [None, 0.05, 0.03])
def test_a_thin_solid_too_has_one_frame_however_it_is_meshed(edge):
    """A cushion of 8 cm under a layer of 12 cm: 45 % of it on either side is soft."""
    plate = mesh_of(trimesh.creation.box((0.3, 0.3, 0.08)), edge)
    made = soft_frame(plate, layer(0.12))
    middle = np.abs(made.surface[:, :2]).max(axis=1) < 0.1
    assert middle.any()
    assert made.thickness[middle] == pytest.approx(0.45 * 0.08, rel=SAME)
    assert np.abs(made.inner[middle, 2]).max() < 0.05 * 0.08 + SAME * 0.12


def test_a_wedge_is_soft_as_far_as_it_is_thick_also_between_its_corners():
    corners = [[x, y, z] for x in (0.0, 1.0) for y in (0.0, 0.5) for z in (0.0, 0.4 * x)]
    wedge = mesh_of(trimesh.convex.convex_hull(np.unique(np.array(corners), axis=0)))
    made = soft_frame(wedge, layer(0.1))
    assert wedge.query.inside(made.inner).all()
    assert (made.thickness <= 0.1 + 1e-9).all()
    deep = made.thickness[(made.surface[:, 0] > 0.7) & (np.abs(made.surface[:, 1] - 0.25) < 0.1)]
    assert np.median(deep) == pytest.approx(0.1, rel=SAME)
    assert deep.min() > 0.07


def test_a_mesh_turned_inside_out_has_the_same_frame():
    box = trimesh.creation.box((1.0, 1.0, 0.5))
    turned = Mesh(np.asarray(box.vertices), np.asarray(box.faces[:, ::-1], dtype=np.int32))
    assert np.ptp(soft_frame(turned, layer(0.1)).inner, axis=0) == pytest.approx([0.8, 0.8, 0.3])


def test_a_frame_is_made_once_per_mesh_and_thickness():
    mesh = mesh_of(trimesh.creation.box((1.0, 1.0, 0.5)))
    first = soft_frame(mesh, layer(0.1))
    assert soft_frame(mesh, hp.Soft(0.1, 5e5)) is first
    assert soft_frame(mesh, layer(0.05)) is not first


@pytest.mark.parametrize(
    ("shape", "most"),
    [
        (hp.Box((1.0, 0.5, 0.2)), 0.09),
        (hp.Sphere(0.1), 0.09),
        (hp.Capsule(0.1, 1.0), 0.09),
        (hp.Cylinder(0.1, 1.0), 0.09),
        (hp.Cylinder(1.0, 0.2), 0.09),
        (hp.Plane(), np.inf),
    ],
)
def test_a_primitive_keeps_a_tenth_of_itself_hard(shape, most):
    assert most_thickness(shape) == pytest.approx(most)
    if np.isfinite(most):
        with pytest.raises(InputError, match=r"static 'x': soft: thickness is 0\.1 m; .* 0\.09 m"):
            fitting("static 'x'", shape, layer(0.1), named=False)
        thin = fitting("static 'x'", shape, layer(0.1), named=True)
        assert thin.thickness == pytest.approx(0.09)
        assert thin.thickness * thin.stiffness == pytest.approx(1e4)


def test_a_thin_mesh_that_moves_has_the_layer_of_the_same_box():
    """One thickness all over: what half of its surface has, so that nothing stands above it."""
    box = trimesh.creation.box((0.5, 0.4, 0.1))
    scene = hp.Scene()
    moving = scene.add_moving("lift", box, [[0.0, 0.0, 0.0]], fps=1.0, soft="pillow")
    loose = scene.add_object("pillow", box, mass=1.0, soft="pillow")
    same = scene.add_object("box", hp.Box((0.5, 0.4, 0.1)), mass=1.0, soft="pillow")
    for item in (moving, loose):
        assert item.soft.thickness == pytest.approx(same.soft.thickness, rel=1e-3)
        assert item.soft.stiffness == pytest.approx(same.soft.stiffness, rel=1e-3)
    thick = scene.add_object("cube", trimesh.creation.box((1.0, 1.0, 1.0)), mass=1.0, soft="pillow")
    assert thick.soft == checked_soft("cube", "pillow")
    with pytest.raises(InputError, match=r"sheet.*too thin for a layer"):
        scene.add_static("sheet", hp.Box((2.0, 2.0, 0.004)), soft="sofa")


def test_a_thin_mesh_that_moves_is_the_same_after_it_was_saved(tmp_path):
    """Its layer settles: whatever is thinned again stays as it is."""
    ball = trimesh.creation.icosphere(subdivisions=3)
    ball.apply_scale((0.15, 0.1, 0.025))
    scene = hp.Scene()
    first = scene.add_object("pebble", ball, mass=1.0, soft="pillow").soft
    assert first.thickness < 0.05
    for _ in range(2):
        scene.save(tmp_path / "a.yaml")
        scene = hp.Scene.load(tmp_path / "a.yaml")
        assert scene.objects["pebble"].soft == first
    with pytest.raises(InputError, match=r"sheet.*too thin for a layer"):
        scene.add_object("sheet", trimesh.creation.box((1, 1, 0.0015)), mass=1.0, soft="sofa")
