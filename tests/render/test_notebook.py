"""Notebooks show objects with a picture and a summary, quickly, whatever is broken."""

from __future__ import annotations

import base64
import html
import io
import re
import time

import numpy as np
import pytest
from PIL import Image

import halfphysics as hp
from halfphysics.render import notebook
from halfphysics.results.result import PersonResult
from support import small_results as small

#: A few tenths of a second of one processor, the first time with imports [s].
SOON = 1.5


def simulator(steps=4):
    made = hp.Simulator(small.scene(), body=[hp.Body.default()] * 2, fps=30.0)
    motions = small.motions()
    if steps:
        made.reset([motion[0] for motion in motions])
    for t in range(1, steps):
        made.step([motion[t] for motion in motions])
    return made


#: What is shown, and words of its summary.
THINGS = {
    "Result": (small.result, "touched wall in 5 frames"),
    "PersonResult": (lambda: small.result().people[0], "touches wall in 5 frames with "),
    "Simulator": (simulator, "box: 2 kg, Box(size=(0.3, 0.3, 0.3)) at (0.15, -0.40, 1.30) m"),
    "Simulator before reset": (lambda: simulator(0), "call reset(pose) first"),
    "Motion": (lambda: small.motions()[0], "Motion(24 frames at 30 fps"),
    "Pose": (lambda: small.motions()[0][0], "Pose(55 joints"),
    "Body": (hp.Body.default, "Body(free neutral"),
    "Scene": (small.scene, "platform: kinematic Box(size=(0.5, 0.5, 0.1)) at"),
    "Sequence": (lambda: hp.scenarios.load("meet"), "floor: static Plane("),
}


def picture(text):
    """The pixels of the picture in HTML (height, width, 3)."""
    data = re.search(r'src="data:image/png;base64,([^"]+)"', text)
    assert data, text[:300]
    return np.asarray(Image.open(io.BytesIO(base64.b64decode(data[1]))).convert("RGB"))


@pytest.mark.parametrize("name", THINGS)
def test_picture_and_summary(name):
    make, words = THINGS[name]
    shown = make()
    start = time.process_time()
    text = shown._repr_html_()
    assert time.process_time() - start < SOON
    assert html.escape(words) in text
    assert len(text) < 60_000
    pixels = picture(text)
    assert pixels.shape[0] in (notebook.TILE[1], notebook.WIDE[1])
    # Something stands before the grey of the studio: colours, or what is darker than it.
    assert (np.ptp(pixels.astype(int), axis=2) > 20).mean() > 0.005


def test_the_picture_shows_the_people():
    """In each tile: without them the pixels differ."""
    pixels = picture(small.result()._repr_html_())
    tiles = pixels.reshape(notebook.TILE[1], -1, notebook.TILE[0], 3).swapaxes(0, 1)
    assert len(tiles) == notebook.TILES
    skin = [(np.abs(tile.astype(int) - (196, 164, 140)).max(axis=2) < 50).sum() for tile in tiles]
    assert min(skin) > 300


def test_what_was_simulated_moves_in_the_picture():
    first, later = (picture(simulator(n)._repr_html_()) for n in (1, 10))
    assert (first != later).any(axis=2).mean() > 0.02


@pytest.mark.parametrize(
    ("make", "unit"),
    [
        (lambda: small.result().contacts, "impulse [N s], frames 1 to 23; highest 104"),
        (lambda: sunken().inside, "depth [mm], frames 0 to "),
    ],
)
def test_tables_show_bars(make, unit):
    table = make()
    text = table._repr_html_()
    assert unit in text
    heights = [float(h) for h in re.findall(r'<rect[^>]* height="([\d.]+)"', text)]
    frames = len(np.unique(table.frame))
    assert len(heights) == frames
    assert max(heights) == pytest.approx(90.0, abs=0.01)


def test_contacts_name_who_touches_what():
    result = small.result()
    contacts = result.contacts
    rows = (contacts.person == 0) & (contacts.other == result.names.index("wall"))
    hardest = 30.0 * np.linalg.norm(contacts.impulse[rows], axis=1).max()
    frames = len(set(contacts.frame[rows]))
    text = contacts._repr_html_()
    assert f"person0 on wall: {frames} frames, up to {hardest:.0f} N" in text
    assert "crate on platform: 8 frames" in text


def test_bars_are_proportional_to_the_impulses():
    contacts = small.result().contacts
    sums = np.bincount(contacts.frame, weights=contacts.strength)
    text = contacts._repr_html_()
    found = np.array([float(h) for h in re.findall(r'<rect[^>]* height="([\d.]+)"', text)])
    expected = 90.0 * sums[sums > 0.0] / sums.max()
    assert np.abs(found - expected).max() < 0.01  # two decimals are written


def sunken():
    scene = hp.Scene()
    scene.add_static("wall", hp.Box((0.1, 6.0, 6.0)), position=(-0.35, -0.4, 1.0))
    with pytest.warns(hp.HalfPhysicsWarning, match="start is not clear"):
        return hp.simulate(small.motions()[0], scene, settings=hp.Settings(weight=False))


def test_empty_tables_and_scenes():
    assert "Contacts(none)" in small.result().contacts[:0]._repr_html_()
    assert "Inside(none)" in small.result().inside._repr_html_()
    assert "<img" not in hp.Scene()._repr_html_()


def test_names_are_text():
    scene = hp.Scene()
    scene.add_static("<b>&", hp.Box((1.0, 1.0, 1.0)))
    text = scene._repr_html_()
    assert "<b>" not in text
    assert "&lt;b&gt;&amp;: static" in text


def test_what_fails_is_left_out(monkeypatch, caplog):
    """Neither a renderer that fails nor a summary that does keeps a result from being shown."""

    def fails(*_, **__):
        raise RuntimeError("no triangles today")

    monkeypatch.setattr(notebook, "render", fails)
    monkeypatch.setattr("halfphysics.metrics.result_report.summary", fails)
    result = small.result()
    with caplog.at_level("DEBUG", logger="halfphysics"):
        text = result._repr_html_()
    assert "Result(24 frames at 30 fps, 2 people, 4 objects, 197 contacts)" in text
    assert "<img" not in text
    assert [r.getMessage() for r in caplog.records] == [
        "no picture of a Result: no triangles today",
        "no summary of a Result: no triangles today",
    ]


def test_a_person_of_no_result():
    motion = small.motions()[0]
    alone = PersonResult(name="x", motion=motion, reference=motion, body=hp.Body.default())
    assert "PersonResult(x: 24 frames" in alone._repr_html_()


def test_large_meshes_are_left_out(monkeypatch):
    """The picture comes soon all the same."""
    monkeypatch.setattr(notebook, "MOST_TRIANGLES", 40)
    drawn = []
    monkeypatch.setattr(
        notebook, "render", lambda surfaces, *a, **k: drawn.extend(surfaces) or _grey()
    )
    scene = hp.Scene()
    scene.add_static("ball", hp.Sphere(1.0))
    scene.add_static("box", hp.Box((1.0, 1.0, 1.0)))
    scene._repr_html_()
    assert [len(surface.faces) for surface in drawn] == [12]


def _grey():
    return np.full((*notebook.WIDE[::-1], 3), 128, dtype=np.uint8)
