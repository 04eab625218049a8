"""The picture strip: its frames, its text, its pictures."""

from __future__ import annotations

from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from halfphysics.errors import FileError, InputError
from halfphysics.render.contact_sheet import (
    caption,
    contact_sheet_png,
    key_frames,
    save_contact_sheet,
)
from halfphysics.render.rasterizer import Camera
from support.results.small_result import FRAMES, small_result


def test_key_frames_have_the_ends_and_every_first_contact():
    frames = key_frames(small_result(), 5)
    # 6: wall, 10: ball, 12: ball on bench; never 2 (no impulse) or the floor.
    assert frames == [0, 6, 10, 12, FRAMES - 1]


def test_key_frames_fill_the_gaps():
    frames = key_frames(small_result(), 9)
    assert len(frames) == 9
    assert {0, 6, 10, 12, FRAMES - 1} <= set(frames)
    assert max(np.diff(frames)) <= 3
    assert key_frames(small_result(), 100) == list(range(FRAMES))
    assert len(key_frames(small_result(), 1)) == 1
    with pytest.raises(InputError, match="count"):
        key_frames(small_result(), 0)


def test_captions_say_when_and_what_touches():
    assert caption(small_result(), 6) == ("frame 6   0.20 s", "right shoulder : wall")
    assert caption(small_result(), 12) == ("frame 12   0.40 s", "ball : bench")
    assert caption(small_result(), 2) == ("frame 2   0.07 s", "")


def test_a_strip_has_its_size_and_shows_body_ghost_and_ball(tmp_path):
    path = tmp_path / "strip.png"
    size = (120, 132)
    assert save_contact_sheet(small_result(), path, frames=[0, 6, -1], columns=2, size=size) == path
    sheet = np.asarray(Image.open(path).convert("RGB")).astype(int)
    gap, margin, text = 6, 14, 18
    assert sheet.shape[1] == 2 * margin + 2 * size[0] + gap
    assert sheet.shape[0] == 2 * margin + 2 * (size[1] + 2 * text + gap + 4) + text
    corners = [(0, 0), (0, size[0] + gap), (size[1] + 2 * text + gap + 4, 0)]
    tiles = [
        sheet[margin + y : margin + y + size[1], margin + x : margin + x + size[0]]
        for y, x in corners
    ]
    red, _, blue = np.moveaxis(np.array(tiles), -1, 0)
    ball = (red > 150) & (red - blue > 80)
    ghost = (blue - red > 35) & (blue > 120)
    skin = (red - blue > 12) & (red - blue < 70)
    assert (skin.sum(axis=(1, 2)) > 300).all()
    # Until frame 6 body and ghost coincide; then the ghost is beside the body.
    assert ghost[0].sum() < 15
    assert (ghost[1:].sum(axis=(1, 2)) > 150).all()
    assert (ball.sum(axis=(1, 2)) > 10).any()
    assert np.abs(np.diff(np.array(tiles), axis=0)).max(axis=(1, 2, 3)).min() > 60
    # The text below the first picture.
    below = sheet[margin + size[1] + 4 : margin + size[1] + 22, margin : margin + size[0]]
    assert (below.max(axis=2) < 110).sum() > 40


def test_a_strip_is_the_same_every_time(tmp_path):
    for name, threads in (("a.png", 1), ("b.png", 3)):
        save_contact_sheet(
            small_result(), tmp_path / name, frames=[7], size=(60, 60), threads=threads
        )
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"frames": [FRAMES]}, "0 to"),
        ({"frames": []}, "at least one"),
        ({"columns": 0}, "columns"),
        ({"size": (8, 100)}, "16 x 16"),
        ({"frames": [0, 1], "views": [Camera(position=(0.0, -4.0, 1.0))]}, "found 1, expected 2"),
    ],
)
def test_impossible_strips_are_refused_and_leave_nothing(tmp_path, wrong, message):
    with pytest.raises(InputError, match=message):
        save_contact_sheet(small_result(), tmp_path / "a.png", **wrong)
    assert list(tmp_path.iterdir()) == []


def test_a_path_that_cannot_be_is_refused_before_the_work(tmp_path, monkeypatch):
    def work(*_args, **_kwargs):
        raise AssertionError("worked before looking at the path")

    monkeypatch.setattr("halfphysics.render.contact_sheet.choose_direction", work)
    with pytest.raises(FileError, match="does not exist"):
        save_contact_sheet(small_result(), tmp_path / "no" / "a.png")
    with pytest.raises(FileError, match="folder"):
        save_contact_sheet(small_result(), tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_strip_is_seen_from_where_one_says(tmp_path):
    far, near = (
        Camera(position=(0.5, -distance, 1.0), target=(0.5, 0.0, 0.9)) for distance in (12.0, 4.0)
    )
    people = []
    for view in (far, near):
        path = save_contact_sheet(
            small_result(), tmp_path / "a.png", [0], 1, (120, 120), views=[view]
        )
        red, _, blue = np.moveaxis(np.asarray(Image.open(path).convert("RGB")).astype(int), -1, 0)
        people.append(int(((red - blue > 12) & (red - blue < 70)).sum()))
    assert people[1] > 4 * people[0]


def test_a_palette_keeps_what_is_small_and_bright():
    sheet = Image.open(BytesIO(contact_sheet_png(small_result(), [12], 1, (160, 160), colors=64)))
    assert sheet.mode == "P"
    red, _, blue = np.moveaxis(np.asarray(sheet.convert("RGB")).astype(int), -1, 0)
    assert ((red > 200) & (red - blue > 120)).sum() > 10, "no orange ball"
    assert ((blue > 200) & (blue - red > 120)).sum() > 60, "no blue in the key"
