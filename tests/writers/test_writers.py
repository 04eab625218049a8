"""Common to all file writers: the same bytes, atomic writes, plain files."""

from __future__ import annotations

import os
import time

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.errors import FileError, InputError
from halfphysics.formats import FORMATS
from halfphysics.writers import KINDS
from support.files.layouts import movement


@pytest.fixture(scope="module")
def motion():
    return hp.Motion(*movement(6), 30.0)


def names():
    """A file name for every format and kind of scene that can be written."""
    for name, known in FORMATS.items():
        if known.save is not None:
            yield pytest.param(name, known.suffixes[0], id=name)
    for suffix in KINDS:
        yield pytest.param(None, suffix, id=suffix)


def write(motion, path, name):
    if name is None:
        if KINDS[path.suffix] == "usd":
            pytest.importorskip("pxr")
        hp.export(motion, path)
    else:
        motion.save(path, format=name, body=hp.Body.default())


@pytest.mark.parametrize(("name", "suffix"), list(names()))
def test_the_same_bytes_at_any_time(tmp_path, motion, monkeypatch, name, suffix):
    (tmp_path / "then").mkdir()
    (tmp_path / "now").mkdir()
    write(motion, tmp_path / "now" / f"o{suffix}", name)
    if suffix == ".usdz":
        time.sleep(2.1)  # its clock differs from ours; zip's goes in steps of two seconds
    monkeypatch.setattr(time, "time", lambda: 1e9)
    write(motion, tmp_path / "then" / f"o{suffix}", name)
    once, again = ((tmp_path / when / f"o{suffix}").read_bytes() for when in ("then", "now"))
    assert once == again


@pytest.mark.parametrize(("name", "suffix"), list(names()))
def test_what_goes_wrong_leaves_what_was_there(tmp_path, motion, monkeypatch, name, suffix):
    path = tmp_path / f"o{suffix}"
    path.write_bytes(b"of yesterday")

    def full(*args):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full)  # after all data has been written
    with pytest.raises(FileError, match=f"o\\{suffix}: cannot write: No space left on device"):
        write(motion, path, name)
    assert [file.name for file in tmp_path.iterdir()] == [path.name]
    assert path.read_bytes() == b"of yesterday"


@pytest.mark.parametrize(("name", "suffix"), list(names()))
def test_a_pipe_is_not_replaced(tmp_path, motion, name, suffix):
    path = tmp_path / f"o{suffix}"
    os.mkfifo(path)
    with pytest.raises(FileError, match="this is a pipe or a device"):
        write(motion, path, name)
    assert path.is_fifo()


@pytest.mark.parametrize("order", ["C", "F"])
@pytest.mark.parametrize("dtype", ["f2", "f4", ">f4", "f8", ">f8"])
def test_any_kind_of_number(tmp_path, dtype, order):
    translation, rotations = movement()
    arrays = {"trans": translation, "poses": rotations.reshape(12, 165)}
    arrays = {key: np.asarray(array, dtype, order=order) for key, array in arrays.items()}
    np.savez(tmp_path / "a.npz", **arrays, betas=[0.0], gender=b"female", mocap_framerate=30)
    motion = hp.Motion.load(tmp_path / "a.npz")
    assert motion.gender == "female"
    motion.save(tmp_path / "b.npz")
    with np.load(tmp_path / "b.npz") as again:
        for key, array in arrays.items():
            assert again[key].dtype == array.dtype
            assert np.array_equal(again[key], array)


def test_arguments_of_another_kind(tmp_path, motion):
    for path in (tmp_path / "o.glb", tmp_path / "o.xml"):
        with pytest.raises(InputError, match=r"body: expected a halfphysics\.Body"):
            hp.export(motion, path, body="SMPLX_NEUTRAL.npz")
    for path in (tmp_path / "o.bvh", tmp_path / "o.smpl", tmp_path / "o.npz"):
        with pytest.raises(InputError, match=r"body: expected a halfphysics\.Body"):
            motion.save(path, body="SMPLX_NEUTRAL.npz")
    with pytest.raises(InputError, match="format: found"):
        motion.save(tmp_path / "o.npz", format=["bvh"])
    assert not list(tmp_path.iterdir())
    motion.save(tmp_path / "o.npz")
    with pytest.raises(InputError, match="path: expected the path of a file"):
        hp.load_sequence(tmp_path / "o.npz", assets=3)


def test_what_moves_along_a_trajectory_moves_in_files_too():
    """A sequence that was not simulated: its lift rises in whatever is written of it."""
    from halfphysics.simulation.sequence import Sequence
    from halfphysics.viewer.motions import _track
    from halfphysics.writers.take import take_of

    motion = hp.Motion(*movement(31), 30.0)
    scene = hp.Scene()
    path = np.outer(np.linspace(0.0, 2.0, 16), (0.0, 0.0, 1.0))
    scene.add_moving("lift", hp.Box((1.0, 1.0, 0.1)), path, fps=15.0)
    sequence = Sequence(motion, scene)
    (lift,) = (prop for prop in take_of(sequence).props if prop.name == "lift")
    rise = np.linspace(0.0, 2.0, 31)
    np.testing.assert_allclose(lift.position[:, 2], rise, atol=1e-12)
    shown = _track("lift", scene, sequence, 31)
    np.testing.assert_allclose(shown.position[:, 2], rise, atol=1e-12)
