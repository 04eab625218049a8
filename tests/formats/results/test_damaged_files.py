"""Messages for damaged, incomplete and foreign files that are read as results."""

from __future__ import annotations

import io
import json
import zipfile

import numpy as np
import pytest

from halfphysics.base.npz import write_npz
from halfphysics.body.body import Body
from halfphysics.errors import FileError
from halfphysics.results.result import Result
from support.results.random_result import make_result


@pytest.fixture(scope="module")
def body():
    return Body.default()


@pytest.fixture(scope="module")
def saved(body, tmp_path_factory):
    path = tmp_path_factory.mktemp("saved") / "r.npz"
    make_result(body, people=2, holds=2).save(path)
    with np.load(path) as file:
        return {key: file[key] for key in file}, path.read_bytes()


@pytest.mark.parametrize("share", [0.01, 0.3, 0.6, 0.9, 0.999])
def test_truncated(tmp_path, saved, share):
    path = tmp_path / "r.npz"
    path.write_bytes(saved[1][: int(share * len(saved[1]))])
    with pytest.raises(FileError, match=r"r\.npz"):
        Result.load(path)


@pytest.mark.parametrize("seed", range(4))
def test_a_changed_byte_is_found_or_harmless(tmp_path, saved, seed):
    """After any damage the arrays that come back are right, or a FileError is raised."""
    rng = np.random.default_rng(seed)
    path = tmp_path / "r.npz"
    refused = 0
    for _ in range(25):
        raw = bytearray(saved[1])
        raw[rng.integers(len(raw))] ^= int(rng.integers(1, 256))
        path.write_bytes(raw)
        try:
            result = Result.load(path)
        except FileError:
            refused += 1
        else:
            np.testing.assert_array_equal(result.motion.rotations, saved[0]["meta/rotations"])
            np.testing.assert_array_equal(result.contacts.impulse, saved[0]["contact/impulse"])
    assert refused > 10  # most bytes are data


@pytest.mark.parametrize("at", [60, 100, 140])
def test_a_damaged_array_header(tmp_path, saved, at):
    """numpy reads headers as Python source, which fails in many ways."""
    with zipfile.ZipFile(tmp_path / "r.npz", "w") as archive:
        for key, value in saved[0].items():
            stream = io.BytesIO()
            np.lib.format.write_array(stream, value)
            raw = bytearray(stream.getvalue())
            if key == "meta/translation":
                raw[10 : at - 20] = b"(" * (at - 30)
            archive.writestr(f"{key}.npy", bytes(raw))
    with pytest.raises(FileError, match="field 'meta/translation' is damaged"):
        Result.load(tmp_path / "r.npz")


def _json_of(value):
    return np.array(json.dumps(value))


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("meta/format_version", None, "found no 'meta/format_version'.*Motion.load"),
        ("meta/format_version", np.array(99), r"found 99, expected 1.*newer"),
        ("meta/people", None, "field 'meta/people' is missing"),
        ("meta/people", np.array("{"), "field 'meta/people': not valid JSON"),
        ("meta/people", _json_of([]), "no people"),
        ("meta/people", _json_of([{"name": "a"}]), "body of person 0"),
        ("meta/people", np.zeros(3), "expected JSON text"),
        ("meta/hold/1/position", None, "field 'meta/hold/1/position' is missing"),
        ("person/1/hold/0/position", np.zeros((4, 3)), r"quaternion: found shape \(5, 4\)"),
        ("meta/recorded_rotations", np.zeros((4, 55, 3)), "rotations: found 4 frames"),
        ("meta/recorded_rotations", None, "field 'meta/recorded_rotations' is missing"),
        ("meta/settings", _json_of({"stiffness": -1.0}), "stiffness is -1.0"),
        ("meta/settings", _json_of({"stifness": 1.0}), "unknown settings .'stifness'"),
        ("meta/scene", _json_of({"statics": {}}), "field 'meta/scene': found.*expected version"),
        ("meta/fps", np.array("x"), "field 'meta/fps'.*expected a number"),
        ("meta/fps", np.array(-30.0), "fps: found -30.0"),
        ("meta/names", np.arange(3), "field 'meta/names'"),
        ("meta/names", np.array(["ball", "floor"]), "names: found ball, floor"),
        ("meta/rotations", np.full((5, 55, 3), np.nan), "rotations: 825 values are NaN"),
        ("meta/rotations", np.zeros((5, 54, 3)), r"rotations: found shape \(5, 54, 3\)"),
        ("meta/clearance", np.zeros(4), r"found lengths .*'clearance': 4.*expected 5"),
        ("meta/clearance", np.full(5, np.nan), "clearance: found .* with 5 NaN"),
        ("object/ball/position", np.zeros((4, 3)), "position has 4 frames and quaternion 5"),
        ("object/ball/quaternion", None, "field 'object/ball/quaternion' is missing"),
        ("contact/frame", np.array([0.5]), "contacts.frame.*whole numbers"),
        ("contact/part", np.array([1]), r"contacts.part: found 1 rows"),
        ("person/1/rotations", None, "field 'person/1/rotations' is missing"),
        ("poses", np.zeros((5, 165)), "changed after it was written"),
    ],
)
def test_wrong_fields(tmp_path, saved, key, value, message):
    fields = dict(saved[0])
    if value is None:
        del fields[key]
    else:
        fields[key] = value
    path = tmp_path / "r.npz"
    write_npz(path, fields)
    with pytest.raises(FileError, match=message) as caught:
        Result.load(path)
    assert str(path) in str(caught.value)


@pytest.mark.parametrize(
    ("holds", "message"),
    [
        ("both", "holds of person 0: found 'both', expected a list"),
        ([{"object": "ball"}], "holds of person 0: found .*expected object, parts, first"),
        ({"parts": "left_wrist"}, "expected lists of parts and of moved"),
        ({"parts": [[]]}, "expected one of JOINT_NAMES"),
        ({"object": None}, "expected the name of an object"),
        ({"first": None}, "found frames None to 4"),
        ({"force": "much"}, "force: expected a number"),
    ],
)
def test_wrong_holds(tmp_path, saved, holds, message):
    fields = dict(saved[0])
    people = json.loads(str(fields["meta/people"]))
    if isinstance(holds, dict):
        people[0]["holds"][0] |= holds
    else:
        people[0]["holds"] = holds
    fields["meta/people"] = _json_of(people)
    write_npz(tmp_path / "r.npz", fields)
    with pytest.raises(FileError, match=message):
        Result.load(tmp_path / "r.npz")


def test_contacts_beyond_the_result_are_refused(tmp_path, saved):
    fields = dict(saved[0])
    fields["contact/frame"] = np.full(len(fields["contact/frame"]), 5)
    write_npz(tmp_path / "r.npz", fields)
    with pytest.raises(FileError, match=r"contacts\.frame: found 5 to 5, expected 0 to 4"):
        Result.load(tmp_path / "r.npz")


def test_python_objects_are_never_read(tmp_path, saved):
    fields = dict(saved[0])
    fields["meta/names"] = np.array([{"a": 1}], dtype=object)
    np.savez(tmp_path / "r.npz", **fields)
    with pytest.raises(FileError, match="Python objects"):
        Result.load(tmp_path / "r.npz")


def test_other_files(tmp_path):
    with pytest.raises(FileError, match=r"nothing.npz: no such file"):
        Result.load(tmp_path / "nothing.npz")
    with pytest.raises(FileError, match="this is a folder"):
        Result.load(tmp_path)
    (tmp_path / "text.npz").write_text("hello")
    with pytest.raises(FileError, match=r"not an .npz archive"):
        Result.load(tmp_path / "text.npz")


def test_nothing_is_left_where_it_cannot_be_written(tmp_path, body):
    with pytest.raises(FileError, match="does not exist"):
        make_result(body).save(tmp_path / "no" / "r.npz")
    assert not list(tmp_path.iterdir())
