"""What numbers that are kept on disk were made by: they are used again only where nothing of it has
changed."""

from __future__ import annotations

import contextlib
import hashlib
import platform
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path

import numpy as np


@cache
def made_by(
    folders: tuple[str, ...], files: tuple[str, ...] = (), packages: tuple[str, ...] = ()
) -> str:
    """A digest of code, libraries and kind of machine that numbers depend on.

    Not `base.code_hash`: that reads the whole package, which takes as long as half of a first call,
    and a change of the core would make everything anew.

    Args:
        folders: Folders of the package whose code decides the numbers.
        files: Data files of the package that do, below its folder.
        packages: Those whose version does, besides numpy and scipy; they may be missing.
    """
    digest = hashlib.sha256(f"{platform.machine()} {np.__version__}\n".encode())
    package = Path(__file__).parents[1]
    code = [path for folder in folders for path in sorted((package / folder).glob("*.py"))]
    for path in (*code, *(package / name for name in files)):
        digest.update(path.read_bytes())
    scipy = find_spec("scipy")  # without importing it
    if scipy is not None and scipy.origin is not None:
        digest.update((Path(scipy.origin).parent / "version.py").read_bytes())
    for name in packages:
        with contextlib.suppress(PackageNotFoundError):
            digest.update(f"{name} {version(name)}\n".encode())
    # Libraries choose their loops by what the processor can do.
    with contextlib.suppress(ImportError):
        from numpy._core._multiarray_umath import __cpu_features__

        digest.update(repr(sorted(__cpu_features__.items())).encode())
    return digest.hexdigest()
