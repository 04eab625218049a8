"""The messages: the same in JSON and MessagePack, and what is refused."""

from __future__ import annotations

import json
import re

import msgspec
import pytest

from halfphysics.errors import InputError
from halfphysics.live import schema
from support.live.faults import WRONG
from support.paths import ROOT

POSE = schema.PoseMessage(
    {"ada": schema.PersonPose((1.0, 2.0, 3.0), [(0.1, 0.2, 0.3)] * 55, [True] * 55)}, 4.5
)
FROM_CLIENT = [
    POSE,
    schema.Edit(schema.Add("ball", "sphere:0.1", 1.0, (0.0, 0.0, 1.0)), 1),
    schema.Edit(schema.Remove("ball"), "two"),
    schema.Edit(schema.Drag("ball", None)),
    schema.Edit(schema.Mass("ball", 2.0)),
    schema.Edit(schema.Friction("ball", 0.5)),
    schema.Edit(schema.Stiffness({"arms": 0.5}, "ada")),
    schema.Edit(schema.Impulse("ball", (1.0, 0.0, 0.0))),
    schema.Subscribe(["poses"], ["ada"], 30.0),
    schema.Ping(7, 1.5),
    schema.ClientHello(1, "test"),
]


@pytest.mark.parametrize("message", FROM_CLIENT, ids=lambda m: type(m).__name__)
def test_json_and_messagepack_say_the_same(message):
    text, data = schema.encode(message, False).decode(), schema.encode(message, True)
    assert schema.from_client(text) == schema.from_client(data) == message
    assert json.loads(text) == msgspec.msgpack.decode(data)


def test_whole_numbers_and_unknown_fields_are_fine():
    text = '{"type": "ping", "id": 1, "time": 3, "later": {"more": []}}'
    assert schema.from_client(text) == schema.Ping(1, 3.0)


#: Of those, what is understood and refused by the session.
UNDERSTOOD = {
    *("nobody", "version", "no such object", "no mass", "nan mass", "remove a wall", "file"),
    *("comma", "no rotation", "nan push", "huge push", "stiffness"),
}


@pytest.mark.parametrize("name", sorted(set(WRONG) - UNDERSTOOD))
def test_what_is_wrong_is_refused_in_one_sentence(name):
    with pytest.raises(InputError, match="no message of version 1") as caught:
        schema.from_client(WRONG[name])
    assert len(str(caught.value)) < 500


@pytest.mark.parametrize("number", [float("nan"), float("inf"), -float("inf")])
def test_numbers_that_are_none_are_named(number):
    """As a lost tracker gives them; Python's json writes them, though JSON has no such numbers."""
    text = '{"type": "pose", "people": {"ada": {"translation": [0, %s, 0]}}}'
    with pytest.raises(InputError, match=r"-?(NaN|Infinity) is no number of JSON; .*'tracked'"):
        schema.from_client(text % json.dumps(number))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('{"type": "ping", "id": "a, NaN", "time": "x"}', r"got `str` - at `\$\.time`\. docs"),
        ('{"type": "ping", "time": "x", "more": NaN}', r"got `str` - at `\$\.time`\. docs"),
        ('{"type": "ping", "time": NaN}', r"malformed: .* \(NaN is no number of JSON\)\. docs"),
        ('{"type": "ping", "id": "\\", NaN", "time": 1', r"truncated\. docs"),
    ],
)
def test_what_is_wrong_is_said_whatever_numbers_there_are(text, said):
    with pytest.raises(InputError, match=said):
        schema.from_client(text)


@pytest.mark.parametrize("number", [float("nan"), float("inf"), -float("inf")])
@pytest.mark.parametrize("message", [schema.Ping(1, 0.0), POSE])
def test_times_are_finite(message, number):
    told = msgspec.structs.replace(message, time=number)
    with pytest.raises(InputError, match=r"at `\$\.time`"):
        schema.from_client(schema.encode(told, True))


@pytest.mark.parametrize("number", [2**63, -(2**63) - 1, 2**64, 10**30])
def test_numbers_of_messages_have_64_bits(number):
    """Of JSON they may have more: the answer in MessagePack could not have them."""
    with pytest.raises(InputError, match=r"at `\$\.id`"):
        schema.from_client(json.dumps({"type": "ping", "id": number}))
    for most in (2**63 - 1, -(2**63), "9" * 30):
        ping = schema.from_client(json.dumps({"type": "ping", "id": most}))
        assert schema.from_server(schema.encode(schema.Pong(ping.id, None, 0.0), True)).id == most


@pytest.mark.parametrize("number", [7, "seven", None])
def test_what_is_wrong_keeps_its_number(number):
    wrong = {"type": "edit", "id": number, "edit": {"action": "mass", "mass": "heavy"}}
    assert schema.number_of(json.dumps(wrong)) == number
    assert schema.number_of(msgspec.msgpack.encode(wrong)) == number


@pytest.mark.parametrize("data", ["", "{", "[1]", '{"id": [1]}', '{"id": 1e30}', b"", b"\xff"])
def test_what_has_no_number_has_none(data):
    assert schema.number_of(data) is None


def test_messages_of_the_server_come_back():
    for message in (
        schema.Done(3),
        schema.Pong(None, 1.0, 2.0),
        schema.ErrorMessage("busy", "wait"),
        schema.FrameMessage(1, 0.1, 5.0, None, {"ada": schema.PersonFrame("live")}),
    ):
        for binary in (False, True):
            data = schema.encode(message, binary)
            assert schema.from_server(data if binary else data.decode()) == message
    with pytest.raises(InputError, match="no message"):
        schema.from_server("{}")


def test_the_document_has_every_field():
    """docs/live.md names all types, actions and fields."""
    text = (ROOT / "docs" / "live.md").read_text(encoding="utf-8")
    words = set(re.findall(r"\w+", text))
    structs = [s for s in vars(schema).values() if isinstance(s, type) and s is not msgspec.Struct]
    structs = [s for s in structs if issubclass(s, msgspec.Struct)]
    assert len(structs) > 20
    named = {field for struct in structs for field in struct.__struct_fields__}
    tags = {s.__struct_config__.tag for s in structs} - {None}
    assert (named | tags) - words == set()
