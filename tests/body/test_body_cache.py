"""What is kept of a body on disk is what would be made; what is damaged is made anew."""

from __future__ import annotations

import dataclasses
import os
import shutil
import subprocess
import sys

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base.npz import write_npz
from halfphysics.body import body_cache
from halfphysics.body.rigid_parts import build_variant
from halfphysics.body.skin_corners import without_inner


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("HALFPHYSICS_CACHE", str(tmp_path))
    return tmp_path / "bodies"


@pytest.fixture(scope="module")
def once(tmp_path_factory):
    """A folder in which the default body is kept, and what was made of it: seconds of work."""
    folder = tmp_path_factory.mktemp("once")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("HALFPHYSICS_CACHE", str(folder))
        body = unknown()
        return folder / "bodies", (body.variant, body.skin_corners)


@pytest.fixture
def kept(folder, once):
    """What was made of the default body, which is kept in this test's folder."""
    shutil.copytree(once[0], folder)
    return once[1]


def unknown(**changes):
    """A body of which nothing is kept in this process."""
    return dataclasses.replace(hp.Body.default(), **changes)


def made(body):
    image = None if body.symmetry is None else body.symmetry.vertex
    pieces = without_inner(body.skin_hulls, body.weights, body.rest_vertices, body.posedirs, image)
    return build_variant(body), pieces


def same(variant, corners, others):
    theirs, its = others
    for mine, other in zip(variant.parts, theirs.parts, strict=True):
        for field in dataclasses.fields(mine):
            a, b = getattr(mine, field.name), getattr(other, field.name)
            assert np.array_equal(a, b), field.name
            assert getattr(a, "dtype", None) == getattr(b, "dtype", None), field.name
    assert np.array_equal(variant.joint_offsets, theirs.joint_offsets)
    assert (variant.volume, variant.mass) == (theirs.volume, theirs.mass)
    for field in dataclasses.fields(corners):
        assert np.array_equal(getattr(corners, field.name), getattr(its, field.name))


def files(folder):
    return sorted(folder.glob("*.npz")) if folder.is_dir() else []


def test_kept_is_what_would_be_made(folder, kept):
    assert len(files(folder)) == 2
    again = unknown()
    same(again.variant, again.skin_corners, kept)
    same(again.variant, again.skin_corners, made(again))
    for part in again.variant.parts:
        assert not part.vertices.flags.writeable
        assert not part.inertia.flags.writeable


def test_other_bodies_are_others(folder, kept):
    mean, tall = unknown(), hp.Body.default(stature=1.9)
    assert mean.variant.mass != tall.variant.mass
    bent = unknown(posedirs=np.full((13718, 3, 486), 1e-6))
    assert len(bent.skin_corners.vertex) > len(mean.skin_corners.vertex)
    assert len(files(folder)) == 4


def damage_by(change):
    def damaged(path):
        path.write_bytes(change(path.read_bytes()))

    return damaged


def swapped(path):
    """A sound file with other numbers under the same name."""
    from halfphysics.base.npz import Npz

    file = Npz(path)
    arrays = {name: np.array(file[name]) for name in file}
    number = "mass" if "mass" in arrays else "vertex"
    arrays[number] = arrays[number] + 1
    write_npz(path, arrays)


def pickled(path):
    np.savez(path, digest=np.array([{}], dtype=object))


DAMAGE = {
    "half": damage_by(lambda data: data[: len(data) // 2]),
    "empty": damage_by(lambda data: b""),
    "one byte": damage_by(lambda data: data[:700] + bytes([data[700] ^ 1]) + data[701:]),
    "text": damage_by(lambda data: b"not an archive"),
    "other numbers": swapped,
    "a pickle": pickled,
    "a folder": lambda path: (path.unlink(), path.mkdir()),
}


@pytest.mark.parametrize("damage", DAMAGE)
def test_damaged_files_are_made_anew(folder, kept, damage):
    for path in files(folder):
        DAMAGE[damage](path)
    again = unknown()
    same(again.variant, again.skin_corners, kept)
    if damage != "a folder":
        mended = body_cache.read_variant(again), body_cache.read_corners(again)
        same(*mended, kept)


def test_a_file_too_large_is_not_read(kept, monkeypatch):
    body = unknown()
    assert body_cache.read_variant(body) is not None
    monkeypatch.setattr(body_cache, "LARGEST", 100)
    assert body_cache.read_variant(body) is None


def test_other_code_or_libraries_make_other_files(kept, monkeypatch):
    body = unknown()
    assert body_cache.read_variant(body) is not None
    monkeypatch.setattr(body_cache, "made_by", lambda *of: "another version")
    assert body_cache.read_variant(body) is None


def test_what_says_nothing_possible_is_refused(kept):
    body = unknown()
    with pytest.raises((ValueError, KeyError)):
        body_cache._variant_from({})
    corners = body.skin_corners
    arrays = {"part": corners.part, "first": corners.first, "vertex": corners.vertex + 10**6}
    with pytest.raises(ValueError, match="not what was written"):
        body_cache._corners_from(arrays, body)


def test_the_oldest_make_room(folder, kept, monkeypatch):
    monkeypatch.setattr(body_cache, "MOST", 3)
    variant = unknown().variant
    for i in range(6):
        body = unknown(rest_joints=hp.Body.default().rest_joints + 0.001 * i)
        body_cache.write_variant(body, variant)
        for path in files(folder):
            os.utime(path, ns=(path.stat().st_mtime_ns - 10**9,) * 2)
    assert len(files(folder)) == 3
    assert body_cache.read_variant(body) is not None


def test_nothing_is_kept_when_switched_off(folder, monkeypatch):
    monkeypatch.setenv("HALFPHYSICS_CACHE", "off")
    monkeypatch.chdir(folder.parent)
    assert unknown().variant.mass > 50.0
    assert list(folder.parent.iterdir()) == []


def test_a_folder_that_cannot_be_written_costs_nothing(folder, monkeypatch):
    folder.parent.joinpath("file").write_text("")
    monkeypatch.setenv("HALFPHYSICS_CACHE", str(folder.parent / "file"))
    assert unknown().variant.mass > 50.0


def test_what_was_warned_of_is_warned_of_again(folder):
    default = hp.Body.default()
    flat = np.array(default.rest_vertices)
    jaw = default.weights.argmax(axis=1) == 22
    flat[jaw, 2] = flat[jaw, 2].mean()
    for _ in range(2):
        with pytest.warns(hp.HalfPhysicsWarning, match="the skin of jaw is flat") as found:
            _ = unknown(rest_vertices=flat).variant
        assert found[0].filename.endswith(("body.py", "test_body_cache.py", "functools.py"))
    assert not [path for path in files(folder) if path.name.startswith("parts")]


def test_a_second_process_needs_neither_scipy_nor_mujoco():
    code = (
        "import sys, numpy as np, halfphysics as hp\n"
        "still = hp.Motion(np.zeros((3, 3)), np.zeros((3, 55, 3)), 30.0)\n"
        "scene = hp.Scene()\n"
        "scene.add_static('floor', hp.Plane(offset=-2.0))\n"
        "scene.add_object('ball', hp.Sphere(0.1), mass=1.0, position=(3, 0, 0))\n"
        "result = hp.simulate(still, scene)\n"
        "print(result.motion.rotations.tobytes().hex()[:40], result.clearance.tobytes().hex())\n"
        "print([name for name in ('scipy', 'mujoco', 'trimesh', 'tqdm') if name in sys.modules])"
    )
    said = [
        subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
        for _ in range(2)
    ]
    first, second = (run.stdout.splitlines() for run in said)
    assert first[0] == second[0]
    assert second[1] == "[]"
