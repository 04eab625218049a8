"""Packages of js/ in tests, with their dependencies, where npm and a registry are there.

A package of the checkout in which `npm ci` was run is used as it is; else it is copied and its
dependencies, those of its lock file, are installed in the copy. Nothing is written to the checkout.
"""

from __future__ import annotations

import functools
import os
import shutil
import subprocess
import tempfile
from pathlib import Path

import pytest

from support.paths import ROOT

#: How long the registry may take to answer, and any call of npm [s].
_ANSWERS, _MOST = 10, 300
_QUIET = ("--no-audit", "--no-fund", "--loglevel=error")


def run(folder: Path, *command: str, **environment: str) -> str:
    """Output of a program of node in a folder; a failure is the test's."""
    done = subprocess.run(
        [shutil.which(command[0]) or command[0], *command[1:]],
        cwd=folder,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        timeout=_MOST,
    )
    assert done.returncode == 0, f"{' '.join(command)}\n{done.stdout}\n{done.stderr}"
    return done.stdout


def npm(folder: Path, *arguments: str, **environment: str) -> str:
    """Output of `npm run ...` in a folder."""
    return run(folder, "npm", "run", "--silent", *arguments, **environment)


@functools.cache
def package(name: str) -> Path:
    """The folder of a package of js/ with its dependencies; skips where they cannot be had."""
    if shutil.which("npm") is None:
        pytest.skip("no npm")
    own = ROOT / "js" / name
    if (own / "node_modules").is_dir():
        return own
    if not _registry():
        pytest.skip(f"no npm ci in js/{name}, and no registry of npm answers")
    return _installed(own)


@functools.cache
def _registry() -> bool:
    """Whether the registry of npm answers."""
    options = ("--fetch-retries=0", f"--fetch-timeout={1000 * _ANSWERS}")
    try:
        return (
            subprocess.run(
                [str(shutil.which("npm")), "ping", *options],
                capture_output=True,
                timeout=2 * _ANSWERS,
                check=False,
            ).returncode
            == 0
        )
    except subprocess.TimeoutExpired:
        return False


#: Kept as long as the tests run; their folder goes with them.
_FOLDERS: list[tempfile.TemporaryDirectory[str]] = []


def _installed(own: Path) -> Path:
    """A copy of a package in which `npm ci` was run."""
    _FOLDERS.append(tempfile.TemporaryDirectory(prefix="halfphysics-npm-"))
    copy = Path(_FOLDERS[-1].name) / own.name
    shutil.copytree(own, copy, ignore=shutil.ignore_patterns("node_modules", "dist", "out"))
    run(copy, "npm", "ci", *_QUIET)
    return copy
