"""GRAB npz: a person who handles an object; z-up, 120 fps.

`gender, sbj_id, obj_name, motion_intent, framerate, n_frames, n_comps`, and dicts that numpy
pickled: `body {params, vtemp}` with `transl, global_orient (T, 3) body_pose (T, 63) jaw_pose,
leye_pose, reye_pose (T, 3) left_hand_pose, right_hand_pose (T, n_comps) fullpose (T, 165)`;
`object {params, object_mesh}` and `table {params, table_mesh}` with `transl, global_orient (T, 3)`.

Hands are the first `n_comps` principal components about the mean hand of SMPL-X; `fullpose` has
the full rotations, on a flat hand. The body has no betas but the subject's own template, `vtemp`.
Vertices of object and table are `v @ R + t`: the world rotation is R transposed.
"""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.npz_objects import NpzObjects
from halfphysics.base.reader_warnings import warn
from halfphysics.body.model_files import read_hands
from halfphysics.errors import InputError
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.datasets.assets import ends, find
from halfphysics.formats.datasets.recorded import add_recorded, of_file
from halfphysics.formats.datasets.subject import model_names, named_model, subject_body
from halfphysics.formats.format import Format, Options, Source
from halfphysics.formats.gender_names import gender_named
from halfphysics.formats.motion_builder import motion_of, own_fields, rotations_of, same_length
from halfphysics.geometry.mesh_files import load_mesh
from halfphysics.motion.motion import Motion
from halfphysics.motion.smplx_names import PARTS
from halfphysics.results.result import ObjectTrack
from halfphysics.scene.scene import Scene
from halfphysics.simulation.sequence import Sequence

Array = NDArray[np.float64]

NAME = "grab"
_KEYS = {"body", "lhand", "rhand", "object", "sbj_id", "obj_name", "motion_intent"}
_ENOUGH = 3
_NAMES = ("sbj_id", "obj_name", "motion_intent")
_FULL = "fullpose"
_HANDS = ("left_hand_pose", "right_hand_pose")
_FINGERS = {"left_hand_pose": slice(75, 120), "right_hand_pose": slice(120, 165)}
_COMPONENTS = 45
# Single precision and other model releases differ by less than this, another mean hand by more.
_SAME_HANDS = 0.01
#: A table that moves by less than this is static [m].
STILL = 2e-3


def _sniff(source: Source) -> bool:
    return source.npz is not None and len(_KEYS & set(source.npz)) >= _ENOUGH


def _record(source: Source) -> Record:
    return Record(source.path, NpzObjects(source.path))


def _part(record: Record, key: str) -> Record:
    """One of the dicts in the file."""
    part = record.raw(key, "(a dict with params)")
    if not isinstance(part, dict):
        raise record.error(key, f"found {type(part).__name__}, expected a dict with params")
    return Record(f"{record.where}, {key}", part)


def _params(part: Record) -> Record:
    """The parameters of a part."""
    params = part.raw("params", "(a dict of arrays)")
    if not isinstance(params, dict):
        raise part.error("params", f"found {type(params).__name__}, expected a dict of arrays")
    return Record(f"{part.where}.params", params)


def _rows(params: Record, key: str, width: int, total: int, options: Options) -> Array:
    """A parameter (T, width) of the requested frames, of a clip with `total` frames."""
    rows = params.array(key, None, width, frames=options.frames)
    same_length(params.where, {"n_frames": total, key: len(params.raw(key))})
    return rows


def _load(source: Source, options: Options) -> Motion:
    if options.hands == "mean":
        raise InputError(
            f"hands: found 'mean', but {source.path} says itself what its fingers are: components "
            "about the mean hand. Leave it out"
        )
    record = _record(source)
    total = int(record.number("n_frames", above=0.0))
    gender = options.gender or gender_named(record.text("gender"))
    params = _params(_part(record, "body"))
    parts = {
        joints: _rows(params, key, 3 * len(joints), total, options)
        for key, joints in PARTS.items()
        if key not in _HANDS
    }
    hands = _hands(source, options, record, params, gender, total)
    return motion_of(
        record.where,
        options,
        format=NAME,
        translation=_rows(params, "transl", 3, total, options),
        rotations=rotations_of({**parts, **{PARTS[key]: part for key, part in hands.items()}}),
        fps=options.fps or record.number("framerate", above=0.0),
        up="z",
        model="smplx",
        gender=gender,
        fields={
            **{key: record.text(key) for key in _NAMES if key in record},
            "template": _part(record, "body").text("vtemp"),
        },
    )


def _hands(
    source: Source, options: Options, record: Record, params: Record, gender: str, total: int
) -> dict[str, Array]:
    """Fingers (T, 45) of both hands on a flat hand."""
    count = int(record.number("n_comps", above=0.0, below=_COMPONENTS + 1))
    components = {key: _rows(params, key, count, total, options) for key in _HANDS}
    unfolded = None
    if _FULL in params:
        full = _rows(params, _FULL, 165, total, options)
        unfolded = {key: full[:, columns] for key, columns in _FINGERS.items()}
        if named_model(options) is None:
            return unfolded
    model = named_model(options) or find(
        source,
        options,
        model_names(gender),
        f"an SMPL-X model (model=, for example model='SMPLX_{gender.upper()}.npz') for its hands "
        f"of {count} principal components",
    )
    mean, axes = read_hands(model, gender if model.is_dir() else None)
    hands = {key: mean[i] + components[key] @ axes[i, :count] for i, key in enumerate(_HANDS)}
    if unfolded is not None:
        off = max(float(np.abs(hands[key] - unfolded[key]).max(initial=0.0)) for key in _HANDS)
        if off > _SAME_HANDS:
            warn(
                f"{record.where}: the hands by {model} differ by up to {off:.2g} rad from those in "
                f"field '{_FULL}': another model than the file was made with? Without model= "
                f"those of '{_FULL}' are taken"
            )
    return hands


def _load_sequence(source: Source, options: Options) -> Sequence:
    motion = _load(source, options)
    record = _record(source)
    total = int(record.number("n_frames", above=0.0))
    scene = Scene()
    tracks: dict[str, ObjectTrack] = {}
    if "table" in record:
        with of_file(record.where):
            tracks.update(_add_table(source, options, scene, _part(record, "table"), motion, total))
    name = record.text("obj_name")
    item = _part(record, "object")
    places, turns = _poses(item, total, options)
    mesh = find(source, options, ends(item.text("object_mesh")), f"the mesh of {name!r}")
    with of_file(record.where):
        tracks[name] = add_recorded(
            scene,
            name,
            mesh,
            places,
            turns,
            where=record.where,
            axes=motion.axes,
            fps=motion.fps,
            options=options,
        )
    template = ends(own_fields(motion)["template"])
    body = subject_body(source, options, motion=motion, tracks=tracks, template=template)
    return Sequence(motion, scene, body, recorded=tracks)


def _poses(item: Record, total: int, options: Options) -> tuple[Array, Array]:
    """Positions (T, 3) and rotations (T, 3, 3) for column vectors; the file's are for rows."""
    params = _params(item)
    turns = _rows(params, "global_orient", 3, total, options)
    return _rows(params, "transl", 3, total, options), rot.rotvec_to_matrix(-turns)


def _add_table(
    source: Source, options: Options, scene: Scene, table: Record, motion: Motion, total: int
) -> dict[str, ObjectTrack]:
    """Add the table as a static, or as a kinematic body if it was pushed or lifted."""
    places, turns = _poses(table, total, options)
    places = options.unit * places
    mesh = find(source, options, ends(table.text("table_mesh")), "the mesh of the table")
    solid, _ = load_mesh(mesh, up="z")
    low, high = solid.vertices.min(axis=0), solid.vertices.max(axis=0)
    box = np.array(list(itertools.product(*zip(low, high, strict=True))))
    moved = np.einsum("tij,kj->tki", turns, box) + places[:, None]
    quaternions = rot.from_matrix(motion.axes @ turns)
    if np.linalg.norm(moved - moved[:1], axis=2).max() < STILL:
        scene.add_static(
            "table", mesh, position=motion.axes @ places[0], quaternion=quaternions[0], up="z"
        )
        return {}
    positions = places @ motion.axes.T
    scene.add_moving("table", mesh, positions, quaternions, fps=motion.fps, up="z")
    return {"table": ObjectTrack(position=positions, quaternion=quaternions)}


FORMAT = Format(
    name=NAME,
    about="GRAB: people who grasp objects at a table",
    invents="the person's shape: a template instead",
    expects="npz with body, object {params}, gender, sbj_id, obj_name, n_comps",
    sniff=_sniff,
    load=_load,
    load_sequence=_load_sequence,
)
