"""Provenance: the program that made a result, and its parts that decide the bytes."""

from __future__ import annotations

import json

import mujoco
import numpy

import halfphysics
from halfphysics.base.code_hash import code_hash, engines
from halfphysics.sweep.make.provenance import changed, versions


def test_versions_are_those_in_use():
    found = versions()
    assert found["halfphysics"] == halfphysics.__version__
    assert found["numpy"] == numpy.__version__
    assert found["mujoco"] == mujoco.__version__
    assert found["program"] == code_hash()
    assert len(code_hash()) == 64
    assert json.loads(json.dumps(found)) == found
    assert set(engines()) < set(found)


def test_what_differs_is_said_in_words():
    assert changed(versions()) == []
    there = {**versions(), "mujoco": "0.1", "program": "ff" * 32}
    assert changed(there) == [
        f"mujoco 0.1 there, {mujoco.__version__} here",
        f"the program (ffffffffffff... there, {code_hash()[:12]}... here)",
    ]
    del there["numpy"]
    assert f"numpy None there, {numpy.__version__} here" in changed(there)
