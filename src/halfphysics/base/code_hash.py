"""The hash of the code that computes numbers: results of other code are not reused."""

from __future__ import annotations

import hashlib
import zlib
from collections.abc import Mapping
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path
from types import MappingProxyType

from halfphysics.base.digests import sha256_of

#: Suffixes of the files that decide numbers, besides compiled modules: code and data that is read.
_KINDS = frozenset({".py", ".npz", ".json", ".yaml", ".xml"})
#: Compiled modules of the package.
_EXTENSIONS = ("_native", "_render")
#: Packages whose version decides numbers; the last one is optional and divides meshes.
_ENGINES = ("mujoco", "numpy", "scipy", "trimesh", "coacd")


@cache
def engines() -> Mapping[str, str | None]:
    """Versions of the packages that decide numbers and bytes; None: not installed."""

    def known(name: str) -> str | None:
        try:
            return version(name)
        except PackageNotFoundError:
            return None

    # Builds of zlib pack the same numbers into different bytes.
    packs = {"zlib": zlib.ZLIB_RUNTIME_VERSION}
    return MappingProxyType({name: known(name) for name in _ENGINES} | packs)


@cache
def code_hash() -> str:
    """SHA-256 of the package's files and of the versions of `engines`."""
    digest = hashlib.sha256()
    folder = Path(__file__).parents[1]
    files = {
        path.relative_to(folder).as_posix(): path
        for path in folder.rglob("*")
        if path.suffix in _KINDS
    }
    # The extensions that are used: there may be others beside them, and in an editable install
    # they are somewhere else.
    for extension in _EXTENSIONS:
        spec = find_spec(f"halfphysics.{extension}")
        if spec is not None and spec.origin is not None:
            files[extension] = Path(spec.origin)
    for name, path in sorted(files.items()):
        content = sha256_of(path)
        digest.update(f"{name} {content}\n".encode())
    for name, which in engines().items():
        digest.update(f"{name} {which}\n".encode())
    return digest.hexdigest()
