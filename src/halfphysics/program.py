"""Which program this is: what another one computed is not taken for its own."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from types import MappingProxyType

#: What numbers come from: code, the native core, the default body and what else is read.
_KINDS = frozenset({".py", ".so", ".pyd", ".dylib", ".npz", ".json", ".yaml", ".xml"})
#: Packages whose version decides numbers; the last one is optional and cuts meshes into pieces.
_ENGINES = ("mujoco", "numpy", "scipy", "trimesh", "coacd")


@cache
def engines() -> Mapping[str, str | None]:
    """Versions of the packages that numbers depend on; None: not installed."""

    def known(name: str) -> str | None:
        try:
            return version(name)
        except PackageNotFoundError:
            return None

    return MappingProxyType({name: known(name) for name in _ENGINES})


@cache
def program() -> str:
    """SHA-256 of the package's files and of the versions of what it computes with."""
    digest = hashlib.sha256()
    folder = Path(__file__).parent
    for path in sorted(p for p in folder.rglob("*") if p.suffix in _KINDS):
        content = hashlib.sha256(path.read_bytes()).hexdigest()
        digest.update(f"{path.relative_to(folder).as_posix()} {content}\n".encode())
    for name, which in engines().items():
        digest.update(f"{name} {which}\n".encode())
    return digest.hexdigest()
