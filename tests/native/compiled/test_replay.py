"""World files of strangers: what is damaged or made up is refused, and what is not can be stepped.

Each case is a file with a checksum that fits. `tools/sanitize.sh tests/native/compiled` watches
memory; `HALFPHYSICS_FUZZ=SECONDS` goes on with new cases.
"""

from __future__ import annotations

import struct
import zlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import halfphysics as hp
from halfphysics import _native
from support.doors import DOOR
from support.fuzzing import drawn

HEADER = 32


@pytest.fixture(scope="module")
def files():
    """A world file of a person, objects, a mesh and a trajectory, and one of objects alone."""
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    scene.add_static("roof", hp.Mesh([(0, 0, 3), (1, 0, 3), (0, 1, 3)], [(0, 1, 2)]))
    scene.add_object("ball", hp.Sphere(0.1), mass=1.0, position=(1, 0, 0.101))
    scene.add_object("can", hp.Cylinder(0.05, 0.2), mass=0.3, position=(2, 0, 0.11), start="asleep")
    small = hp.compile_world(scene, body=[])
    scene.add_moving("cart", hp.Box((0.5, 0.5, 0.5)), [(5, 0, 0.5), (5, 1, 0.5)], fps=1.0)
    settings = hp.Settings(self_contact=True)
    return hp.compile_world(scene, settings=settings), small


def sealed(body, count):
    """A file of a body, with a header that fits it."""
    head = struct.pack("<IIQII", 1, zlib.crc32(body), len(body), count, 0)
    return b"\x89HPW\r\n\x1a\n" + head + body


def tried(data):
    """Reads and steps a file; whether it was taken. Only `ValueError` may say no."""
    try:
        qpos = _native.run_world(data, 2)
    except ValueError:
        return False
    assert qpos.ndim == 1
    return True


def test_whole_files_run(files):
    for data in files:
        assert np.isfinite(_native.run_world(data, 2)).all()


@drawn(40)
@given(st.data())
def test_flipped_bits(files, data):
    original = data.draw(st.sampled_from(files))
    body, count = bytearray(original[HEADER:]), struct.unpack("<I", original[24:28])[0]
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(body) - 1))
        body[at] ^= 1 << data.draw(st.integers(0, 7))
    tried(sealed(bytes(body), count))


@drawn(40)
@given(st.data())
def test_words_that_mean_something_else(files, data):
    """Sizes, indices and numbers replaced by others, in headers and small arrays above all."""
    original = files[1]
    body, count = bytearray(original[HEADER:]), struct.unpack("<I", original[24:28])[0]
    words = [0, 1, 2, 55, -1, 2**31 - 1, -(2**31)]
    at = 4 * data.draw(st.integers(0, len(body) // 4 - 2))
    if data.draw(st.booleans()):
        body[at : at + 4] = struct.pack("<i", data.draw(st.sampled_from(words)))
    else:
        at -= at % 8
        body[at : at + 8] = struct.pack("<d", data.draw(st.floats()))
    tried(sealed(bytes(body), count))


@drawn(20)
@given(st.data())
def test_cut_and_joined(files, data):
    original = data.draw(st.sampled_from(files))
    body, count = original[HEADER:], struct.unpack("<I", original[24:28])[0]
    a, b = sorted(8 * data.draw(st.integers(0, len(body) // 8)) for _ in range(2))
    assert not tried(sealed(body[:a] + body[b:], count)) or a == b
    assert not tried(original[: HEADER + a]) or a == len(body)


def calls_of(data):
    """The calls of a file: (name, bytes)."""
    body, at, calls = data[HEADER:], 0, []
    for _ in range(struct.unpack("<I", data[24:28])[0]):
        begin, (count,) = at, struct.unpack_from("<I", body, at)
        name = body[at + 8 : at + 32].rstrip(b"\0").decode()
        at += 32
        for _ in range(count):
            kind, _dims, *shape = struct.unpack_from("<II3Q", body, at + 24)
            size = {1: 4, 2: 8, 3: 1}[kind] * shape[0] * shape[1] * shape[2]
            at += 56 + size + -size % 8
        calls.append((name, body[begin:at]))
    assert at == len(body)
    return calls


@pytest.mark.parametrize("substeps", [1_001, 65_536, 2**31 - 1])
def test_files_that_would_run_for_minutes(files, substeps):
    """One flipped bit in the number of substeps: a frame in contact took two minutes."""
    original = files[1]
    body, count = bytearray(original[HEADER:]), struct.unpack("<I", original[24:28])[0]
    at = body.rindex(b"substeps\0") + 56  # the array's bytes, behind its name, kind and shape
    assert struct.unpack_from("<i", body, at) == (0,)
    body[at : at + 4] = struct.pack("<i", substeps)
    assert not tried(sealed(bytes(body), count))
    body[at : at + 4] = struct.pack("<i", 1_000)
    assert tried(sealed(bytes(body), count))


def test_calls_in_another_order_missing_or_twice(files):
    """What is taken runs without a crash, and what must be there is missed."""
    calls = calls_of(files[1])
    needed = {
        "set_model",
        "set_pairings",
        "finish",
        "label_everything",
        "label_start",
        "label_friction",
    }
    for i, (name, _) in enumerate(calls):
        without = [data for j, (_, data) in enumerate(calls) if j != i]
        assert not (tried(sealed(b"".join(without), len(without))) and name in needed), name
        twice = [data for _, data in calls] + [calls[i][1]]
        taken = tried(sealed(b"".join(twice), len(twice)))
        assert not (taken and name in {"set_model", "finish", "add_shape"}), name
    backwards = [data for _, data in reversed(calls)]
    assert not tried(sealed(b"".join(backwards), len(backwards)))


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (b"", "this is no world file: expected one that halfphysics.compile_world"),
        (sealed(b"", 0), "it ends before the world is whole"),
        (sealed(struct.pack("<II24s", 0, 0, b"set_moon"), 1), "there is no call set_moon"),
        (sealed(struct.pack("<II24s", 0, 0, b"set_model"), 1), "set_model lacks"),
        (sealed(struct.pack("<II24s", 0, 0, b"finish"), 1), "finish is out of order"),
    ],
)
def test_what_is_wrong_is_said(data, says):
    with pytest.raises(ValueError, match=says):
        _native.run_world(data, 1)


def written(data, call, argument, index, value):
    """A file with another whole number in the first call of a name."""
    body, count = bytearray(data[HEADER:]), struct.unpack("<I", data[24:28])[0]
    at = body.index(call.encode() + b"\0")
    at = body.index(argument.encode().ljust(24, b"\0"), at) + 56 + 4 * index
    struct.pack_into("<i", body, at, value)
    return sealed(bytes(body), count)


@pytest.fixture(scope="module")
def door():
    """A world file of a door, which has a joint and a link that no joint moves."""
    scene = hp.Scene()
    scene.add_articulated("door", DOOR)
    return hp.compile_world(scene, body=[])


def test_coordinates_of_joints_are_those_of_the_model(door):
    """A sum of them beyond the whole numbers was taken for a small one."""
    assert tried(written(door, "label_joint", "qpos", 0, 0))
    for qpos in (-1, 1, 2**31 - 1, 2**31 - 7):
        assert not tried(written(door, "label_joint", "qpos", 0, qpos)), qpos


def test_first_joints_and_dofs_of_bodies_without_any_are_near(door):
    """The factor of the inertia walks from them."""
    for argument in ("jnt_first", "dof_first"):
        assert tried(written(door, "set_model", argument, 0, -1)), argument
        for value in (-(2**31), -2, 100, 2**31 - 1):
            assert not tried(written(door, "set_model", argument, 0, value)), (argument, value)


@pytest.mark.parametrize("value", [0.0, 2.0])
def test_a_start_has_unit_quaternions(value):
    """A quaternion of zeros made every pose NaN."""
    scene = hp.Scene()
    scene.add_object("box", hp.Box((0.1, 0.1, 0.1)), mass=1.0, position=(0, 0, 1))
    data = hp.compile_world(scene, body=[])
    body, count = bytearray(data[HEADER:]), struct.unpack("<I", data[24:28])[0]
    at = body.index(b"qpos".ljust(24, b"\0"), body.index(b"label_start\0")) + 56 + 8 * 3
    assert struct.unpack_from("<d", body, at) == (1.0,)
    struct.pack_into("<d", body, at, value)
    with pytest.raises(ValueError, match="quaternion is no unit"):
        _native.run_world(sealed(bytes(body), count), 1)


@pytest.mark.parametrize("weights", [0.0, -1.0, np.nan])
def test_skin_needs_weights(weights):
    def of(weight):
        return _native.SkinShapes(
            body=whole(1), dof=whole(0), parent=whole(-1), joint=np.zeros((1, 3)),
            rest=np.vstack([np.zeros(3), np.eye(3)]), first=whole(0, 1, 2, 3, 4),
            at=whole(0, 0, 0, 0), weight=weight, bend=np.zeros((0, 3, 0)), part=whole(0),
            start=whole(0, 4), vertex=whole(0, 1, 2, 3),
        )  # fmt: skip

    def whole(*numbers):
        return np.array(numbers, np.int32)

    of(np.ones(4))
    with pytest.raises(ValueError, match="weights are 0"):
        of(np.array([1.0, 1.0, 1.0, weights]))
