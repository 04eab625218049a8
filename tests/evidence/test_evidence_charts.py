"""Charts of the report: well-formed, finite, within their box, for any values."""

from __future__ import annotations

import math
import re
from xml.etree import ElementTree

import evidence_sample as sample
import pytest
from evidence_sample import plot, series
from hypothesis import given, settings
from hypothesis import strategies as st

from evidence.page import charts
from evidence.page.chart_scale import finite

PAIR = re.compile(r"(-?[\d.]+) (-?[\d.]+)")
COLOUR = re.compile(r"var\(--(s\d)\)")
VALUES = st.one_of(st.none(), st.floats(), st.floats(-1e3, 1e3), st.integers(-5, 5))


def lines(*ys, x=None):
    return plot("p", ("time", "s"), ("height", "mm"),
                *(series(f"s{k}", x or range(len(y)), y) for k, y in enumerate(ys)))  # fmt: skip


def bars(names, *ys):
    return plot("p", ("mass", "kg"), ("speed", "m/s"),
                *(series(f"s{k}", names, y) for k, y in enumerate(ys)), kind="bars")  # fmt: skip


def drawn(plot, width=charts.WIDE):
    """The parsed chart; every coordinate in it is a number within the chart's box."""
    made = charts.draw(plot, width)
    code = re.sub(r'>[^<]*<|aria-label="[^"]*"', "", made)
    assert not re.search(r"nan|inf|#[0-9a-f]{6}|url\(|id=|xmlns|href", code)
    root = ElementTree.fromstring(made)
    height = float(root.get("height"))
    assert root.get("viewBox") == f"0 0 {width} {root.get('height')}"
    for element in root.iter():
        assert element.tag in ("svg", "path", "text")
        points = PAIR.findall(element.get("d", ""))
        if element.tag == "text":
            points = [(element.get("x"), element.get("y"))]
        if element.get("transform"):
            points = PAIR.findall(element.get("transform"))
        for x, y in points:
            assert -0.5 <= float(x) <= width + 0.5, (element.get("style"), x)
            assert -0.5 <= float(y) <= height + 0.5, (element.get("style"), y)
    return root


def texts(root):
    return [t.text for t in root.iter("text")]


def paths(root, pattern):
    """Paths whose style contains this pattern, marks left out."""
    styled = [p for p in root.iter("path") if p.get("transform") is None]
    return [p for p in styled if re.search(pattern, p.get("style"))]


def marks(root):
    moved = [p for p in root.iter("path") if p.get("transform") is not None]
    return [p for p in moved if COLOUR.search(p.get("style"))]  # ticks do not have a series' colour


def curves(root):
    return paths(root, r"stroke:var\(--s\d")


def filled(root):
    return paths(root, r"fill:var\(--s\d")


def ends(path):
    """The points of a path."""
    return [(float(x), float(y)) for x, y in PAIR.findall(path.get("d"))]


def length(bar):
    across = [x for x, _ in ends(bar)]
    return max(across) - min(across)


@settings(max_examples=30, deadline=None)
@given(st.lists(st.lists(VALUES, max_size=6), min_size=1, max_size=4), st.booleans(),
       st.sampled_from([charts.WIDE, charts.NARROW]))  # fmt: skip
def test_any_values_make_a_chart(ys, lie, width):
    what = (bars if lie else lambda x, *y: lines(*y))([f"n{k}" for k in range(6)], *ys)
    assert charts.is_empty(what) == (not any(finite(y) is not None for s in ys for y in s))
    if not charts.is_empty(what):
        drawn(what, width)


@pytest.mark.parametrize("width", [charts.WIDE, charts.NARROW])
def test_the_charts_of_a_report(width):
    for part in (*sample.document()["sections"], *sample.speed()["sections"]):
        for one in part["plots"]:
            root = drawn(one, width)
            assert any("var(--s0)" in e.get("style", "") for e in root.iter())
            assert root.get("aria-label") == one["title"]


def test_a_line_goes_through_its_points():
    root = drawn(lines([0.0, 10.0, 5.0]))
    (curve,) = curves(root)
    (x0, y0), (x1, y1), (x2, y2) = ends(curve)
    assert x1 - x0 == pytest.approx(x2 - x1, abs=0.11)
    assert y0 - y2 == pytest.approx(y2 - y1, abs=0.11)
    up = [t for t in root.iter("text") if "text-anchor:end" in t.get("style")]
    heights = {t.text: float(t.get("y")) for t in up}
    assert y0 - y1 == pytest.approx(heights["0"] - heights["10"], abs=0.21)
    assert len(marks(root)) == 3


def test_gaps_stay_gaps_and_lone_points_are_seen():
    root = drawn(lines([1.0, 2.0, None, 4.0, math.nan, 5.0, 6.0, 7.0]))
    assert len(marks(root)) == 6
    (curve,) = curves(root)
    parts = [len(PAIR.findall(part)) for part in curve.get("d").split("M")[1:]]
    assert [n for n in parts if n > 1] == [2, 3]
    many = [1.0] * 40 + [None, 3.0, None] + [2.0] * 40
    root = drawn(lines(many))
    assert len(re.findall("M[^M]*L", curves(root)[0].get("d"))) == 2
    assert len(marks(root)) == 1


def test_long_lines_stay_small():
    wave = [math.sin(k / 3000) for k in range(100_000)]
    assert len(charts.draw(lines(wave), charts.WIDE)) < 60_000


def test_series_differ_without_colour():
    root = drawn(lines(*([float(k), k + 1.0] for k in range(12))))
    styles = [p.get("style") for p in curves(root)]
    assert len(set(styles)) == 12
    assert len({COLOUR.sub("", style) for style in styles[:6]}) == 6


def test_more_series_of_bars_than_colours_differ():
    root = drawn(bars(["a"], *([k + 1.0] for k in range(12))))
    styles = {p.get("style") for p in [*filled(root), *curves(root)]}
    assert len(styles) == 12
    assert len({charts.swatch(k, "bars") for k in range(12)}) == 12
    assert len({charts.swatch(k, "lines") for k in range(12)}) == 12


def test_bars_have_their_length_and_their_value():
    root = drawn(bars(["light", "heavy", "none"], [4.0, -2.0, None]))
    first, second = filled(root)
    assert length(first) == pytest.approx(2 * length(second), abs=0.3)
    assert min(x for x, _ in ends(first)) == pytest.approx(max(x for x, _ in ends(second)), abs=0.2)
    assert {"4", "−2", "–", "light", "heavy", "none", "mass [kg]", "speed [m/s]"} <= set(
        texts(root)
    )


def test_bars_on_a_logarithmic_scale_differ_by_decades():
    root = drawn(bars("abcd", [0.01, 0.1, 1.0, 10.0]))
    a, b, c, d = map(length, filled(root))
    assert b - a == pytest.approx(c - b, abs=0.3)
    assert c - b == pytest.approx(d - c, abs=0.3)


def test_series_of_bars_meet_by_name():
    one = plot("p", ("", ""), ("y", ""), series("a", ["x", "y"], [1, 2]),
               series("b", ["y", "z", "y"], [3, 4, 5]), kind="bars")  # fmt: skip
    found = charts._categories(one)
    assert found == [("x", [1, None]), ("y", [2, 3]), ("z", [None, 4]), ("y", [None, 5])]
    assert texts(drawn(one)).count("–") == 3


def test_places_have_names_and_a_quantity():
    found = texts(drawn(bars([0.1, 1000], [1.0, 2.0])))
    assert {"0.1", "1000", "mass [kg]", "speed [m/s]"} <= set(found)


def test_long_names_are_above_their_bars():
    names = ["a name that is too long to stand beside its bar", "another that is as long as that"]
    root = drawn(bars(names, [1.0, 2.0], [3.0, 4.0]), charts.NARROW)
    tops = [min(y for _, y in ends(bar)) for bar in filled(root)]
    for name, top in zip(names, (tops[0], tops[2]), strict=True):
        start = name[:20]
        (text,) = (t for t in root.iter("text") if t.text.startswith(start))
        assert top - 12 < float(text.get("y")) < top


def test_lines_along_names_are_bars():
    assert charts.kind_of(plot("p", ("", ""), ("", ""), series("a", ["x"], [1.0]))) == "bars"


def test_logarithmic_scales_are_named():
    assert charts.scales(lines([1.0, 10.0, 100.0, 1e4])) == ("vertical axis logarithmic",)
    assert charts.scales(lines([1.0, 2.0, 3.0], x=[1, 100, 10_000])) == (
        "horizontal axis logarithmic",
    )
    assert charts.scales(lines([0.0, 1.0, 10.0, 100.0, 1e4])) == ()
    assert charts.scales(bars("abcd", [0.0, 1e-9, 1e-4, 1e-2, 1.0])) == (
        "axis logarithmic, zero at its foot",
    )
    assert charts.scales(lines([])) == ()


def test_the_same_chart_is_the_same_bytes():
    one = lines([1.0, 2.0, None, 4.0])
    assert charts.draw(one, charts.WIDE) == charts.draw(one, charts.WIDE)


def test_a_users_matplotlib_settings_change_nothing():
    import matplotlib

    one = bars(["a $x$"], [1.0])
    expected = charts.draw(one, charts.WIDE)
    with matplotlib.rc_context({"font.size": 30, "text.color": "red", "axes.grid": True}):
        assert charts.draw(one, charts.WIDE) == expected


def test_hostile_names_are_text():
    name = sample.HOSTILE
    one = plot(name, (name, name), (name, name), series(name, [name], [1.0]))
    for width in (charts.WIDE, charts.NARROW):
        for text in texts(drawn(one, width)):
            assert charts.text_width(text) <= width


def test_shortened_names_fit():
    assert charts.shortened("abc", 100) == "abc"
    for text in ("long name " * 20, "宽" * 60, "M" * 90):
        cut = charts.shortened(text, 200)
        assert cut.endswith("…")
        assert charts.text_width(cut) <= 200
