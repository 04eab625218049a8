"""The parts in MuJoCo: their joints and masses, and that standard MuJoCo runs them."""

from __future__ import annotations

from types import SimpleNamespace

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from halfphysics.base import rotations
from halfphysics.body.body import Body
from halfphysics.body.mjcf_person import (
    FINGER_ARMATURE,
    UPRIGHT,
    add_person,
    addresses,
    part_color,
    to_mjcf,
)
from halfphysics.body.rigid_parts import Variant, build_variant
from halfphysics.errors import InputError
from halfphysics.motion.skeleton import (
    JOINT_NAMES,
    LEFT_HAND_JOINTS,
    N_JOINTS,
    PARENTS,
    RIGHT_HAND_JOINTS,
)

Array = NDArray[np.float64]


@pytest.fixture(scope="module")
def body() -> Body:
    return Body.default()


@pytest.fixture(scope="module")
def variant(body: Body) -> Variant:
    return build_variant(body)


@pytest.fixture(scope="module")
def text(variant: Variant) -> str:
    return to_mjcf(variant)


@pytest.fixture(scope="module")
def model(text: str) -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(text)


def forward(rest: Array, position: Array, local: Array) -> tuple[Array, Array]:
    """World positions (55, 3) and matrices (55, 3, 3) of joints, by SMPL-X's rules."""
    turns = rotations.to_matrix(local)
    places, frames = np.empty((N_JOINTS, 3)), np.empty((N_JOINTS, 3, 3))
    places[0], frames[0] = position, turns[0]
    for i in range(1, N_JOINTS):
        p = PARENTS[i]
        places[i] = places[p] + frames[p] @ (rest[i] - rest[p])
        frames[i] = frames[p] @ turns[i]
    return places, frames


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**31))
def test_joints_are_where_the_body_has_them(
    seed: int, body: Body, variant: Variant, model: mujoco.MjModel
) -> None:
    rng = np.random.default_rng(seed)
    position = rng.normal(size=3)
    local = rotations.exp(rng.normal(size=(N_JOINTS, 3)))
    at, data = addresses(model), mujoco.MjData(model)
    at.write(data.qpos, position, local)
    mujoco.mj_kinematics(model, data)
    places, frames = forward(body.rest_joints, position, local)
    np.testing.assert_allclose(data.xpos[at.body], places, rtol=0, atol=1e-12)
    found = data.xmat[at.body].reshape(-1, 3, 3)
    np.testing.assert_allclose(found, frames, rtol=0, atol=1e-12)
    coms = places + np.einsum("nij,nj->ni", frames, np.array([p.com for p in variant.parts]))
    np.testing.assert_allclose(data.xipos[at.body], coms, rtol=0, atol=1e-12)


@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 2**31))
def test_velocities_are_of_the_joints_named(seed: int, model: mujoco.MjModel) -> None:
    """A velocity at a joint's dof turns that joint and its subtree, in its own axes."""
    rng = np.random.default_rng(seed)
    at, data = addresses(model), mujoco.MjData(model)
    local = rotations.exp(rng.normal(size=(N_JOINTS, 3)))
    at.write(data.qpos, rng.normal(size=3), local)
    joint, omega = int(rng.integers(N_JOINTS)), rng.normal(size=3)
    qvel = np.zeros(model.nv)
    qvel[at.dof[joint] : at.dof[joint] + 3] = omega
    mujoco.mj_integratePos(model, data.qpos, qvel, 0.1)
    local[joint] = rotations.multiply(local[joint], rotations.exp(0.1 * omega))
    got = data.qpos[at.quat[:, None] + np.arange(4)]
    difference = rotations.log(rotations.multiply(rotations.conjugate(local), got))
    np.testing.assert_allclose(difference, 0.0, atol=1e-12)


def test_stock_mujoco_opens_the_text(variant: Variant, model: mujoco.MjModel) -> None:
    at = addresses(model)
    assert (model.nbody, model.njnt, model.nq, model.nv) == (56, 55, 223, 168)
    assert model.body_mass.sum() == pytest.approx(variant.mass, rel=1e-12)
    np.testing.assert_array_equal(model.body_mass[at.body], [p.mass for p in variant.parts])
    axes = rotations.to_matrix(model.body_iquat[at.body])
    inertia = np.einsum("nij,nj,nkj->nik", axes, model.body_inertia[at.body], axes)
    for part, found in zip(variant.parts, inertia, strict=True):
        np.testing.assert_allclose(found, part.inertia, atol=1e-9 * np.trace(part.inertia))


def test_geoms_are_the_hulls(variant: Variant, model: mujoco.MjModel) -> None:
    """MuJoCo moves meshes to their own centre and axes; the geoms must move them back."""
    assert model.ngeom == N_JOINTS
    for part in variant.parts:
        geom = model.geom(part.name)
        assert model.body(geom.bodyid[0]).name == part.name
        mesh = geom.dataid[0]
        first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
        found = model.mesh_vert[first : first + count].astype(np.float64)
        found = rotations.rotate(geom.quat, found) + geom.pos
        apart = np.linalg.norm(found[:, None] - part.vertices, axis=-1)
        assert apart.min(axis=0).max() < 1e-6, "float32 at half a metre"
        np.testing.assert_allclose(geom.rgba, part_color(part.index), atol=1e-3)


def test_stock_mujoco_steps_it(model: mujoco.MjModel, variant: Variant) -> None:
    data = mujoco.MjData(model)
    np.testing.assert_allclose(data.qpos[:7], [0, 0, variant.standing_height, *UPRIGHT])
    mujoco.mj_forward(model, data)
    assert data.ncon == 0
    masses = model.body_mass

    def com_height() -> float:
        return float(masses @ data.xipos[:, 2] / masses.sum())

    start = com_height()
    for _ in range(250):
        mujoco.mj_step(model, data)
    mujoco.mj_forward(model, data)
    assert not any(w.number for w in data.warning)
    # Gravity alone: half g t^2 after 0.5 s, and one step's error of Euler.
    fallen = 0.5 * 9.81 * data.time * (data.time + model.opt.timestep)
    assert start - com_height() == pytest.approx(fallen, rel=1e-4)


def test_it_lands_on_a_floor(variant: Variant) -> None:
    spec = mujoco.MjSpec()
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[5, 5, 0.1])
    add_person(spec, variant)
    model = spec.compile()
    data = mujoco.MjData(model)
    for _ in range(500):
        mujoco.mj_step(model, data)
    assert not any(w.number for w in data.warning)
    assert data.ncon > 0
    others = {int(g) for c in data.contact for g in c.geom if g != 0}
    assert len(others) == len({g for c in data.contact for g in c.geom}) - 1, "each with the floor"
    assert data.xipos[1:, 2].min() > -0.05


def test_spec_and_text_are_the_same_model(variant: Variant, model: mujoco.MjModel) -> None:
    spec = mujoco.MjSpec()
    add_person(spec, variant)
    other = spec.compile()
    names = "body_parentid body_pos body_quat body_mass body_ipos body_iquat body_inertia qpos0 "
    names += "dof_armature geom_pos geom_quat geom_contype geom_conaffinity mesh_vert"
    for name in names.split():
        np.testing.assert_array_equal(getattr(other, name), getattr(model, name), err_msg=name)


def test_two_people_by_prefix(variant: Variant) -> None:
    spec = mujoco.MjSpec()
    root = add_person(spec, variant, "ann/", position=(1, 2, 3), quaternion=(1, 0, 0, 0))
    add_person(spec, variant, "bob/", geoms=False)
    model = spec.compile()
    assert root.name == "ann/pelvis"
    ann, bob = addresses(model, "ann/"), addresses(model, "bob/")
    assert not set(ann.body) & set(bob.body)
    np.testing.assert_array_equal(model.qpos0[ann.root_position :][:7], [1, 2, 3, 1, 0, 0, 0])
    for who in (ann, bob):
        every = np.concatenate([(who.dof[:, None] + np.arange(3)).ravel()])
        assert len(set(every)) == 165
        assert who.root_velocity == who.dof[0] - 3
    assert model.ngeom == N_JOINTS, "only one of them has geoms"
    with pytest.raises(InputError, match="no person with prefix 'eve/'"):
        addresses(model, "eve/")


def test_bodies_are_numbered_depth_first(model: mujoco.MjModel) -> None:
    """The reason for `addresses`: MuJoCo's order is not the order of the joint names."""
    at = addresses(model)
    assert [model.body(int(i)).name for i in at.body] == list(JOINT_NAMES)
    assert list(at.body) != sorted(at.body)
    parents = np.where(PARENTS < 0, 0, at.body[PARENTS])
    np.testing.assert_array_equal(model.body_parentid[at.body], parents)


def test_armature(variant: Variant, model: mujoco.MjModel) -> None:
    at = addresses(model)
    fingers = list(LEFT_HAND_JOINTS + RIGHT_HAND_JOINTS)
    expected = np.zeros(N_JOINTS)
    expected[fingers] = FINGER_ARMATURE
    for k in range(3):
        np.testing.assert_array_equal(model.dof_armature[at.dof + k], expected)
    own = np.linspace(0.0, 1.0, N_JOINTS)
    other = mujoco.MjModel.from_xml_string(to_mjcf(variant, armature=own))
    np.testing.assert_array_equal(other.dof_armature[at.dof], own)
    none = mujoco.MjModel.from_xml_string(to_mjcf(variant, finger_armature=0.0))
    np.testing.assert_array_equal(none.dof_armature, 0.0)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"armature": np.ones(54)}, r"shape \(54,\), expected \(55,\)"),
        ({"armature": np.ones(55)}, "armature of the pelvis is 1.0"),
        ({"finger_armature": -1.0}, "not negative"),
        ({"finger_armature": float("nan")}, "finite"),
        ({"position": (0, 0)}, r"shapes \(2,\)"),
        ({"quaternion": (0, 0, 0, 0)}, "quaternion not zero"),
    ],
)
def test_impossible_options_are_refused(
    variant: Variant, options: dict[str, object], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        add_person(mujoco.MjSpec(), variant, **options)  # type: ignore[arg-type]


def test_joints_without_skin_compile_and_step(body: Body) -> None:
    weights = np.array(body.weights, dtype=np.float64)
    for i in range(N_JOINTS - 1, 21, -1):
        weights[:, PARENTS[i]] += weights[:, i]
        weights[:, i] = 0.0
    arrays = {name: getattr(body, name) for name in ("rest_vertices", "rest_joints", "faces")}
    plain = build_variant(SimpleNamespace(weights=weights, **arrays))
    model = mujoco.MjModel.from_xml_string(to_mjcf(plain))
    assert (model.nbody, model.ngeom) == (56, 22)
    data = mujoco.MjData(model)
    for _ in range(100):
        mujoco.mj_step(model, data)
    assert not any(w.number for w in data.warning)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_any_shape_compiles(seed: int) -> None:
    """Corners of the cube of shapes, all ten components at -3 or 3 at once."""
    betas = 3.0 * np.random.default_rng(seed).choice([-1.0, 1.0], size=10)
    variant = build_variant(Body.default(betas=betas))
    model = mujoco.MjModel.from_xml_string(to_mjcf(variant))
    assert model.body_mass.sum() == pytest.approx(variant.mass, rel=1e-12)
    assert model.ngeom == N_JOINTS
