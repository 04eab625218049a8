"""Paths without a plain file: pipes, devices, rings of links, closed folders."""

from __future__ import annotations

import os
import shutil

import pytest

import halfphysics as hp
from halfphysics.cli import main
from halfphysics.errors import FileError
from support.files.layouts import movement


@pytest.fixture
def clip(tmp_path):
    path = tmp_path / "clip.npz"
    hp.Motion(*movement(), 30.0).save(path)
    return path


def test_a_pipe_is_refused_and_not_waited_for(tmp_path, clip, capsys):
    pipe = tmp_path / "pipe.npz"
    os.mkfifo(pipe)
    for load in (hp.Motion.load, hp.load_sequence, lambda path: list(hp.clips(path))):
        with pytest.raises(FileError, match=r"pipe\.npz: this is a pipe or a device"):
            load(pipe)
    for command in ("convert", "evaluate", "simulate"):
        out = {"convert": [str(tmp_path / "o.npz")], "simulate": ["--out", str(tmp_path / "o.npz")]}
        assert main([command, str(pipe), *out.get(command, [])]) == 2
        assert "pipe or a device" in capsys.readouterr().err
    assert [found.path for found in hp.clips(tmp_path)] == [clip]
    with pytest.raises(FileError, match="/dev/zero: this is a pipe or a device"):
        hp.Motion.load("/dev/zero")


@pytest.mark.parametrize("pattern", ["", "**/*.npz"])
def test_links_in_a_ring(tmp_path, clip, pattern):
    folder = tmp_path / "a" / "b"
    folder.mkdir(parents=True)
    shutil.move(clip, folder / clip.name)
    for k in range(4):
        (folder / f"up{k}").symlink_to(tmp_path)
    (tmp_path / "self").symlink_to(".")
    (tmp_path / "lost.npz").symlink_to("nowhere")
    (tmp_path / "round.npz").symlink_to("round.npz")
    found = [found.path for found in hp.clips(tmp_path / pattern)]
    assert found == [folder / clip.name]
    with pytest.raises(FileError, match=r"round\.npz: no such file"):
        hp.Motion.load(tmp_path / "round.npz")


def test_a_name_that_no_file_can_have(tmp_path, clip):
    path = tmp_path / ("x" * 300 + ".npz")
    motion = hp.Motion.load(clip)
    calls = (hp.Motion.load, hp.Result.load, hp.Body.load, motion.save, lambda p: list(hp.clips(p)))
    for call in calls:
        with pytest.raises(FileError, match="cannot be reached: File name too long"):
            call(path)
    with pytest.raises(FileError, match="File name too long"):
        hp.export(motion, path.with_suffix(".glb"))
    with pytest.raises(FileError, match="File name too long"):
        hp.Scene().add_static("a", path.with_suffix(".obj"))


@pytest.mark.skipif(not getattr(os, "geteuid", int)(), reason="root, or Windows: nothing is shut")
def test_closed_folders(tmp_path, clip):
    motion = hp.Motion.load(clip)
    shut = tmp_path / "shut"
    shut.mkdir()
    inside = shut / "clip.npz"
    shutil.copy(clip, inside)
    shut.chmod(0)
    try:
        for call in (hp.Motion.load, hp.Result.load, hp.Body.load, motion.save):
            with pytest.raises(FileError, match="Permission denied"):
                call(inside)
        with pytest.warns(hp.HalfPhysicsWarning, match="shut: cannot read this folder"):
            assert [found.path for found in hp.clips(tmp_path)] == [clip]
        with pytest.raises(FileError, match="shut: cannot read this folder"):
            list(hp.clips(shut))
    finally:
        shut.chmod(0o700)
