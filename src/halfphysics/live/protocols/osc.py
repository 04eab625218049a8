"""OSC 1.0: messages and bundles as bytes, and bytes as messages.

A message is an address, a string of types and the arguments, each a multiple of four bytes long,
big-endian. A bundle is ``#bundle``, a time and elements with their sizes: messages or bundles.
Read are the types i, f, s, b of OSC 1.0 and the usual h, d, t, S, c, r, m, T, F, N, I; written are
i, f, s, b, T and F.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from halfphysics.live.protocols.malformed import Malformed

#: An OSC bundle's time that means "now".
IMMEDIATELY = 1
#: Largest number of messages that are read from one packet, and of bundles within bundles.
MAX_MESSAGES, MAX_DEPTH = 4096, 8

_BUNDLE = b"#bundle\0"
_FIXED = {"i": ">i", "f": ">f", "h": ">q", "d": ">d", "t": ">Q", "c": ">i", "r": ">I", "m": ">I"}
_VALUES: dict[str, Any] = {"T": True, "F": False, "N": None, "I": float("inf")}


@dataclass(frozen=True)
class Message:
    """One OSC message.

    Attributes:
        address: Such as "/VMC/Ext/OK".
        arguments: Numbers, strings, bytes, booleans and None.
    """

    address: str
    arguments: tuple[Any, ...] = ()


def encode(message: Message) -> bytes:
    """The bytes of a message: int as i, float as f, str as s, bytes as b, bool as T or F.

    Raises:
        TypeError: An argument of another type.
        struct.error: An int beyond 32 bits.
    """
    types, data = ",", b""
    for value in message.arguments:
        if isinstance(value, bool):
            types += "T" if value else "F"
        elif isinstance(value, int):
            types, data = types + "i", data + struct.pack(">i", value)
        elif isinstance(value, float):
            types, data = types + "f", data + struct.pack(">f", value)
        elif isinstance(value, str):
            types, data = types + "s", data + _string(value)
        elif isinstance(value, bytes):
            size = struct.pack(">i", len(value))
            types, data = types + "b", data + size + value + bytes(-len(value) % 4)
        else:
            raise TypeError(f"OSC has no {type(value).__name__}")
    return _string(message.address) + _string(types) + data


def bundle(elements: Iterable[bytes], time: int = IMMEDIATELY) -> bytes:
    """A bundle of encoded messages or bundles; `time`: its NTP time as 64 bits."""
    parts = [_BUNDLE, struct.pack(">Q", time)]
    for element in elements:
        parts += [struct.pack(">i", len(element)), element]
    return b"".join(parts)


def bundles(messages: Iterable[Message], most: int) -> list[bytes]:
    """Bundles of at most `most` bytes that hold all messages in their order."""
    packets: list[bytes] = []
    elements: list[bytes] = []
    size = 16
    for message in messages:
        element = encode(message)
        if elements and size + 4 + len(element) > most:
            packets.append(bundle(elements))
            elements, size = [], 16
        elements.append(element)
        size += 4 + len(element)
    return [*packets, bundle(elements)] if elements else packets


def decode(packet: bytes) -> list[Message]:
    """All messages of a packet, in their order.

    Raises:
        Malformed: It is no OSC, is cut off, has types that are not known, more than
            `MAX_MESSAGES` messages or bundles deeper than `MAX_DEPTH`.
    """
    messages: list[Message] = []
    _read(packet, messages, 0)
    return messages


def _read(packet: bytes, messages: list[Message], depth: int) -> None:
    if not packet or len(packet) % 4:
        raise Malformed(f"OSC: found {len(packet)} bytes, expected a multiple of four above 0")
    if not packet.startswith(_BUNDLE):
        if len(messages) >= MAX_MESSAGES:
            raise Malformed(f"OSC: more than {MAX_MESSAGES} messages in one packet")
        messages.append(_message(packet))
        return
    if depth >= MAX_DEPTH:
        raise Malformed(f"OSC: bundles more than {MAX_DEPTH} deep")
    at = 16
    if len(packet) < at:
        raise Malformed("OSC: a bundle without its time")
    while at < len(packet):
        (size,) = struct.unpack_from(">i", packet, at)
        at += 4
        if not 0 < size <= len(packet) - at:
            raise Malformed(f"OSC: an element of {size} bytes where {len(packet) - at} are left")
        _read(packet[at : at + size], messages, depth + 1)
        at += size


def _message(packet: bytes) -> Message:
    address, at = _text(packet, 0)
    if not address.startswith("/"):
        raise Malformed(f"OSC: found {address[:40]!r}, expected an address that begins with /")
    if at == len(packet):
        return Message(address)
    types, at = _text(packet, at)
    if not types.startswith(","):
        raise Malformed("OSC: arguments without their types")
    arguments: list[Any] = []
    for kind in types[1:]:
        if kind in _VALUES:
            arguments.append(_VALUES[kind])
        elif kind in "sS":
            text, at = _text(packet, at)
            arguments.append(text)
        elif kind == "b":
            (size,) = _fixed(packet, ">i", at)
            if not 0 <= size <= len(packet) - at - 4:
                raise Malformed(f"OSC: a blob of {size} bytes where fewer are left")
            arguments.append(packet[at + 4 : at + 4 + size])
            at += 4 + size + -size % 4
        elif kind in _FIXED:
            arguments += _fixed(packet, _FIXED[kind], at)
            at += struct.calcsize(_FIXED[kind])
        else:
            raise Malformed(f"OSC: the type {kind!r} is not known")
    if at != len(packet):
        raise Malformed(f"OSC: {len(packet) - at} bytes after the last argument")
    return Message(address, tuple(arguments))


def _fixed(packet: bytes, layout: str, at: int) -> tuple[Any, ...]:
    if struct.calcsize(layout) > len(packet) - at:
        raise Malformed("OSC: an argument is cut off")
    return struct.unpack_from(layout, packet, at)


def _string(text: str) -> bytes:
    data = text.encode()
    return data + bytes(4 - len(data) % 4)


def _text(packet: bytes, at: int) -> tuple[str, int]:
    end = packet.find(b"\0", at)
    if end < 0:
        raise Malformed("OSC: a string without an end")
    try:
        return packet[at:end].decode(), end + 4 - (end - at) % 4
    except UnicodeDecodeError:
        raise Malformed("OSC: a string that is not UTF-8") from None
