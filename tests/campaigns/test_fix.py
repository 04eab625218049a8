"""A sample of `campaigns.fix`: one recorded walk, whole."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from campaigns.fix import Row, main, rows, summary
from support.damage import DAMAGES

#: Of the damages that are of the whole clip, so much of the joints' distance is left [mm].
LEFT = 6.0


@pytest.fixture(scope="module")
def walk():
    return {row.damage: row for row in rows("asap_walk1.npz", hp.Body.default())}


def test_a_clean_clip_comes_back_bit_by_bit(walk):
    assert walk["clean"].moved == (0.0, 0.0)
    assert walk["clean"].done == ()


def test_every_damage_is_undone_or_lessened(walk):
    assert set(walk) == {"clean", *DAMAGES}
    for damage in ("sunk", "floating", "drifting"):
        assert walk[damage].falls > 10.0
        assert walk[damage].moved[1] < LEFT < walk[damage].moved[0]
    assert walk["sliding"].moved[1] < LEFT
    assert walk["tilted"].falls > 10.0
    assert walk["noisy"].falls > 8.0
    for damage, row in walk.items():
        assert row.posed[1] < row.posed[0] + 10.0
        assert damage == "clean" or row.excess > 10.0


def row(clip, damage, before, after, posed, clean):
    return Row(clip, damage, (before, after), posed, (30.0, 4.0), (), clean)


def test_the_excess_is_over_the_clean_clips_own():
    # 0.5 + 40 + 1.5 of 42 mm, put right to 10 + 2 of which the clean clip has 8 + 2.
    one = row("jump", "floating", (0.5, 40.0, 1.5), (0.0, 10.0, 2.0), (0.0, 1.0), 10.0)
    assert one.error == (42.0, 12.0)
    assert one.falls == 3.5
    assert one.most == 4.2
    assert one.excess == 16.0
    # Less than the clean clip's own is no excess; where a damage adds none, none can fall.
    better = row("jump", "floating", (0.0, 40.0, 2.0), (0.0, 7.0, 2.0), (0.0, 1.0), 10.0)
    assert better.excess == pytest.approx(32.0 / 0.1)
    assert np.isnan(row("jump", "sunk", (1.0, 7.0, 1.0), (0.0, 8.0, 2.0), (0.0, 1.0), 10.0).excess)


def test_the_summary_counts_what_the_damage_added():
    clean = row("walk", "clean", (0.0, 0.5, 1.5), (0.0, 0.5, 1.5), (0.0, 0.0), 2.0)
    bad = row("walk", "sunk", (30.0, 0.5, 1.5), (0.0, 1.5, 1.5), (0.0, 11.0), 2.0)
    line = summary([clean, bad])[1]
    assert "error 10.7 times less (most 16.0), over the clean clip's 30.0 -> 1.0 mm" in line
    assert "30.0 times less; joints in the world 30.0 -> 4.0 mm" in line
    assert "10 times less in 1 of 1 (could be in 1), excess in 1 of 1" in line
    assert "MPJPE at most 10 mm over the damage's in 0" in line


def test_the_campaign_prints_a_row_a_copy(capsys):
    assert main(["--only", "no such clip"]) == 0
    assert capsys.readouterr().out == ""
