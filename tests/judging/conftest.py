"""A folder of clips to judge."""

from __future__ import annotations

import pytest

from support.made_clips import walk


@pytest.fixture
def library(tmp_path):
    """Two clips, one of them in a folder, a broken one, and a file that is no motion."""
    (tmp_path / "deep").mkdir()
    walk().save(tmp_path / "a.npz")
    walk(1).save(tmp_path / "deep" / "b.npz")
    (tmp_path / "broken.npz").write_bytes(b"PK\x03\x04 half a file")
    (tmp_path / "README.txt").write_text("no motion")
    return tmp_path
