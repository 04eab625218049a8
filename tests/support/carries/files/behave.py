"""Recordings as files of BEHAVE: a camera's axes, SMPL-H, betas that say nothing in metres."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.motion.skeleton import SMPLH_JOINTS
from support.carries.files.written import SINGLE, Written, centred, in_axes
from support.carries.files.written import poses as poses_of
from support.carries.recordings import Recording

#: World from the axes of the camera: x right, y down, z ahead.
CAMERA = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
#: Where the mesh file has the mean of its vertices [m]: the scans are not centred.
ASIDE = np.array([0.4, -0.3, 0.2])


def write(made: Recording, folder: Path) -> Written:
    """`sequences/Date01_Sub01_THING/` and `objects/THING/` below `folder`."""
    name = made.case.thing
    mesh, middle = centred(made)
    mesh.vertices += ASIDE
    meshes = folder / "objects" / name
    meshes.mkdir(parents=True, exist_ok=True)
    mesh.export(meshes / f"{name}_f1000.ply")
    position, matrix = poses_of(made, middle)
    translation, rotations = in_axes(made, CAMERA)
    frames = len(position)
    times = np.array([f"t{k / made.motion.fps:08.3f}" for k in range(frames)])
    path = folder / "sequences" / f"Date01_Sub01_{name}"
    path.mkdir(parents=True, exist_ok=True)
    np.savez(
        path / "smpl_fit_all.npz",
        poses=rotations[:, list(SMPLH_JOINTS)].reshape(frames, 156),
        betas=np.zeros((frames, 10)),
        trans=translation,
        frame_times=times,
    )
    np.savez(
        path / "object_fit_all.npz",
        angles=rot.matrix_to_rotvec(CAMERA.T @ matrix),
        trans=position @ CAMERA,
        frame_times=times,
    )
    (path / "info.json").write_text(json.dumps({"gender": "male", "cat": name}))
    return Written(path, middle + ASIDE, SINGLE)
