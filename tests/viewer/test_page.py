"""The one-file page: self-contained, complete, made without leaving files behind."""

from __future__ import annotations

import base64
import html
import json
import re
import socket
import subprocess
import sys
import threading
from types import SimpleNamespace

import numpy as np
import pytest

from halfphysics.errors import FileError, InputError
from halfphysics.render.rasterizer import Camera
from halfphysics.render.result_meshes import Drawing
from halfphysics.render.viewpoint import FOV
from halfphysics.results.held import HeldReport
from halfphysics.viewer.contacts import ContactFrames
from halfphysics.viewer.page import save_page
from support.results.small_result import FPS, FRAMES, small_result


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    path = tmp_path_factory.mktemp("page") / "story.html"
    assert save_page(small_result(), path, title="a <walk>") == path
    return path


def recording(path) -> dict:
    """The content of the page: times and messages, as the viewer decodes them."""
    import msgspec
    import zstandard

    text = path.read_text(encoding="utf-8")
    data = base64.b64decode(re.search(r'__VISER_EMBED_DATA__="([^"]*)"', text)[1])
    size = int.from_bytes(data[:8], "little")
    inner = zstandard.ZstdDecompressor().decompressobj().decompress(data[8:])
    assert len(inner) == size
    length = int.from_bytes(inner[:8], "little")
    return msgspec.msgpack.decode(inner[8 : 8 + length])


def test_the_page_needs_nothing_from_outside(page):
    text = page.read_text(encoding="utf-8")
    assert text.lstrip().lower().startswith("<!doctype html>")
    assert text.rstrip().endswith("</html>")
    assert "<title>a &lt;walk&gt;</title>" in text
    # Nothing is fetched: links are inlined, and no other file is imported.
    assert re.findall(r"""(?:src|href)\s*=\s*["'](?!data:)[^"']*""", text) == []
    assert "@import" not in text
    # The only address is the name of a format, inside the icon.
    assert set(re.findall(r"https?://[\w./-]*", text)) == {"http://www.w3.org/2000/svg"}


def test_the_page_plays_every_frame_of_body_ghost_and_ball(page):
    content = recording(page)
    assert content["durationSeconds"] == pytest.approx(FRAMES / FPS)
    messages = content["messages"]
    added = {m["name"]: m["props"] for _, m in messages if "props" in m and "name" in m}
    for name in ("/static/floor", "/static/wall", "/static/bench", "/object/ball"):
        assert name in added
    assert added["/person/0"]["opacity"] is None
    assert 0 < added["/ghost/0"]["opacity"] < 1
    # The pelvis of both, played back at the last frame, is where the joints are.
    person = small_result().people[0]
    for kind, motion in (("person", person.motion), ("ghost", person.reference)):
        pelvis = [
            (time, m["position"])
            for time, m in messages
            if m["type"] == "SetBonePositionMessage"
            and m["name"] == f"/{kind}/0"
            and m["bone_index"] == 0
        ]
        assert len(pelvis) == FRAMES
        joints = person.body.joints(motion)[:, 0]
        np.testing.assert_allclose([p for _, p in pelvis], joints, atol=1e-4)  # the grain
        np.testing.assert_allclose([t for t, _ in pelvis], np.arange(FRAMES) / FPS, atol=1e-9)
    ball = [m["position"] for _, m in messages if m["type"] == "SetPositionMessage"
            and m["name"] == "/object/ball"]  # fmt: skip
    np.testing.assert_allclose(ball[-1], small_result().objects["ball"].position[-1], atol=1e-4)


def test_fast_results_are_thinned(tmp_path):
    path = save_page(small_result(), tmp_path / "a.html", max_fps=10.0)
    messages = recording(path)["messages"]
    times = sorted({t for t, m in messages if m["type"] == "SetBonePositionMessage"})
    np.testing.assert_allclose(times, np.arange(0, FRAMES, 3) / FPS, atol=1e-9)


def test_saving_says_nothing_and_leaves_nothing_running(tmp_path, capfd, monkeypatch):
    import rich

    monkeypatch.setenv("_VISER_PORT_OVERRIDE", "")  # not inherited from a shell
    monkeypatch.delenv("_VISER_PORT_OVERRIDE")
    before = set(threading.enumerate())
    with socket.socket() as busy:  # viser's usual port being taken does not matter
        try:
            busy.bind(("127.0.0.1", 8080))
            busy.listen()
        except OSError:
            pass  # taken already: equally good
        save_page(small_result(), tmp_path / "a.html")
    assert capfd.readouterr() == ("", "")
    assert [p.name for p in tmp_path.iterdir()] == ["a.html"]
    assert not rich.get_console().quiet
    left = [t for t in set(threading.enumerate()) - before if t.is_alive()]
    assert left == []


def test_the_same_result_makes_the_same_page(page, tmp_path):
    again = save_page(small_result(), tmp_path / "a.html", title="a <walk>")
    assert again.read_bytes() == page.read_bytes()


def test_a_page_that_cannot_be_written_leaves_nothing(tmp_path, monkeypatch):
    with pytest.raises(FileError, match="does not exist"):
        save_page(small_result(), tmp_path / "no" / "a.html")
    with pytest.raises(InputError, match="max_fps"):
        save_page(small_result(), tmp_path / "a.html", max_fps=0.0)

    def fails(*_args):
        raise RuntimeError("half-way")

    monkeypatch.setattr("halfphysics.viewer.page._build", fails)
    with pytest.raises(RuntimeError, match="half-way"):
        save_page(small_result(), tmp_path / "a.html")
    assert list(tmp_path.iterdir()) == []
    assert not [t for t in threading.enumerate() if "viser" in t.name]


def test_the_page_says_what_it_shows_and_nothing_in_a_title_runs(tmp_path):
    title = "</script><img src=x onerror=alert(1)>"
    text = save_page(small_result(), tmp_path / "a.html", title=title).read_text(encoding="utf-8")
    key = json.loads(re.search(r"key.innerHTML = (\".*\");", text)[1])
    assert key.startswith(f"<b>{html.escape(title)}</b>")
    assert [html.unescape(e) for e in re.findall(r"</i>([^<]*)</span>", key)] == [
        "reference",
        "simulated",
        "force by the scene",
        "by an object",
        "on an object",
    ]
    assert "<img" not in text.replace(key, "")


def test_the_page_says_what_hands_held(tmp_path):
    result = SimpleNamespace(**vars(small_result()))
    result.people = (SimpleNamespace(**vars(result.people[0]) | {"name": "a<b"}),)
    held = HeldReport(
        object="ball", person="a<b", part="left_wrist", start=0.1, end=0.5, asked=40.0,
        reached=38.0, margin=2.0, touched=1.0, rise=0.1, recorded_rise=0.4, away=0.3,
        turned_deg=5.0, end_away=0.3, lost=None, late=0.0,
    )  # fmt: skip
    result.holds = (held,)
    text = save_page(result, tmp_path / "a.html").read_text(encoding="utf-8")
    key = json.loads(re.search(r"key.innerHTML = (\".*\");", text)[1])
    (line,) = re.findall(r"<div>([^<]*)</div>", key)
    assert html.unescape(line).startswith("holds ball with left hand, 0.1 to 0.5 s: 40 N required")
    assert "not lifted: 0.10 of 0.40 m" in line


def test_the_page_has_a_camera_for_every_shape_of_window(page):
    drawing = Drawing(small_result())
    text = page.read_text(encoding="utf-8")
    cameras = json.loads(re.search(r"const fitting = (\[.*\])\.filter", text)[1])
    shapes = [shape for shape, _, _ in cameras]
    assert shapes == sorted(shapes)
    assert shapes[0] <= 390 / 844 < 2.0 < shapes[-1]
    for shape, position, target in cameras:
        camera = Camera(
            position=np.array(position.split(","), float),
            target=np.array(target.split(","), float),
            fov=FOV,
        )
        right, down, forward = camera.axes()
        for frame in (0, FRAMES // 2, FRAMES - 1):
            for name in ("person/0", "ghost/0"):
                points = drawing.surfaces(frame)[name].vertices - camera.position
                reach = np.tan(np.radians(FOV) / 2) * (points @ forward)
                assert (np.abs(points @ right) < shape * reach).all()
                assert (np.abs(points @ down) < reach).all()


def test_contacts_are_on_the_page(page):
    messages = recording(page)["messages"]
    added = {m["name"]: t for t, m in messages if "props" in m and "name" in m}
    assert {n for n in added if n.startswith("/contact/")} == {
        f"/contact/{what}-{kind}" for what in ("points", "arrows") for kind in (0, 1, 3)
    }
    # Each kind shows from the frame of its first contact on.
    shown = {
        (m["name"], round(t * FPS)) for t, m in messages
        if m["type"] == "SetSceneNodeVisibilityMessage" and m["visible"]
    }  # fmt: skip
    contacts = ContactFrames(small_result())
    for number in (0, 1, 3):
        first = next(k for k in range(FRAMES) if number in contacts.at(k).kind)
        assert (f"/contact/points-{number}", first) in shown
        assert not [t for name, t in shown if name.endswith(f"points-{number}") and t < first]


def test_importing_the_page_does_not_import_viser():
    code = (
        "import sys, halfphysics.viewer.page, halfphysics.render.contact_sheet; "
        "print('viser' in sys.modules, 'PIL' in sys.modules)"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.split() == ["False", "False"]


def test_several_results_play_side_by_side(tmp_path):
    """Each has its nodes, moved apart; the page is as long as the longest."""
    story = small_result()
    path = save_page([story, story], tmp_path / "two.html", notes=["a <note>"])
    text = path.read_text(encoding="utf-8")
    assert "a &lt;note&gt;" in text.replace("\\u003c", "<").replace("\\u0026", "&")
    names = {m["name"] for _, m in recording(path)["messages"] if "name" in m}
    people = {name for name in names if name.endswith("person/0")}
    assert people == {"/person/0", "/1/person/0"}
    assert recording(path)["durationSeconds"] == pytest.approx(FRAMES / FPS, abs=1.0 / FPS)


def test_results_of_different_rates_are_not_played_together(tmp_path):
    slow = SimpleNamespace(fps=15.0)
    with pytest.raises(InputError, match="found 30, 15 fps"):
        save_page([SimpleNamespace(fps=30.0), slow], tmp_path / "two.html")
    assert list(tmp_path.iterdir()) == []
