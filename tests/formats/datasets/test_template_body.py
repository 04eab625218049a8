"""The size of a person from a mesh of their skin at rest."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

import halfphysics as hp
from halfphysics.errors import FileError, InputError
from halfphysics.formats.datasets.template_body import template_body
from support.carries.people import person

#: Joints of a person whose arms are longer than those of the free body [m].
NEAR = 1e-3
#: Those of a person with other shape coefficients, by the regressor: single precision [m].
SINGLE = 1e-6


def written(body, path, finer=False):
    vertices, faces = body.rest_vertices, body.faces
    if finer:
        vertices, faces = trimesh.remesh.subdivide(vertices, faces)
    trimesh.Trimesh(vertices, faces, process=False).export(path)
    return path


@pytest.mark.parametrize("size", [(1.55, 0.9), (1.95, 1.1), (1.7, 1.0)])
@pytest.mark.parametrize("finer", [False, True])
def test_people_of_other_proportions(tmp_path, size, finer):
    """Also by a mesh of which nothing is known but that it is a person at rest."""
    body = person(*size)
    found = template_body(written(body, tmp_path / "s1.ply", finer))
    assert np.linalg.norm(found.rest_joints - body.rest_joints, axis=1).max() < NEAR
    assert abs(found.stature - body.stature) < NEAR


def test_another_shape_has_the_joints_of_its_skin(tmp_path):
    body = hp.Body.default(betas=[2.0, -2.0, 1.0])
    found = template_body(written(body, tmp_path / "s1.obj"))
    assert np.linalg.norm(found.rest_joints - body.rest_joints, axis=1).max() < SINGLE


def test_where_it_is_does_not_matter(tmp_path):
    """The pelvis is where the template has it: data sets add their translation to it."""
    body = person(1.62)
    moved = trimesh.Trimesh(
        body.rest_vertices + np.array([0.0, 0.5, 0.1]), body.faces, process=False
    )
    moved = moved.subdivide()
    moved.export(tmp_path / "s1.ply")
    found = template_body(tmp_path / "s1.ply")
    assert np.abs(found.rest_joints - body.rest_joints - [0.0, 0.5, 0.1]).max() < NEAR


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda v: 1000.0 * v, "a template 17"),
        (lambda v: v[:, [0, 2, 1]], "expected a person at rest in metres: y up"),
        (lambda v: v * [0.78, 1.0, 1.0], "found arms 0.6"),
        (lambda v: v * np.nan, "vertices, expected the skin of a person"),
    ],
)
def test_what_is_no_person_at_rest(tmp_path, change, message):
    skin = trimesh.remesh.subdivide(hp.Body.default().rest_vertices, hp.Body.default().faces)
    lines = [f"v {x} {y} {z}" for x, y, z in change(skin[0])]
    (tmp_path / "s1.obj").write_text("\n".join(lines))
    with pytest.raises(InputError, match=f"s1.obj: .*({message})"):
        template_body(tmp_path / "s1.obj")


def test_a_file_that_cannot_be_read(tmp_path):
    (tmp_path / "s1.ply").write_text("not a mesh")
    with pytest.raises(FileError, match=r"s1\.ply"):
        template_body(tmp_path / "s1.ply")
