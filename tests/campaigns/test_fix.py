"""A sample of `campaigns.fix`: one recorded walk, whole."""

from __future__ import annotations

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
    assert walk["noisy"].falls > 4.0
    for row in walk.values():
        assert row.posed[1] < row.posed[0] + 10.0


def test_the_summary_counts_what_the_damage_added():
    clean = Row("walk", "clean", (2.0, 2.0), (0.0, 0.0), (0.0, 0.0), ())
    bad = Row("walk", "sunk", (32.0, 3.0), (0.0, 11.0), (30.0, 4.0), ("sunk",))
    line = summary([clean, bad])[1]
    assert "error 10.7 times less, over the clean clip's 30.0 -> 1.0 mm" in line
    assert "10 times less in 1 of 1, MPJPE at most 10 mm over the damage's in 0" in line


def test_the_campaign_prints_a_row_a_copy(capsys):
    assert main(["--only", "no such clip"]) == 0
    assert capsys.readouterr().out == ""
