"""Plots of the report: well-formed, finite, within their box, whatever the values are."""

from __future__ import annotations

import math
import re
from xml.etree import ElementTree

import evidence_sample as sample
import pytest
from evidence_sample import plot, series
from hypothesis import given, settings
from hypothesis import strategies as st

from evidence.page import svg

NUMBER = re.compile(r"-?\d+(\.\d+)?")
VALUES = st.one_of(st.none(), st.floats(), st.floats(-1e3, 1e3), st.integers(-5, 5))


def lines(*ys, x=None):
    return plot("p", ("time", "s"), ("height", "mm"),
                *(series(f"s{k}", x or range(len(y)), y) for k, y in enumerate(ys)))  # fmt: skip


def bars(names, *ys):
    return plot("p", ("mass", "kg"), ("speed", "m/s"),
                *(series(f"s{k}", names, y) for k, y in enumerate(ys)), kind="bars")  # fmt: skip


def drawn(plot, width=svg.WIDE):
    """The parsed picture; every coordinate in it is a number within the box."""
    root = ElementTree.fromstring(svg.draw(plot, width))
    height = float(root.get("height"))
    assert root.get("viewBox") == f"0 0 {width} {root.get('height')}"
    for element in root.iter():
        for name in ("x", "cx", "x1", "x2", "y", "cy", "y1", "y2"):
            limit = width if "x" in name else height
            value = element.get(name)
            if value is not None:
                assert NUMBER.fullmatch(value), (element.tag, name, value)
                assert -0.5 <= float(value) <= limit + 0.5, (element.tag, name, value)
        for name in ("d", "points"):
            for value in NUMBER.finditer(element.get(name, "")):
                assert -6 <= float(value[0]) <= max(width, height) + 6
            assert not re.search("nan|inf|e", element.get(name, ""))
    return root


def texts(root, kind):
    return [t.text for t in root.iter("text") if t.get("class") == kind]


@settings(max_examples=60, deadline=None)
@given(st.lists(st.lists(VALUES, max_size=6), min_size=1, max_size=4), st.booleans(),
       st.sampled_from([svg.WIDE, svg.NARROW]))  # fmt: skip
def test_any_values_make_a_picture(ys, lie, width):
    what = (bars if lie else lambda x, *y: lines(*y))([f"n{k}" for k in range(6)], *ys)
    drawn(what, width)
    assert svg.is_empty(what) == (not any(svg.finite(y) is not None for s in ys for y in s))


@pytest.mark.parametrize("width", [svg.WIDE, svg.NARROW])
def test_the_plots_of_a_report(width):
    for part in (*sample.document()["sections"], *sample.speed()["sections"]):
        for one in part["plots"]:
            root = drawn(one, width)
            bars_and_lines = [e for e in root.iter() if "s0" in (e.get("class") or "").split()]
            assert bars_and_lines
            assert root.get("aria-label") == one["title"]


def test_a_line_goes_through_its_points():
    root = drawn(lines([0.0, 10.0, 5.0]))
    ticks = {t.text: float(t.get("y")) - 5 for t in root.iter("text") if t.get("class") == "tick"
             and t.get("text-anchor") == "end"}  # fmt: skip
    path = next(e for e in root.iter("path"))
    ys = [float(p.split()[1]) for p in path.get("d").removeprefix("M").split("L")]
    assert ys == pytest.approx([ticks["0"], ticks["10"], (ticks["0"] + ticks["10"]) / 2], abs=0.11)
    assert len(list(root.iter("circle"))) == 3


def test_gaps_stay_gaps_and_lone_points_are_seen():
    root = drawn(lines([1.0, 2.0, None, 4.0, math.nan, 5.0, 6.0, 7.0]))
    assert [len(p.get("d").split("L")) for p in root.iter("path")] == [2, 3]
    assert len(list(root.iter("circle"))) == 6
    many = [1.0] * 40 + [None, 3.0, None] + [2.0] * 40
    root = drawn(lines(many))
    assert len(list(root.iter("path"))) == 2
    assert len(list(root.iter("circle"))) == 1


def test_long_lines_stay_small():
    wave = [math.sin(k / 3000) for k in range(100_000)]
    assert len(svg.draw(lines(wave), svg.WIDE)) < 60_000


def test_series_differ_without_colour():
    root = drawn(lines(*([float(k), k + 1.0] for k in range(12))))
    dashes = [(p.get("class"), p.get("stroke-dasharray")) for p in root.iter("path")]
    assert len(set(dashes)) == 12
    assert len({d for _, d in dashes[:6]}) == 6


def test_more_series_of_bars_than_colours_differ():
    root = drawn(bars(["a"], *([k + 1.0] for k in range(12))))
    assert len({r.get("class") for r in root.iter("rect")}) == 12
    assert all(svg.swatch(k, "bars") != svg.swatch(j, "bars") for k in range(12) for j in range(k))


def test_bars_have_their_length_and_their_value():
    root = drawn(bars(["light", "heavy", "none"], [4.0, -2.0, None]))
    found = {r.get("class"): r for r in root.iter("rect")}
    assert set(found) == {"bar s0"}
    first, second = root.iter("rect")
    assert float(first.get("width")) == pytest.approx(2 * float(second.get("width")), abs=0.2)
    base = next(e for e in root.iter("line") if e.get("class") == "base")
    assert first.get("x") == base.get("x1")
    assert texts(root, "value") == ["4", "−2", "–"]
    assert texts(root, "name") == ["light", "heavy", "none"]
    assert texts(root, "axis") == ["mass [kg]", "speed [m/s]"]


def test_series_of_bars_meet_by_name():
    one = plot("p", ("", ""), ("y", ""), series("a", ["x", "y"], [1, 2]),
               series("b", ["y", "z", "y"], [3, 4, 5]), kind="bars")  # fmt: skip
    root = drawn(one)
    assert texts(root, "name") == ["x", "y", "z", "y"]
    assert texts(root, "value") == ["1", "–", "2", "3", "–", "4", "–", "5"]


def test_places_have_names_and_a_quantity():
    root = drawn(bars([0.1, 1000], [1.0, 2.0]))
    assert texts(root, "name") == ["0.1", "1000"]
    assert texts(root, "axis") == ["mass [kg]", "speed [m/s]"]


def test_lines_of_the_grid_keep_clear_of_names_above_bars():
    names = ["a name that is too long to stand beside its bar", "another that is as long as that"]
    root = drawn(bars(names, [1.0, 2.0], [3.0, 4.0]), svg.NARROW)
    lines = [(float(e.get("y1")), float(e.get("y2"))) for e in root.iter("line")]
    for text in root.iter("text"):
        if text.get("class") == "name":
            base = float(text.get("y"))
            assert all(y2 < base - 11 or base + 1 < y1 for y1, y2 in lines)


def test_lines_along_names_are_bars():
    assert svg.kind_of(plot("p", ("", ""), ("", ""), series("a", ["x"], [1.0]))) == "bars"


def test_what_is_logarithmic_is_said():
    assert svg.scales(lines([1.0, 10.0, 100.0, 1e4])) == ("vertical axis logarithmic",)
    assert svg.scales(lines([1.0, 2.0, 3.0], x=[1, 100, 10_000])) == (
        "horizontal axis logarithmic",
    )
    assert svg.scales(lines([0.0, 1.0, 10.0, 100.0, 1e4])) == ()
    assert svg.scales(bars("abcd", [0.0, 1e-9, 1e-4, 1e-2, 1.0])) == (
        "axis logarithmic, zero at its foot",
    )
    assert svg.scales(lines([])) == ()


def test_hostile_names_are_text():
    name = sample.HOSTILE
    one = plot(name, (name, name), (name, name), series(name, [name], [1.0]))
    for width in (svg.WIDE, svg.NARROW):
        root = drawn(one, width)
        assert {e.tag for e in root.iter()} <= {"svg", "text", "line", "rect"}
        for text in root.iter("text"):
            assert svg.text_width(text.text) <= width


def test_shortened_names_fit():
    assert svg.shortened("abc", 100) == "abc"
    for text in ("long name " * 20, "宽" * 60, "M" * 90):
        cut = svg.shortened(text, 200)
        assert cut.endswith("…")
        assert svg.text_width(cut) <= 200
