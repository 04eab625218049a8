"""OSC beside python-osc, and against bytes that are not OSC."""

from __future__ import annotations

import contextlib
import struct

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from halfphysics.live.protocols import osc
from halfphysics.live.protocols.malformed import Malformed
from halfphysics.live.protocols.osc import Message

ADDRESS = st.from_regex(r"/[a-zA-Z/]{1,30}", fullmatch=True)
NUMBER = st.floats(width=32, allow_nan=False)
TEXT = st.text(st.characters(exclude_characters="\0", exclude_categories=["Cs"]), max_size=30)
ARGUMENTS = st.lists(
    st.integers(-(2**31), 2**31 - 1)
    | NUMBER
    | TEXT
    | st.booleans()
    | st.binary(min_size=1, max_size=40),
    max_size=8,
).map(tuple)
MESSAGE = st.builds(Message, ADDRESS, ARGUMENTS)


def test_the_bytes_of_the_specification():
    """The example of OSC 1.0's specification, byte for byte."""
    packet = bytes.fromhex(
        "2f666f6f 00000000 2c696973 66660000 000003e8 ffffffff 68656c6c 6f000000 3f9df3b6 40b5b22d"
    )
    message = Message("/foo", (1000, -1, "hello", *struct.unpack(">2f", packet[-8:])))
    assert osc.encode(message) == packet
    assert osc.decode(packet) == [message]


@given(MESSAGE)
def test_an_independent_implementation_reads_what_is_written(message):
    from pythonosc.osc_message import OscMessage

    theirs = OscMessage(osc.encode(message))
    assert theirs.address == message.address
    assert tuple(theirs.params) == message.arguments


@given(MESSAGE)
def test_what_an_independent_implementation_writes_is_read(message):
    from pythonosc.osc_message_builder import OscMessageBuilder

    builder = OscMessageBuilder(message.address)
    for value in message.arguments:
        builder.add_arg(value)
    assert osc.decode(builder.build().dgram) == [message]


@given(st.lists(MESSAGE, min_size=1, max_size=20))
def test_bundles_are_within_their_size_and_read_by_others(messages):
    from pythonosc.osc_packet import OscPacket

    packets = osc.bundles(messages, 1500)
    assert all(len(packet) <= 1500 for packet in packets)
    assert [m for packet in packets for m in osc.decode(packet)] == messages
    theirs = [timed.message for packet in packets for timed in OscPacket(packet).messages]
    assert [(m.address, tuple(m.params)) for m in theirs] == [
        (m.address, m.arguments) for m in messages
    ]


def test_bundles_within_bundles():
    inner = osc.bundle([osc.encode(Message("/a", (1,))), osc.encode(Message("/b"))])
    packet = osc.bundle([inner, osc.encode(Message("/c"))])
    assert [message.address for message in osc.decode(packet)] == ["/a", "/b", "/c"]


def deep(levels):
    packet = osc.encode(Message("/a"))
    for _ in range(levels):
        packet = osc.bundle([packet])
    return packet


@pytest.mark.parametrize(
    "packet",
    [
        b"",
        b"/a\0",
        b"abc\0",
        b"/abc",
        b"/a\0\0x\0\0\0",
        b"/a\0\0,i\0\0",
        b"/a\0\0,q\0\0\0\0\0\0",
        b"/a\0\0,b\0\0\x7f\xff\xff\xff",
        b"/a\0\0,b\0\0\xff\xff\xff\xff",
        b"/a\0\0,\0\0\0\0\0\0\0",
        b"/\xff\xff\0",
        b"#bundle\0",
        b"#bundle\0" + bytes(8) + b"\0\0\0\x08/a\0\0",
        b"#bundle\0" + bytes(12),
        deep(osc.MAX_DEPTH + 1),
        osc.bundle([osc.encode(Message("/a"))] * (osc.MAX_MESSAGES + 1)),
    ],
)
def test_what_is_not_osc_is_refused(packet):
    with pytest.raises(Malformed):
        osc.decode(packet)


def test_limits_are_reached():
    assert len(osc.decode(deep(osc.MAX_DEPTH))) == 1
    packet = osc.bundle([osc.encode(Message("/a"))] * osc.MAX_MESSAGES)
    assert len(osc.decode(packet)) == osc.MAX_MESSAGES


@settings(max_examples=300)
@given(st.binary(max_size=200), st.lists(MESSAGE, max_size=4), st.integers(0, 400))
def test_any_bytes_are_read_or_refused(noise, messages, cut):
    """Also real packets that are cut off, or have noise in their middle."""
    packet = osc.bundle([osc.encode(message) for message in messages])
    for data in (noise, packet[:cut], packet[:cut] + noise + packet[cut:]):
        with contextlib.suppress(Malformed):
            assert all(isinstance(message, Message) for message in osc.decode(data))
