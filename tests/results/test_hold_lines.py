"""Holds in words: what was reached, and what failed."""

from __future__ import annotations

import dataclasses

import pytest

from halfphysics.results.held import HeldReport
from halfphysics.results.hold_lines import line_of

GOOD = HeldReport(
    object="largebox", person="ann", part="left_wrist", start=2.56, end=6.6, asked=82.0,
    reached=79.4, margin=2.1, touched=1.0, rise=0.78, recorded_rise=0.80, away=0.042,
    turned_deg=5.4, end_away=0.03, lost=None, late=0.1,
)  # fmt: skip


def hands(**changes):
    left = dataclasses.replace(GOOD, **changes)
    return [left, dataclasses.replace(left, part="right_wrist", reached=81.0, margin=2.3)]


def test_what_went_well():
    assert line_of(hands()) == (
        "holds largebox with left and right hand, 2.6 to 6.6 s: 82 N required, 79 and 81 N "
        "reached, friction margin 2.1; lifted 0.78 of 0.80 m; up to 4 cm and 5° off its record, "
        "3 cm at the end"
    )


def test_one_hand_whose_fingers_hold_and_nothing_rises():
    line = line_of([dataclasses.replace(GOOD, asked=0.0, recorded_rise=0.01, rise=0.0)])
    assert line == (
        "holds largebox with left hand, 2.6 to 6.6 s: 79 N reached, friction margin 2.1; up to "
        "4 cm and 5° off its record, 3 cm at the end"
    )


def test_other_parts_have_their_names():
    def said(*parts):
        line = line_of([dataclasses.replace(GOOD, part=part) for part in parts])
        return line.removeprefix("holds largebox with ").split(",")[0]

    assert said("right_ankle") == "right foot"
    assert said("left_ankle", "right_ankle") == "left and right foot"
    assert said("pelvis") == "the seat"
    assert said("left_wrist", "right_ankle") == "left_wrist and right_ankle"
    assert said("left_elbow") == "left_elbow"


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"rise": 0.02}, "; not lifted: 0.02 of 0.80 m; "),
        ({"rise": 0.7}, "; lifted only 0.70 of 0.80 m; "),
        ({"lost": 4.21}, "; lost at 4.2 s; "),
        ({"late": 0.3}, "; let go 0.3 s late; "),
        ({"touched": 0.4}, ", touched 40 % of the time; "),
        ({"away": 0.85}, "; not carried as recorded: up to 85 cm and 5° off its record"),
        ({"turned_deg": 31.0}, "; not carried as recorded: up to 4 cm and 31° off its record"),
    ],
)
def test_what_failed_is_said(changes, said):
    assert said in line_of(hands(**changes))
    assert said not in line_of(hands())


def test_never_touched():
    line = line_of(hands(touched=0.0, reached=0.0, margin=0.0, lost=2.56, rise=0.0))
    assert ": never touched; not lifted: 0.00 of 0.80 m; " in line
    assert "lost" not in line
