"""The baked default body: the file itself, whatever reads it."""

from __future__ import annotations

import hashlib
from importlib.resources import files
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull, cKDTree

from halfphysics.motion.skeleton import JOINT_INDEX, JOINT_NAMES, N_JOINTS, PARENTS

ASSETS = Path(str(files("halfphysics"))) / "assets"
V, F, K = 13_718, 27_420, 10
# Of the mean body: bones are exactly along their axes but for the tolerance of the regressor's fit.
MEAN = 5e-6
# Rows of small entries cannot hold a joint still while the skin around it changes: a unit of beta
# moves the pelvis, or the two ends of a bone across it, by up to this much [m]; 0.06 degrees and
# less, 0.1 for the shortest bones.
PELVIS, LEG, ARM, FINGER = 3e-4, 4.5e-4, 2e-4, 1e-4
LARGEST_BETA = 3.0
SHAPES = [np.zeros(K), *(s * unit for unit in np.eye(K) for s in (-LARGEST_BETA, LARGEST_BETA))]


@pytest.fixture(scope="module")
def arrays() -> dict[str, np.ndarray]:
    with np.load(ASSETS / "body.npz", allow_pickle=False) as data:
        return {
            k: a.astype(np.int64 if a.dtype.kind == "u" else float) if a.dtype.kind in "fu" else a
            for k, a in ((k, data[k]) for k in data.files)
        }


@pytest.fixture(scope="module")
def skins(arrays) -> list[np.ndarray]:
    """The skin (V, 3) of each of `SHAPES`."""
    return [arrays["v_template"] + arrays["shapedirs"] @ betas for betas in SHAPES]


@pytest.fixture(scope="module")
def joints(arrays, skins) -> np.ndarray:
    """The joints (len(SHAPES), 55, 3) of each of `SHAPES`."""
    return np.array([arrays["J_regressor"] @ skin for skin in skins])


def volume(skin: np.ndarray, faces: np.ndarray) -> float:
    a, b, c = skin[faces].transpose(1, 0, 2)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def opposite(name: str) -> int:
    swap = {"left": "right", "right": "left"}
    first, *rest = name.split("_")
    return JOINT_INDEX["_".join([swap.get(first, first), *rest])]


def winding(points: np.ndarray, skin: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Winding number of the skin about each point (n,): sum of solid angles over 4 pi."""
    out = []
    for p in points:
        a, b, c = (skin - p)[faces].transpose(1, 0, 2)
        la, lb, lc = (np.linalg.norm(x, axis=1) for x in (a, b, c))
        dot = lambda x, y: np.einsum("ij,ij->i", x, y)  # noqa: E731
        below = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb
        out.append(2 * np.arctan2(dot(a, np.cross(b, c)), below).sum() / (4 * np.pi))
    return np.array(out)


def test_checksum():
    digest, name = (ASSETS / "body.npz.sha256").read_text().split()
    assert name == "body.npz"
    assert hashlib.sha256((ASSETS / "body.npz").read_bytes()).hexdigest() == digest


def test_layout():
    with np.load(ASSETS / "body.npz", allow_pickle=False) as data:
        found = {k: (data[k].shape, data[k].dtype.name) for k in data.files}
        parents = data["kintree_table"][0].astype(np.int64)
        names = tuple(data["joint_names"].tolist())
        assert "CC0" in str(data["licence"])
    expected = {
        "v_template": ((V, 3), "float32"),
        "f": ((F, 3), "uint32"),
        "weights": ((V, N_JOINTS), "float32"),
        "J_regressor": ((N_JOINTS, V), "float32"),
        "shapedirs": ((V, 3, K), "float16"),
        "kintree_table": ((2, N_JOINTS), "uint32"),
        "hands_componentsl": ((45, 45), "float32"),
        "hands_componentsr": ((45, 45), "float32"),
        "hands_meanl": ((45,), "float32"),
        "hands_meanr": ((45,), "float32"),
    }
    assert {k: found[k] for k in expected} == expected
    assert set(found) == {*expected, "joint_names", "licence"}  # no posedirs: none needed
    assert names == JOINT_NAMES
    assert parents[0] == 2**32 - 1
    assert (parents[1:] == PARENTS[1:]).all()
    assert (ASSETS / "body.npz").stat().st_size < 2e6


def test_skin_is_closed_and_outward(arrays):
    faces = arrays["f"]
    directed = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    key, back = directed @ [V, 1], directed @ [1, V]
    assert len(np.unique(key)) == len(key)  # each edge once in each direction:
    assert np.isin(back, key).all()  # two faces, of one orientation
    assert len(np.unique(faces)) == V
    graph = coo_matrix((np.ones(len(key)), directed.T), shape=(V, V))
    n, label = connected_components(graph, directed=False)
    assert n == 4  # skin, two eyeballs, tongue
    for part in range(n):
        own = faces[label[faces[:, 0]] == part]
        assert (label == part).sum() - len(own) // 2 == 2  # Euler: a sphere
        assert volume(arrays["v_template"], own) > 0


def test_weights(arrays):
    weights = arrays["weights"]
    assert (weights >= 0).all()
    assert ((weights > 0).sum(1) <= 4).all()
    assert (weights.sum(1) == 1.0).all()  # whole multiples of 2^-14: exact


def test_left_and_right_mirror(arrays):
    mirror = np.array([-1.0, 1.0, 1.0])
    skin, swap = arrays["v_template"], [opposite(name) for name in JOINT_NAMES]
    distance, partner = cKDTree(skin * mirror).query(skin)
    assert distance.max() == 0
    assert (partner[partner] == np.arange(V)).all()
    assert (arrays["shapedirs"][partner] == arrays["shapedirs"] * mirror[:, None]).all()
    assert (arrays["weights"][partner][:, swap] == arrays["weights"]).all()
    assert (arrays["J_regressor"][swap][:, partner] == arrays["J_regressor"]).all()


def test_size(arrays, skins):
    statures = [np.ptp(skin[:, 1]) for skin in skins]
    litres = [1000 * volume(skin, arrays["f"]) for skin in skins]
    assert statures[0] == pytest.approx(1.73, abs=0.01)
    assert litres[0] == pytest.approx(62, abs=1)
    assert min(statures) > 1.3
    assert max(statures) < 2.2
    assert min(litres) > 30
    assert max(litres) < 110
    assert statures[2] - statures[1] > 0.5  # the first component is size


def test_every_part_has_a_body(arrays, skins):
    owner, faces = arrays["weights"].argmax(1), arrays["f"]
    for j, name in enumerate(JOINT_NAMES):
        rows = np.unique(faces[(owner[faces] == j).any(1)])
        for skin in (skins[0], skins[1], skins[2]):
            hull = ConvexHull(skin[rows])
            assert len(hull.vertices) >= 8, name
            assert hull.volume > 1e-6, name  # a cubic centimetre: the tip of a small finger


def test_regressor_rows_are_nearly_averages(arrays):
    regressor = arrays["J_regressor"]
    assert (regressor.sum(1) == 1.0).all()  # whole multiples of 2^-24: exact
    assert np.abs(regressor).sum(1).max() < 1.5 + 1e-6  # what it can enlarge a rounding by
    assert (regressor != 0).sum(1).max() <= 34  # a corner of the programme it solves
    step = np.eye(N_JOINTS, dtype=bool)
    child = np.arange(1, N_JOINTS)
    step[child, PARENTS[child]] = step[PARENTS[child], child] = True
    near = (arrays["weights"] > 0).astype(int) @ step @ step
    assert (near.T[regressor != 0] > 0).all()  # skin that goes with joints at most two bones away


def test_single_precision_is_enough_for_the_joints(arrays):
    """Within two or three roundings of a coordinate of a metre, added up in whatever order."""
    regressor, skin = arrays["J_regressor"], arrays["v_template"]
    order = np.random.default_rng(0).permutation(V)
    single = np.zeros((N_JOINTS, 3), dtype=np.float32)
    for row, at in zip(regressor, single, strict=True):
        for v in order[row[order] != 0]:
            at += np.float32(row[v]) * skin[v].astype(np.float32)
    np.testing.assert_allclose(single, regressor @ skin, rtol=0, atol=2e-7)


def test_rest_pose_holds_for_every_shape(joints):
    """Exact for each sampled person, and the regressor's first concern after the mean joints."""

    def across(start: str, end: str, along: tuple[float, ...]) -> np.ndarray:
        """How far (len(SHAPES),) the end is off the line from the start."""
        d, axis = joints[:, JOINT_INDEX[end]] - joints[:, JOINT_INDEX[start]], np.array(along)
        assert (d @ axis > 0.01).all()
        return np.linalg.norm(d - np.outer(d @ axis, axis), axis=1)

    def assert_still(distance: np.ndarray, per_unit: float) -> None:
        assert distance[0] < MEAN
        assert distance.max() < LARGEST_BETA * per_unit

    assert_still(np.linalg.norm(joints[:, 0] - [0, -0.4, 0], axis=1), PELVIS)
    for side, sign in (("left", 1.0), ("right", -1.0)):
        straight = {
            ("shoulder", "elbow", "wrist", "middle1"): ((sign, 0, 0), ARM),
            ("hip", "knee", "ankle"): ((0, -1, 0), LEG),
        }
        for chain, (along, per_unit) in straight.items():
            for a, b in pairwise(chain):
                assert_still(across(f"{side}_{a}", f"{side}_{b}", along), per_unit)
        for finger, yaw in {"index": 5, "middle": 0, "ring": -5, "pinky": -10}.items():
            along = (sign * np.cos(np.radians(yaw)), 0, np.sin(np.radians(yaw)))
            for k in (1, 2):
                assert_still(
                    across(f"{side}_{finger}{k}", f"{side}_{finger}{k + 1}", along), FINGER
                )
        thumb, toes = (
            joints[:, JOINT_INDEX[f"{side}_{end}"]] - joints[:, JOINT_INDEX[f"{side}_{start}"]]
            for start, end in (("thumb1", "thumb3"), ("ankle", "foot"))
        )
        assert (thumb[:, 2] > 0.5 * np.linalg.norm(thumb, axis=1)).all()
        assert_still(np.abs(toes[:, 0]), LEG)
        assert (toes[:, 2] > 0.9 * np.linalg.norm(toes, axis=1)).all()


def test_soles_are_flat(arrays, skins):
    for side in ("left", "right"):
        foot = [JOINT_INDEX[f"{side}_ankle"], JOINT_INDEX[f"{side}_foot"]]
        own = arrays["weights"][:, foot].sum(1) > 0.5
        for skin in skins[:3]:
            x = skin[own]
            low = x[x[:, 1] < x[:, 1].min() + 0.002]  # rests on the heel and on the ball
            assert np.ptp(low[:, 2]) > 0.75 * np.ptp(x[:, 2])
            assert x[:, 1].min() == pytest.approx(skin[:, 1].min(), abs=1e-6)


def test_joints_lie_in_the_flesh(arrays, skins, joints):
    deep = {
        "shoulder": 0.03,
        "elbow": 0.02,
        "hip": 0.05,
        "knee": 0.03,
        "wrist": 0.01,
        "ankle": 0.02,
    }
    for skin, at in zip(skins[:3], joints[:3], strict=True):
        assert (winding(at, skin, arrays["f"]) > 0.5).all()
        depth, _ = cKDTree(skin).query(at)
        for name, least in deep.items():
            assert depth[JOINT_INDEX[f"left_{name}"]] > least, name
