"""Stick figures of text: up is up, left is left, all to one scale."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.cli.stick_figure import ROWS, stick_figures

#: Dots of a braille character, by row and column (Unicode 15, block 2800).
BITS = ((0, 3), (1, 4), (2, 5), (6, 7))


def dots(lines):
    """The picture as True and False, one a dot, without captions."""
    cells = np.array([[ord(c) - 0x2800 if c >= "\u2800" else 0 for c in line] for line in lines])
    picture = np.zeros((4 * len(lines), 2 * cells.shape[1]), dtype=bool)
    for row, bits in enumerate(BITS):
        for column, bit in enumerate(bits):
            picture[row::4, column::2] = cells >> bit & 1
    return picture


def drawn(turn=(np.pi / 2, 0.0, 0.0), lift=0.0, arms=0.0):
    rotations = np.zeros((2, 55, 3))
    rotations[:, 0] = turn
    rotations[:, 17, 2] = arms  # the right arm
    motion = hp.Motion(np.zeros((2, 3)), rotations, 30.0)
    body = hp.Body.default()
    motion = motion.grounded(body, lift)
    lines = stick_figures([body.joints(motion)[0]], captions=["now"])
    assert lines[-1].strip() == "now"
    width = max(map(len, lines[:-1]))
    return dots([line.ljust(width, "\u2800") for line in lines[:-1]])


def test_who_stands_is_tall_and_the_head_is_a_ring_on_top():
    picture = drawn()
    assert len(picture) == 4 * ROWS
    columns = np.flatnonzero(picture[: 4 * ROWS - 2].any(axis=0))
    rows = np.flatnonzero(picture.any(axis=1))
    assert rows[-1] - rows[0] > 0.8 * 4 * ROWS
    # The arms of the rest pose span about as much as the person is tall.
    assert 0.7 < (columns[-1] - columns[0]) / (rows[-1] - rows[0]) < 1.1
    top = picture[rows[0] : rows[0] + 5]
    assert top.any(axis=0).sum() >= 4  # a ring, not a line


def test_who_lies_is_flat():
    picture = drawn((0.0, 0.0, 0.0))
    rows = np.flatnonzero(picture.any(axis=1))
    assert rows[-1] - rows[0] < 0.4 * 4 * ROWS


def test_the_right_arm_is_on_the_left_of_who_is_seen_from_the_front():
    down = drawn(arms=1.4)[: 4 * ROWS - 3]
    middle = down.shape[1] // 2
    spread = np.flatnonzero(down.any(axis=0))
    body = np.flatnonzero(down[-12])  # the legs
    assert abs(body.mean() - spread[0]) < abs(body.mean() - spread[-1])
    assert middle > 0


def test_the_ground_is_a_dotted_line_where_it_is_in_the_picture():
    assert (drawn()[-1, ::2]).all()
    assert not drawn(lift=5.0)[-1, ::2].all()


def test_everyone_is_drawn_to_one_scale():
    body = hp.Body.default()
    rotations = np.zeros((1, 55, 3))
    rotations[:, 0, 0] = np.pi / 2
    motion = hp.Motion(np.zeros((2, 3)), np.repeat(rotations, 2, axis=0), 30.0).grounded(body)
    joints = body.joints(motion)[0]
    lines = stick_figures([joints, 0.5 * joints], captions=["big", "small"])
    assert {len(lines)} == {ROWS + 1}
    head = lines[1]
    assert any(c > "\u2800" for c in head[: len(head) // 2])
    assert not any(c > "\u2800" for c in head[len(head) // 2 + 8 :])


@pytest.mark.parametrize("joints", [np.zeros((55, 3)), np.full((55, 3), 40.0)])
def test_no_pose_breaks_it(joints):
    assert len(stick_figures([joints], captions=["x"])) == ROWS + 1
