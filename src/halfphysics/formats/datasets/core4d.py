"""CORE4D: two people who carry one object; y-up, 15 fps.

A sequence is a folder with `person1_poses.npz`, `person2_poses.npz`, `smooth_objposes.npy`
(N, 4, 4), world from object, and `object_metadata.json` with `obj_name` ("Chair001"); or, with the
object's name in the file's, `object_poses_chair001.npy`. A person's file has one field `arr_0`, a
dict of `betas (N, 10)`, `transl, global_orient (N, 3)`, `body_pose (N, 21, 3)`, `left_hand_pose,
right_hand_pose (N, 12)`, `joints (N, 127, 3)` and `vertices (N, 10475, 3)` of the neutral SMPL-X.
Meshes: `object_models/CATEGORY/NAME_m.obj` [m], the category is the name without its number.
Frames are those of the cameras: the files have no rate.

`joints` are SMPL-X's 55, then landmarks of the skin, of which 66 to 70 are the tips of thumb,
index, middle, ring and little finger of the left hand, 71 to 75 of the right. They say the person's
bones exactly. Hands are 12 principal components on a flat hand, which only the licensed model
expands; without it every finger joint is turned so that the next joint is where `joints` has it
(its turn about the bone is not known).
"""

from __future__ import annotations

import json
from pathlib import Path
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.npy import Npy
from halfphysics.base.npz_objects import NpzObjects
from halfphysics.base.reader_warnings import warn
from halfphysics.body.body import Body
from halfphysics.body.model_files import read_hands
from halfphysics.errors import FileError
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.datasets.assets import find, note
from halfphysics.formats.datasets.fingers_from_joints import fingers_from_joints
from halfphysics.formats.datasets.recorded import add_recorded, of_file
from halfphysics.formats.datasets.shape_from_joints import bones_of, default_like, world_turns
from halfphysics.formats.datasets.size_from_motion import body_by_motion
from halfphysics.formats.datasets.subject import named_model
from halfphysics.formats.format import Format, Options, Source
from halfphysics.formats.motion_builder import motion_of, rotations_of, same_length
from halfphysics.motion import skeleton
from halfphysics.motion.motion import Motion
from halfphysics.motion.skeleton import JOINT_INDEX, N_JOINTS
from halfphysics.results.result import ObjectTrack
from halfphysics.scene.scene import Scene
from halfphysics.simulation.sequence import Sequence

Array = NDArray[np.float64]

NAME = "core4d"
FPS = 15.0
PEOPLE = ("person1_poses.npz", "person2_poses.npz")
_FIELD = "arr_0"
_KEYS = {"global_orient", "transl", "body_pose"}
_HANDS = ("left_hand_pose", "right_hand_pose")
_COMPONENTS = 12
#: Positions and rotations in single precision agree to this [m].
_AGREE = 0.01
#: The object's poses, where its name is in the table beside them.
_POSES, _TABLE = ("smooth_objposes.npy", "aligned_objposes.npy"), "object_metadata.json"

_UNSAID = "nothing says how tall the person is in metres"


def _sniff(source: Source) -> bool:
    if source.is_folder:
        return any((source.path / name).is_file() for name in PEOPLE)
    if source.npz is None or set(source.npz) != {_FIELD}:
        return False
    return source.npz.header(_FIELD)[1].hasobject and _is_person(_fields(source.path, source))


def _is_person(fields: object) -> bool:
    return isinstance(fields, dict) and fields.keys() >= _KEYS


#: Fields of each open file: with its vertices it may have a hundred megabytes.
_KNOWN: WeakKeyDictionary[Source, dict[Path, object]] = WeakKeyDictionary()


def _fields(path: Path, source: Source) -> object:
    known = _KNOWN.setdefault(source, {})
    if path not in known:
        known[path] = NpzObjects(path)[_FIELD]
    return known[path]


def _record(path: Path, source: Source) -> Record:
    if not path.is_file():
        raise FileError(f"{path}: no such file, expected one person of a CORE4D sequence")
    keys = set(NpzObjects(path))
    if _FIELD not in keys:
        raise FileError(f"{path}: found fields {sorted(keys)}, expected '{_FIELD}' of CORE4D")
    fields = _fields(path, source)
    if not isinstance(fields, dict):
        raise FileError(
            f"{path}: field '{_FIELD}': found {type(fields).__name__}, expected a dict of arrays"
        )
    return Record(path, fields)


def _load(source: Source, options: Options) -> Motion:
    if source.is_folder:
        raise FileError(
            f"{source.path}: holds two people: load_sequence reads both, Motion.load "
            f"one: {' or '.join(PEOPLE)} in it"
        )
    return _person(source.path, source, options)[0]


def _person(path: Path, source: Source, options: Options) -> tuple[Motion, Body | None]:
    """One person's motion and body; None: the file does not say their size."""
    record = _record(path, source)
    translation = record.array("transl", None, 3, frames=options.frames)
    root = record.array("global_orient", None, 3, frames=options.frames)
    pose = record.array("body_pose", None, 21, 3, frames=options.frames)
    keys = ["transl", "global_orient", "body_pose", *(k for k in _HANDS if k in record)]
    places = None
    if "joints" in record:
        count = record.shape("joints")[1:2]
        if not count or count[0] < N_JOINTS:
            raise record.error(
                "joints", f"found shape {record.shape('joints')}, expected (N, 127, 3)"
            )
        places = record.array("joints", None, count[0], 3, frames=options.frames)
        keys.append("joints")
    same_length(record.where, {key: len(record.raw(key)) for key in keys})
    rotations = rotations_of({(0,): root, skeleton.BODY_JOINTS: pose})
    model = named_model(options)
    for side, fingers in _hands(record, options, model, places, rotations).items():
        rotations[:, list(side)] = fingers
    motion = motion_of(
        record.where,
        options,
        format=NAME,
        translation=translation,
        rotations=rotations,
        fps=FPS,
        up="y",
        model="smplx",
        gender="neutral",
        betas=_betas(record, options),
    )
    if model is not None:
        folder = model.is_dir()
        body: Body | None = Body.load(
            model,
            motion.betas,
            gender="neutral" if folder else None,
            model="smplx" if folder else None,
        )
    else:
        body = None if places is None else _body(record, places, translation, rotations)
    return motion, body


def _betas(record: Record, options: Options) -> Array | None:
    """One shape for every frame (T, n), or one for all."""
    if "betas" not in record:
        return None
    shape = record.shape("betas")
    if len(shape) != 2:
        return record.array("betas", *shape)
    betas = record.array("betas", None, shape[1])
    return betas if len(betas) == 1 else betas[options.frames]


def _hands(
    record: Record, options: Options, model: Path | None, places: Array | None, rotations: Array
) -> dict[tuple[int, ...], Array]:
    """Rotations (T, 15, 3) of the fingers of each hand, by its joints."""
    sides = {"left": skeleton.LEFT_HAND_JOINTS, "right": skeleton.RIGHT_HAND_JOINTS}
    if model is not None:
        axes = read_hands(model, "neutral" if model.is_dir() else None)[1]
        return {
            joints: (
                record.array(key, None, _COMPONENTS, frames=options.frames) @ axes[k, :_COMPONENTS]
            ).reshape(-1, 15, 3)
            for k, (key, joints) in enumerate(zip(_HANDS, sides.values(), strict=True))
        }
    if places is None:
        if any(np.any(record.raw(key)) for key in _HANDS if key in record):
            warn(
                f"{record.where}: hands of {_COMPONENTS} principal components and no 'joints': the "
                "fingers stay flat. Name the SMPL-X model with model="
            )
        return {}
    turns = world_turns(rotations)
    return {
        joints: fingers_from_joints(side, places, turns[:, JOINT_INDEX[f"{side}_wrist"]])
        for side, joints in sides.items()
    }


def _body(record: Record, places: Array, translation: Array, rotations: Array) -> Body:
    """The free body with the bones that the joints say."""
    bones = bones_of(places[:, :N_JOINTS], rotations)
    off = places[:, 0] - translation
    bones.offsets[0] = np.median(off, axis=0)
    spread = max(bones.spread, float(np.linalg.norm(off - bones.offsets[0], axis=1).max()))
    if spread > _AGREE:
        warn(
            f"{record.where}: field 'joints': positions and rotations disagree by up to "
            f"{spread:.2g} m; the rotations are taken"
        )
    body = default_like(record.where, bones)
    warn(
        f"{record.where}: the default body has the recorded bones: stature {body.stature:.2f} m. "
        "For the person's own shape name the SMPL-X model with model="
    )
    return body


def _load_sequence(source: Source, options: Options) -> Sequence:
    folder = source if source.is_folder else Source(source.path.resolve().parent)
    paths = [folder.path / name for name in PEOPLE if (folder.path / name).is_file()]
    if not source.is_folder and source.path.resolve() not in paths:
        paths = [source.path]
    people = [_person(note(path), source, options) for path in paths]
    lengths = {path.name: len(motion) for path, (motion, _) in zip(paths, people, strict=True)}
    same_length(str(folder.path), lengths)
    scene = Scene()
    tracks = _add_object(folder, options, people[0][0], scene)
    bodies = []
    for path, (motion, body) in zip(paths, people, strict=True):
        own = body if body is not None else body_by_motion(f"{path}: {_UNSAID}", motion, tracks)
        bodies.append(Body.default() if own is None else own)
    motions = tuple(motion for motion, _ in people)
    if len(people) == 1:
        return Sequence(motions[0], scene, bodies[0], recorded=tracks)
    return Sequence(motions, scene, tuple(bodies), recorded=tracks)


def _add_object(
    folder: Source, options: Options, motion: Motion, scene: Scene
) -> dict[str, ObjectTrack]:
    path, name = _object(folder)
    poses = Record(path, {"array": Npy(path).array}).array(
        "array", None, 4, 4, frames=options.frames
    )
    same_length(str(folder.path), {"people": len(motion), path.name: len(poses)})
    kind = name.rstrip("0123456789_")
    files = [f"object_models/{kind}/{name}_m.obj", f"object_models/{name}_m.obj"]
    files += [f"{kind}/{name}_m.obj", f"{kind}/{name}/{name}_m.obj", f"{name}_m.obj"]
    files += ["object_mesh.obj"]
    mesh = find(folder, options, files, f"the mesh of {name!r}")
    with of_file(str(path)):
        track = add_recorded(
            scene,
            name,
            mesh,
            poses[:, :3, 3],
            poses[:, :3, :3],
            where=str(path),
            axes=motion.axes,
            fps=motion.fps,
            options=options,
        )
    return {name: track}


def _object(folder: Source) -> tuple[Path, str]:
    """The file of the object's poses, and the object's name."""
    named = sorted(folder.path.glob("object_poses_*.npy"))
    if len(named) > 1:
        raise FileError(
            f"{folder.path}: found {', '.join(path.name for path in named)}, expected the poses of "
            "one object. Move the others away"
        )
    if named:
        return note(named[0]), named[0].stem.removeprefix("object_poses_")
    found = [path for name in _POSES if (path := folder.path / name).is_file()]
    if not found:
        raise FileError(
            f"{folder.path}: its object is in {_POSES[0]} or object_poses_NAME.npy, neither is "
            "there. Copy it there, or read one person alone with Motion.load"
        )
    table = folder.path / _TABLE
    try:
        said = json.loads(note(table).read_text(encoding="utf-8")) if table.is_file() else {}
    except (OSError, ValueError, RecursionError) as error:
        raise FileError(f"{table}: cannot be read ({error}). Copy it again") from None
    name = said.get("obj_name") if isinstance(said, dict) else None
    if not isinstance(name, str) or not name:
        raise FileError(
            f"{folder.path}: which object it is, is in {_TABLE} ('obj_name'), which does not say "
            "it; or name the file of its poses object_poses_NAME.npy"
        )
    return note(found[0]), name.lower()


FORMAT = Format(
    name=NAME,
    about="CORE4D: two people who carry one object",
    invents="the girth of the people, the twist of fingers, the frame rate (15)",
    expects=f"a folder with {' and '.join(PEOPLE)} ({_FIELD}: a dict) and {_POSES[0]}",
    sniff=_sniff,
    load=_load,
    load_sequence=_load_sequence,
)
