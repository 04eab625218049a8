"""Fixtures shared by the tests."""

from __future__ import annotations

import os
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Folder with real motions and meshes; tests that need it skip where it is absent."""
    default = Path(__file__).resolve().parents[2] / "shared" / "data"
    folder = Path(os.environ.get("HALFPHYSICS_TEST_DATA", default))
    if not folder.is_dir():
        pytest.skip(f"no test data at {folder} (set HALFPHYSICS_TEST_DATA)")
    return folder
