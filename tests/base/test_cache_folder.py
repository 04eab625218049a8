"""Where caches are: the environment says it."""

import sys
from pathlib import Path

import pytest

from halfphysics.base.cache_folder import cache_folder


def test_its_own_variable_comes_first(monkeypatch, tmp_path):
    monkeypatch.setenv("HALFPHYSICS_CACHE", str(tmp_path / "mine"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    assert cache_folder() == tmp_path / "mine"
    monkeypatch.setenv("HALFPHYSICS_CACHE", "")
    assert cache_folder() == tmp_path / "xdg" / "halfphysics"


def test_the_home_folder_is_the_last(monkeypatch, tmp_path):
    monkeypatch.delenv("HALFPHYSICS_CACHE")
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setattr(sys, "platform", "linux")
    assert cache_folder() == tmp_path / ".cache" / "halfphysics"


@pytest.mark.parametrize(
    ("platform", "where"),
    [
        ("linux", ".cache/halfphysics"),
        ("darwin", "Library/Caches/halfphysics"),
        ("win32", "Local/halfphysics/Cache"),
    ],
)
def test_every_platform_has_its_folder(monkeypatch, tmp_path, platform, where):
    monkeypatch.delenv("HALFPHYSICS_CACHE")
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr(Path, "home", lambda: tmp_path)
    monkeypatch.setenv("LOCALAPPDATA", str(tmp_path / "Local"))
    monkeypatch.setattr(sys, "platform", platform)
    assert cache_folder() == tmp_path / where


def test_a_user_without_a_home_keeps_nothing(monkeypatch):
    def homeless():
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.delenv("HALFPHYSICS_CACHE")
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr(Path, "home", homeless)
    assert cache_folder() is None


def test_off(monkeypatch):
    monkeypatch.setenv("HALFPHYSICS_CACHE", "off")
    assert cache_folder() is None
