"""tools/check_installed.py: the tests that can run with what is installed, on what is installed."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys

import pytest

from support.paths import ROOT, TESTS

TOOL = ROOT / "tools" / "check_installed.py"


@pytest.fixture
def tool():
    spec = importlib.util.spec_from_file_location("check_installed", TOOL)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_sources_are_no_installed_package():
    """On the path of this checkout it stops, before any test, and says why."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "src")}
    done = subprocess.run(
        [sys.executable, TOOL], env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    assert "not an installed one. Unset PYTHONPATH" in done.stderr


def test_what_is_missing_is_found_through_the_tests_own_helpers(tool, monkeypatch):
    """Without coal, files that import it are left out, also those whose helper does; no others."""
    direct = TESTS / "native" / "geometry" / "test_convex.py"
    far = TESTS / "support" / "judges" / "test_clear_judge.py"
    none = TESTS / "base" / "test_atomic.py"
    there = tool.is_installed
    monkeypatch.setattr(tool, "is_installed", lambda top: top != "coal" and there(top))
    assert "import coal" not in far.read_text(encoding="utf-8")
    files, left = tool.chosen([direct, far, none])
    assert files == [none]
    assert left == {"coal": [p.relative_to(ROOT).as_posix() for p in (direct, far)]}


def test_all_that_is_named_exists_and_the_quick_ones_are_many(tool):
    for name in (*tool.QUICK, *tool.OF_THE_SOURCES):
        assert (TESTS / name).exists(), name
    files, _ = tool.chosen([])
    assert len(files) > 60
    assert TESTS / "native" / "test_tuning.py" not in files


def test_tests_run_on_the_package_that_is_installed(tool, tmp_path, capfd):
    """In an empty folder, with PYTHONPATH out of the way; the exit code is pytest's."""
    made = tmp_path / "test_made.py"
    made.write_text(
        "import os\ndef test_one():\n    assert os.listdir() == []\n"
        "    assert 'PYTHONPATH' not in os.environ\ndef test_two():\n    assert False\n",
        encoding="utf-8",
    )
    empty = tmp_path / "empty"
    empty.mkdir()
    assert tool.pytest([made], ["-k", "one", "-p", "no:hypothesispytest"], empty) == 0
    assert tool.pytest([made], ["-k", "two"], empty) == 1
    assert "1 passed" in capfd.readouterr().out
