"""Recordings as files of InterMimic: joint positions and fingers, in single precision."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from halfphysics.motion.file_metadata import FileMetadata
from support.carries.files.written import SINGLE, Written, centred
from support.carries.files.written import poses as poses_of
from support.carries.recordings import Recording


def write(made: Recording, folder: Path) -> Written:
    """`sub1_THING_000.pt` and `objects/THING/THING.obj` below `folder`."""
    name = made.case.thing
    mesh, middle = centred(made)
    meshes = folder / "objects" / name
    meshes.mkdir(parents=True, exist_ok=True)
    mesh.export(meshes / f"{name}.obj", digits=16)
    position, _ = poses_of(made, middle)
    xyzw = made.track.quaternion[:, [1, 2, 3, 0]]
    rows = {"object": np.hstack([position, xyzw]), "touch": np.zeros((len(xyzw), 53), int)}
    kept = FileMetadata(format="intermimic", fields={"hands_mean": None}, per_frame=rows)
    path = folder / f"sub1_{name}_000.pt"
    replace(made.motion, origin=kept).save(path, format="intermimic", body=made.body)
    return Written(path, middle, SINGLE)
