"""Recordings as files of OMOMO: the person's bones, no fingers."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import trimesh

from halfphysics.base import rotations as rot
from halfphysics.motion.skeleton import BODY_JOINTS, JOINT_INDEX
from support.carries.files.written import EXACT, Written
from support.carries.people import offsets_of
from support.carries.recordings import Recording

#: Metres per unit of a mesh file, and where its middle is in it [units].
SCALE, ASIDE = 0.5, np.array([0.3, 0.1, 0.2])
#: OMOMO's 24 joints: SMPL's 22, and the first of each middle finger.
JOINTS_24 = [*range(22), JOINT_INDEX["left_middle1"], JOINT_INDEX["right_middle1"]]


def omomo_clip(made: Recording, number: int = 0) -> dict:
    """A clip as OMOMO's `.p` has it: no fingers, whatever the recording has.

    `rest_offsets` are joints from their parents (the root from the origin), `trans2joint` is what
    takes the root joint to `trans`.
    """
    rotations, offsets = made.motion.rotations, offsets_of(made.body)
    matrix = rot.to_matrix(made.track.quaternion)
    position = made.track.position - matrix @ (SCALE * ASIDE)
    frames = len(position)
    return {
        "seq_name": f"sub1_{made.case.thing}_{number:03}",
        "betas": np.zeros((1, 16)),
        "gender": "male",
        "trans": np.array(made.motion.translation),
        "root_orient": np.array(rotations[:, 0]),
        "pose_body": rotations[:, list(BODY_JOINTS)].reshape(frames, 63),
        "rest_offsets": offsets[JOINTS_24],
        "trans2joint": -np.asarray(made.body.rest_joints)[0],
        "obj_trans": position[:, :, None],
        "obj_rot": matrix,
        "obj_scale": np.full(frames, SCALE),
        "obj_com_pos": made.track.position.copy(),
    }


def write_omomo(recordings, folder: Path) -> Path:
    """Write clips and the meshes of their things below `folder`; returns the file of the clips."""
    meshes = folder / "captured_objects"
    meshes.mkdir(parents=True, exist_ok=True)
    for made in recordings:
        mesh = made.thing.mesh
        inside = trimesh.Trimesh(mesh.vertices / SCALE + ASIDE, mesh.faces, process=False)
        # By sixteen digits, so that a recording read back is the same to rounding.
        inside.export(meshes / f"{made.case.thing}_cleaned_simplified.obj", digits=16)
    path = folder / "train_diffusion_manip_seq_joints24.p"
    clips = {k: omomo_clip(made, k) for k, made in enumerate(recordings)}
    path.write_bytes(pickle.dumps(clips))
    return path


def write(made: Recording, folder: Path) -> Written:
    """One recording."""
    return Written(write_omomo([made], folder), SCALE * ASIDE, EXACT)
