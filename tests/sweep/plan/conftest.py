"""The folder that the sweep files of these tests name."""

from __future__ import annotations

from pathlib import Path

import pytest


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with the files of the plan."""
    for name in ("clips/b.npz", "clips/ä/a.npz", "clips/a.npz", "clips/notes.txt", "takes/1/x"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    (tmp_path / "takes" / "2").mkdir()
    (tmp_path / "meshes").mkdir()
    (tmp_path / "room.yaml").write_text("statics: {floor: {shape: plane}}\n")
    return tmp_path
