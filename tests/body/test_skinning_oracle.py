"""Skinning against an independent implementation: the numpy back end of `body-models`."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from halfphysics.base import rotations as rot
from halfphysics.body.body import _ASSET, Body
from halfphysics.body.model_files import read_model
from halfphysics.motion.pose import Pose
from halfphysics.motion.skeleton import JOINT_NAMES, PARENTS

SAMPLES, BATCH = 40, 10

# The unmodified reader: its skinning runs in double precision, its joint regressor
# in single, and an error in a joint adds up along the limb.
AS_SHIPPED = 1e-6
SINGLE_PRECISION_JOINTS = 2e-7  # two or three roundings of a coordinate of a metre
# With its joints regressed in double precision too: rounding along chains of ten joints.
ROUNDING = 1e-12


@pytest.fixture(scope="module")
def model_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The default body in SMPL-X layout, 300 + 100 shape columns, random pose blend shapes."""
    rng = np.random.default_rng(7)
    with np.load(_ASSET) as asset:
        fields = {key: asset[key] for key in asset.files}
    count = len(fields["v_template"])
    directions = np.zeros((count, 3, 400), dtype=np.float32)
    directions[:, :, :10] = fields["shapedirs"][:, :, :10]
    directions[:, :, 300:310] = 0.01  # expressions: must not be read as shape
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
        # A pickled dict, as in the real file: the oracle needs it, our reader must not.
        joint2num=np.array({name: i for i, name in enumerate(JOINT_NAMES)}, dtype=object),
    )
    return path


@dataclasses.dataclass(frozen=True, kw_only=True)
class Samples:
    """Random people in random poses, and the oracle's inputs for them."""

    rotations: np.ndarray
    translation: np.ndarray
    betas: np.ndarray

    @classmethod
    def random(cls) -> Samples:
        rng = np.random.default_rng(0)
        rotations = rng.normal(size=(SAMPLES, 55, 3)) * 0.6
        rotations[:, 0] *= 4.0
        translation = rng.normal(size=(SAMPLES, 3)) * 3.0
        betas = rng.normal(size=(SAMPLES, 300)) * 1.5
        return cls(rotations=rotations, translation=translation, betas=betas)

    def pose(self, part: slice) -> dict[str, np.ndarray]:
        return {
            "body_pose": self.rotations[part, 1:22],
            "head_pose": self.rotations[part, 22:25],
            "hand_pose": self.rotations[part, 25:],
            "pelvis_rotation": self.rotations[part, 0],
            "global_translation": self.translation[part],
        }


@pytest.mark.parametrize(
    ("joints_in_double", "tolerance"),
    [(False, AS_SHIPPED), (True, ROUNDING)],
    ids=["as-shipped", "joints-in-double"],
)
def test_vertices_and_joints_equal_body_models(
    model_file: Path, joints_in_double: bool, tolerance: float
) -> None:
    pytest.importorskip("body_models", reason="of the extra test")
    from body_models.smplx.numpy import SMPLX

    oracle = SMPLX(model_path=model_file, flat_hand_mean=True)
    space = read_model(model_file)
    assert space.shapedirs.shape[2] == 300
    assert space.posedirs is not None
    samples = Samples.random()
    for start in range(0, SAMPLES, BATCH):
        part = slice(start, start + BATCH)
        identity = dict(oracle.prepare_identity(samples.betas[part], np.zeros((BATCH, 10))))
        joints = np.einsum("jv,tvc->tjc", space.joint_regressor, identity["rest_vertices"])
        assert np.abs(joints - identity["rest_joints"]).max() < SINGLE_PRECISION_JOINTS
        if joints_in_double:
            identity["rest_joints"] = joints
            identity["local_joint_offsets"] = joints - np.where(
                np.arange(55)[:, None] > 0, joints[:, PARENTS], 0.0
            )
        given = samples.pose(part) | {"identity": identity}
        vertices = oracle.forward_vertices(**given)
        frames = oracle.forward_skeleton(**given)
        assert vertices.dtype == np.float64
        for i in range(BATCH):
            body = Body.shaped(space, samples.betas[start + i])
            pose = Pose(samples.translation[start + i], samples.rotations[start + i])
            positions, quaternions = body.joint_frames(pose)
            np.testing.assert_allclose(body.vertices(pose), vertices[i], rtol=0, atol=tolerance)
            np.testing.assert_allclose(positions, frames[i, :, :3, 3], rtol=0, atol=tolerance)
            np.testing.assert_allclose(
                rot.to_matrix(quaternions), frames[i, :, :3, :3], rtol=0, atol=tolerance
            )
    # The pose blend shapes are included: without them vertices would differ by millimetres.
    bare = dataclasses.replace(body, posedirs=None)
    assert np.abs(bare.vertices(pose) - vertices[-1]).max() > 1e-3
