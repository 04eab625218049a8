"""Skinning against an independent implementation: the numpy back end of `body-models`."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from halfphysics import rotations as rot
from halfphysics.body import _ASSET, Body
from halfphysics.io.body_models import read_model
from halfphysics.pose import Pose
from halfphysics.skeleton import JOINT_NAMES, PARENTS

SAMPLES, BATCH = 100, 10

# Rounding of float64 along chains of ten joints; asked for is 1e-6.
TOLERANCE = 1e-12
# The oracle's own rest joints: regressed in single precision, rows of a thousand signed weights.
SINGLE_PRECISION_JOINTS = 1e-6


@pytest.fixture(scope="module")
def model_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The default body in SMPL-X layout, 300 + 100 shape columns, random pose blend shapes."""
    rng = np.random.default_rng(7)
    with np.load(_ASSET) as asset:
        fields = {key: asset[key] for key in asset.files}
    count = len(fields["v_template"])
    directions = np.zeros((count, 3, 400), dtype=np.float32)
    directions[:, :, :10] = fields["shapedirs"][:, :, :10]
    directions[:, :, 300:310] = 0.01  # expressions: must not be taken for shape
    posedirs = rng.standard_normal((count, 3, 486), dtype=np.float32)
    posedirs *= 0.003
    path = tmp_path_factory.mktemp("models") / "SMPLX_NEUTRAL.npz"
    np.savez(
        path,
        v_template=fields["v_template"],
        f=fields["f"],
        weights=fields["weights"],
        J_regressor=fields["J_regressor"],
        kintree_table=fields["kintree_table"],
        shapedirs=directions,
        posedirs=posedirs,
        hands_meanl=np.zeros(45),
        hands_meanr=np.zeros(45),
        # A pickled dict, as in the real file: the oracle needs it, we must not.
        joint2num=np.array({name: i for i, name in enumerate(JOINT_NAMES)}, dtype=object),
    )
    return path


def test_vertices_and_joints_equal_body_models(model_file: Path) -> None:
    from body_models.smplx.numpy import SMPLX

    oracle = SMPLX(model_path=model_file, flat_hand_mean=True)
    space = read_model(model_file)
    assert space.shapedirs.shape[2] == 300
    assert space.posedirs is not None

    rng = np.random.default_rng(0)
    rotations = rng.normal(size=(SAMPLES, 55, 3)) * 0.6
    rotations[:, 0] *= 4.0
    translation = rng.normal(size=(SAMPLES, 3)) * 3.0
    betas = rng.normal(size=(SAMPLES, 300)) * 1.5
    for start in range(0, SAMPLES, BATCH):
        part = slice(start, start + BATCH)
        # Its skinning runs in double precision, its joint regressor only in single: joints are
        # regressed here, from its own vertices.
        identity = dict(oracle.prepare_identity(betas[part], np.zeros((BATCH, 10))))
        joints = np.einsum("jv,tvc->tjc", space.joint_regressor, identity["rest_vertices"])
        assert np.abs(joints - identity["rest_joints"]).max() < SINGLE_PRECISION_JOINTS
        identity["rest_joints"] = joints
        identity["local_joint_offsets"] = joints - np.where(
            np.arange(55)[:, None] > 0, joints[:, PARENTS], 0.0
        )
        given = {
            "body_pose": rotations[part, 1:22],
            "head_pose": rotations[part, 22:25],
            "hand_pose": rotations[part, 25:],
            "pelvis_rotation": rotations[part, 0],
            "identity": identity,
            "global_translation": translation[part],
        }
        vertices = oracle.forward_vertices(**given)
        frames = oracle.forward_skeleton(**given)
        assert vertices.dtype == np.float64
        for i in range(BATCH):
            body = Body.shaped(space, betas[start + i])
            pose = Pose(translation[start + i], rotations[start + i])
            positions, quaternions = body.joint_frames(pose)
            np.testing.assert_allclose(body.vertices(pose), vertices[i], rtol=0, atol=TOLERANCE)
            np.testing.assert_allclose(positions, frames[i, :, :3, 3], rtol=0, atol=TOLERANCE)
            np.testing.assert_allclose(
                rot.to_matrix(quaternions), frames[i, :, :3, :3], rtol=0, atol=TOLERANCE
            )
    # The pose blend shapes are in it: without them vertices would be off by millimetres.
    bare = dataclasses.replace(body, posedirs=None)
    assert np.abs(bare.vertices(pose) - vertices[-1]).max() > 1e-3
