"""Kinematics, inertia matrix and factor of the native core and of the reference, against MuJoCo."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from halfphysics import _native
from halfphysics.reference import step as reference
from halfphysics.simulation.compiled_model import model_arrays

# All features of the trees: free, ball, hinge (two on one body) and slide joints, offsets, turned
# frames and inertias, branches, armature, two trees.
MJCF = """
<mujoco>
  <worldbody>
    <body pos="1 2 3"><freejoint/>
      <inertial pos="0.1 0.02 -0.05" quat="0.9 0.1 0.3 -0.2" mass="2" diaginertia="0.1 0.2 0.25"/>
      <body pos="0 0.1 0.3" quat="0.8 0.1 -0.3 0.5">
        <joint type="ball" pos="0.01 0.02 0.03" armature="0.01"/>
        <inertial pos="0.05 0 0.1" mass="1" diaginertia="0.01 0.02 0.02"/>
        <body pos="0 0.2 0"><joint type="hinge" axis="1 2 0.5" pos="0 0.05 0"/>
          <joint type="hinge" axis="0 1 1"/>
          <inertial pos="0 0 0.1" mass="0.5" diaginertia="0.004 0.003 0.002"/>
        </body>
        <body pos="0.2 0 0"><joint type="slide" axis="0 1 3"/>
          <inertial pos="0 0.03 0.1" mass="0.7" diaginertia="0.004 0.003 0.002"/>
          <body pos="0 0 0.2"><joint type="ball"/>
            <inertial pos="0 0.03 0" mass="0.2" diaginertia="0.0004 0.0003 0.0002"/></body>
        </body>
      </body>
    </body>
    <body pos="0 0 1"><freejoint/>
      <inertial pos="0 0 0" mass="3" diaginertia="0.1 0.1 0.1"/></body>
  </worldbody>
</mujoco>
"""
ROUNDING = 1e-12  # a few hundred operations on numbers of order one


@pytest.fixture(scope="module")
def model():
    return mujoco.MjModel.from_xml_string(MJCF)


@pytest.fixture(scope="module")
def core(model):
    stepper = _native.Stepper()
    stepper.set_model(**model_arrays(model))
    return stepper


def poses(model, count=20):
    rng = np.random.default_rng(0)
    for _ in range(count):
        qpos = np.array(model.qpos0)
        mujoco.mj_integratePos(model, qpos, rng.normal(size=model.nv), 1.0)
        yield qpos, rng


def test_body_frames(model, core):
    data = mujoco.MjData(model)
    for qpos, _ in poses(model):
        data.qpos[:] = qpos
        mujoco.mj_kinematics(model, data)
        for x, q in (core.body_frames(qpos), reference.body_frames(model, qpos)):
            np.testing.assert_allclose(x, data.xpos, atol=ROUNDING)
            same = np.abs(np.sum(q * data.xquat, axis=1))
            np.testing.assert_allclose(same, 1.0, atol=ROUNDING)


def test_inertia_matrix_and_factor(model, core):
    data = mujoco.MjData(model)
    for qpos, rng in poses(model):
        data.qpos[:] = qpos
        mujoco.mj_forward(model, data)
        # Column by column through M v: the same call in every version of MuJoCo.
        expected = np.zeros((model.nv, model.nv))
        for i, unit in enumerate(np.eye(model.nv)):
            mujoco.mj_mulM(model, data, expected[i], unit)
        M = core.inertia_matrix(qpos)
        np.testing.assert_allclose(M, expected, atol=ROUNDING)
        np.testing.assert_allclose(reference.inertia_matrix(model, qpos), expected, atol=ROUNDING)
        x = rng.normal(size=model.nv)
        # The solution is as good as its residual: M is badly conditioned on purpose.
        np.testing.assert_allclose(expected @ core.inertia_solve(qpos, x), x, atol=1e-10)


def test_integration_on_the_manifold(model, core):
    for qpos, rng in poses(model):
        qvel = rng.normal(size=model.nv)
        expected = qpos.copy()
        mujoco.mj_integratePos(model, expected, qvel, 0.3)
        np.testing.assert_allclose(core.integrate(qpos, qvel, 0.3), expected, atol=ROUNDING)


def test_jacobian_is_the_derivative_of_the_point(model):
    step = 1e-6  # central differences: error about step^2
    for qpos, rng in poses(model, count=3):
        body = model.nbody - 2
        x, q = reference.body_frames(model, qpos)
        local = rng.normal(size=3)
        from halfphysics.base import rotations as rot

        point = x[body] + rot.rotate(q[body], local)
        linear, _ = reference.jacobian(model, qpos, body, point)
        for i, unit in enumerate(np.eye(model.nv)):
            ends = []
            for t in (step, -step):
                moved = qpos.copy()
                mujoco.mj_integratePos(model, moved, unit, t)
                xm, qm = reference.body_frames(model, moved)
                ends.append(xm[body] + rot.rotate(qm[body], local))
            np.testing.assert_allclose(linear[:, i], (ends[0] - ends[1]) / (2 * step), atol=1e-8)
