"""Tar archives in pieces: concatenated they equal one written by `tarfile` in one go."""

from __future__ import annotations

import io
import tarfile

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from halfphysics.errors import InputError
from halfphysics.sweep.store import tar
from halfphysics.sweep.store.contents import DAMAGE
from support.sweeps.sweep_shards import sample, write_tar


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(st.text("ab.é_", min_size=1, max_size=40), st.binary(max_size=3000))))
def test_members_and_end_are_an_archive(files):
    pieces = b"".join(b"".join(tar.member(name, data)) for name, data in files)
    whole = io.BytesIO()
    with tarfile.open(fileobj=whole, mode="w", format=tarfile.USTAR_FORMAT) as archive:
        for name, data in files:
            info = tarfile.TarInfo(name)
            info.size = len(data)
            archive.addfile(info, io.BytesIO(data))
    assert pieces + tar.ending(len(pieces)) == whole.getvalue()


def test_a_name_that_does_not_fit():
    with pytest.raises(InputError, match="does not fit an archive"):
        tar.member("a" * 300, b"")


def test_samples_are_read_as_they_were_written(tmp_path):
    shard = write_tar(tmp_path / "a.tar", [sample(n) for n in (0, 1, 4)])
    assert list(tar.samples(shard)) == [sample(n) for n in (0, 1, 4)]
    cards = list(tar.samples(shard, lambda name: name == "card.json"))
    assert [list(files) for _, files in cards] == [["card.json"]] * 3
    assert list(tar.samples(write_tar(tmp_path / "b.tar", []))) == []


@pytest.mark.parametrize("cut", [1, 1024, 10_240])
def test_an_archive_without_its_end_is_refused(tmp_path, cut):
    shard = write_tar(tmp_path / "a.tar", [sample(0)])
    whole = shard.read_bytes()
    content = len(whole.rstrip(b"\0"))
    shard.write_bytes(whole[: content - cut])
    with pytest.raises(DAMAGE):
        list(tar.samples(shard))
    # For `tarfile` a missing header ends the archive.
    with tarfile.open(fileobj=io.BytesIO(whole)) as archive:
        header = archive.getmembers()[1].offset
    shard.write_bytes(whole[:header] + bytes(512) + whole[header + 512 :])
    with pytest.raises(DAMAGE):
        list(tar.samples(shard))
