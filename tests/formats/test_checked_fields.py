"""Fields of files: their shapes and values, and what is no array."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.base.npz import Npz
from halfphysics.errors import FileError
from halfphysics.formats.checked_fields import Record, shape_of

UNEVEN = [[1.0, 2.0], [3.0]]


def test_shapes_and_values_of_arrays_and_lists(tmp_path):
    fields = {"array": np.zeros((4, 3)), "list": [[1, 2], [3, 4]], "one": 2.5, "word": "walk"}
    np.savez(tmp_path / "a.npz", **fields)
    for record in (Record("a", fields), Record("a", Npz(tmp_path / "a.npz"))):
        shapes = {key: record.shape(key) for key in fields}
        assert shapes == {"array": (4, 3), "list": (2, 2), "one": (), "word": ()}
        assert record.flat("list").tolist() == [1, 2, 3, 4]
        assert record.flat("word").tolist() == ["walk"]
        with pytest.raises(FileError, match=r"a: field 'other' is missing.*expected other \(T,\)"):
            record.shape("other", "(T,)")


@pytest.mark.parametrize(
    "read",
    [
        lambda record: record.shape("x"),
        lambda record: record.flat("x"),
        lambda record: record.array("x", None, 2),
        lambda record: record.number("x"),
        lambda record: record.text("x"),
    ],
)
def test_rows_of_different_lengths_are_named(read):
    with pytest.raises(
        FileError, match=r"a\.pkl: field 'x': found rows of shapes \(2,\) and \(1,\), expected "
    ):
        read(Record("a.pkl", {"x": UNEVEN}))
    assert shape_of(UNEVEN) is None
    assert shape_of(np.zeros((4, 3))) == (4, 3)
