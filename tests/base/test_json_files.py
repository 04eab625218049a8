"""Small JSON files: one text for one value, written atomically, read with checks."""

from __future__ import annotations

import pytest

from halfphysics.base import json_files
from halfphysics.errors import FileError


def test_equal_values_are_equal_texts():
    one, other = {"b": 1.5, "a": [1, "é"]}, {"a": [1, "é"], "b": 1.5}
    assert json_files.text_of(one) == json_files.text_of(other) == '{"a":[1,"é"],"b":1.5}'
    with pytest.raises(ValueError, match="not JSON compliant"):
        json_files.text_of({"a": float("nan")})


@pytest.mark.parametrize("lasting", [False, True])
def test_what_is_written_is_read(tmp_path, lasting):
    path = tmp_path / "made" / "a.json"
    json_files.write(path, {"a": [1, 2]}, lasting=lasting)
    assert path.read_bytes() == b'{"a":[1,2]}\n'
    assert json_files.read(path) == {"a": [1, 2]}


@pytest.mark.parametrize("content", [b"", b'{"a": [1', b"[1]", b"\xff", b"[" * 100_000])
def test_what_is_no_document_is_none(tmp_path, content):
    path = tmp_path / "a.json"
    assert json_files.read(path) is None
    path.write_bytes(content)
    assert json_files.read(path) is None


def test_errors_of_the_system_name_the_file(tmp_path):
    with pytest.raises(FileError, match=r"cannot read: Is a directory"):
        json_files.read(tmp_path)
    (tmp_path / "file").touch()
    with pytest.raises(FileError, match=r"b\.json: cannot write"):
        json_files.write(tmp_path / "file" / "b.json", {})
