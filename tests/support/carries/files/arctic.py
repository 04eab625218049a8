"""Recordings as files of ARCTIC: the subject's template, a thing of two parts, its hinge shut."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import trimesh

from halfphysics.base import rotations as rot
from halfphysics.motion.skeleton import BODY_JOINTS, LEFT_HAND_JOINTS, RIGHT_HAND_JOINTS
from support.carries.files.written import SINGLE, Written
from support.carries.recordings import Recording

MILLIMETRES = 1000.0


def parts_of(made: Recording) -> dict[str, trimesh.Trimesh]:
    """The thing as a bottom and a top [m]: its first solid and the others, or one cut in two."""
    solids = [solid.mesh for solid in made.thing.solids]
    if len(solids) > 1:
        return {"bottom": solids[0], "top": trimesh.util.concatenate(solids[1:])}
    (solid,) = solids
    out = {}
    corners, (a, b) = solid.vertices, solid.vertices[solid.edges_unique].swapaxes(0, 1)
    crosses = a[:, 2] * b[:, 2] < 0.0
    share = (a[:, 2] / np.where(crosses, a[:, 2] - b[:, 2], 1.0))[crosses, None]
    rim = a[crosses] + share * (b - a)[crosses]
    for name, up in (("bottom", -1.0), ("top", 1.0)):  # both convex, as every solid is
        half = np.concatenate([corners[up * corners[:, 2] >= 0.0], rim])
        out[name] = trimesh.convex.convex_hull(half)
    return out


def write(made: Recording, folder: Path) -> Written:
    """`raw_seqs/s01/THING_use_01.smplx.npy`, its object beside it, and `meta/` below `folder`."""
    name, meta = made.case.thing, folder / "meta"
    frames, rotations = len(made.motion), made.motion.rotations
    body = {
        "transl": np.array(made.motion.translation),
        "global_orient": rotations[:, 0],
        "body_pose": rotations[:, list(BODY_JOINTS)].reshape(frames, 63),
        "jaw_pose": rotations[:, 22],
        "leye_pose": rotations[:, 23],
        "reye_pose": rotations[:, 24],
        "left_hand_pose": rotations[:, list(LEFT_HAND_JOINTS)].reshape(frames, 45),
        "right_hand_pose": rotations[:, list(RIGHT_HAND_JOINTS)].reshape(frames, 45),
    }
    thing = np.hstack(
        [
            np.zeros((frames, 1)),
            rot.log(made.track.quaternion),
            MILLIMETRES * made.track.position,
        ]
    )
    path = folder / "raw_seqs" / "s01" / f"{name}_use_01.smplx.npy"
    shapes, subjects = meta / "object_vtemplates" / name, meta / "subject_vtemplates"
    for each in (path.parent, shapes, subjects):
        each.mkdir(parents=True, exist_ok=True)
    np.save(path, body, allow_pickle=True)
    np.save(path.with_name(f"{name}_use_01.object.npy"), thing)
    for part, mesh in parts_of(made).items():
        scaled = trimesh.Trimesh(MILLIMETRES * mesh.vertices, mesh.faces, process=False)
        scaled.export(shapes / f"{part}.obj", digits=16)
    skin = trimesh.Trimesh(made.body.rest_vertices, made.body.faces, process=False)
    skin.export(subjects / "s01.obj", digits=16)
    (meta / "misc.json").write_text(json.dumps({"s01": {"gender": "male"}}))
    return Written(path, np.zeros(3), SINGLE)
