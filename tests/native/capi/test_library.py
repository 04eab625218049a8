"""The C library from C: the example compiles as C99 without a warning and has Python's bits."""

from __future__ import annotations

import ctypes
import re

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.motion.skeleton import JOINT_NAMES
from support import c_library
from support.c_example import EXAMPLE, c_end, python_end
from support.c_library import CError, CWorld
from support.paths import ROOT


def test_the_example_has_the_bits_of_python(tmp_path, monkeypatch):
    pose, ball = c_end(tmp_path, monkeypatch, 120)
    expected_pose, expected_ball = python_end(120)
    assert np.array_equal(pose, expected_pose)
    assert np.array_equal(ball, expected_ball)
    assert ball[0] > 2.0  # kicked away


def test_the_example_is_short():
    assert len(EXAMPLE.read_text(encoding="utf-8").splitlines()) <= 60


def test_the_library_has_what_the_header_declares():
    lib = c_library.load()
    for name in c_library.functions():
        assert hasattr(lib, name), name


def test_the_header_is_documented():
    """docs/c-api.md names every function."""
    text = (ROOT / "docs" / "c-api.md").read_text(encoding="utf-8")
    missing = [name for name in c_library.functions() if not re.search(rf"\b{name}\b", text)]
    assert missing == []


def test_versions_and_joints_are_those_of_python():
    lib = c_library.load()
    assert lib.hp_version().decode() == hp.__version__
    names = [lib.hp_joint_name(i).decode() for i in range(len(JOINT_NAMES))]
    assert names == list(JOINT_NAMES)
    assert lib.hp_joint_name(55) is None
    assert lib.hp_joint_name(-1) is None


def test_names_and_kinds():
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    scene.add_object("ball", hp.Sphere(0.1), mass=1.0, position=(1, 0, 0.1))
    world = CWorld(hp.compile_world(scene))
    lib = c_library.load()
    assert world.names == ["floor", "ball", "person"]
    assert [lib.hp_kind_of(world.handle, i) for i in range(-1, 4)] == [-1, 0, 1, 3, -1]
    assert lib.hp_find(world.handle, b"ball") == 1
    assert lib.hp_find(world.handle, b"bell") == -1
    bodies = [lib.hp_body_name(world.handle, i).decode() for i in range(56)]
    assert bodies == [*(f"person/{name}" for name in JOINT_NAMES), "ball"]


@pytest.mark.parametrize("data", [b"", b"no world", b"\x89HPW\r\n\x1a\n" + bytes(24)])
def test_what_is_no_world_file_is_refused(data):
    with pytest.raises(CError, match="world file"):
        CWorld(data)


def test_a_file_that_is_not_there(tmp_path):
    lib = c_library.load()
    assert not lib.hp_world_open(str(tmp_path / "none.hpw").encode())
    assert "cannot read it" in lib.hp_error().decode()
    assert not lib.hp_world_open(None)


def test_nothing_is_done_to_null():
    lib = c_library.load()
    lib.hp_world_free(None)
    assert lib.hp_person_count(None) == 0
    assert lib.hp_reset(None, None, None) == 1
    assert lib.hp_name(None, 0) is None
    assert lib.hp_set_mass(None, b"ball", ctypes.c_double(1.0)) == 1
