"""Which program it is: what another one computed is not taken for its own."""

from __future__ import annotations

import hashlib
from functools import cache
from importlib.metadata import version
from pathlib import Path

import halfphysics

_KINDS = {".py", ".so", ".pyd", ".npz"}
_ENGINES = ("numpy", "scipy", "mujoco", "trimesh")


@cache
def program() -> str:
    """SHA-256 of the package's files and of the versions of what it computes with."""
    digest = hashlib.sha256()
    folder = Path(halfphysics.__file__).parent
    for path in sorted(p for p in folder.rglob("*") if p.suffix in _KINDS):
        digest.update(path.relative_to(folder).as_posix().encode())
        digest.update(path.read_bytes())
    for name in _ENGINES:
        digest.update(f"{name} {version(name)}".encode())
    return digest.hexdigest()
