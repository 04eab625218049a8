"""The quick tests, run on the halfphysics that is installed, without a compiler and far from src.

    pip install halfphysics pytest hypothesis
    python tools/check_installed.py                     # all that can run with what is installed
    python tools/check_installed.py tests/base -k atomic     # some; options go to pytest

Needs a clone of this repository, for its tests, but nothing of its `src`: the package must come from
elsewhere, or this says so and stops. Test files that import what is not installed (the extra `test`
names all of it) are left out; which, and for want of what, is printed.
"""

from __future__ import annotations

import ast
import importlib.metadata
import importlib.util
import itertools
import os
import subprocess
import sys
import tempfile
from collections import defaultdict
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
#: What is tested by itself, below tests: what a wheel can get wrong (the compiled modules, the data
#: files, paths and processes of the system, the entry points), in a few minutes.
QUICK = (
    "assets", "base", "body", "motion", "mujoco", "native", "render", "results", "scene",
    "cli/test_cli.py", "simulation/test_objects.py", "simulation/test_simulate_many.py", "formats/test_loading.py",
)  # fmt: skip
#: Tests of the sources rather than of the package, by their path below tests.
OF_THE_SOURCES = {"native/test_tuning.py"}
#: Where the tests' own helpers are found, as `pythonpath` in pyproject.toml says.
OWN = (ROOT, ROOT / "tests", ROOT / "tests" / "evidence")
#: Packages of theirs; a name of one that is no file is a function in it.
OWN_NAMES = {"evidence", *(folder.name for folder in (ROOT / "tests").iterdir() if folder.is_dir())}


def main() -> int:
    """Find the package, choose the tests, run pytest; its exit code, or 2."""
    arguments = sys.argv[1:]
    if arguments[:1] in (["-h"], ["--help"]):
        print(__doc__)
        return 0
    # Files and folders come first; from the first option on, all is pytest's.
    paths = list(itertools.takewhile(lambda argument: not argument.startswith("-"), arguments))
    options = arguments[len(paths) :]
    problem = not_installed()
    if problem:
        print(f"check_installed: {problem}", file=sys.stderr)
        return 2
    files, left = chosen([Path(path).resolve() for path in paths])
    for name, names in sorted(left.items()):
        print(f"check_installed: without {name}, left out: {', '.join(sorted(names))}")
    if not files:
        print("check_installed: no test is left", file=sys.stderr)
        return 2
    with tempfile.TemporaryDirectory() as folder:  # what a test writes beside itself is seen
        return pytest(files, options, Path(folder))


def not_installed() -> str | None:
    """Why the package that Python finds is not one to test; None: it is."""
    spec = importlib.util.find_spec("halfphysics")
    if spec is None or spec.origin is None:
        return "halfphysics is not installed in this Python. Install a wheel first"
    if ROOT / "src" in Path(spec.origin).resolve().parents:
        return f"halfphysics is {spec.origin}, not an installed one. Unset PYTHONPATH"
    version = importlib.metadata.version("halfphysics")
    print(f"check_installed: halfphysics {version} of {Path(spec.origin).parent}", flush=True)
    return None


def chosen(paths: list[Path]) -> tuple[list[Path], dict[str, list[str]]]:
    """The test files to run; those that cannot, under the name of what is missing."""
    tests = ROOT / "tests"
    found = {
        file
        for path in paths or [tests / name for name in QUICK]
        for file in (path.rglob("test_*.py") if path.is_dir() else [path])
        if paths or file.relative_to(tests).as_posix() not in OF_THE_SOURCES
    }
    files: list[Path] = []
    left: dict[str, list[str]] = defaultdict(list)
    for file in sorted(found):
        lacking = missing(file)
        for name in lacking:
            left[name].append(file.relative_to(ROOT).as_posix())
        if not lacking:
            files.append(file)
    return files, left


def missing(file: Path) -> set[str]:
    """Modules that importing a file takes, through the tests' own, and that are not installed."""
    lacking: set[str] = set()
    seen: set[Path] = set()
    to_read = [file]
    while to_read:
        at = to_read.pop()
        seen.add(at)
        for name in sorted(imported(at)):
            own = own_file(name)
            top = name.partition(".")[0]
            if own is None and top not in OWN_NAMES and not is_installed(top):
                lacking.add(top)
            elif own is not None and own not in seen:
                to_read.append(own)
    return lacking


@cache
def is_installed(top: str) -> bool:
    """Whether this Python has a module of that name, which is not imported."""
    return importlib.util.find_spec(top) is not None


@cache
def imported(file: Path) -> set[str]:
    """Modules that a file imports when it is imported: not those in its functions."""
    names: set[str] = set()
    for node in ast.parse(file.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            names.add(node.module)
            names |= {
                f"{node.module}.{alias.name}" for alias in node.names if own_file(node.module)
            }
    names |= {
        ".".join(parts[:n])
        for parts in (name.split(".") for name in names)
        for n in range(1, len(parts))
        if parts[0] in OWN_NAMES
    }
    return names - {"__future__"}


@cache
def own_file(name: str) -> Path | None:
    """The file of a module of the tests or of `evidence`."""
    for top in OWN:
        base = top.joinpath(*name.split("."))
        for file in (base.with_suffix(".py"), base / "__init__.py"):
            if file.is_file():
                return file
    return None


def pytest(files: list[Path], options: list[str], folder: Path) -> int:
    """Run pytest in an empty folder, on this Python's package."""
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    environment.setdefault("OMP_NUM_THREADS", "1")
    if not any(option.startswith("-m") for option in options):
        options = ["-m", "not slow and not fuzz", *options]
    command = [sys.executable, "-m", "pytest", f"--rootdir={ROOT}", f"-c={ROOT / 'pyproject.toml'}"]
    command += ["-p", "no:cacheprovider", *options, *map(str, files)]
    return subprocess.run(command, cwd=folder, env=environment, check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
