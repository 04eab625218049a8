"""An environment with only what a document says to install."""

from __future__ import annotations

import contextlib
import importlib.abc
import re
import sys
import tomllib
from collections.abc import Iterator

import pytest

from support.paths import ROOT

#: Package of an extra -> the module that is imported; the others have the name of their package.
_MODULES = {"usd-core": "pxr", "imageio-ffmpeg": "imageio_ffmpeg", "pyzmq": "zmq"}
#: Extras that `./run NAME` installs.
_SETS_UP = ("evidence", "docs")
_INSTALL = re.compile(r"pip install ((?:-e )?[^`\n#]+)")
_REQUIREMENT = re.compile(r"^(?:halfphysics|\.)?(?:\[([\w,-]+)\])?(?:==[\w.]+)?$")


def extras() -> dict[str, set[str]]:
    """Extra -> packages that it installs."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return {
        name: {re.split(r"[\[><=~! ]", line)[0] for line in lines}
        for name, lines in project["optional-dependencies"].items()
    }


def packages_of(requirement: str) -> set[str]:
    """The packages of one word after `pip install`: `.`, `halfphysics[film]`, `h5py`."""
    word = requirement.strip("'\",.;:)").removeprefix("-e ")
    match = _REQUIREMENT.match(requirement.strip("'\""))
    if match is None:
        return {word}
    named = (match[1] or "").split(",") if match[1] else []
    known = extras()
    missing = [name for name in named if name not in known]
    assert not missing, f"pip install {requirement}: there is no extra {missing}"
    return set().union(*(known[name] for name in named))


def said(text: str) -> set[str]:
    """The optional packages that a document says to install."""
    found: set[str] = set()
    for line in _INSTALL.findall(text):
        for word in line.split():
            if not word.startswith("-"):
                found |= packages_of(word)
    for name in _SETS_UP:
        if f"./run {name}" in text:
            found |= extras()[name]
    return found


class _Missing(importlib.abc.MetaPathFinder):
    """Refuses modules as if their packages were not installed."""

    def __init__(self, modules: set[str]) -> None:
        self.modules = modules

    def find_spec(self, fullname: str, path: object = None, target: object = None) -> None:
        if fullname.partition(".")[0] in self.modules:
            raise ModuleNotFoundError(f"No module named {fullname!r}", name=fullname)


@contextlib.contextmanager
def only(packages: set[str], patch: pytest.MonkeyPatch) -> Iterator[None]:
    """No optional package can be imported but these, and no program is on the path."""
    optional = set().union(*(v for k, v in extras().items() if k not in ("test", "dev", "docs")))
    absent = (optional | {"webdataset", "pandas", "polars", "xarray"}) - packages
    modules = {_MODULES.get(name, name.replace("-", "_")) for name in absent}
    with patch.context() as inside:
        inside.setenv("PATH", "")
        for name in [n for n in sys.modules if n.partition(".")[0] in modules]:
            inside.delitem(sys.modules, name)
        inside.setattr(sys, "meta_path", [_Missing(modules), *sys.meta_path])
        yield
