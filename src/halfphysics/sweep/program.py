"""Which program made a sweep: a hash of all that its numbers come from."""

from __future__ import annotations

import hashlib
from functools import cache
from pathlib import Path

_ENDINGS = (".py", ".so", ".pyd", ".npz", ".xml", ".json", ".yaml")


@cache
def program_hash() -> str:
    """SHA-256 over this package (code, native core, assets) and the versions it computes with."""
    import mujoco
    import numpy
    import scipy

    import halfphysics

    folder = Path(halfphysics.__file__).parent
    digest = hashlib.sha256()
    for package in (mujoco, numpy, scipy):
        digest.update(f"{package.__name__} {package.__version__}\n".encode())
    for path in sorted(p for p in folder.rglob("*") if p.suffix in _ENDINGS):
        content = hashlib.sha256(path.read_bytes()).hexdigest()
        digest.update(f"{path.relative_to(folder).as_posix()} {content}\n".encode())
    return digest.hexdigest()
