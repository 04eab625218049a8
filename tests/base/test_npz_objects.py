"""Archives with pickled members: data is read, damage and hostile content are refused."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp

from halfphysics.base.npz_objects import NpzObjects
from halfphysics.body.body import Body
from halfphysics.errors import FileError
from support.files.model_files import fields as model_fields
from support.files.wrong_files import Boom


def test_objects_and_arrays_come_out_as_they_went_in(tmp_path):
    path = tmp_path / "a.npz"
    sparse = sp.csc_matrix(np.eye(3))
    words = np.array(["a", None, "b"], dtype=object)
    np.savez(
        path, part={"x": np.arange(4)}, plain=np.ones(2), sparse=sparse, words=words, text="hi"
    )
    npz = NpzObjects(path)
    assert npz["part"]["x"].tolist() == [0, 1, 2, 3]
    assert np.array_equal(npz["sparse"], np.eye(3))
    assert npz["words"].tolist() == ["a", None, "b"]
    assert npz["plain"].tolist() == [1.0, 1.0]
    assert npz["text"].item() == "hi"
    with pytest.raises(KeyError):
        npz["nothing"]


def damaged(path, key):
    """The compressed bytes of a member, replaced by zeros."""
    whole = bytearray(path.read_bytes())
    at = whole.index(f"{key}.npy".encode()) + 60
    whole[at : at + 40] = bytes(40)
    path.write_bytes(bytes(whole))
    return path


def test_damage(tmp_path):
    path = tmp_path / "a.npz"
    np.savez_compressed(path, part={"x": np.random.default_rng(0).normal(size=400)})
    with pytest.raises(FileError, match=r"a\.npz: field 'part' is damaged or truncated"):
        NpzObjects(damaged(path, "part"))["part"]


def test_damage_in_a_body_model(tmp_path):
    path = tmp_path / "SMPLX_MALE.npz"
    content = model_fields("smplx")
    content["J_regressor"] = np.array(sp.csc_matrix(content["J_regressor"]), dtype=object)
    np.savez_compressed(path, **content)
    Body.load(path)
    with pytest.raises(FileError, match="field 'J_regressor' is damaged or truncated"):
        Body.load(damaged(path, "J_regressor"))


def test_hostile(tmp_path):
    path = tmp_path / "a.npz"
    np.savez(path, part=np.array({"x": Boom(tmp_path / "was_run")}, dtype=object))
    with pytest.raises(FileError, match="field 'part': unsafe or unknown content"):
        NpzObjects(path)["part"]
    assert not (tmp_path / "was_run").exists()


def test_absurd_sizes(tmp_path, monkeypatch):
    path = tmp_path / "a.npz"
    np.savez_compressed(path, part={"x": np.zeros(1000)})
    monkeypatch.setattr("halfphysics.base.pickle_placeholders.MAX_BYTES", 1000)
    with pytest.raises(FileError, match="field 'part' unpacks to"):
        NpzObjects(path)["part"]
