"""Atomic writes: a file appears complete or not at all."""

from __future__ import annotations

import errno
import os
import stat
import subprocess
import sys

import pytest

from halfphysics.base.atomic import atomic_path, atomic_write, reason
from halfphysics.errors import FileError


def test_the_file_is_there_when_all_of_it_is(tmp_path):
    path = tmp_path / "a.bin"
    path.write_bytes(b"old")
    with atomic_write(path) as handle:
        handle.write(b"new")
        assert path.read_bytes() == b"old"
    assert path.read_bytes() == b"new"
    assert os.listdir(tmp_path) == ["a.bin"]


def test_an_error_leaves_what_was_there_and_nothing_else(tmp_path):
    path = tmp_path / "a.bin"
    path.write_bytes(b"old")

    def fail():
        with atomic_write(path) as handle:
            handle.write(b"half")
            raise KeyError("of the caller")

    with pytest.raises(KeyError):
        fail()
    assert path.read_bytes() == b"old"
    assert os.listdir(tmp_path) == ["a.bin"]


def test_another_program_may_write_it(tmp_path):
    path = tmp_path / "a.txt"
    with atomic_path(path) as temporary:
        assert temporary.parent == tmp_path
        temporary.write_text("by another program")
    assert path.read_text() == "by another program"


@pytest.mark.skipif(os.name != "posix", reason="ends a process by a signal")
def test_what_a_killed_writer_left_is_removed_by_the_next(tmp_path):
    path = tmp_path / "film.mp4"
    program = (
        "import os, sys\nfrom halfphysics.base.atomic import atomic_write\n"
        "with atomic_write(sys.argv[1]) as handle:\n"
        "    handle.write(b'half')\n    handle.flush()\n    os.kill(os.getpid(), 9)\n"
    )
    subprocess.run([sys.executable, "-c", program, str(path)], check=False)
    (left,) = os.listdir(tmp_path)
    assert left.endswith(".part")
    with atomic_write(tmp_path / "another"):  # not its own
        pass
    assert left in os.listdir(tmp_path)
    with atomic_write(path) as handle:
        assert len([name for name in os.listdir(tmp_path) if name.endswith(".part")]) == 1
        # One that is being written by a process that runs stays.
        with atomic_write(path) as second:
            second.write(b"first")
        handle.write(b"new")
    assert path.read_bytes() == b"new"
    assert sorted(os.listdir(tmp_path)) == ["another", "film.mp4"]


def test_files_of_other_machines_stay_for_a_day(tmp_path):
    path = tmp_path / "a.bin"
    others = [tmp_path / name for name in (".a.bin.far-1.x1y2.part", ".a.bin.x1y2z3.part")]
    mine = tmp_path / ".a.bin.notes.txt"
    for file in (*others, mine):
        file.write_bytes(b"")
    with atomic_write(path):
        pass
    assert all(file.exists() for file in others)
    for file in others:
        os.utime(file, (1.0, 1.0))
    with atomic_write(path):
        pass
    assert not any(file.exists() for file in others)
    assert mine.exists()


@pytest.mark.skipif(os.name != "posix", reason="rights of POSIX")
def test_its_rights_are_those_of_any_new_file(tmp_path):
    plain, path = tmp_path / "plain", tmp_path / "atomic"
    plain.write_bytes(b"")
    with atomic_write(path):
        pass
    assert stat.S_IMODE(path.stat().st_mode) == stat.S_IMODE(plain.stat().st_mode)


@pytest.mark.skipif(os.name != "posix", reason="rights of POSIX")
def test_a_file_that_is_written_anew_keeps_its_rights(tmp_path):
    path = tmp_path / "private"
    path.write_bytes(b"")
    path.chmod(0o600)
    with atomic_write(path) as handle:
        handle.write(b"new")
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert path.read_bytes() == b"new"


@pytest.mark.skipif(os.name != "posix", reason="Windows lets few make links")
def test_a_link_is_written_through(tmp_path):
    """To a file that is there, to one that is not yet, to a folder, to nowhere, to itself."""
    there, link = tmp_path / "there", tmp_path / "link"
    there.mkdir()
    link.symlink_to("there/a.bin")
    for content in (b"new", b"newer"):
        with atomic_write(link) as handle:
            handle.write(content)
            assert [name.endswith(".part") for name in os.listdir(there)].count(True) == 1
        assert link.is_symlink()
        assert (there / "a.bin").read_bytes() == content
        assert os.listdir(there) == ["a.bin"]
    (tmp_path / "second").symlink_to("link")
    with atomic_write(tmp_path / "second") as handle:
        handle.write(b"newest")
    assert (there / "a.bin").read_bytes() == b"newest"
    for name, to, message in (
        ("folder", "there", "this is a folder"),
        ("nowhere", "gone/a.bin", "gone does not exist"),
        ("loop", "loop", "leads to itself"),
        ("device", "/dev/null", "a pipe or a device"),
    ):
        (tmp_path / name).symlink_to(to)
        with pytest.raises(FileError, match=message), atomic_write(tmp_path / name):
            pass
        assert (tmp_path / name).is_symlink()


def test_places_where_no_file_can_be(tmp_path):
    for path, words in (
        (tmp_path / "none" / "a", "does not exist. Create it first"),
        (tmp_path, "this is a folder. Give a file name"),
        (os.devnull, "a pipe or a device"),
    ):
        with pytest.raises(FileError, match=words), atomic_write(path):
            pass


def test_a_full_disk_is_said_with_the_way_out():
    full = OSError(errno.ENOSPC, "No space left on device")
    assert reason(full) == "No space left on device. Make room on the disk and try again"
    assert reason(OSError(errno.EACCES, "Permission denied")) == "Permission denied"
