"""What kept numbers were made by: any change of it is another."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from halfphysics.base import made_by as module
from halfphysics.base.made_by import made_by


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A copy of the package's folder `base`, with a data file, in the package's place."""
    source = Path(module.__file__)
    shutil.copytree(source.parent, tmp_path / "base", ignore=shutil.ignore_patterns("*.pyc"))
    (tmp_path / "data.npz").write_bytes(b"1")
    monkeypatch.setattr(module, "__file__", str(tmp_path / "base" / source.name))
    made_by.cache_clear()
    yield tmp_path
    made_by.cache_clear()


def asked():
    made_by.cache_clear()
    return made_by(("base",), ("data.npz",), ("trimesh", "no-such-package"))


def test_code_data_and_versions_count(package, monkeypatch):
    found = [asked()]
    assert asked() == found[0]
    with (package / "base" / "atomic.py").open("a") as handle:
        handle.write("# changed")
    found.append(asked())
    (package / "data.npz").write_bytes(b"2")
    found.append(asked())
    monkeypatch.setattr(module, "version", lambda name: "another")
    found.append(asked())
    assert len(set(found)) == 4
