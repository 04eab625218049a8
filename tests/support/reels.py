"""Reads the data of a page and its reel, by the layout that viewer/reel.py describes."""

from __future__ import annotations

import base64
import json
import re
import zlib

import numpy as np

from halfphysics.viewer.bones import GRAIN


def data_of(path):
    """What a page gives its script."""
    text = path.read_text(encoding="utf-8")
    return json.loads(re.search(r'id="hp-data">(.*?)</script>', text, re.DOTALL)[1])


def unpacked(text):
    """Header, numbers (columns, frames) and arrays of a reel."""
    inner = zlib.decompress(base64.b64decode(text))
    length = int.from_bytes(inner[:4], "little")
    assert length % 4 == 0
    header = json.loads(inner[4 : 4 + length])
    count = header["columns"] * header["frames"]
    rest = inner[4 + length :]
    planes = [np.frombuffer(rest[k * count : (k + 1) * count], dtype="u1") for k in range(4)]
    steps = sum(plane.astype(np.uint32) << 8 * k for k, plane in enumerate(planes)).view("<i4")
    steps = steps.reshape(header["columns"], header["frames"])
    return header, np.cumsum(steps, axis=1) * GRAIN, rest[4 * count :]


def poses(text, kind):
    """(name, bone) -> values of every frame (T, n), of the messages of a kind."""
    header, numbers, _ = unpacked(text)
    return {
        (e["message"]["name"], e["message"].get("bone_index")): numbers[e["columns"]].T
        for e in header["numbers"]
        if e["message"]["type"] == kind
    }
