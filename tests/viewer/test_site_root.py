"""The folder that a server serves: viser's page with our script, and files of data."""

from __future__ import annotations

import threading
from urllib.request import ProxyHandler, build_opener

import pytest

from halfphysics.viewer.server import close_server, open_server
from halfphysics.viewer.site_root import SiteRoot


def fetched(server, name=""):
    with build_opener(ProxyHandler({})).open(
        f"http://127.0.0.1:{server.get_port()}/{name}", timeout=20.0
    ) as answer:
        return answer.read().decode()


@pytest.fixture
def root():
    made = SiteRoot()
    yield made
    made.close()
    assert not made.folder.exists()


def test_the_page_is_visers_with_our_script(root):
    import viser.infra

    theirs = viser.infra.WebsockServer
    server, plain = open_server("127.0.0.1", 0, root=root), open_server("127.0.0.1", 0)
    try:
        assert viser.infra.WebsockServer is theirs
        page, without = fetched(server), fetched(plain)
        assert "startServed();" in page
        assert "startServed" not in without
        # All that viser's page has is in ours, in its order.
        body = without.partition("<head>")[2].partition("<title>")[0]
        assert body in page
        assert page.index("startServed();") < page.index(body)
        first = root.publish('{"a": 1}')
        assert fetched(server, first) == '{"a": 1}'
        # A new file has a new name: the server keeps what it read.
        second = root.publish('{"a": 2}')
        assert (first != second, fetched(server, second)) == (True, '{"a": 2}')
    finally:
        close_server(server)
        close_server(plain)
    assert not [t for t in threading.enumerate() if "viser" in t.name]
