"""Recordings as files of GRAB: 120 fps, the subject's template, a table, fingers in full."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh

from halfphysics.base import rotations as rot
from halfphysics.motion.skeleton import BODY_JOINTS
from support.carries.files.written import SINGLE, Written, centred
from support.carries.files.written import poses as poses_of
from support.carries.recordings import Recording

#: Of the table top [m]: the data set's table has no legs.
TOP = 0.03
_TEMPLATE = "tools/subject_meshes/male/s1.ply"
_MESHES = "tools/object_meshes/contact_meshes"


def table_of(made: Recording) -> trimesh.Trimesh:
    """What the thing stands on, as one mesh in the world's frame."""
    tops = []
    for size, position, quaternion in made.stands.values():
        top = trimesh.creation.box((size[0], size[1], TOP))
        at = position + np.array([0.0, 0.0, 0.5 * (size[2] - TOP)])
        top.vertices = rot.rotate(quaternion, top.vertices) + at
        tops.append(top)
    return trimesh.util.concatenate(tops)


def write(made: Recording, folder: Path) -> Written:
    """`GRAB/grab/s1/THING_lift.npz` and `GRAB/tools/` below `folder`."""
    name, root = made.case.thing, folder / "GRAB"
    mesh, middle = centred(made)
    position, matrix = poses_of(made, middle)
    frames, rotations = len(position), made.motion.rotations
    body = {
        "transl": made.motion.translation,
        "global_orient": rotations[:, 0],
        "body_pose": rotations[:, list(BODY_JOINTS)].reshape(frames, 63),
        "jaw_pose": rotations[:, 22],
        "leye_pose": rotations[:, 23],
        "reye_pose": rotations[:, 24],
        "left_hand_pose": np.zeros((frames, 24)),
        "right_hand_pose": np.zeros((frames, 24)),
        "fullpose": rotations.reshape(frames, 165),
    }
    thing = {"transl": position, "global_orient": -rot.matrix_to_rotvec(matrix)}
    content = {
        "gender": "male", "sbj_id": "s1", "obj_name": name, "motion_intent": "lift",
        "framerate": made.motion.fps, "n_frames": frames, "n_comps": 24,
        "body": {"params": body, "vtemp": _TEMPLATE},
        "object": {"params": thing, "object_mesh": f"{_MESHES}/{name}.ply"},
    }  # fmt: skip
    for path in (_TEMPLATE, f"{_MESHES}/{name}.ply"):
        (root / path).parent.mkdir(parents=True, exist_ok=True)
    skin = trimesh.Trimesh(made.body.rest_vertices, made.body.faces, process=False)
    skin.export(root / _TEMPLATE)
    mesh.export(root / _MESHES / f"{name}.ply")
    if made.stands:
        table_of(made).export(root / _MESHES / "table.ply")
        still = {key: np.zeros((frames, 3)) for key in ("transl", "global_orient")}
        content["table"] = {"params": still, "table_mesh": f"{_MESHES}/table.ply"}
    path = root / "grab" / "s1" / f"{name}_lift.npz"
    path.parent.mkdir(parents=True, exist_ok=True)
    np.savez(path, **content)
    return Written(path, middle, SINGLE)
