"""Mesh files of every format, and invalid files."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np
import pytest

from halfphysics.errors import FileError
from halfphysics.geometry.mesh import Mesh
from halfphysics.geometry.mesh_files import load_mesh
from halfphysics.geometry.shapes import Box

trimesh = pytest.importorskip("trimesh")

# Written as text with eight digits or as float32.
WRITTEN = 1e-6


@pytest.mark.parametrize("suffix", ["obj", "glb", "ply", "stl", "off"])
def test_every_format(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"box.{suffix}"
    trimesh.creation.box((1.0, 2.0, 3.0)).apply_translation((1.0, 2.0, 3.0)).export(path)
    mesh, source = load_mesh(path)
    assert mesh.closed
    assert mesh.vertices.shape == (8, 3)
    assert mesh.volume == pytest.approx(6.0, rel=WRITTEN)
    # glTF is y-up by its standard: (x, y, z) becomes (x, -z, y) here.
    y_up = suffix == "glb"
    np.testing.assert_allclose(mesh.centre, (1, -3, 2) if y_up else (1, 2, 3), atol=WRITTEN)
    assert source.up == ("y" if y_up else "z")
    assert source.path == str(path.resolve())
    assert source.sha256 == hashlib.sha256(path.read_bytes()).hexdigest()
    scaled, _ = load_mesh(path, scale=0.5, up="y")
    np.testing.assert_allclose(scaled.centre, (0.5, -1.5, 1.0), atol=WRITTEN)
    as_is, _ = load_mesh(path, up="z")
    np.testing.assert_allclose(as_is.centre, (1, 2, 3), atol=WRITTEN)


def test_several_geometries_with_transforms(tmp_path: Path) -> None:
    box = trimesh.creation.box((1.0, 1.0, 1.0))
    scene = trimesh.Scene()
    scene.add_geometry(box, geom_name="box", node_name="a")
    moved = trimesh.transformations.translation_matrix([3.0, 0.0, 0.0])
    scene.add_geometry(box, geom_name="box", node_name="b", transform=moved)
    mirror = np.diag([-2.0, 1.0, 1.0, 1.0])
    mirror[0, 3] = -5.0
    scene.add_geometry(box, geom_name="box", node_name="c", transform=mirror)
    path = tmp_path / "room.glb"
    scene.export(path)
    mesh, _ = load_mesh(path, up="z")
    assert len(mesh.vertices) == 24
    assert mesh.volume == pytest.approx(4.0, rel=WRITTEN)  # the mirrored one is not inside out
    np.testing.assert_allclose(mesh.vertices.min(axis=0), (-6.0, -0.5, -0.5), atol=WRITTEN)
    inside = mesh.query.inside([[0, 0, 0], [3, 0, 0], [-5.5, 0, 0], [1.5, 0, 0]])
    np.testing.assert_array_equal(inside, [True, True, True, False])


def test_same_file_same_mesh(tmp_path: Path) -> None:
    path = tmp_path / "m.obj"
    trimesh.creation.icosphere(subdivisions=2).export(path)
    a, b = load_mesh(path)[0], load_mesh(path)[0]
    np.testing.assert_array_equal(a.vertices, b.vertices)
    np.testing.assert_array_equal(a.faces, b.faces)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n", "found no triangles|cannot be read"),
        ("cloud.xyz", "0 0 0\n1 0 0\n0 1 0\n", "unknown kind of mesh '.xyz'"),
        ("bad.stl", "\0\1\2", "found no triangles|cannot be read as a stl mesh"),
        ("bad.glb", "this is no glTF", "cannot be read as a glb mesh"),
        ("nan.obj", "v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n", "NaN or infinite"),
        ("flat.off", "OFF\n3 1 0\n0 0 0\n0 0 0\n0 0 0\n3 0 1 2\n", "three different corners"),
        ("scene.blend", "BLENDER", "unknown kind of mesh '.blend', expected one of .*obj"),
        ("noname", "x", "no suffix"),
    ],
)
def test_files_that_are_no_meshes(tmp_path: Path, name: str, content: str, message: str) -> None:
    path = tmp_path / name
    path.write_text(content)
    with pytest.raises(FileError, match=message) as caught:
        load_mesh(path)
    assert str(path) in str(caught.value)


def test_missing_files(tmp_path: Path) -> None:
    (tmp_path / "chair.obj").write_text("")
    with pytest.raises(FileError, match=r"no such file.*did you mean .*chair\.obj"):
        load_mesh(tmp_path / "chiar.obj")
    with pytest.raises(FileError, match=r"folder .*nowhere does not exist"):
        load_mesh(tmp_path / "nowhere" / "chair.obj")
    with pytest.raises(FileError, match="is a folder"):
        load_mesh(tmp_path)


def test_all_real_meshes(shared_data: Path) -> None:
    paths = sorted((shared_data / "meshes").glob("*/*.obj"))
    assert len(paths) > 10
    for path in paths:
        mesh, _ = load_mesh(path, scale=0.7, up="y")
        assert isinstance(mesh, Mesh)
        extent = np.ptp(mesh.vertices, axis=0)
        assert 0.1 < extent.max() < 4.0, path.name
        assert 0.0 < mesh.solid_volume <= mesh.hull.volume * 1.02, path.name
        assert mesh.hull.volume <= Box(extent).volume * (1 + 1e-9), path.name
