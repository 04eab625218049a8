"""Names of source files: one for each file, from any path of it, and links are followed."""

from __future__ import annotations

import os

import pytest

from halfphysics.sweep.make.source_name import source_name


@pytest.fixture
def there(tmp_path):
    """`plan/clips/a.npz`, `far/plan/b.npz`, and links: `link` to far/out, `plan/more` to far."""
    for name in ("plan/clips/a.npz", "far/out/x", "far/b.npz", "far/plan/c.npz"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    (tmp_path / "link").symlink_to(tmp_path / "far" / "out")
    (tmp_path / "plan" / "more").symlink_to(tmp_path / "far")
    return tmp_path


def test_one_name_for_every_path_of_the_folder(there, monkeypatch):
    monkeypatch.chdir(there)
    (there / "other").symlink_to(there / "plan")
    (there / "far" / "home").symlink_to(there / "plan")
    # A process that starts in the folder of results goes over a link and back.
    for base in (
        "plan",
        "other",
        there / "plan",
        "./far/../plan",
        "link/../home",
        "plan/more/home",
    ):
        for way in ("clips/a.npz", there / base / "clips/a.npz", "clips/../clips/./a.npz"):
            assert source_name(way, base) == "clips/a.npz"
        assert source_name(there / "plan/clips/a.npz", base) == "clips/a.npz"
        assert source_name(there / "other/clips/a.npz", base) == "clips/a.npz"


def test_a_link_in_the_folder_keeps_its_name(there):
    (there / "plan" / "d.npz").symlink_to(there / "far" / "b.npz")
    for way in ("more/b.npz", "d.npz"):
        assert source_name(way, there / "plan") == way
        assert source_name(there / "plan" / way, there / "plan") == way
        assert source_name(f"clips/../{way}", there / "plan") == way


def test_what_is_elsewhere_can_be_opened(there):
    real = os.path.realpath(there)
    assert source_name(there / "far/b.npz", there / "plan") == f"{real}/far/b.npz"
    assert source_name("../far/b.npz", there / "plan") == f"{real}/far/b.npz"
    # `..` is the folder above what the link leads to.
    assert source_name(there / "link/../b.npz", there / "plan") == f"{real}/far/b.npz"
    assert source_name("more/../plan/clips/a.npz", there / "plan") == "clips/a.npz"
    assert source_name(there / "link/../plan/c.npz", there) == "far/plan/c.npz"
