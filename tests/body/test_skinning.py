"""The native skinning against its numpy reference, and its guarantees on bytes."""

from __future__ import annotations

import threading
import time

import numpy as np
import pytest

from halfphysics import _native
from halfphysics.base import rotations as rot
from halfphysics.body import skinning
from halfphysics.errors import InputError
from halfphysics.motion.skeleton import PARENTS
from support.files.model_files import VERTICES, fields
from support.references.skinning import kinematics_reference, skin_reference

FRAMES = 21  # two whole blocks of the native core and a part of one

# The same products summed in another order, numbers of a few metres.
TOLERANCE = 1e-12


def make_skin(posedirs: bool, seed: int = 0) -> skinning.Skin:
    content = fields(seed=seed)
    rest = content["v_template"]
    return skinning.Skin(
        rest_vertices=rest,
        rest_joints=content["J_regressor"] @ rest,
        weights=content["weights"],
        posedirs=content["posedirs"] if posedirs else None,
    )


@pytest.fixture(params=[False, True], ids=["plain", "posedirs"])
def skin(request: pytest.FixtureRequest) -> skinning.Skin:
    return make_skin(request.param)


def make_rotations(frames: int = FRAMES, seed: int = 1) -> np.ndarray:
    rng = np.random.default_rng(seed)
    turns = rng.normal(size=(frames, 55, 3))
    turns[:, 30:40] = 0.0  # joints that never turn
    turns[1:, 4] = 0.0  # one joint that turns in the first frame only
    turns[0, 5] *= 1e-9
    turns[0, 6] *= 40.0  # many turns
    turns[0, 7] = [np.pi, 0.0, 0.0]
    return turns


def run(skin: skinning.Skin, turns: np.ndarray, **options: object) -> np.ndarray:
    root = np.linspace(-2.0, 3.0, 3 * len(turns)).reshape(-1, 3)
    frames = skinning.kinematics(turns, root, skin.rest_joints)
    return skinning.skin(skin, turns, *frames, **options)  # type: ignore[arg-type]


def test_kinematics_equals_the_reference(skin: skinning.Skin) -> None:
    turns = make_rotations()
    root = np.random.default_rng(2).normal(size=(FRAMES, 3))
    found = skinning.kinematics(turns, root, skin.rest_joints)
    expected = kinematics_reference(turns, root, skin.rest_joints)
    for a, b in zip(found, expected, strict=True):
        np.testing.assert_allclose(a, b, rtol=0, atol=TOLERANCE)
    np.testing.assert_allclose(np.linalg.norm(found[1], axis=-1), 1.0, rtol=0, atol=1e-14)


def test_skin_equals_the_reference(skin: skinning.Skin) -> None:
    turns = make_rotations()
    root = np.random.default_rng(2).normal(size=(FRAMES, 3))
    frames = kinematics_reference(turns, root, skin.rest_joints)
    found = skinning.skin(skin, turns, *frames)
    expected = skin_reference(skin, turns, *frames)
    np.testing.assert_allclose(found, expected, rtol=0, atol=TOLERANCE)


def test_reference_equals_transforms_of_four_by_four() -> None:
    """The reference itself, against homogeneous matrices vertex by vertex."""
    skin = make_skin(posedirs=True)
    turns = make_rotations(1)
    frames = kinematics_reference(turns, np.array([[1.0, -2.0, 0.5]]), skin.rest_joints)
    found = skin_reference(skin, turns, *frames)[0]
    world = []
    for j, parent in enumerate(PARENTS):
        step = np.eye(4)
        step[:3, :3] = rot.rotvec_to_matrix(turns[0, j])
        step[:3, 3] = skin.rest_joints[j] - skin.rest_joints[parent] if j else [1.0, -2.0, 0.5]
        world.append(world[parent] @ step if j else step)
    features = np.concatenate(
        [(rot.rotvec_to_matrix(turns[0, j]) - np.eye(3)).ravel() for j in range(1, 55)]
    )
    assert skin.posedirs is not None
    for v in range(VERTICES):
        shaped = skin.rest_vertices[v] + skin.posedirs[v] @ features
        expected = sum(
            skin.weights[v, j] * (world[j] @ [*(shaped - skin.rest_joints[j]), 1.0])
            for j in range(55)
        )
        np.testing.assert_allclose(found[v], expected[:3], rtol=0, atol=TOLERANCE)


def test_same_bytes_for_any_threads_batch_and_subset(skin: skinning.Skin) -> None:
    turns = make_rotations()
    root = np.random.default_rng(3).normal(size=(FRAMES, 3))
    frames = skinning.kinematics(turns, root, skin.rest_joints)
    whole = skinning.skin(skin, turns, *frames)
    for threads in (2, 3, 64):
        again = skinning.skin(skin, turns, *frames, threads=threads)
        assert again.tobytes() == whole.tobytes()
    for size in (1, 2, 3, 4, 5, 7, 8, 13):
        for start in range(0, FRAMES, size):
            part = slice(start, start + size)
            piece = skinning.skin(skin, turns[part], *(f[part] for f in frames))
            assert piece.tobytes() == whole[part].tobytes()
    chosen = np.array([7, 7, 0, VERTICES - 1, 3])
    picked = skinning.skin(skin, turns, *frames, indices=chosen, threads=2)
    assert picked.tobytes() == np.ascontiguousarray(whole[:, chosen]).tobytes()


def test_translation_passes_through(skin: skinning.Skin) -> None:
    """Far from the origin the skin keeps its form: translation does not enter the blending."""
    turns = make_rotations(3)
    near = skinning.kinematics(turns, np.zeros((3, 3)), skin.rest_joints)
    far = skinning.kinematics(turns, np.full((3, 3), 4096.0), skin.rest_joints)
    moved = skinning.skin(skin, turns, *far) - 4096.0
    # Positions near 4096 m are whole multiples of 1e-12 m.
    np.testing.assert_allclose(moved, skinning.skin(skin, turns, *near), rtol=0, atol=1e-11)


def test_nothing_to_do(skin: skinning.Skin) -> None:
    assert run(skin, np.zeros((0, 55, 3))).shape == (0, VERTICES, 3)
    assert run(skin, make_rotations(2), indices=np.array([], dtype=int)).shape == (2, 0, 3)


def test_what_is_wanted_of_groups_is_the_same(skin: skinning.Skin) -> None:
    turns = make_rotations(19)
    frames = skinning.kinematics(turns, np.zeros((19, 3)), skin.rest_joints)
    vertex = np.arange(0, VERTICES, 2)
    first = np.array([0, 3, 3, len(vertex) // 2, len(vertex)], dtype=np.int32)
    wanted = np.random.default_rng(3).random((19, 4)) < 0.3
    wanted[8:16, 2] = False  # a whole block of frames
    found = skinning.skin(skin, turns, *frames, indices=vertex, wanted=(first, wanted))
    every = skinning.skin(skin, turns, *frames, indices=vertex)
    there = np.repeat(wanted, np.diff(first), axis=1)
    assert 0 < there.sum() < there.size
    np.testing.assert_array_equal(found[there], every[there])


@pytest.mark.parametrize("indices", [[VERTICES], [-1], [0.5], [[1, 2]], [True]])
def test_indices_are_checked(indices: list[int], skin: skinning.Skin) -> None:
    with pytest.raises(InputError, match="indices"):
        run(skin, make_rotations(2), indices=np.array(indices))


def test_threads_are_checked(skin: skinning.Skin) -> None:
    for threads in (0, None, 1.5, "2", np.nan):
        with pytest.raises(InputError, match=f"threads: found {threads!r}, expected 1 or more"):
            run(skin, make_rotations(2), threads=threads)


def test_native_core_refuses_what_would_read_foreign_memory() -> None:
    skin = make_skin(posedirs=True)
    turns = make_rotations(2)
    frames = skinning.kinematics(turns, np.zeros((2, 3)), skin.rest_joints)
    first, joint, weights = skin.sparse_weights
    good = [skin.rest_vertices, skin.rest_joints, first, joint, weights, skin.posedirs, turns,
            *frames, np.zeros(0, np.int32), True, 1, np.full((2, VERTICES, 3), np.inf)]  # fmt: skip
    _native.skin(*good)
    assert np.isfinite(good[-1]).all()
    bad = {
        0: skin.rest_vertices[:-1],
        2: first + 1,
        3: joint + 55,
        4: weights[:-1],
        5: np.ascontiguousarray(skin.posedirs[:, :, :9]),  # type: ignore[index]
        6: turns[:1],
        7: frames[0][:, :54].copy(),
        8: frames[1][:1],
        12: np.empty((2, VERTICES - 1, 3)),
    }
    for place, value in bad.items():
        with pytest.raises(ValueError, match="skinning"):
            _native.skin(*[value if i == place else item for i, item in enumerate(good)])
    good[10], good[9] = False, np.array([VERTICES], np.int32)
    with pytest.raises(ValueError, match="out of range"):
        _native.skin(*good)
    good[9] = np.arange(5, dtype=np.int32)
    good[12] = np.empty((2, 5, 3))
    first, wanted = np.array([0, 2, 5], np.int32), np.ones((2, 2), np.uint8)
    _native.skin(*good, first, wanted)
    for group_first, mask in (
        (first, None), (first, wanted[:1]), (first[:2], wanted), (first + 1, wanted),
        (np.array([0, 6, 5], np.int32), wanted), (np.array([0, 2, 6], np.int32), wanted),
    ):  # fmt: skip
        with pytest.raises(ValueError, match="skinning"):
            _native.skin(*good, group_first, mask)
    out = np.empty((2, 55, 3)), np.empty((2, 55, 4))
    for parents in (np.roll(PARENTS, 1), np.full(55, -1, np.int32), np.arange(55, dtype=np.int32)):
        with pytest.raises(ValueError, match="parents"):
            _native.kinematics(turns, np.zeros((2, 3)), skin.rest_joints, parents, *out)


def test_other_threads_run_meanwhile() -> None:
    """The lock of the interpreter is released: a counter advances during a long call."""
    skin = make_skin(posedirs=True)
    turns = make_rotations(6000)
    frames = skinning.kinematics(turns, np.zeros((6000, 3)), skin.rest_joints)
    ticks: list[float] = []
    stop = threading.Event()

    def count() -> None:
        while not stop.wait(0.002):
            ticks.append(time.perf_counter())

    counter = threading.Thread(target=count)
    counter.start()
    start = time.perf_counter()
    skinning.skin(skin, turns, *frames)
    end = time.perf_counter()
    stop.set()
    counter.join()
    assert end - start > 0.02, "too quick to tell"
    inside = [t for t in ticks if start + 0.005 < t < end - 0.005]
    assert inside
