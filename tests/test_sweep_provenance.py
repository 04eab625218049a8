"""Provenance: which program made something, and what of it decides its bytes."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import mujoco
import numpy

import halfphysics
from halfphysics.program import engines, program
from halfphysics.sweep.provenance import changed, told, versions


def test_versions_are_those_in_use():
    found = versions()
    assert found["halfphysics"] == halfphysics.__version__
    assert found["numpy"] == numpy.__version__
    assert found["mujoco"] == mujoco.__version__
    assert found["program"] == program()
    assert len(program()) == 64
    assert json.loads(json.dumps(found)) == found
    assert set(engines()) < set(found)


def test_what_is_only_told_is_not_among_them():
    assert set(told()) == {"python", "system", "machine"}
    assert not set(told()) & set(versions())


def hash_of(folder):
    """What `program` gives for a copy of the package, in a process of its own."""
    code = "import halfphysics.program as p; print(p.__file__, p.program())"
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={"PYTHONPATH": str(folder), "PYTHONDONTWRITEBYTECODE": "1"},
        capture_output=True,
        text=True,
        check=True,
    )
    file, digest = done.stdout.split()
    assert Path(file).is_relative_to(folder)
    return digest


def test_any_change_of_the_code_is_another_program(tmp_path):
    """Not: where it lies, when it was written, what compiling left beside it."""
    here = Path(halfphysics.__file__).parent
    there = tmp_path / "halfphysics"
    shutil.copytree(here, there, ignore=shutil.ignore_patterns("__pycache__"))
    (there / "__pycache__").mkdir()
    (there / "__pycache__" / "x.pyc").write_bytes(b"x")
    assert hash_of(tmp_path) == program()
    module = there / "scenarios" / "gait.py"
    code = module.read_bytes()
    module.write_bytes(code + b"#\n")
    assert hash_of(tmp_path) != program()
    module.write_bytes(code)
    native = there / Path(find_spec("halfphysics._native").origin).name
    native.write_bytes(native.read_bytes() + b"\0")  # still what it was to who loads it
    assert hash_of(tmp_path) != program()


def test_what_differs_is_said_in_words():
    assert changed(versions()) == []
    there = {**versions(), "mujoco": "0.1", "program": "ff" * 32}
    assert changed(there) == [
        f"mujoco 0.1 there, {mujoco.__version__} here",
        f"the program (ffffffffffff... there, {program()[:12]}... here)",
    ]
    del there["numpy"]
    assert f"numpy None there, {numpy.__version__} here" in changed(there)
