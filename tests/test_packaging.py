"""What is installed: versions and dependencies agree wherever they are stated; no build tools."""

from __future__ import annotations

import ast
import re
import sys
import tomllib

import pytest
import yaml

import halfphysics
from support.paths import ROOT

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
PACKAGE = ROOT / "src" / "halfphysics"
#: Distributions whose module has another name.
MODULES = {"pillow": "PIL", "pyyaml": "yaml", "usd-core": "pxr", "imageio-ffmpeg": "imageio_ffmpeg"}
#: Names of the same on conda-forge, where they differ.
CONDA = {"mujoco": "mujoco-python"}
#: Modules of distributions that our dependencies themselves need, and hand their objects out of.
BROUGHT = {"msgspec", "rich", "zstandard"}
#: Done without where they are not: whoever passes a tensor has the library that made it.
IF_THERE = {"torch", "jax", "pandas", "polars", "xarray", "IPython"}


def name_of(requirement: str) -> str:
    return re.match(r"[\w-]+", requirement)[0]


def modules_of(requirements: list[str]) -> set[str]:
    return {MODULES.get(name_of(r), name_of(r)) for r in requirements}


def recipe() -> dict:
    return yaml.safe_load((ROOT / "recipe" / "recipe.yaml").read_text(encoding="utf-8"))


def test_one_version():
    assert PROJECT["project"]["version"] == halfphysics.__version__
    assert recipe()["context"]["version"] == halfphysics.__version__


def test_the_recipe_asks_for_what_the_package_asks_for():
    """Each dependency with its lowest version, of running and of building."""
    requirements = recipe()["requirements"]
    stated = {line.replace(" ", "") for line in requirements["run"]} - {"python"}
    asked = PROJECT["project"]["dependencies"]
    assert stated == {r.replace(name_of(r), CONDA.get(name_of(r), name_of(r))) for r in asked}
    built = {line.replace(" ", "") for line in requirements["host"]} - {"python", "pip"}
    assert built == set(PROJECT["build-system"]["requires"])
    cmake = "cmake" + PROJECT["tool"]["scikit-build"]["cmake"]["version"]
    assert cmake in {r.replace(" ", "") for r in requirements["build"] if isinstance(r, str)}
    python = PROJECT["project"]["requires-python"].removeprefix(">=")
    assert recipe()["context"]["python_min"] == python


def imports(tree: ast.AST, *, nested: bool) -> set[str]:
    """Top-level names that a file imports: when it is imported, or `nested` anywhere."""
    nodes = ast.walk(tree) if nested else tree.body
    names: set[str] = set()
    for node in nodes:
        if isinstance(node, ast.Import):
            names |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and not node.level:
            names.add(node.module.partition(".")[0])
    return names - set(sys.stdlib_module_names) - {"halfphysics"}


@pytest.fixture(scope="module")
def trees():
    files = sorted(PACKAGE.rglob("*.py"))
    assert len(files) > 300
    return {file: ast.parse(file.read_text(encoding="utf-8")) for file in files}


def test_what_is_imported_is_installed_with_the_package_or_by_an_extra(trees):
    """Nothing that only builds, tests or checks it; what an extra brings only where it is used."""
    always = modules_of(PROJECT["project"]["dependencies"]) | BROUGHT
    extras = PROJECT["project"]["optional-dependencies"]
    at_need = {
        m for name, r in extras.items() if name not in ("test", "dev") for m in modules_of(r)
    }
    for file, tree in trees.items():
        assert imports(tree, nested=False) <= always, file
        assert imports(tree, nested=True) <= always | at_need | IF_THERE, file


def test_the_sdist_has_what_compiles_and_what_runs():
    """What is left out is at the root: without its slash `run` would take sweep/run along."""
    out = PROJECT["tool"]["scikit-build"]["sdist"]["exclude"]
    assert {name[0] for name in out} == {"/"}
    assert [name for name in out if not (ROOT / name[1:]).exists()] == []
    needed = {"src", "CMakeLists.txt", "pyproject.toml", "README.md", "LICENSE", "NOTICE"}
    assert needed.isdisjoint(name[1:] for name in out)


def test_the_wheels_are_of_every_python_that_is_allowed():
    """One of the oldest Python, and from the next on the stable ABI's."""
    lowest = PROJECT["project"]["requires-python"].removeprefix(">=3.")
    stable = PROJECT["tool"]["scikit-build"]["wheel"]["py-api"]
    assert stable == f"cp3{int(lowest) + 1}"
    assert PROJECT["tool"]["cibuildwheel"]["build"] == [f"cp3{lowest}-*", f"{stable}-*"]
