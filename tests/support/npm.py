"""Packages of js/ in tests, where node and their dependencies are there; nothing is fetched."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

from support.paths import ROOT

NODE = shutil.which("node")


def installed(package: str) -> bool:
    """Whether `npm ci` was run in a package of js/."""
    return NODE is not None and (ROOT / "js" / package / "node_modules").is_dir()


def npm(package: str, *arguments: str, **environment: str) -> str:
    """Output of `npm run ...` in a package of js/."""
    import os

    done = subprocess.run(
        [shutil.which("npm"), "run", "--silent", *arguments],
        cwd=ROOT / "js" / package,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, f"{done.stdout}\n{done.stderr}"
    return done.stdout


def package(name: str) -> Path:
    """The folder of a package of js/."""
    return ROOT / "js" / name
