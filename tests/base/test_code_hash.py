"""The hash of the program: it covers every file that affects numbers, and no other."""

from __future__ import annotations

import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import halfphysics
from halfphysics.base.code_hash import code_hash


def hash_of(folder):
    """The result of `program` for a copy of the package, in its own process."""
    code = "import halfphysics.base.code_hash as p; print(p.__file__, p.code_hash())"
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
    """The hash ignores the folder, the modification times and compiled leftovers."""
    here = Path(halfphysics.__file__).parent
    there = tmp_path / "halfphysics"
    shutil.copytree(here, there, ignore=shutil.ignore_patterns("__pycache__"))
    (there / "__pycache__").mkdir()
    (there / "__pycache__" / "x.pyc").write_bytes(b"x")
    assert hash_of(tmp_path) == code_hash()
    module = there / "scenarios" / "acting" / "gait.py"
    code = module.read_bytes()
    module.write_bytes(code + b"#\n")
    assert hash_of(tmp_path) != code_hash()
    module.write_bytes(code)
    native = there / Path(find_spec("halfphysics._native").origin).name
    native.write_bytes(native.read_bytes() + b"\0")  # the loader still reads the same extension
    assert hash_of(tmp_path) != code_hash()
