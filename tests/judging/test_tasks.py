"""Which clips are judged, and against which truth."""

from __future__ import annotations

import pytest

from halfphysics.errors import FileError, HalfPhysicsError
from halfphysics.judging.tasks import tasks_of
from support.made_clips import walk


def test_folders_and_globs_and_files(library):
    names = ["a.npz", "broken.npz", "deep/b.npz"]
    assert [t.path.relative_to(library).as_posix() for t in tasks_of([library], None)] == names
    found = tasks_of([library / "a.npz", library / "deep", library / "*.npz"], None)
    assert [t.path.name for t in found] == ["a.npz", "b.npz"]
    with pytest.raises(HalfPhysicsError, match="no such file or folder"):
        tasks_of([library / "gone.npz"], None)
    (library / "empty").mkdir()
    with pytest.raises(HalfPhysicsError, match="no motion in it"):
        tasks_of([library / "empty"], None)


def test_truth_by_name(library, tmp_path_factory):
    truths = tmp_path_factory.mktemp("truth")
    (truths / "deep").mkdir()
    for name in ("a.npz", "broken.npz", "deep/b.npz"):
        walk().save(truths / name)
    found = tasks_of([library], truths)
    assert [t.truth for t in found] == [truths / t.path.relative_to(library) for t in found]
    one = truths / "a.npz"
    assert {t.truth for t in tasks_of([library], one)} == {one}
    (truths / "deep" / "b.npz").unlink()
    with pytest.raises(FileError, match=r"found no files for b\.npz, expected one"):
        tasks_of([library], truths)
    with pytest.raises(HalfPhysicsError, match="no such file or folder"):
        tasks_of([library], truths / "gone")


def test_names_of_clips_are_no_patterns(tmp_path):
    """A truth of another format, found by its stem."""
    for folder in ("clips", "truth"):
        (tmp_path / folder).mkdir()
    walk().save(tmp_path / "clips" / "walk[1].npz")
    walk().save(tmp_path / "truth" / "walk[1].pkl", format="smplx-params")
    (task,) = tasks_of([tmp_path / "clips"], tmp_path / "truth")
    assert task.truth == tmp_path / "truth" / "walk[1].pkl"
