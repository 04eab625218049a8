"""The sky of a browser: a style sheet with the colours of pictures, light and dark."""

from __future__ import annotations

import re

from halfphysics.render.look import DARK, LIGHT
from halfphysics.viewer.server import close_server, open_server
from halfphysics.viewer.theme import add_sky, style


def test_both_skies_are_there_in_the_colours_of_pictures():
    rules = dict(re.findall(r"([^{}]+?) \{ ([^{}]*) \}", style()))
    light, dark = (rules[name] for name in sorted(rules, key=lambda name: "dark" in name))
    for text, theme in ((light, LIGHT), (dark, DARK)):
        found = [tuple(map(int, c)) for c in re.findall(r"rgb\((\d+), (\d+), (\d+)\)", text)]
        assert found == [tuple(round(255 * x) for x in c) for c in (theme.top, theme.horizon)]
    assert all("canvas[data-engine]" in name for name in rules)


def test_a_server_gives_it_to_its_browsers():
    server = open_server("127.0.0.1", 0)
    try:
        add_sky(server)
        sent = [
            m for m in server._websock_server.get_message_buffer().message_from_id.values()
            if "Html" in type(m).__name__
        ]  # fmt: skip
        assert style() in sent[0].props.content
    finally:
        close_server(server)
