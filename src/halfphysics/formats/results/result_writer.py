"""Writes result files; docs/result-files.md describes the keys."""

from __future__ import annotations

import json
import logging
import os
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.npz import write_npz
from halfphysics.base.stopwatch import Stopwatch
from halfphysics.baselines.options import options_of
from halfphysics.body.soft_skin import SoftSkin
from halfphysics.formats.amass import smpl as amass_smpl
from halfphysics.formats.amass import smplh as amass_smplh
from halfphysics.formats.amass import smplx as amass_smplx
from halfphysics.formats.results.keys import (
    BREACHES,
    CONTACT,
    DIAGNOSTICS,
    HOLD,
    INSIDE,
    JOINT,
    OBJECT,
    SOFT,
    SUBSTEPS,
    VERSION,
    VERSION_KEY,
    person_prefix,
)
from halfphysics.motion.adapted_hold import AdaptedHold
from halfphysics.results.records import BodyRecord, SceneRecord
from halfphysics.results.result import ObjectTrack, PersonResult, Result
from halfphysics.results.table import Table
from halfphysics.settings import Settings

logger = logging.getLogger(__name__)

Fields = dict[str, NDArray[Any]]

_LAYOUTS = {
    "smplx": amass_smplx.LAYOUT,
    "smplh": amass_smplh.LAYOUT,
    "smpl": amass_smpl.LAYOUT,
}


def save_result(result: Result, path: str | os.PathLike[str]) -> None:
    """Implements `Result.save`; see there."""
    clock = Stopwatch(logger)
    write_npz(path, result_fields(result))
    clock.done("saved %s, %d frames", path, len(result))


def result_fields(result: Result) -> Fields:
    """The arrays of a result file, by key."""
    from halfphysics import __version__

    fields: Fields = dict(_on_top(result.people[0]))
    fields |= _track_fields("", result.objects)
    fields |= {f"{JOINT}{name}": values for name, values in result.joints.items()}
    fields |= _columns(CONTACT, result.contacts)
    if len(result.inside):
        fields |= _columns(INSIDE, result.inside)
    if len(result.breaches):
        fields |= _columns(BREACHES, result.breaches)
    if result.soft_contacts is not None:
        fields |= _small(_columns(SOFT, result.soft_contacts))
    people = []
    for index, person in enumerate(result.people):
        fields |= _person_fields(person_prefix(index), person)
        people.append(_person_document(person))
    scene = vars(result)["_scene"]
    record_of_scene = scene if isinstance(scene, SceneRecord) else SceneRecord.of(result.scene)
    fields |= {
        "meta/clearance": result.clearance,
        "meta/lost_time": result.lost_time,
        "meta/fps": np.array(result.fps),
        "meta/names": np.array(result.names, dtype=np.str_),
        "meta/settings": _json(settings_document(result.settings)),
        "meta/scene": _json(record_of_scene.document),
        "meta/people": _json(people),
        "meta/written_by": np.array(f"halfphysics {__version__}"),
        VERSION_KEY: np.array(VERSION),
    }
    for name, values in result.diagnostics.items():
        fields[f"{DIAGNOSTICS}{name}"] = values
    if result.substeps is not None:
        for index, motion in enumerate(result.substeps.motions):
            fields[f"{SUBSTEPS}person/{index}/translation"] = motion.translation
            fields[f"{SUBSTEPS}person/{index}/rotations"] = motion.rotations
        fields[f"{SUBSTEPS}fps"] = np.array(result.substeps.motions[0].fps)
        fields |= _track_fields(SUBSTEPS, result.substeps.objects)
    return fields


def _person_fields(prefix: str, person: PersonResult) -> Fields:
    fields: Fields = {
        f"{prefix}translation": person.motion.translation,
        f"{prefix}rotations": person.motion.rotations,
        f"{prefix}reference_translation": person.reference.translation,
        f"{prefix}reference_rotations": person.reference.rotations,
    }
    if person.reference.stiffness_scale is not None:
        fields[f"{prefix}stiffness_scale"] = person.reference.stiffness_scale
    if person.reference.recorded is not None:
        fields[f"{prefix}recorded_translation"] = person.recorded.translation
        fields[f"{prefix}recorded_rotations"] = person.recorded.rotations
    for k, hold in enumerate(person.reference.holds):
        fields[f"{prefix}{HOLD}{k}/position"] = hold.position
        fields[f"{prefix}{HOLD}{k}/quaternion"] = hold.quaternion
    if person.torque is not None:
        fields[f"{prefix}torque"] = person.torque
    if person.corrected is not None and person.corrected.any():
        fields[f"{prefix}corrected"] = person.corrected
    frames = np.arange(len(person.motion)) / person.motion.fps
    if person.clock is not None and (person.clock != frames).any():
        fields[f"{prefix}clock"] = person.clock
    return fields


def _person_document(person: PersonResult) -> dict[str, Any]:
    body = vars(person)["_body"]
    record = body if isinstance(body, BodyRecord) else BodyRecord.of(body)
    motion, holds = person.motion, person.reference.holds
    return {
        "name": person.name,
        "gender": motion.gender,
        "model": motion.model,
        "betas": None if motion.betas is None else motion.betas.tolist(),
        "axes": motion.axes.tolist(),
        "body": dict(record.data),
        **({"holds": [_hold_document(hold) for hold in holds]} if holds else {}),
    }


def _hold_document(hold: AdaptedHold) -> dict[str, Any]:
    """A hold without the record of the thing."""
    return {
        "object": hold.object,
        "parts": list(hold.parts),
        "first": hold.first,
        "last": hold.last,
        "force": hold.force,
        "moved": list(hold.moved),
    }


def _columns(prefix: str, table: Table) -> Fields:
    return {f"{prefix}{name}": getattr(table, name) for name in table.columns()}


def _small(fields: Fields) -> Fields:
    """Arrays in half the size, where that keeps every number."""
    halves = {"f": np.float32, "i": np.int32}
    smaller = {key: array.astype(halves[array.dtype.kind]) for key, array in fields.items()}
    return {k: s if np.array_equal(s, fields[k]) else fields[k] for k, s in smaller.items()}


def _track_fields(prefix: str, tracks: Mapping[str, ObjectTrack]) -> Fields:
    fields: Fields = {}
    for name, track in tracks.items():
        fields[f"{prefix}{OBJECT}{name}/position"] = track.position
        fields[f"{prefix}{OBJECT}{name}/quaternion"] = track.quaternion
    return fields


def _on_top(person: PersonResult) -> Fields:
    """The keys of the AMASS file that the motion came from, or AMASS keys for its model."""
    motion = person.motion
    own = motion.origin.format if motion.origin is not None else None
    by_name: Mapping[str | None, Any] = {layout.name: layout for layout in _LAYOUTS.values()}
    if own not in by_name and not np.array_equal(motion.axes, np.eye(3)):
        motion = motion.rebased(person.body)
    result: Fields = by_name.get(own, _LAYOUTS[motion.model]).encode(motion)
    return result


def _json(data: Any) -> NDArray[Any]:
    return np.array(json.dumps(data, ensure_ascii=False, sort_keys=False, allow_nan=False))


def settings_document(settings: Settings) -> dict[str, Any]:
    """Settings as plain data, as files have them."""
    values = options_of(settings)
    skin = values.pop("soft_skin")
    if skin is not False:
        values["soft_skin"] = skin.document if isinstance(skin, SoftSkin) else skin
    return {k: dict(v) if isinstance(v, Mapping) else v for k, v in values.items()}
