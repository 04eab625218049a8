"""What a viser server lets in."""

from __future__ import annotations

import http.client
from types import SimpleNamespace

import pytest

from halfphysics.viewer import guard
from halfphysics.viewer.guard import Uploads
from halfphysics.viewer.server import close_server, open_server
from halfphysics.viewer.site_root import SiteRoot


@pytest.fixture(scope="module")
def port():
    root = SiteRoot()
    server = open_server("127.0.0.1", 0, root=root)
    yield server.get_port()
    close_server(server)
    root.close()


def status(port, **headers):
    asked = http.client.HTTPConnection("127.0.0.1", port, timeout=20)
    asked.putrequest("GET", "/", skip_host="Host" in headers)
    for name, value in headers.items():
        asked.putheader(name, value)
    asked.endheaders()
    return asked.getresponse().status


UPGRADE = {
    "Upgrade": "websocket",
    "Connection": "Upgrade",
    "Sec-WebSocket-Key": "AAAAAAAAAAAAAAAAAAAAAA==",
    "Sec-WebSocket-Version": "13",
}


def test_its_own_page_may(port):
    assert status(port) == 200
    assert status(port, Origin=f"http://127.0.0.1:{port}") == 200
    assert status(port, **UPGRADE, Origin=f"http://127.0.0.1:{port}") == 101


@pytest.mark.parametrize("upgrade", [{}, UPGRADE])
@pytest.mark.parametrize(
    "headers", [{"Origin": "https://evil.example"}, {"Origin": "null"}, {"Host": "evil.example"}]
)
def test_strangers_pages_may_not(port, headers, upgrade):
    assert status(port, **headers, **upgrade) == 403


def start(name, size, parts=1):
    kind = type("FileTransferStartUpload", (SimpleNamespace,), {})
    return kind(transfer_uuid=name, size_bytes=size, part_count=parts)


def part(name, size):
    kind = type("FileTransferPart", (SimpleNamespace,), {})
    return kind(transfer_uuid=name, content=bytes(size))


def test_uploads_have_a_total_size(monkeypatch):
    monkeypatch.setattr(guard, "TOTAL", 100)
    uploads = Uploads()
    assert not uploads.under_way
    assert uploads.welcome(1, start("a", 60, 2))
    assert uploads.under_way
    assert not uploads.welcome(2, start("b", 41))
    assert not uploads.welcome(2, part("b", 1))
    assert uploads.welcome(2, start("c", 40))
    assert uploads.welcome(1, part("a", 30))
    assert not uploads.welcome(1, part("a", 31))  # more than it said
    assert not uploads.welcome(2, part("a", 1))  # somebody else's
    assert uploads.welcome(1, part("a", 30))
    assert uploads.welcome(1, start("d", 60))  # there is room again
    assert not uploads.welcome(3, start("e", 1))
    uploads.forget(1)
    assert uploads.welcome(3, start("e", 60))
    assert uploads.welcome(3, part("e", 60))
    assert uploads.under_way
    assert uploads.welcome(2, part("c", 40))
    assert not uploads.under_way


@pytest.mark.parametrize("size", [-1, 10**12, 1.5, "1", None])
def test_uploads_of_no_size(size):
    assert not Uploads().welcome(1, start("a", size))


def test_other_messages_pass():
    assert Uploads().welcome(1, SimpleNamespace())
    assert Uploads().welcome(1, start("empty", 0, 0))


def test_the_messages_are_visers():
    import viser._messages as messages

    for name, fields in (
        ("FileTransferStartUpload", {"transfer_uuid", "size_bytes", "part_count"}),
        ("FileTransferPart", {"transfer_uuid", "content"}),
    ):
        assert fields <= set(getattr(messages, name).__annotations__)
