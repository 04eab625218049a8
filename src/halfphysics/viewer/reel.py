"""What changes in a scene from frame to frame, packed for the page's own player.

viser records a scene as a list of messages with times and plays it forwards only: to go back, it
plays all again. A reel has the same messages by frame, so that the player shows any frame at once.

Layout, deflated, then base64:

    u32   length of the header [bytes], little-endian, as all numbers
    ...   header, JSON, filled with spaces to a multiple of 4 bytes
    i32   numbers: multiples of GRAIN, each less the one of the frame before, split into their
          four bytes: first the lowest of all numbers, column by column, then the second, ...
    ...   arrays

The header has `frames`; `columns`, the number of columns; `numbers`, the messages whose `field`
holds the numbers of these `columns` in every frame (poses of bones and nodes; equal columns are
stored once); and `events`, the messages with other values, which change in the frames `at`. A
value {"start", "bytes", "dtype"} is in the arrays.
"""

from __future__ import annotations

import base64
import json
import zlib
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.viewer.bones import GRAIN

Array = NDArray[np.float64]
Message = dict[str, Any]
#: A message without its value, and where its value stands.
Key = tuple[tuple[tuple[str, Any], ...], str]

# Types of messages that change a pose -> the field with its numbers.
_POSES = {
    "SetBonePositionMessage": "position",
    "SetBoneOrientationMessage": "wxyz",
    "SetPositionMessage": "position",
    "SetOrientationMessage": "wxyz",
}
_UPDATE, _VISIBILITY = "SceneNodeUpdateMessage", "SetSceneNodeVisibilityMessage"


class Recording:
    """The messages of a recording of viser, decoded.

    Args:
        data: What a serializer of viser returns.

    Attributes:
        messages: Time [s] and message, in order.
    """

    def __init__(self, data: bytes) -> None:
        import msgspec
        import zstandard

        inner = zstandard.ZstdDecompressor().decompressobj().decompress(data[8:])
        length = int.from_bytes(inner[:8], "little")
        content = msgspec.msgpack.decode(inner[8 : 8 + length])
        self.messages: list[tuple[float, Message]] = content["messages"]
        self._buffers: list[bytes] = []
        start = 8 + length
        for size in content["binaryBufferLengths"]:
            start += -start % 8
            self._buffers.append(inner[start : start + size])
            start += size

    def array(self, value: Any) -> tuple[bytes, str] | None:
        """The bytes and the type of an array in a message; None: the value is no array."""
        if not isinstance(value, dict) or "__binary_index" not in value:
            return None
        return self._buffers[value["__binary_index"]], value["dtype"]


def reel(recording: Recording, frames: int, seconds: float) -> str:
    """A recording as a reel.

    Args:
        recording: Of all that is in the scene at its start, and of what changes then.
        frames: Number of frames.
        seconds: Time from one to the next [s].
    """
    numbers: dict[Key, Array] = {}
    events: dict[Key, dict[int, Any]] = {}
    added: dict[str, Message] = {}
    for time, message in recording.messages:
        frame = round(time / seconds)
        if "props" in message and "name" in message:
            added[message["name"]] = message["props"]
        for key, value in _values(message):
            if key[1] in _POSES.values():
                if key not in numbers:
                    numbers[key] = np.full((frames, len(value)), np.nan)
                numbers[key][frame] = value
            else:
                events.setdefault(key, {})[frame] = value
    fixed = {key for key, values in events.items() if set(values) == {0}}
    header: dict[str, Any] = {"frames": frames, "numbers": [], "events": []}
    columns: dict[bytes, int] = {}
    for key, values in numbers.items():
        whole = np.round(_filled(values, key[1]) / GRAIN).astype("<i4")
        if (whole == whole[0]).all():
            continue
        own = [columns.setdefault(column.tobytes(), len(columns)) for column in whole.T]
        header["numbers"].append({"message": dict(key[0]), "field": key[1], "columns": own})
    header["columns"] = len(columns)
    arrays = _Arrays(recording)
    for key, changes in events.items():
        if key in fixed:
            continue
        changes.setdefault(0, _initial(key, added))
        at = sorted(changes)
        header["events"].append(
            {
                "message": dict(key[0]),
                "field": key[1],
                "at": at,
                "values": [arrays.put(changes[frame]) for frame in at],
            }
        )
    return _packed(header, columns, arrays.data)


def _values(message: Message) -> Iterable[tuple[Key, Any]]:
    """The values that a message sets, each with its key."""
    kind = message["type"]
    rest = dict(message)
    if kind in _POSES and "name" in message:
        value = rest.pop(_POSES[kind])
        yield (tuple(sorted(rest.items())), _POSES[kind]), value
    elif kind == _VISIBILITY:
        value = rest.pop("visible")
        yield (tuple(sorted(rest.items())), "visible"), value
    elif kind == _UPDATE:
        for name, value in rest.pop("updates").items():
            yield (tuple(sorted(rest.items())), f"updates.{name}"), value


def _filled(values: Array, field: str) -> Array:
    """Values of all frames (T, n): where none is sent, the last one stays."""
    if np.isnan(values[0]).any():
        values[0] = (1.0, 0.0, 0.0, 0.0) if field == "wxyz" else 0.0
    known = np.where(np.isnan(values[:, 0]), 0, np.arange(len(values)))
    result: Array = values[np.maximum.accumulate(known)]
    return result


def _initial(key: Key, added: dict[str, Message]) -> Any:
    """The value that a node was added with."""
    if key[1] == "visible":
        return True
    return added[dict(key[0])["name"]][key[1].removeprefix("updates.")]


class _Arrays:
    """The arrays of a reel, each stored once."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        self._starts: dict[bytes, int] = {}
        self.data = bytearray()

    def put(self, value: Any) -> Any:
        """The value as it stands in the header."""
        found = self._recording.array(value)
        if found is None:
            return value
        data, dtype = found
        if data not in self._starts:
            self.data += bytes(-len(self.data) % 8)
            self._starts[data] = len(self.data)
            self.data += data
        return {"start": self._starts[data], "bytes": len(data), "dtype": dtype}


def _packed(header: dict[str, Any], columns: Iterable[bytes], arrays: bytearray) -> str:
    """The reel of a header, columns of whole numbers and arrays."""
    whole = np.frombuffer(b"".join(columns), dtype="<i4").reshape(-1, header["frames"])
    steps = np.diff(whole, axis=1, prepend=np.zeros((len(whole), 1), dtype="<i4"))
    planes = np.ascontiguousarray(steps).reshape(-1, 1).view(np.uint8).T
    text = json.dumps(header, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    inner = len(text).to_bytes(4, "little") + text + planes.tobytes() + bytes(arrays)
    return base64.b64encode(zlib.compress(inner, 6)).decode("ascii")
