"""The TypeScript client: its own tests in node against a real server; its page is as built."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

import pytest

import halfphysics
from support.npm import npm, package
from support.paths import ROOT

PAGE = ROOT / "src" / "halfphysics" / "live" / "page.html"


@pytest.mark.slow
def test_the_client_passes_its_tests_against_a_real_server():
    command = json.dumps([sys.executable, "-m", "halfphysics", "serve"])
    # The package that is tested: of the checkout, or installed.
    tested = str(Path(halfphysics.__file__).parents[1])
    path = os.pathsep.join([tested, os.environ.get("PYTHONPATH", "")])
    said = npm(package("client"), "test", HALFPHYSICS_SERVE=command, PYTHONPATH=path)
    assert "# fail 0" in said
    assert "# pass 10" in said


@pytest.mark.slow
def test_the_page_of_the_server_is_the_one_that_is_built(tmp_path):
    npm(package("client"), "page", "--", str(tmp_path / "page.html"))
    assert (tmp_path / "page.html").read_bytes() == PAGE.read_bytes()


def test_the_page_is_small_and_fetches_nothing():
    text = PAGE.read_text(encoding="utf-8")
    assert len(text) < 60_000
    assert 'src="' not in text
    assert "http://" not in text.replace("http://www.w3.org", "")
    assert "https://" not in text


def test_one_version():
    ours = json.loads((ROOT / "js" / "client" / "package.json").read_text(encoding="utf-8"))
    assert ours["version"] == halfphysics.__version__
