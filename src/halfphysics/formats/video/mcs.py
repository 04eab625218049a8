"""`.mcs` of Meshcapade and PromptHMR: people and a camera in one glTF document; SMPL-X, y-up.

`scenes[0].extensions.MC_scene_description` has `num_frames` and `smpl_bodies`, each with
`frame_presence` [first, after the last) and `bufferView`, the bytes of a whole `.smpl` file
(`smpl_codec`) in a base64 data URI. The camera is not read. Other files are never opened.
"""

from __future__ import annotations

import base64
import binascii
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from halfphysics.base import json_files
from halfphysics.base.npz import Npz
from halfphysics.errors import FileError
from halfphysics.formats import smpl_codec
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.estimates import Seen, seen, tracked
from halfphysics.formats.format import Options, Source
from halfphysics.formats.motion_builder import lost_model
from halfphysics.formats.written_people import Written
from halfphysics.motion.motion import Motion

NAME = "mcs"
_EXTENSION, _BODIES = "MC_scene_description", "smpl_bodies"
_DATA = "base64,"
#: Frames of a video are numbered below this.
_MOST_FRAMES = 2**31
_URI = f"data:application/octet-stream;{_DATA}"


def _scene(source: Source) -> dict[str, Any] | None:
    """The extension of the first scene; None: there is none."""
    document = source.document
    scenes = document.get("scenes") if isinstance(document, dict) else None
    first = scenes[0] if isinstance(scenes, list) and scenes else None
    extensions = first.get("extensions") if isinstance(first, dict) else None
    found = extensions.get(_EXTENSION) if isinstance(extensions, dict) else None
    return found if isinstance(found, dict) else None


def _sniff(source: Source) -> bool:
    return not source.is_folder and _scene(source) is not None


def _people(source: Source) -> dict[str, Seen]:
    scene = Record(source.path, _scene(source) or {})
    bodies = scene.raw(_BODIES, "(a list of people)")
    if not isinstance(bodies, list):
        raise scene.error(_BODIES, f"found {type(bodies).__name__}, expected a list of people")
    found = {}
    for number, body in enumerate(bodies):
        where = f"{source.path}: {_BODIES}[{number}]"
        if not isinstance(body, dict):
            raise FileError(f"{where}: found {type(body).__name__}, expected an object")
        npz = Npz(where, _bytes(where, source.document, body))
        shape = npz.header("bodyTranslation")[0] if "bodyTranslation" in npz else (0, 3)
        if len(shape) != 2 or shape[1] != 3:
            raise FileError(f"{where}: bodyTranslation: found shape {shape}, expected (T, 3)")
        rows = shape[0]
        first = body.get("frame_presence", [0, rows])
        start = first[0] if isinstance(first, list) and first else None
        whole = isinstance(start, int) and not isinstance(start, bool)
        if not (isinstance(start, int) and whole and 0 <= start < _MOST_FRAMES):
            raise FileError(
                f"{where}: frame_presence: found {first!r}, expected [first, after the last]"
            )
        found[str(number + 1)] = start + np.arange(max(rows, 1)), npz
    return seen(source.path, found)


def _bytes(where: str, document: dict[str, Any], body: dict[str, Any]) -> bytes:
    """The bytes of a buffer view."""
    try:
        view = document["bufferViews"][body["bufferView"]]
        uri = document["buffers"][view["buffer"]]["uri"]
        start, size = int(view.get("byteOffset", 0)), int(view["byteLength"])
        head, _, text = uri.partition(_DATA)
    except (
        AttributeError, IndexError, KeyError, OverflowError, TypeError, ValueError,
    ) as error:  # fmt: skip
        raise FileError(
            f"{where}: its bytes are not found ({type(error).__name__}: {error}), expected "
            "bufferView, bufferViews and buffers with a base64 data URI"
        ) from None
    if not head.startswith("data:"):
        raise FileError(
            f"{where}: its buffer is in another file, expected a base64 data URI. Other files are "
            "not read: load the .smpl file itself"
        )
    try:
        data = base64.b64decode(text, validate=True)
    except (binascii.Error, ValueError) as error:
        raise FileError(
            f"{where}: its buffer is no base64 ({error}). Copy the file again"
        ) from None
    if min(start, size) < 0 or len(data) < start + size:
        raise FileError(f"{where}: found {len(data)} bytes, expected {start + size}. Copy it again")
    return data[start : start + size]


def _read(who: Seen, options: Options) -> Motion:
    npz = who.record.fields
    if not isinstance(npz, Npz):
        raise FileError(f"{who.record.where}: not a file of the SMPL codec")
    first = int(np.min(np.asarray(who.frames)))
    first += options.frames.indices(len(np.asarray(who.frames)))[0]
    motion = smpl_codec.motion_in(who.record.where, npz, options)
    if motion.origin is None:
        return motion
    fields = {**motion.origin.fields, "first": first}
    return replace(motion, origin=replace(motion.origin, format=NAME, fields=fields))


def _write(people: Mapping[str, Written], path: Path) -> None:
    """People in the scene of a camera that stands still."""
    bodies: list[dict[str, Any]] = []
    buffers: list[dict[str, Any]] = []
    for number, person in enumerate(people.values()):
        data = smpl_codec.content_of(person.motion, NAME)
        text = base64.b64encode(data).decode()
        buffers.append({"byteLength": len(data), "uri": f"{_URI}{text}"})
        presence = [int(person.frames[0]), int(person.frames[-1]) + 1]
        bodies.append({"frame_presence": presence, "bufferView": number})
    views = [
        {"buffer": number, "byteOffset": 0, "byteLength": buffer["byteLength"]}
        for number, buffer in enumerate(buffers)
    ]
    scene = {"num_frames": max(own["frame_presence"][1] for own in bodies), _BODIES: bodies}
    camera = {"yfov": 0.8, "znear": 0.01}
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0], "extensions": {_EXTENSION: scene}}],
        "nodes": [{"name": "RootNode", "children": [1]}, {"name": "AnimatedCamera", "camera": 0}],
        "cameras": [{"type": "perspective", "perspective": camera}],
        "bufferViews": views,
        "buffers": buffers,
        "extensionsUsed": [_EXTENSION],
    }
    json_files.write(path, document)


FORMAT = tracked(
    NAME,
    "glTF JSON with MC_scene_description: smpl_bodies, each a .smpl file in base64",
    about="people and a camera of PromptHMR and Meshcapade",
    invents="fingers, where it has none",
    sniff=_sniff,
    people=_people,
    read=_read,
    write=_write,
    suffix=".mcs",
    loses=lost_model,
)
