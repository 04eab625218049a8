"""The 55 rigid parts of the default body, of its shapes, and of unusual skins."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from halfphysics.body.body import Body
from halfphysics.body.rigid_parts import DENSITY, Variant, build_variant
from halfphysics.errors import HalfPhysicsWarning, InputError
from halfphysics.geometry.mesh_queries import is_closed
from halfphysics.geometry.mesh_solids import solid_moments
from halfphysics.motion.skeleton import (
    JOINT_INDEX,
    JOINT_NAMES,
    LEFT_HAND_JOINTS,
    N_JOINTS,
    PARENTS,
)

#: Segment -> joints of the left side (or of the middle), and its share of body mass [%] in men and
#: women after de Leva, "Adjustments to Zatsiorsky-Seluyanov's segment inertia parameters",
#: J. Biomechanics 29(9), 1996, and the bounds held here.
SEGMENTS: dict[str, tuple[tuple[str, ...], float, float, tuple[float, float]]] = {
    "head + neck": (
        ("neck", "head", "jaw", "left_eye_smplhf", "right_eye_smplhf"),
        *(6.94, 6.68, (6.0, 7.5)),
    ),
    # The skin's largest weight cuts the leg below de Leva's plane through the hip and the arm
    # inside his shoulder: the trunk keeps some thigh, the upper arm takes the deltoid.
    "trunk": (
        ("pelvis", "spine1", "spine2", "spine3", "left_collar", "right_collar"),
        *(43.46, 42.57, (44.0, 50.0)),
    ),
    "thigh": (("left_hip",), 14.16, 14.78, (10.5, 14.5)),
    "upper arm": (("left_shoulder",), 2.71, 2.55, (2.4, 3.6)),
    "forearm": (("left_elbow",), 1.62, 1.38, (1.1, 1.7)),
    "hand": (("left_wrist", *(JOINT_NAMES[i] for i in LEFT_HAND_JOINTS)), 0.61, 0.56, (0.45, 0.7)),
    "shank": (("left_knee",), 4.33, 4.81, (4.0, 5.0)),
    "foot": (("left_ankle", "left_foot"), 1.37, 1.29, (1.2, 1.7)),
}


@pytest.fixture(scope="module")
def body() -> Body:
    return Body.default()


@pytest.fixture(scope="module")
def variant(body: Body) -> Variant:
    return build_variant(body)


def skin(body: Any, **changes: Any) -> SimpleNamespace:
    """The body's four arrays, some of them replaced."""
    names = ("rest_vertices", "rest_joints", "faces", "weights")
    return SimpleNamespace(**({name: getattr(body, name) for name in names} | changes))


def check(variant: Variant) -> None:
    """Properties of the variant of any body."""
    assert tuple(part.name for part in variant.parts) == JOINT_NAMES
    assert [part.index for part in variant.parts] == list(range(N_JOINTS))
    for part in variant.parts:
        assert part.mass > 0.0
        assert is_closed(part.faces, len(part.vertices))
        np.testing.assert_array_equal(part.inertia, part.inertia.T)
        a, b, c = np.linalg.eigvalsh(part.inertia)
        assert a > 0.0, part.name
        assert a + b >= c * (1.0 - 1e-9), f"{part.name}: no body has this inertia"
    assert variant.mass == pytest.approx(sum(p.mass for p in variant.parts), rel=1e-12)


def test_parts_of_the_default_body(variant: Variant) -> None:
    check(variant)
    assert all(len(part.vertices) >= 4 for part in variant.parts)
    assert 55.0 < variant.mass < 70.0


def test_hulls_hold_the_skin_they_are_cut_from(body: Body, variant: Variant) -> None:
    labels = body.weights.argmax(axis=1)
    for part in variant.parts:
        own = body.rest_vertices[labels == part.index] - body.rest_joints[part.index]
        assert {tuple(x) for x in part.vertices} <= {tuple(x) for x in own}
        a, b, c = np.moveaxis(part.vertices[part.faces], 1, 0)
        normals = np.cross(b - a, c - a)
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
        out = own @ normals.T - np.einsum("fi,fi->f", normals, a)
        assert out.max() < 1e-7, f"{part.name}: skin outside (float32 assets make slivers)"


def test_offsets_lead_back_to_the_joints(body: Body, variant: Variant) -> None:
    joints = np.tile(body.rest_joints[0], (N_JOINTS, 1))
    for i in range(1, N_JOINTS):
        joints[i] = joints[PARENTS[i]] + variant.joint_offsets[i]
    np.testing.assert_allclose(joints, body.rest_joints, rtol=0, atol=1e-14)
    np.testing.assert_array_equal(variant.joint_offsets[0], 0.0)


def test_whole_body_has_the_moments_of_the_skin(body: Body, variant: Variant) -> None:
    """The sum of the parts against the exact integrals over the triangles."""
    volume, centre, inertia = solid_moments(body.rest_vertices, body.faces)
    assert variant.volume == pytest.approx(volume, rel=1e-9)
    assert variant.mass == pytest.approx(volume * DENSITY, rel=1e-3)
    masses = np.array([part.mass for part in variant.parts])
    coms = np.array([p.com for p in variant.parts]) + body.rest_joints
    com = masses @ coms / masses.sum()
    np.testing.assert_allclose(com, centre, rtol=0, atol=1e-4)
    total = np.zeros((3, 3))
    for part, x in zip(variant.parts, coms - com, strict=True):
        total += part.inertia + part.mass * (x @ x * np.eye(3) - np.outer(x, x))
    np.testing.assert_allclose(total, DENSITY * inertia, rtol=0, atol=1e-3 * np.trace(total))


def test_segments_beside_de_leva(variant: Variant) -> None:
    share = {part.name: 100.0 * part.mass / variant.mass for part in variant.parts}
    got = {name: sum(share[j] for j in row[0]) for name, row in SEGMENTS.items()}
    print(f"\n{'segment':<12}{'here %':>8}{'men':>8}{'women':>8}")
    for name, (_, men, women, _) in SEGMENTS.items():
        print(f"{name:<12}{got[name]:8.2f}{men:8.2f}{women:8.2f}")
    for name, (_, _, _, (low, high)) in SEGMENTS.items():
        assert low < got[name] < high, name
    sides = {name: 1 if name in ("head + neck", "trunk") else 2 for name in SEGMENTS}
    assert sum(sides[n] * got[n] for n in SEGMENTS) == pytest.approx(100.0, abs=1e-6)
    # The planes at hip and shoulder have no effect once both their sides are summed.
    together = got["trunk"] + 2.0 * (got["thigh"] + got["upper arm"])
    assert together == pytest.approx(77.2, abs=1.5)  # men 77.20, women 77.23


def test_left_and_right_weigh_the_same(variant: Variant) -> None:
    for part in variant.parts:
        if part.name.startswith("left_"):
            other = variant.parts[JOINT_INDEX[part.name.replace("left", "right", 1)]]
            assert part.mass == pytest.approx(other.mass, rel=1e-6)
            np.testing.assert_allclose(part.com * [-1, 1, 1], other.com, rtol=0, atol=1e-6)


def test_hulls_overlap_so_their_volumes_are_no_masses(variant: Variant) -> None:
    hulls = sum(solid_moments(part.vertices, part.faces)[0] for part in variant.parts)
    assert 1.04 < hulls / variant.volume < 1.2


@pytest.mark.slow
@pytest.mark.parametrize("component", range(10))
@pytest.mark.parametrize("value", [-3.0, 3.0])
def test_any_shape_has_parts(component: int, value: float) -> None:
    betas = np.zeros(10)
    betas[component] = value
    shaped = Body.default(betas=betas)
    variant = build_variant(shaped)
    check(variant)
    assert all(len(part.vertices) >= 4 for part in variant.parts)
    volume = solid_moments(shaped.rest_vertices, shaped.faces)[0]
    assert variant.mass == pytest.approx(volume * DENSITY, rel=1e-3)
    share = {part.name: 100.0 * part.mass / variant.mass for part in variant.parts}
    assert 4.0 < sum(share[j] for j in SEGMENTS["head + neck"][0]) < 12.0
    assert 35.0 < sum(share[j] for j in SEGMENTS["trunk"][0]) < 60.0


def test_density_and_mass(body: Body, variant: Variant) -> None:
    heavy = build_variant(body, mass=80.0)
    assert heavy.mass == pytest.approx(80.0, rel=1e-9)
    scale = 80.0 / variant.mass
    for a, b in zip(heavy.parts, variant.parts, strict=True):
        np.testing.assert_allclose(a.inertia, scale * b.inertia, rtol=1e-9)
    with pytest.raises(InputError, match="density is 0"):
        build_variant(body, density=0.0)
    with pytest.raises(InputError, match="mass is nan"):
        build_variant(body, mass=float("nan"))


def test_same_body_same_bytes(body: Body, variant: Variant) -> None:
    again = build_variant(body)
    for a, b in zip(again.parts, variant.parts, strict=True):
        for name in ("vertices", "faces", "com", "inertia"):
            assert getattr(a, name).tobytes() == getattr(b, name).tobytes()
        assert a.mass == b.mass


def test_joints_without_skin_are_empty_and_light(body: Body, variant: Variant) -> None:
    """SMPL has no fingers, jaw or eyes; their skin belongs to the wrist and the head."""
    weights = np.array(body.weights, dtype=np.float64)
    joints = np.array(body.rest_joints)
    for i in range(N_JOINTS - 1, 21, -1):
        weights[:, PARENTS[i]] += weights[:, i]
        weights[:, i] = 0.0
    for i in range(22, N_JOINTS):
        joints[i] = joints[PARENTS[i]]
    plain = build_variant(skin(body, weights=weights, rest_joints=joints))
    check(plain)
    for part in plain.parts[22:]:
        assert part.vertices.shape == part.faces.shape == (0, 3)
        assert part.mass < 1e-5
    np.testing.assert_array_equal(plain.joint_offsets[22:], 0.0)
    assert plain.mass == pytest.approx(variant.mass, rel=1e-3)


def test_a_part_of_one_vertex_is_thickened_aloud(body: Body) -> None:
    weights = np.array(body.weights, dtype=np.float64)
    jaw = JOINT_INDEX["jaw"]
    weights[:, jaw] = 0.0
    weights[0] = np.eye(N_JOINTS)[jaw]
    with pytest.warns(HalfPhysicsWarning, match="skin of jaw is flat"):
        variant = build_variant(skin(body, weights=weights))
    check(variant)
    assert len(variant.parts[jaw].vertices) == 8


def test_open_eyes_and_mouth_change_little(body: Body, variant: Variant) -> None:
    """Faces missing about the eyes, as in skins that are not watertight."""
    labels = body.weights.argmax(axis=1)
    eyes = [JOINT_INDEX["left_eye_smplhf"], JOINT_INDEX["right_eye_smplhf"]]
    middle = body.rest_vertices[body.faces].mean(axis=1)
    eye = body.rest_vertices[labels == eyes[0]].mean(axis=0)
    near = np.linalg.norm(middle - eye, axis=1) < 0.02
    head = np.isin(labels[body.faces], eyes).any(axis=1)
    holed = build_variant(skin(body, faces=body.faces[~(near & ~head)]))
    assert (near & ~head).sum() > 20
    check(holed)
    assert holed.mass == pytest.approx(variant.mass, rel=2e-3)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"weights": np.zeros((3, 55))}, r"weights of the body is \(3, 55\)"),
        ({"rest_joints": np.zeros((24, 3))}, r"rest_joints of the body is \(24, 3\)"),
        ({"rest_joints": np.full((55, 3), np.nan)}, "rest_joints of the body holds NaN"),
        ({"faces": np.array([[0, 1, 99_999]])}, "name vertices 0 to 99999"),
    ],
)
def test_impossible_bodies_are_refused(body: Body, changes: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        build_variant(skin(body, **changes))


def test_a_skin_in_millimetres_is_refused(body: Body) -> None:
    with pytest.raises(InputError, match="is it in metres"):
        build_variant(skin(body, rest_vertices=1e3 * body.rest_vertices))


def test_standing_height_is_over_the_soles(body: Body, variant: Variant) -> None:
    sole = body.rest_joints[0, 1] - body.rest_vertices[:, 1].min()
    assert variant.standing_height == pytest.approx(sole, abs=1e-12)
