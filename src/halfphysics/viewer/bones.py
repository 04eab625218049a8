"""Fast transfer of skinned poses to a browser: the only module that uses viser's internals.

viser has a setter for every bone and value; each checks, compares, locks and wakes the server's
thread, and sends every number as eight bytes. A person and a ghost need 220 setters per update,
about 12 ms with a browser connected. Here a pose becomes its messages in one step: rounded numbers
of four bytes, only for bones that moved. The browser gets viser's own messages. If viser's
internals differ from those expected (`_expected`), the public setters are used.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Positions [m] and quaternions are rounded to multiples of this: an invisible 0.1 mm.
GRAIN = 2.0**-13

# (viser's message, its field, count of numbers)
_KINDS = (("SetBonePositionMessage", "position", 3), ("SetBoneOrientationMessage", "wxyz", 4))
_FLOAT32 = 0xCA  # msgpack's type byte of a four-byte float
_MAX_BONES = 128  # msgpack packs integers below this in one byte
# viser sends at most 128 queued messages at once, which would tear a pose in two for a moment.
_WHOLE = 4096


class Bones:
    """The bones of skinned meshes that share one pose.

    Args:
        handles: Results of `server.scene.add_mesh_skinned`, one or several with the same bones.
        fast: Send without viser's setters, if possible.

    Attributes:
        fast: Whether poses are sent without viser's setters.
    """

    def __init__(self, handles: Sequence[Any], *, fast: bool = True) -> None:
        self._handles = tuple(handles)
        self._sent: Array | None = None
        self._writers: list[_Writer] = []
        if fast and _expected(self._handles[0]):
            self._writers = [_Writer(handle) for handle in self._handles]
        self.fast = bool(self._writers)

    def __len__(self) -> int:
        """Number of bones."""
        return len(self._handles[0].bones)

    def send(self, positions: Array, quaternions: Array) -> int:
        """Queue a pose; inside `server.atomic()` it is sent as a whole.

        Args:
            positions: Positions of the bones in the frame of the mesh (B, 3) [m].
            quaternions: Unit, wxyz (B, 4).

        Returns:
            Number of bones that moved.
        """
        pose = np.concatenate([positions, quaternions], axis=1)
        pose = np.round(pose * (1.0 / GRAIN))
        if self._sent is None:
            moved = np.ones((len(pose), 2), dtype=bool)
        else:
            # A quaternion and its negative are one rotation: keep the sign of the last one.
            turned = np.einsum("ij,ij->i", pose[:, 3:], self._sent[:, 3:]) < 0.0
            pose[turned, 3:] *= -1.0
            differs = pose != self._sent
            moved = np.stack([differs[:, :3].any(axis=1), differs[:, 3:].any(axis=1)], axis=1)
        self._sent = pose
        values = pose * GRAIN
        if self._writers:
            for writer in self._writers:
                writer.queue(values, moved)
        else:
            for handle in self._handles:
                _set(handle, values, moved)
        return int(moved.any(axis=1).sum())


def _set(handle: Any, values: Array, moved: NDArray[np.bool_]) -> None:
    """Send a pose with viser's public setters."""
    for bone, value, (position, turn) in zip(handle.bones, values, moved, strict=True):
        if position:
            bone.position = value[:3]
        if turn:
            bone.wxyz = value[3:]


class _Writer:
    """Converts poses of one mesh to viser's messages."""

    def __init__(self, handle: Any) -> None:
        from viser import _messages

        api = handle.bones[0]._impl.mesh_impl.api
        self._interface = api._websock_interface
        buffer = self._interface.get_message_buffer()
        buffer.max_window_size = max(buffer.max_window_size, _WHOLE)
        self._node = handle.bones[0]._impl.mesh_impl
        self._kinds = []
        for (name, _, count), columns in zip(_KINDS, (slice(0, 3), slice(3, 7)), strict=True):
            plain = getattr(_messages, name)
            prototypes = []
            for bone in range(len(handle.bones)):
                message = plain(handle.bones[0]._impl.name, bone, (0.0,) * count)
                message.owner = api._owner_id
                prototypes.append(message)
            table = np.stack([np.frombuffer(_packed(m), dtype=np.uint8) for m in prototypes])
            slots = table.shape[1] - 5 * count + 1 + 5 * np.arange(count)[:, None] + np.arange(4)
            keys = [(m.redundancy_key(), m.entity_state_key()) for m in prototypes]
            self._kinds.append((table, slots.ravel(), columns, keys, _quick(plain)))

    def queue(self, values: Array, moved: NDArray[np.bool_]) -> None:
        """Queue the bones that moved."""
        if self._node.removed:
            raise RuntimeError("a pose for a mesh that was removed from the scene")
        push = self._interface.queue_message
        for k, (table, slots, columns, keys, message) in enumerate(self._kinds):
            bones = np.nonzero(moved[:, k])[0]
            if not len(bones):
                continue
            rows = table[bones]
            numbers = np.ascontiguousarray(values[bones, columns], dtype=">f4")
            rows[:, slots] = numbers.view(np.uint8).reshape(len(bones), -1)
            data, width = rows.tobytes(), rows.shape[1]
            for at, bone in enumerate(bones.tolist()):
                push(message(data[at * width : (at + 1) * width], *keys[bone]))


def _packed(message: Any) -> bytes:
    """A viser message, packed with its numbers last, four bytes each."""
    import msgspec

    content = message.as_serializable_dict()
    field = next(field for _, field, _ in _KINDS if field in content)
    numbers = content.pop(field)
    head = msgspec.msgpack.encode({**content, field: ()})
    # An empty list is one byte, 0x90; the head of a short list is one byte, 0x90 + its length.
    floats = b"".join(bytes([_FLOAT32]) + np.array(n, dtype=">f4").tobytes() for n in numbers)
    return head[:-1] + bytes([0x90 + len(numbers)]) + floats


def _quick(plain: type) -> type:
    """A class of packed messages that viser treats as messages of class `plain`."""
    import msgspec

    class _Quick(plain):  # type: ignore[misc]
        def __init__(self, data: bytes, redundancy: str, entity: tuple[str, str]) -> None:
            self._data = data
            self._redundancy = redundancy
            self._entity = entity

        def as_serializable_dict(self, binary_buffers: Any = None) -> Any:
            return msgspec.Raw(self._data)

        def redundancy_key(self) -> str:
            return self._redundancy

        def entity_state_key(self) -> tuple[str, str]:
            return self._entity

    return _Quick


def _expected(handle: Any) -> bool:
    """Whether viser has the internals that `_Writer` uses, and decodes our messages as its own."""
    try:
        import msgspec
        from viser import _messages

        state = handle.bones[0]._impl
        if len(handle.bones) > _MAX_BONES or state.mesh_impl.removed:
            return False
        interface = state.mesh_impl.api._websock_interface
        if not callable(interface.queue_message):
            return False
        if not isinstance(interface.get_message_buffer().max_window_size, int):
            return False
        for name, field, count in _KINDS:
            kind = getattr(_messages, name)
            fields = [f.name for f in dataclasses.fields(kind)]
            if fields != ["name", "bone_index", field, "owner"]:
                return False
            message = kind(state.name, 1, tuple(0.25 * k - 0.5 for k in range(count)))
            message.owner = state.mesh_impl.api._owner_id
            quick = _quick(kind)(_packed(message), message.redundancy_key(), ())
            read, theirs = (
                msgspec.msgpack.decode(msgspec.msgpack.encode([m.as_serializable_dict([])]))
                for m in (quick, message)
            )
            if read != theirs:
                return False
    except (AttributeError, ImportError, TypeError, ValueError, StopIteration):
        return False
    return True
