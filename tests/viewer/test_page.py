"""The one-file page: self-contained, complete, made without leaving files behind."""

from __future__ import annotations

import base64
import html
import re
import socket
import subprocess
import sys
import threading
import zlib
from types import SimpleNamespace

import numpy as np
import pytest

from halfphysics.errors import FileError, InputError
from halfphysics.results.held import HeldReport
from halfphysics.viewer.bones import GRAIN
from halfphysics.viewer.contacts import ContactFrames
from halfphysics.viewer.page import save_page
from support.reels import data_of, poses, unpacked
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
    """viser has the first frame, the reel has all: of body, ghost, reference and ball."""
    content = recording(page)
    assert content["durationSeconds"] == 0.0
    messages = content["messages"]
    added = {m["name"]: m["props"] for _, m in messages if "props" in m and "name" in m}
    for name in ("/static/floor", "/static/wall", "/static/bench", "/object/ball"):
        assert name in added
    data = data_of(page)
    assert data["fps"] == pytest.approx(FPS)
    places = poses(data["reel"], "SetBonePositionMessage")
    person = small_result().people[0]
    for kind, motion in (
        ("person", person.motion),
        ("ghost", person.reference),
        ("reference", person.reference),
    ):
        # The pelvis is the first bone of whatever the figure is made of.
        pelvis = person.body.joints(motion)[:, 0]
        found = [
            value for (name, _), value in places.items()
            if name.startswith(f"/{kind}/0") and np.allclose(value[-3:], pelvis[-3:], atol=1e-4)
        ]  # fmt: skip
        assert found, kind
        if kind != "ghost":  # a ghost stands still where it coincides with the body
            np.testing.assert_allclose(found[0], pelvis, atol=1e-4)  # the grain
    ball = poses(data["reel"], "SetPositionMessage")["/object/ball", None]
    np.testing.assert_allclose(ball, small_result().objects["ball"].position, atol=1e-4)


def test_fast_results_are_thinned(tmp_path, page):
    path = save_page(small_result(), tmp_path / "a.html", max_fps=10.0)
    data, whole = data_of(path), data_of(page)
    assert data["fps"] == pytest.approx(10.0)
    few = poses(data["reel"], "SetPositionMessage")["/object/ball", None]
    every = poses(whole["reel"], "SetPositionMessage")["/object/ball", None]
    np.testing.assert_array_equal(few, every[::3])
    assert len(data["track"]) == len(range(0, FRAMES, 3))


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
    path = save_page(small_result(), tmp_path / "a.html", title=title, notes=[title])
    data, text = data_of(path), path.read_text(encoding="utf-8")
    assert data["title"] == title  # set as text
    assert f"<div>{html.escape(title)}</div>" in data["key"]
    assert [html.unescape(e) for e in re.findall(r"</i>([^<]*)</span>", data["key"])] == [
        "reference",
        "simulated",
        "force by the scene",
        "by an object",
        "on an object",
    ]
    assert "<img src=x" not in text


def test_the_page_says_what_hands_held(tmp_path):
    result = SimpleNamespace(**vars(small_result()))
    result.people = (SimpleNamespace(**vars(result.people[0]) | {"name": "a<b"}),)
    held = HeldReport(
        object="ball", person="a<b", part="left_wrist", start=0.1, end=0.5, asked=40.0,
        reached=38.0, margin=2.0, touched=1.0, rise=0.1, recorded_rise=0.4, away=0.3,
        turned_deg=5.0, end_away=0.3, lost=None, late=0.0,
    )  # fmt: skip
    result.holds = (held,)
    key = data_of(save_page(result, tmp_path / "a.html"))["key"]
    (line,) = re.findall(r"<div>([^<]*)</div>", key)
    assert html.unescape(line).startswith("holds ball with left hand, 0.1 to 0.5 s: 40 N asked")
    assert "not lifted: 0.10 of 0.40 m" in line


def test_contacts_are_on_the_page(page):
    """Each kind shows from the frame of its first contact on."""
    header, _, arrays = unpacked(data_of(page)["reel"])
    contacts = ContactFrames(small_result())
    shown = {
        e["message"]["name"]: dict(zip(e["at"], e["values"], strict=True))
        for e in header["events"] if e["field"] == "visible"
    }  # fmt: skip
    points = {
        e["message"]["name"]: dict(zip(e["at"], e["values"], strict=True))
        for e in header["events"] if e["field"] == "updates.batched_positions"
    }  # fmt: skip
    for kind in (1, 3):
        first = next(k for k in range(FRAMES) if kind in contacts.at(k).kind)
        visible = shown[f"/contact/point/{kind}"]
        assert (visible[0], min(at for at, on in visible.items() if on)) == (False, first)
    # In frame 6 the shoulder is in contact beside the foot: two points of the scene's kind.
    value = points["/contact/point/0"][6]
    data = arrays[value["start"] : value["start"] + value["bytes"]]
    found = np.frombuffer(data, dtype=value["dtype"]).reshape(-1, 3)
    np.testing.assert_allclose(found, contacts.at(6).of(0).position, atol=1e-6)


def test_the_page_has_marks_layers_and_a_comparison(page):
    data = data_of(page)
    assert [row["label"] for row in data["marks"]] == [
        "contact with the scene", "contact with an object", "contact of objects",
    ]  # fmt: skip
    nodes = {layer["id"]: layer["nodes"] for layer in data["layers"]}
    assert nodes == {
        "body": ["/person"], "ghost": ["/ghost"], "objects": ["/object"],
        "scene": nodes["scene"], "skin": [], "arrows": ["/contact/arrow"],
        "points": ["/contact/point"],
    }  # fmt: skip
    assert "/static" in nodes["scene"]
    (comparison,) = data["compare"]
    assert (comparison["a"]["label"], comparison["b"]["label"]) == ("reference", "simulated")
    names = {m["name"] for _, m in recording(page)["messages"] if "name" in m}
    for side in comparison.values():
        assert set(side.get("show", [])) <= names


def test_a_motion_alone_has_a_page_without_a_reference(tmp_path):
    path = save_page(small_result().motion, tmp_path / "walk.html", title="walk")
    data = data_of(path)
    assert (data["compare"], data["marks"]) == ([], [])
    assert "reference" not in data["key"]
    names = {m["name"] for _, m in recording(path)["messages"] if "name" in m}
    assert "/static/ground" in names
    assert not any(name.startswith("/reference") for name in names)


def test_the_skin_for_dropped_people_is_the_bodys(page):
    """Vertices to the grain, faces exactly, weights of the four strongest joints."""
    packed, body = data_of(page)["body"], small_result().people[0].body

    def whole(name, kind):
        data = np.frombuffer(zlib.decompress(base64.b64decode(packed[name])), dtype="u1")
        size = np.dtype(kind).itemsize
        return np.ascontiguousarray(data.reshape(size, -1).T).view(kind).reshape(-1)

    vertices = whole("vertices", "<i2").reshape(-1, 3) * GRAIN
    np.testing.assert_allclose(vertices, body.rest_vertices, atol=0.5 * GRAIN)
    faces = np.cumsum(whole("faces", "<i4")).reshape(-1, 3)
    np.testing.assert_array_equal(faces, body.faces)
    indices = whole("indices", "u1").reshape(-1, 4)
    weights = whole("weights", "<u2").reshape(-1, 4) / 65535
    np.testing.assert_allclose(weights.sum(axis=1), 1.0, atol=1e-4)
    strongest = np.argmax(body.weights, axis=1)
    np.testing.assert_array_equal(
        np.asarray(body.weights)[np.arange(len(indices)), indices[:, 0]],
        np.asarray(body.weights)[np.arange(len(indices)), strongest],
    )


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
    labels = ["soft", "a <stiff>"]
    path = save_page([story, story], tmp_path / "two.html", notes=["a <note>"], labels=labels)
    data = data_of(path)
    assert "a &lt;note&gt;" in data["key"]
    assert data["people"] == ["/person/0", "/1/person/0"]
    names = {m["name"] for _, m in recording(path)["messages"] if "name" in m}
    assert set(data["people"]) <= names
    assert len(data["track"]) == FRAMES
    (comparison,) = data["compare"]
    assert [comparison[side]["label"] for side in "ab"] == labels
    assert comparison["b"]["move"] == {"/1": [0.0, 0.0, 0.0]}
    assert "/person" in comparison["b"]["hide"]
    assert "/1/person" in comparison["a"]["hide"]
    with pytest.raises(InputError, match="labels: found 1, expected 2"):
        save_page([story, story], tmp_path / "three.html", labels=["one"])


def test_results_of_different_rates_are_not_played_together(tmp_path):
    slow = SimpleNamespace(**vars(small_result()) | {"fps": 15.0})
    with pytest.raises(InputError, match="found 30, 15 fps"):
        save_page([small_result(), slow], tmp_path / "two.html")
    assert list(tmp_path.iterdir()) == []
