"""Habitat 3's humanoid motions, which its `HumanoidSeqPoseController` plays; y-up.

A pickle of ``{"pose_motion": {"joints_array", "transform_array", "displacement", "fps"}}`` (walks
say "walk_motion"): `joints_array` (T, 216) or (T, 54, 4), rotations x, y, z, w of the humanoid's
spherical joints in the parents' frames, in the order of its URDF; `transform_array` (T, 4, 4), the
pelvis in a y-up world. Habitat's own converter of SMPL-X motions writes such files.

The order is that of the URDF, which `assets=` gives; without it, depth first from the pelvis, legs
before spine, as bones follow each other in SMPL-X, and so they are written. Habitat's converter
writes a rate of 1: then the rate is not known. Layout: facebookresearch/habitat-lab,
habitat/utils/humanoid_utils.py and habitat/articulated_agent_controllers.
"""

from __future__ import annotations

import re
from collections.abc import Sequence as Listing
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.reader_warnings import warn
from halfphysics.base.stored_objects import write
from halfphysics.body.body import Body
from halfphysics.errors import FileError
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.datasets.assets import note
from halfphysics.formats.format import Format, Options, Source
from halfphysics.formats.motion_builder import (
    lost_gender,
    lost_model,
    motion_of,
    same_length,
)
from halfphysics.formats.written_people import written
from halfphysics.motion.motion import Motion
from halfphysics.motion.skeleton import JOINT_INDEX, JOINT_NAMES, N_JOINTS, PARENTS

Array = NDArray[np.float64]

NAME = "habitat"
CLIPS = ("pose_motion", "walk_motion")
_KEYS = {"joints_array", "transform_array"}
_LARGEST_URDF = 16 * 2**20


def _depth_first() -> tuple[int, ...]:
    def below(joint: int) -> list[int]:
        found = []
        for child, parent in enumerate(PARENTS.tolist()):
            if parent == joint:
                found += [child, *below(child)]
        return found

    return tuple(below(0))


#: SMPL-X joints in the order in which files have them, if no URDF says another.
ORDER = _depth_first()


def _clip(source: Source) -> dict[str, Any] | None:
    data = source.data
    if not isinstance(data, dict):
        return None
    clips = [data[name] for name in CLIPS if isinstance(data.get(name), dict)]
    return clips[0] if clips and clips[0].keys() >= _KEYS else None


def _sniff(source: Source) -> bool:
    return _clip(source) is not None


def _load(source: Source, options: Options) -> Motion:
    record = Record(source.path, _clip(source) or {})
    shape = record.shape("joints_array")
    wide = shape[1:] == (N_JOINTS - 1, 4)
    layout = (None, N_JOINTS - 1, 4) if wide else (None, 4 * (N_JOINTS - 1))
    turns = record.array("joints_array", *layout, frames=options.frames).reshape(-1, 54, 4)
    places = record.array("transform_array", None, 4, 4, frames=options.frames)
    same_length(
        record.where,
        {name: len(record.raw(name)) for name in ("joints_array", "transform_array")},
    )
    if (np.square(turns).sum(axis=2) < 1e-6).any():
        raise record.error("joints_array", "found quaternions of zeros, expected unit quaternions")
    if not np.allclose(np.linalg.det(places[:, :3, :3]), 1.0, atol=1e-3):
        raise record.error("transform_array", "found matrices that are no rotation and place")
    order = _order(source, options)
    rotations = np.zeros((len(turns), N_JOINTS, 3))
    rotations[:, list(order)] = rot.log(rot.normalize(turns[..., [3, 0, 1, 2]]))
    rotations[:, 0] = rot.matrix_to_rotvec(places[:, :3, :3])
    rest = Body.default().rest_joints
    fps = record.number("fps", above=0.0) if "fps" in record else 1.0
    warn(f"{record.where}: not in the file: the pelvis of the body at rest")
    return motion_of(
        record.where,
        options,
        format=NAME,
        translation=places[:, :3, 3] - rest[0],
        rotations=rotations,
        fps=fps if fps > 1.0 else None,
        up="y",
        model="smplx",
        gender="neutral",
        fields={"rest": rest, "order": order},
    )


def _order(source: Source, options: Options) -> Listing[int]:
    """SMPL-X joints in the order of the URDF in the assets' folders, else `ORDER`."""
    files = [file for folder in options.assets for file in sorted(folder.glob("*.urdf"))]
    return _order_of(note(files[0])) if files else ORDER


def _order_of(path: Path) -> list[int]:
    """The spherical joints of a URDF, depth first from its root, as pybullet numbers them."""
    try:
        if path.stat().st_size > _LARGEST_URDF:
            raise FileError(f"{path}: too large for a URDF")
        text = path.read_text(encoding="utf-8")
        if re.search(r"<!(DOCTYPE|ENTITY)", text):
            raise FileError(f"{path}: a URDF with entities, expected plain XML")
        root = ElementTree.fromstring(text)
    except (OSError, UnicodeDecodeError, ElementTree.ParseError) as error:
        raise FileError(f"{path}: cannot be read ({error})") from None
    below: dict[str, list[tuple[str, str, str]]] = {}
    children = set()
    for joint in root.findall("joint"):
        ends = [joint.find(name) for name in ("parent", "child")]
        parent, child = (("" if end is None else end.get("link", "")) for end in ends)
        entry = (joint.get("name", ""), joint.get("type", ""), child)
        below.setdefault(parent, []).append(entry)
        children.add(child)
    names: list[str] = []
    stack = [entry for link in below if link not in children for entry in reversed(below[link])]
    while stack and len(names) <= len(children):
        name, kind, child = stack.pop()
        if kind == "spherical":
            names.append(name)
        stack += reversed(below.get(child, []))
    if sorted(names) != sorted(JOINT_NAMES[1:]):
        raise FileError(
            f"{path}: found {len(names)} spherical joints, expected the 54 of SMPL-X by their names"
        )
    return [JOINT_INDEX[name] for name in names]


def _save(motion: Motion, path: Path, body: Body | None) -> None:
    person = written([motion], NAME)["0"]
    origin = motion.origin
    own = origin is not None and origin.format == NAME
    order = list(origin.fields["order"]) if own and origin is not None else list(ORDER)
    turns = rot.continuous(rot.exp(person.rotations[:, order]))
    places = np.tile(np.eye(4), (len(motion), 1, 1))
    places[:, :3, :3] = rot.rotvec_to_matrix(person.rotations[:, 0])
    places[:, :3, 3] = person.translation + person.rest[0]
    steps = np.diff(places[:, :3, 3], axis=0, prepend=places[:1, :3, 3])
    clip = {
        "joints_array": turns[..., [1, 2, 3, 0]].reshape(len(motion), -1),
        "transform_array": places,
        "displacement": np.cumsum(np.linalg.norm(steps[:, [0, 2]], axis=1)),
        "fps": motion.fps,
    }
    write(path, {CLIPS[0]: clip})


def _loses(motion: Motion) -> tuple[str, ...]:
    shape = motion.betas is not None and motion.betas.any()
    lost = ("the shape: Habitat's humanoid has its own",) if shape else ()
    return (*lost, *lost_gender(motion), *lost_model(motion))


FORMAT = Format(
    name=NAME,
    about="Habitat 3: motions of humanoids",
    invents="shape, gender, the pelvis at rest, the order of joints without the URDF",
    expects="pkl with pose_motion: a dict of joints_array (T, 216), transform_array (T, 4, 4), fps",
    sniff=_sniff,
    load=_load,
    save=_save,
    suffixes=(".pkl",),
    up="y",
    loses=_loses,
)
