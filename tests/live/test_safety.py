"""Who may connect, and how much of it."""

from __future__ import annotations

import pytest

from halfphysics.errors import InputError
from halfphysics.live.safety import (
    BYTES_PER_SECOND,
    MESSAGES_PER_SECOND,
    Budget,
    Gate,
    is_loopback,
    token_for,
)

LOCAL = {"Host": "127.0.0.1:8765"}


@pytest.mark.parametrize(
    "host", ["127.0.0.1", "localhost", "LOCALHOST", "::1", "[::1]", "127.1.2.3"]
)
def test_loopback(host):
    assert is_loopback(host)


@pytest.mark.parametrize(
    "host", ["0.0.0.0", "::", "192.168.1.2", "example.com", "", "localhost.evil"]
)
def test_no_loopback(host):
    assert not is_loopback(host)


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        (LOCAL, None),
        ({"Host": "localhost:1"}, None),
        ({"Host": "[::1]:8765"}, None),
        ({}, 400),
        ({"Host": "evil.example:8765"}, 403),  # its name points to 127.0.0.1
        ({"Host": "127.0.0.1.evil.example"}, 403),
        ({"Host": "evil.example@127.0.0.1"}, None),  # what no browser sends
        ({**LOCAL, "Origin": "http://127.0.0.1:8765"}, None),
        ({**LOCAL, "Origin": "http://127.0.0.1:1234"}, 403),
        ({**LOCAL, "Origin": "https://evil.example"}, 403),
        ({**LOCAL, "Origin": "null"}, 403),
        ({**LOCAL, "Origin": "file://127.0.0.1:8765"}, 403),
        ({**LOCAL, "Origin": ""}, None),
        ({**LOCAL, "Origin": "http://["}, 403),  # no address at all
    ],
)
def test_host_and_origin(headers, status):
    refusal = Gate("127.0.0.1").refusal("/", headers)
    assert (None if refusal is None else refusal.status) == status


def test_origins_that_are_told():
    gate = Gate("127.0.0.1", None, ("http://localhost:5173", "null"))
    assert gate.refusal("/", {**LOCAL, "Origin": "http://localhost:5173"}) is None
    assert gate.refusal("/", {**LOCAL, "Origin": "null"}) is None
    assert gate.refusal("/", {**LOCAL, "Origin": "http://localhost:5174"}).status == 403
    assert Gate("127.0.0.1", None, ("*",)).refusal("/", {**LOCAL, "Origin": "http://x"}) is None


@pytest.mark.parametrize(
    ("path", "headers", "status"),
    [
        ("/", {}, 401),
        ("/?token=secret-12", {}, None),
        ("/?token=secret-1", {}, 401),
        ("/?token=", {}, 401),
        ("/?token=%FF", {}, 401),
        ("/?token=no&token=secret-12", {}, None),
        ("/", {"Authorization": "Bearer secret-12"}, None),
        ("/", {"Authorization": "bearer secret-12"}, None),
        ("/", {"Authorization": "Basic secret-12"}, 401),
        ("/", {"Authorization": "secret-12"}, 401),
        ("/", {"Authorization": "Bearer \udcff"}, 401),  # a byte that is no ASCII
        ("/?token=\udcff", {}, 401),
        ("//[", {}, 401),
        ("//[?token=secret-12", {}, None),
    ],
)
def test_token(path, headers, status):
    gate = Gate("0.0.0.0", "secret-12")
    refusal = gate.refusal(path, {"Host": "my-machine:8765", **headers})
    assert (None if refusal is None else refusal.status) == status


def test_a_token_is_made_beyond_the_loopback():
    assert token_for("127.0.0.1", None) is None
    assert len(token_for("0.0.0.0", None)) >= 16
    assert token_for("0.0.0.0", None) != token_for("0.0.0.0", None)
    assert token_for("127.0.0.1", "secret-12") == "secret-12"


@pytest.mark.parametrize("token", ["short", "with space", "späteraberlang", "a&b=cdefghi", ""])
def test_tokens_that_addresses_cannot_have(token):
    with pytest.raises(InputError, match="at least 8"):
        token_for("127.0.0.1", token)


def test_a_budget_holds_a_second_and_fills_again():
    now = [0.0]
    budget = Budget(lambda: now[0])
    waits = [budget.spend(10) for _ in range(int(MESSAGES_PER_SECOND) + 10)]
    assert waits[int(MESSAGES_PER_SECOND) - 1] == 0.0
    assert waits[-1] == pytest.approx(10 / MESSAGES_PER_SECOND)
    now[0] += 5.0
    assert budget.spend(10) == 0.0
    assert budget.spend(int(2 * BYTES_PER_SECOND)) == pytest.approx(1.0, rel=0.01)
