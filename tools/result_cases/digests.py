"""SHA-256 of values: an array by its dtype, shape and bytes, everything else by type and content."""

from __future__ import annotations

import hashlib
import struct
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

import halfphysics as hp

#: Digits kept of the hash of one value of a case; the case itself keeps all of them.
SHORT = 12

#: Columns of `Result.contacts` and of `Result.inside`, and those of one frame of a simulator.
CONTACTS = (
    ["frame", "person", "part", "other", "position", "normal", "impulse", "subject", "other_part"],
    ["frame", "person", "part", "subject", "other", "depth"],
)
TOUCHES = (
    ["person", "part", "subject", "other", "other_part", "position", "normal", "impulse"],
    ["person", "part", "subject", "other", "depth"],
)
#: What results refer to and do not contain.
_REFERRED = (hp.Scene, hp.Body, hp.Settings, hp.Result)


def digest(value: Any) -> str:
    """The hash of a value, 64 hexadecimal digits.

    Raises:
        TypeError: A value of a type whose content is not known here.
    """
    state = hashlib.sha256()
    _feed(state, value)
    return state.hexdigest()


def digests(values: Mapping[str, Any]) -> tuple[str, dict[str, str]]:
    """The hash of a case, and the first digits of those of its values."""
    each = {name: digest(value) for name, value in values.items()}
    return digest(each), {name: text[:SHORT] for name, text in each.items()}


def _feed(state: Any, value: Any) -> None:
    if isinstance(value, np.ndarray | np.generic):
        array = np.ascontiguousarray(value)
        if array.dtype.hasobject:
            raise TypeError("an array of objects has no bytes to hash")
        state.update(f"array {array.dtype.str} {np.shape(value)} ".encode() + array.tobytes())
    elif value is None or isinstance(value, bool | int):
        state.update(f"{type(value).__name__} {value} ".encode())
    elif isinstance(value, float):
        state.update(b"float " + struct.pack("<d", value))
    elif isinstance(value, str | bytes):
        raw = value.encode() if isinstance(value, str) else value
        state.update(f"{type(value).__name__} {len(raw)} ".encode() + raw)
    elif isinstance(value, Mapping):
        state.update(f"mapping {len(value)} ".encode())
        for key, one in value.items():
            _feed(state, str(key))
            _feed(state, one)
    elif isinstance(value, tuple | list):
        state.update(f"sequence {len(value)} ".encode())
        for one in value:
            _feed(state, one)
    elif is_dataclass(value) and not isinstance(value, type):
        _feed(state, _content(value))
    else:
        raise TypeError(f"no way to hash {type(value).__name__}")


def _content(value: Any) -> dict[str, Any]:
    """The public fields of a dataclass, without the scenes, bodies and results it refers to."""
    named = ((f.name, getattr(value, f.name)) for f in fields(value) if not f.name.startswith("_"))
    return {name: one for name, one in named if not isinstance(one, _REFERRED)}


def motion_values(motion: hp.Motion) -> tuple[Any, ...]:
    """What a motion says."""
    return motion.translation, motion.rotations, motion.fps, motion.betas, motion.axes


def result_values(result: hp.Result) -> dict[str, Any]:
    """What a simulation found out, by name."""
    values: dict[str, Any] = {
        "names": result.names,
        "motion": [motion_values(person.motion) for person in result.people],
        "torque": [person.torque for person in result.people],
        "objects": {n: (t.position, t.quaternion) for n, t in result.objects.items()},
        "joints": result.joints,
        "contacts": _columns(result.contacts, CONTACTS[0]),
        "inside": _columns(result.inside, CONTACTS[1]),
        "clearance": result.clearance,
        "lost_time": result.lost_time,
        "diagnostics": result.diagnostics,
    }
    if result.substeps is not None:
        tracks = result.substeps.objects
        values["substeps"] = [motion_values(motion) for motion in result.substeps.motions]
        values["substep_objects"] = {n: (t.position, t.quaternion) for n, t in tracks.items()}
    return values


def frame_values(frame: Any) -> dict[str, Any]:
    """What one step of a simulator found out, by name."""
    return {
        "poses": [(pose.translation, pose.rotations) for pose in frame.poses],
        "torques": frame.torques,
        "objects": frame.objects,
        "joints": frame.joints,
        "contacts": _columns(frame.contacts, TOUCHES[0]),
        "inside": _columns(frame.inside, TOUCHES[1]),
        "clearance": (frame.clearance, frame.lost_time),
        "diagnostics": frame.diagnostics,
        "substeps": frame.substeps,
    }


def frames_values(frames: list[Any]) -> dict[str, Any]:
    """What all steps of a simulator found out, by name."""
    each = [frame_values(frame) for frame in frames]
    return {name: [one[name] for one in each] for name in each[0]}


def _columns(table: Any, names: list[str]) -> dict[str, Any]:
    return {name: getattr(table, name) for name in names}
