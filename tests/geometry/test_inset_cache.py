"""Insets kept on the disk: the same bytes as made, and nothing that is damaged."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from halfphysics.geometry import inset as making
from halfphysics.geometry import inset_cache


@pytest.fixture
def ball():
    mesh = trimesh.creation.icosphere(subdivisions=3, radius=0.3)
    assert len(mesh.vertices) > inset_cache.FEWEST
    return np.array(mesh.vertices), np.array(mesh.faces, dtype=np.int32)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("HALFPHYSICS_CACHE", str(tmp_path))
    return tmp_path / "insets"


def test_it_is_made_once_and_read_with_the_same_bytes(ball, folder, monkeypatch):
    made = making.inset(*ball, 0.05)
    assert len(list(folder.glob("*.npz"))) == 1
    monkeypatch.setattr(making, "_made", None)  # made again, it would fail
    read = making.inset(*ball, 0.05)
    assert read.vertices.tobytes() == made.vertices.tobytes()
    assert read.thickness.tobytes() == made.thickness.tobytes()


def test_another_surface_thickness_or_order_is_another_key(ball):
    vertices, faces = ball
    t = np.full(len(vertices), 0.05)
    keys = {
        inset_cache.key_of(*some)
        for some in (
            (vertices, faces, t),
            (vertices + 1e-12, faces, t),
            (vertices, faces[::-1], t),
            (vertices, faces, 1.01 * t),
        )
    }
    assert len(keys) == 4


@pytest.mark.parametrize("damage", ["cut", "other", "nan"])
def test_a_damaged_file_is_made_again(ball, folder, damage):
    made = making.inset(*ball, 0.05)
    (path,) = folder.glob("*.npz")
    if damage == "cut":
        path.write_bytes(path.read_bytes()[:100])
    elif damage == "other":
        inset_cache.write(path.stem, made.vertices[:-1], made.thickness[:-1])
    else:
        inset_cache.write(path.stem, np.nan * made.vertices, made.thickness)
    again = making.inset(*ball, 0.05)
    assert again.vertices.tobytes() == made.vertices.tobytes()
    assert inset_cache.read(path.stem, len(made.vertices)) is not None


def test_small_surfaces_are_not_kept(folder):
    box = trimesh.creation.box((1.0, 1.0, 1.0))
    making.inset(np.array(box.vertices), np.array(box.faces, dtype=np.int32), 0.1)
    assert not folder.exists()


def test_a_folder_that_cannot_be_written_is_said(ball, tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("HALFPHYSICS_CACHE", str(tmp_path / "file"))
    with pytest.warns(match="cannot be kept"):
        making.inset(*ball, 0.05)
