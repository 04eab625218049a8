"""Packages that are missing are named with the command that installs them."""

from __future__ import annotations

import sys

import pytest

from halfphysics.base.optional_package import optional
from halfphysics.errors import MissingDependencyError


def test_a_package_that_is_there():
    assert optional("json", "files", "any") is sys.modules["json"]


def test_a_package_that_is_not():
    with pytest.raises(MissingDependencyError) as caught:
        optional("nowhere_at_all", "charts", "notebook")
    assert str(caught.value) == (
        "charts need nowhere_at_all: pip install 'halfphysics[notebook]' (or pip install "
        "nowhere_at_all)"
    )


def test_a_package_that_fails_to_start_says_why(tmp_path, monkeypatch):
    (tmp_path / "broken_one.py").write_text("import not_to_be_found\n")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(MissingDependencyError, match=r"need broken_one \(it failed: No module"):
        optional("broken_one", "charts", "notebook")
