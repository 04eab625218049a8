"""Dents in glTF and USD, read by other readers: every vertex where the result has it."""

from __future__ import annotations

import dataclasses
import tracemalloc

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.writers.dent_shapes import TOLERANCE, dent_shapes, moving_surface
from halfphysics.writers.take import take_of
from support.files.gltf_reader import Gltf
from support.results.gltf_results import y_up
from support.results.soft_results import FPS, FRAMES, soft_result

#: Single precision, in metres.
SINGLE = 1e-6


@pytest.fixture(scope="module")
def moving():
    return moving_surface(soft_result().dents["bed"])


def test_few_shapes_make_up_all_frames(moving):
    offsets, normals, weights = dent_shapes(moving)
    assert len(offsets) == weights.shape[1] <= FRAMES
    rest = moving.at(0)[1]
    for frame in range(FRAMES):
        vertices, exact = moving.at(frame)
        ours = moving.vertices + np.tensordot(weights[frame], offsets, 1)
        assert np.abs(ours - vertices).max() < 1.5 * TOLERANCE
        turned = rest + np.tensordot(weights[frame], normals, 1)
        turned /= np.linalg.norm(turned, axis=1, keepdims=True)
        angle = np.degrees(np.arccos(np.clip((turned * exact).sum(axis=1), -1.0, 1.0)))
        assert angle.max() < 10.0


def test_memory_does_not_grow_by_the_normals_of_every_frame(moving, monkeypatch):
    """Of more frames it grows by a fifth of their normals in double precision, at most."""
    depth = moving.dent.depth
    monkeypatch.setattr("halfphysics.results.low_rank.MOST_FRAMES", 30)

    def peak(repeats):
        dent = dataclasses.replace(moving.dent, depth=np.tile(depth, (repeats, 1)))
        tracemalloc.start()
        dent_shapes(dataclasses.replace(moving, dent=dent))
        most = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return most, len(dent)

    (small, few), (large, many) = peak(8), peak(12)
    normals = 24 * len(moving.own) * (many - few)
    assert large - small < 0.2 * normals


def test_only_normals_beside_what_gives_turn(moving):
    turning = np.zeros(len(moving.own), dtype=bool)
    turning[moving.turning] = True
    rest = moving.at(0)[1]
    turned = [np.abs(moving.at(frame)[1] - rest).max(axis=1) > 0.0 for frame in range(FRAMES)]
    assert not np.any(turned, axis=0)[~turning].any()
    assert 0 < turning.sum() < len(turning)
    normals = dent_shapes(moving)[1]
    assert not normals[:, ~turning].any()


def test_sharp_edges_stay_sharp(moving):
    """The bed's edges have a vertex for each side: the normals at rest are along the axes."""
    normals = moving.at(0)[1]
    assert np.abs(normals).max(axis=1).min() > 0.999


def test_gltf_has_them_as_morph_targets(tmp_path, moving):
    path = tmp_path / "bed.glb"
    hp.export(soft_result(), path)
    file = Gltf(path)
    file.check()
    bed = soft_result().scene.statics["bed"].position
    for frame in (0, 5, FRAMES - 1):
        theirs = file.vertices("bed", frame / FPS)
        ours = y_up(moving.at(frame)[0] + bed)
        assert np.abs(theirs - ours).max() < 1.5 * TOLERANCE + SINGLE
    primitive = file.json["meshes"][file.json["nodes"][file.node("bed")]["mesh"]]["primitives"][0]
    assert {frozenset(target) for target in primitive["targets"]} == {
        frozenset(("POSITION", "NORMAL"))
    }


def test_other_programs_read_the_gltf(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    path = tmp_path / "bed.glb"
    hp.export(soft_result(), path)
    scene = trimesh.load(path)
    assert any("bed" in name for name in scene.geometry)


def test_usd_has_points_over_time(tmp_path, moving):
    pytest.importorskip("pxr")
    from pxr import Usd, UsdGeom

    path = tmp_path / "bed.usdc"
    hp.export(soft_result(), path)
    stage = Usd.Stage.Open(str(path))
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/World/bed/Mesh"))
    for frame in range(FRAMES):
        points = np.array(mesh.GetPointsAttr().Get(frame))
        assert np.abs(points - moving.at(frame)[0]).max() < SINGLE
        normals = np.array(mesh.GetNormalsAttr().Get(frame))
        assert np.abs(normals - moving.at(frame)[1]).max() < SINGLE


def test_at_another_rate_dents_are_between_theirs():
    take = take_of(soft_result(), fps=2 * FPS)
    dent = next(prop.dent for prop in take.props if prop.name == "bed")
    own = soft_result().dents["bed"]
    assert len(dent) == take.frames
    np.testing.assert_allclose(dent.depth[::2][:FRAMES], own.depth, atol=1e-7)
    np.testing.assert_allclose(dent.depth[9], 0.5 * (own.depth[4] + own.depth[5]), atol=1e-7)


def test_hard_things_are_written_as_before(tmp_path):
    """A result without soft contacts: no targets, the twelve faces of the bed."""
    hard = dataclasses.replace(soft_result(), soft_contacts=None)
    hp.export(hard, tmp_path / "hard.glb")
    file = Gltf(tmp_path / "hard.glb")
    mesh = file.json["meshes"][file.json["nodes"][file.node("bed")]["mesh"]]
    assert "weights" not in mesh
    assert "targets" not in mesh["primitives"][0]
    assert file.json["accessors"][mesh["primitives"][0]["indices"]]["count"] == 36
