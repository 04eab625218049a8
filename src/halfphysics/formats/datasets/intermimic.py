"""InterMimic `.pt`: one tensor (T, 591), the robot model of a person and one object; z-up, 30 fps.

Columns: root position 0:3 and quaternion 3:7, joint angles 9:162 (51 x 3), joint positions 162:318
(52 x 3), object position 318:321 and quaternion 321:325, object touched 330, joints that touch
331:383, joint quaternions 383:591 (52 x 4); 7:9 and 325:330 are empty. Quaternions are x y z w.

The root is the pelvis joint, not the SMPL origin. Joints are the 52 of SMPL-H in the order of the
robot's MJCF, which is depth first. At rest its frames have x forward, y left and z up, SMPL's have
y up and z forward: with U from SMPL's axes to the robot's, the rotation of the root is the file's
times U, and the axis-angle of a joint is U^T times the file's.

The file has no betas; the joint positions determine the bones (see `_bones`), and these the betas
of the user's model, or the proportions of the default body.
"""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base import torch_file
from halfphysics.base.reader_warnings import warn
from halfphysics.body.body import Body
from halfphysics.errors import FileError, InputError
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.datasets.assets import find
from halfphysics.formats.datasets.recorded import add_recorded
from halfphysics.formats.datasets.shape_from_joints import (
    Bones,
    bend,
    bones_of,
    default_like,
    shaped_like,
    world_turns,
)
from halfphysics.formats.format import Format, Options, Source
from halfphysics.formats.motion_builder import (
    file_parameters,
    lost_gender,
    lost_joints,
    lost_rate,
    motion_of,
    rotations_of,
)
from halfphysics.geometry.mesh_files import load_mesh
from halfphysics.motion import skeleton
from halfphysics.motion.motion import MODELS, Motion
from halfphysics.scene.scene import Scene
from halfphysics.simulation.sequence import Sequence

Array = NDArray[np.float64]

NAME = "intermimic"
FPS = 30.0
WIDTH = 591
_ROOT, _ROOT_TURN = slice(0, 3), slice(3, 7)
_ANGLES, _PLACES = slice(9, 162), slice(162, 318)
_OBJECT, _OBJECT_TURN = slice(318, 321), slice(321, 325)
_TOUCH = slice(330, 383)
_TURNS = slice(383, 591)
_FIELD = "tensor"
_OBJECT_KEY, _TOUCH_KEY = "object", "touch"
#: U: upright axes of the robot's frames from those of SMPL.
UPRIGHT = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])


def _depth_first(joint: int = 0) -> list[int]:
    children = [j for j in skeleton.SMPLH_JOINTS if skeleton.PARENTS[j] == joint]
    return [joint, *(below for child in children for below in _depth_first(child))]


#: The joints of the file, as indices into `JOINT_NAMES`.
ORDER = tuple(_depth_first())
#: Fingers at rest are bent by 0.1 to 0.2 rad in a flat hand, by about 0.8 in the model's relaxed
#: hand.
_RELAXED = 0.45
# Tolerance between positions and rotations in single precision or from a simulation [m].
_AGREE = 0.01
_UNIT = 1e-2
# Folders of meshes in the data set's repositories and in repackaged copies.
_FOLDERS = (
    "objects/objects/{0}/",
    "objects/{0}/",
    "assets/objects/objects/{0}/",
    "data/assets/objects/objects/{0}/",
    "intermimic/data/assets/objects/objects/{0}/",
    "isaacgym/src/intermimic/data/assets/objects/objects/{0}/",
    "{0}/",
    "",
)


def _sniff(source: Source) -> bool:
    data = source.data
    if not isinstance(data, np.ndarray):
        return False
    if data.ndim == 2 and data.shape[1] == WIDTH:
        return True
    if source.head[:2] == b"PK":
        raise FileError(
            f"{source.path}: a tensor of shape {data.shape}, expected (T, {WIDTH}), as InterMimic "
            "has it"
        )
    return False


def _turns(record: Record, rows: Array, columns: slice, what: str) -> Array:
    """Quaternions (T, 4), w x y z."""
    xyzw = rows[:, columns]
    off = np.abs(np.linalg.norm(xyzw, axis=1) - 1.0)
    if (off > _UNIT).any():
        at = int(np.argmax(off))
        raise record.error(
            _FIELD,
            f"columns {columns.start}:{columns.stop} ({what}): found {xyzw[at].round(3).tolist()} "
            f"in frame {at}, expected a quaternion of length 1",
        )
    return rot.normalize(rot.continuous(xyzw)[:, [3, 0, 1, 2]])


def _rows(source: Source, options: Options) -> tuple[Record, Array]:
    record = Record(source.path, {_FIELD: source.data})
    return record, record.array(_FIELD, None, WIDTH, frames=options.frames)


def _load(source: Source, options: Options) -> Motion:
    return _with_body(source, options)[0]


def _with_body(source: Source, options: Options) -> tuple[Motion, Body]:
    """The motion, and the body with which its pelvis is at the file's position."""
    record, rows = _rows(source, options)
    if not len(rows):
        raise FileError(f"{source.path}: found 0 frames, expected at least 2")
    turns = _turns(record, rows, _ROOT_TURN, "rotation of the root")
    root = rot.log(rot.multiply(turns, rot.from_matrix(UPRIGHT)))
    angles = rows[:, _ANGLES].reshape(-1, len(ORDER) - 1, 3) @ UPRIGHT
    rotations = rotations_of({(0,): root, ORDER[1:]: angles})
    bones = _bones(record, rows, rotations)
    hands: Literal["flat", "mean"] = "mean" if bend(bones.offsets) > _RELAXED else "flat"
    # A model file or folder, not a name such as "smplx".
    model = None if str(options.model) in MODELS else options.model
    named = model is not None
    if hands == "mean" and options.hands is None and not named:
        raise FileError(
            f"{record.where}: where its fingers are zero, the joints of the hands are those of the "
            "model's relaxed hand. Name the body-model file with model=, or say hands='flat' to "
            "take the hands as flat"
        )
    if model is not None:
        body = shaped_like(record.where, bones, model, options.gender, hands == "flat")
    else:
        body = default_like(record.where, bones)
        warn(
            f"{record.where}: does not say whose shape it is: the default body has the recorded "
            f"bones, stature {body.stature:.2f} m. load_sequence brings it, and the pelvis is "
            "where the file has it on it. For the person's own shape name the body-model file, or "
            "their folder, with model="
        )
    known = body.gender if named and body.gender != "unknown" else None
    motion = motion_of(
        record.where,
        options,
        format=NAME,
        # The pelvis position so far: the offset depends on the axes, which the caller may set.
        translation=rows[:, _ROOT],
        rotations=rotations,
        fps=FPS,
        up="z",
        model=body.model if named else "smplx",
        gender=known or "neutral",
        betas=body.betas if named else None,
        hands=hands,
        per_frame={
            _OBJECT_KEY: np.hstack([rows[:, _OBJECT], rot.continuous(rows[:, _OBJECT_TURN])]),
            _TOUCH_KEY: np.rint(rows[:, _TOUCH]).astype(np.int64),
        },
    )
    moved = motion.translation - motion.axes @ body.rest_joints[0]
    return motion.with_frames(moved, motion.rotations), body


def _bones(record: Record, rows: Array, rotations: Array) -> Bones:
    """The bones estimated from the joint positions."""
    places = np.full((len(rows), skeleton.N_JOINTS, 3), np.nan)
    places[:, list(ORDER)] = rows[:, _PLACES].reshape(len(rows), -1, 3)
    bones = bones_of(places, rotations)
    columns = f"columns {_PLACES.start}:{_PLACES.stop} (joint positions)"
    lengths = np.linalg.norm(bones.offsets[list(ORDER[1:])], axis=1)
    if not (lengths.min() > 1e-4 and lengths.max() < 1.0):
        raise record.error(
            _FIELD,
            f"{columns}: found bones from {lengths.min():.3g} to {lengths.max():.3g}, expected a "
            "person's, in metres",
        )
    off = float(np.linalg.norm(places[:, 0] - rows[:, _ROOT], axis=1).max())
    if max(off, bones.spread) > _AGREE:
        warn(
            f"{record.where}: field '{_FIELD}': {columns} and the rotations disagree by up to "
            f"{max(off, bones.spread):.2g} m; the rotations are taken"
        )
    return bones


def _load_sequence(source: Source, options: Options) -> Sequence:
    motion, body = _with_body(source, options)
    record, rows = _rows(source, options)
    words = source.path.stem.split("_")
    # InterMimic's own rule, then that of GRAB's clips in InterAct (s1_cup_drink_1).
    names = dict.fromkeys(words[i] for i in (-2, 1) if len(words) > 1)
    if not names:
        raise FileError(
            f"{source.path}: the name of the file says which object it is: expected "
            "SUBJECT_OBJECT_NUMBER.pt. Rename it, or read the motion alone with Motion.load"
        )
    files = [folder.format(name) + f"{name}.obj" for name in names for folder in _FOLDERS]
    mesh = find(source, options, files, f"the mesh of the object {' or '.join(map(repr, names))}")
    vertices = load_mesh(mesh, up="z")[0].vertices
    if np.abs(vertices.mean(axis=0)).max() > _AGREE:
        warn(
            f"{mesh}: not centred on the mean of its vertices, as InterMimic's meshes are: is it "
            "the one of another data set?"
        )
    scene = Scene()
    track = add_recorded(
        scene,
        mesh.stem,
        mesh,
        rows[:, _OBJECT],
        rot.to_matrix(_turns(record, rows, _OBJECT_TURN, "rotation of the object")),
        where=record.where,
        axes=motion.axes,
        fps=motion.fps,
        options=options,
    )
    return Sequence(motion, scene, body=body, recorded={mesh.stem: track})


def _save(motion: Motion, path: Path, body: Body | None) -> None:
    if body is None:
        raise InputError(
            f"format: '{NAME}' holds the joints of the person. Say whose motion it is with body="
        )
    _, rotations, said = file_parameters(motion, NAME)
    places = body.joints(motion) @ motion.axes
    turns = world_turns(rotations)
    turns = rot.multiply(turns[:, list(ORDER)], rot.conjugate(rot.from_matrix(UPRIGHT)))
    xyzw = turns[..., [1, 2, 3, 0]]
    # Angles of at most pi, as in the data set's exponential maps.
    angles = rot.log(rot.exp(rotations[:, list(ORDER[1:])])) @ UPRIGHT.T
    frames = len(motion)
    rows = np.zeros((frames, WIDTH))
    rows[:, _ROOT], rows[:, _ROOT_TURN] = places[:, 0], rot.continuous(xyzw[:, 0])
    rows[:, _ANGLES] = angles.reshape(frames, -1)
    rows[:, _PLACES] = places[:, list(ORDER)].reshape(frames, -1)
    rows[:, _TURNS] = xyzw.reshape(frames, -1)
    rows[:, _OBJECT_TURN] = (0.0, 0.0, 0.0, 1.0)
    kept = motion.origin.per_frame if said and motion.origin is not None else {}
    if _OBJECT_KEY in kept:
        rows[:, _OBJECT] = kept[_OBJECT_KEY][:, :3]
        turn = kept[_OBJECT_KEY][:, 3:]  # interpolated ones are not of length 1
        length = np.linalg.norm(turn, axis=1, keepdims=True)
        rows[:, _OBJECT_TURN] = turn / np.where(length > 0.0, length, 1.0)
        rows[:, _TOUCH] = kept[_TOUCH_KEY]
    torch_file.write(path, rows.astype(np.float32))


def _loses(motion: Motion) -> tuple[str, ...]:
    lost = list(lost_joints(motion, skeleton.SMPLH_JOINTS))
    if motion.betas is not None and motion.betas.any():
        lost.append("the shape (betas), but for the joints of it")
    lost += [*lost_gender(motion), *lost_rate(motion, FPS)]
    if motion.origin is None or _OBJECT_KEY not in motion.origin.per_frame:
        lost.append("an object: there is none, and its columns say that it lies at the origin")
    return tuple(lost)


FORMAT = Format(
    name=NAME,
    about="InterMimic and InterAct: a person and an object as one tensor",
    invents="the person's shape, the frame rate (30)",
    expects=f".pt with one tensor (T, {WIDTH})",
    sniff=_sniff,
    load=_load,
    load_sequence=_load_sequence,
    save=_save,
    tells_bones=True,
    suffixes=(".pt",),
    loses=_loses,
)
