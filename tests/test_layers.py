"""Which parts of the package may import which: the outer ones use the inner ones, never back."""

from __future__ import annotations

import ast
import subprocess
import sys

import pytest

from support.paths import ROOT

PACKAGE = ROOT / "src" / "halfphysics"
#: A ring -> those that use it. Nobody else does, not even inside a function or for a type.
RINGS = {
    "labels": {"labels", "sweep", "bench"},
    "sweep": {"sweep", "cli", "bench"},
    "bench": {"bench", "cli"},
    "cli": {"cli", "__main__"},
}


def imported(path):
    """The modules that a file imports, wherever in it."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.module
            yield from (f"{node.module}.{name.name}" for name in node.names)


@pytest.mark.parametrize("ring", RINGS)
def test_imports_go_inwards(ring):
    inside = f"halfphysics.{ring}"
    users = set()
    for path in PACKAGE.rglob("*.py"):
        if any(name == inside or name.startswith(f"{inside}.") for name in imported(path)):
            users.add(path.relative_to(PACKAGE).with_suffix("").parts[0])
    assert users <= RINGS[ring]
    assert users, "of that name there is nothing"


@pytest.mark.parametrize(
    ("module", "late"),
    [
        ("halfphysics", {"numpy", "mujoco"}),
        ("halfphysics.sweep.run.work", {"numpy", "mujoco", "trimesh", "ray", "h5py"}),
        ("halfphysics.labels", {"mujoco", "trimesh", "scipy"}),
        ("halfphysics.sweep.make.vary", {"tyro", "viser", "ray", "h5py", "webdataset"}),
    ],
)
def test_what_is_heavy_is_imported_when_it_is_needed(module, late):
    script = f"import sys, {module}; print(*sys.modules)"
    loaded = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    ).stdout.split()
    assert not late & set(loaded)
