"""Files that are dropped onto `view`: read as on the command line, refused in plain words."""

from __future__ import annotations

import errno
import os

import pytest

from halfphysics.errors import InputError
from halfphysics.viewer import dropped as module
from halfphysics.viewer.dropped import Dropped
from halfphysics.viewer.motions import is_untouched
from support.people import along_x


@pytest.fixture
def dropped():
    files = Dropped()
    yield files
    folder = files._folder
    files.close()
    assert folder is None or not folder.exists()


@pytest.fixture(scope="module")
def walk(tmp_path_factory):
    path = tmp_path_factory.mktemp("walk") / "walk.npz"
    along_x(1.0, 8, 0.0, z=1.2).save(path)
    return path.read_bytes()


@pytest.mark.parametrize("name", ["walk.npz", "../../walk.npz", "C:\\clips\\walk.npz"])
def test_a_motion_is_read_whatever_folder_its_name_has(dropped, walk, name):
    drawing = dropped.read(name, walk)
    assert len(drawing) == 8
    assert is_untouched(drawing.result)
    (file,) = dropped._folder.glob("*/*")
    assert file.name == "walk.npz"


@pytest.mark.parametrize(
    "name",
    ["..", ".", "", "a/..", "w\0alk.npz", 'C:w<>:"|?*alk.npz', "w" * 300 + ".npz", "ü" * 300],
)
def test_a_name_that_no_file_may_have_is_made_one(dropped, walk, name):
    assert len(dropped.read(name, walk)) == 8
    (file,) = dropped._folder.glob("*/*")
    assert not set(file.name) & set('\0<>:"|?*')
    assert len(file.name.encode()) <= 255
    assert file.suffix in ("", ".npz")


def test_a_disk_without_room_is_said(dropped, walk, monkeypatch):
    def full(path, content):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(module.Path, "write_bytes", full)
    with pytest.raises(InputError, match=r"^walk\.npz: cannot be kept: No space left"):
        dropped.read("walk.npz", walk)


def test_what_is_no_motion_is_said_in_one_line_with_its_name(dropped, walk):
    with pytest.raises(InputError, match=r"^notes\.md: no known motion format\.") as error:
        dropped.read("notes.md", b"# Notes")
    assert str(error.value).endswith("Formats that are read: halfphysics formats")
    assert len(str(error.value)) < 200
    with pytest.raises(InputError, match=r"^half\.npz"):
        dropped.read("half.npz", walk[: len(walk) // 2])
    assert list(dropped._folder.glob("*/*")) == []


def test_a_large_file_is_refused_before_it_is_read(dropped, walk, monkeypatch):
    monkeypatch.setattr(module, "LIMIT", len(walk) - 1)
    with pytest.raises(InputError, match=r"walk\.npz: 0 MB, expected up to"):
        dropped.read("walk.npz", walk)
    assert dropped._folder is None


def test_all_files_have_a_total_size(dropped, walk, monkeypatch):
    monkeypatch.setattr(module, "TOTAL", 2 * len(walk) + 1)
    dropped.read("walk.npz", walk)
    with pytest.raises(InputError):
        dropped.read("no motion.npz", walk[: len(walk) // 2])  # not kept, so it does not count
    dropped.read("walk.npz", walk)
    with pytest.raises(InputError, match="Start halfphysics view again"):
        dropped.read("walk.npz", walk)
