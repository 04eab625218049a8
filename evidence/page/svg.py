"""Plots as inline SVG: lines and bars, drawn at the width at which they are shown.

Text is 14 px and stays 14 px, so that a plot is drawn twice, for a wide page and for a phone.
Colours come from the page's style (classes `s0` to `s5`); the shape of marks and the dashes of
lines tell series apart without them.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Mapping, Sequence
from html import escape
from itertools import pairwise
from typing import Any

from evidence.page.axis import Axis, axis, finite
from evidence.page.wording import MISSING, number, plain, quantity, signed

#: Widths in px: of a page, and of a phone.
WIDE, NARROW = 720, 340

_FONT = 14.0
_COLOURS = 6
_DASHES = ("", "7 4", "2 4", "9 3 2 3", "14 5", "5 2")
#: Above as many points a line has no marks.
_MARKED = 24
#: Bars show as many decades at most: a longer axis makes nothing look like something.
_BAR_DECADES = 6
_NARROW_LETTERS = frozenset("iIjlftr.,:;'|!()[] -")


def text_width(text: str) -> float:
    """About how wide a text is in px; rather too wide than too narrow."""
    ems = 0.0
    for letter in text:
        if unicodedata.east_asian_width(letter) in "WF" or letter in "mwMW@%":
            ems += 1.0
        elif letter in _NARROW_LETTERS:
            ems += 0.46
        else:
            ems += 0.7 if letter.isupper() else 0.645
    return ems * _FONT


def shortened(text: str, width: float) -> str:
    """A text cut to a width in px, with an ellipsis where something is left off."""
    if text_width(text) <= width:
        return text
    while text and text_width(text + "…") > width:
        text = text[:-1]
    return text.rstrip() + "…"


def kind_of(plot: Mapping[str, Any]) -> str:
    """ "lines" or "bars": lines too become bars where what they run along is no number."""
    named = any(isinstance(x, str) for series in plot["series"] for x in series["x"])
    return "bars" if plot["kind"] == "bars" or named else "lines"


def is_empty(plot: Mapping[str, Any]) -> bool:
    """Whether there is no finite value to draw."""
    return all(finite(y) is None for series in plot["series"] for y in series["y"])


def scales(plot: Mapping[str, Any]) -> tuple[str, ...]:
    """What a reader must know of the axes before reading values off them."""
    words = []
    if kind_of(plot) == "lines":
        across, up = _axes(plot, 5, 5)
        for name, one in (("horizontal", across), ("vertical", up)):
            if one.log:
                words.append(f"{name} axis logarithmic" + (", zero at its foot" * one.zero))
    elif (along := _bar_axis(plot, 5)).log:
        words.append("axis logarithmic" + (", zero at its foot" * along.zero))
    return tuple(words)


def draw(plot: Mapping[str, Any], width: int) -> str:
    """A plot of the report as an SVG element of a width in px."""
    inside, height = (_bars if kind_of(plot) == "bars" else _lines)(plot, width)
    label = escape(plain(plot["title"]))
    return (
        f'<svg viewBox="0 0 {width} {_px(height)}" width="{width}" height="{_px(height)}" '
        f'role="img" aria-label="{label}">{"".join(inside)}</svg>'
    )


def swatch(k: int, kind: str) -> str:
    """The sign of series `k` in a legend."""
    if kind == "bars":
        inside = f'<rect class="{_bar_kind(k)}" x="7" y="1" width="14" height="12" rx="2"/>'
    else:
        inside = _path([(1.0, 7.0), (27.0, 7.0)], k) + _mark(k, 14.0, 7.0)
    return f'<svg class="swatch" width="28" height="14" aria-hidden="true">{inside}</svg>'


def _px(value: float) -> str:
    return f"{value:.1f}".removesuffix(".0")


def _text(x: float, y: float, text: str, anchor: str = "start", kind: str = "") -> str:
    ends = "" if anchor == "start" else f' text-anchor="{anchor}"'
    named = f' class="{kind}"' if kind else ""
    return f'<text x="{_px(x)}" y="{_px(y)}"{ends}{named}>{escape(text)}</text>'


def _line(x1: float, y1: float, x2: float, y2: float, kind: str) -> str:
    return f'<line class="{kind}" x1="{_px(x1)}" y1="{_px(y1)}" x2="{_px(x2)}" y2="{_px(y2)}"/>'


def _path(points: Sequence[tuple[float, float]], k: int) -> str:
    steps = "L".join(f"{_px(x)} {_px(y)}" for x, y in points)
    dash = _DASHES[(k + k // _COLOURS) % len(_DASHES)]
    dashes = f' stroke-dasharray="{dash}"' if dash else ""
    return f'<path class="line s{k % _COLOURS}"{dashes} d="M{steps}"/>'


def _mark(k: int, x: float, y: float) -> str:
    """A mark whose shape goes with the series."""
    kind = f'class="mark s{k % _COLOURS}"'
    shape = k % 4
    if shape == 0:
        return f'<circle {kind} cx="{_px(x)}" cy="{_px(y)}" r="3.6"/>'
    if shape == 1:
        return f'<rect {kind} x="{_px(x - 3.4)}" y="{_px(y - 3.4)}" width="6.8" height="6.8"/>'
    corners = {
        2: ((0, -4.6), (4.4, 3.4), (-4.4, 3.4)),
        3: ((0, -4.8), (4.8, 0), (0, 4.8), (-4.8, 0)),
    }[shape]
    places = " ".join(f"{_px(x + dx)},{_px(y + dy)}" for dx, dy in corners)
    return f'<polygon {kind} points="{places}"/>'


def _pairs(series: Mapping[str, Any]) -> list[tuple[float, float] | None]:
    """The points of a line; None where there is a gap."""
    points: list[tuple[float, float] | None] = []
    for x, y in zip(series["x"], series["y"], strict=False):
        across, up = finite(x), finite(y)
        points.append(None if across is None or up is None else (across, up))
    return points


def _axes(plot: Mapping[str, Any], across: int, up: int) -> tuple[Axis, Axis]:
    points = [p for series in plot["series"] for p in _pairs(series) if p is not None]
    return (
        axis((x for x, _ in points), ticks=across, snug=True),
        # A curve that leaves zero is read where zero is.
        axis((y for _, y in points), ticks=up, log=False if 0 in {y for _, y in points} else None),
    )


def _fitting(make: Any, room: float) -> Axis:
    """The axis with the most ticks (from 7 down to 2) whose labels keep clear of each other."""
    for count in range(7, 1, -1):
        found: Axis = make(count)
        clear = all(
            (b.at - a.at) * room > (text_width(a.label) + text_width(b.label)) / 2 + 10
            for a, b in pairwise(found.ticks)
        )
        if clear:
            return found
    ends = found.ticks[:: max(1, len(found.ticks) - 1)][:1]
    return Axis(found.low, found.high, found.log, ends, found.zero)


def _lines(plot: Mapping[str, Any], width: int) -> tuple[list[str], float]:
    height = 340.0 if width >= 600 else 270.0
    _, up = _axes(plot, 5, 5)
    points = [p for series in plot["series"] for p in _pairs(series) if p is not None]
    left = max((text_width(tick.label) for tick in up.ticks), default=0.0) + 12
    right, top, bottom = width - 24.0, 34.0, height - 46.0
    across = _fitting(
        lambda count: axis((x for x, _ in points), ticks=count, snug=True), right - left
    )
    out = [_text(2, 16, shortened(quantity(*plot["y"]), width - 4), kind="axis")]
    for tick in up.ticks:
        y = bottom - tick.at * (bottom - top)
        out.append(_line(left, y, right, y, "grid"))
        out.append(_text(left - 8, y + 5, tick.label, "end", "tick"))
    out.append(_line(left, bottom, right, bottom, "base"))
    for tick in across.ticks:
        x = left + tick.at * (right - left)
        half = text_width(tick.label) / 2
        out.append(_line(x, bottom, x, bottom + 5, "base"))
        middle = min(max(x, half + 1), width - half - 1)
        out.append(_text(middle, bottom + 20, tick.label, "middle", "tick"))
    name = shortened(quantity(*plot["x"]), right - left)
    out.append(_text((left + right) / 2, height - 6, name, "middle", "axis"))
    for k, series in enumerate(plot["series"]):
        placed = [
            None
            if p is None
            else (left + across.at(p[0]) * (right - left), bottom - up.at(p[1]) * (bottom - top))
            for p in _pairs(series)
        ]
        out.extend(_curve(placed, k))
    return out, height


def _curve(points: list[tuple[float, float] | None], k: int) -> list[str]:
    """A line with gaps; marks where points are few, and where one stands alone."""
    out: list[str] = []
    marked = sum(p is not None for p in points) <= _MARKED
    run: list[tuple[float, float]] = []
    marks: list[str] = []
    for point in [*points, None]:
        if point is not None:
            # What is nearer than a pixel to the point before it cannot be seen.
            near = run and abs(point[0] - run[-1][0]) + abs(point[1] - run[-1][1]) < 1
            if not near:
                run.append(point)
            continue
        if len(run) > 1:
            out.append(_path(run, k))
        if marked or len(run) == 1:
            marks.extend(_mark(k, *p) for p in run)
        run = []
    return out + marks


def _categories(plot: Mapping[str, Any]) -> list[tuple[str, list[float | None]]]:
    """Name of each bar's place and the values of all series there, in order of appearance."""
    count = len(plot["series"])
    table: dict[tuple[str, int], list[float | None]] = {}
    for k, series in enumerate(plot["series"]):
        seen: dict[str, int] = {}
        for x, y in zip(series["x"], series["y"], strict=False):
            name = plain(x) if isinstance(x, str) else signed(number(x))
            again = seen[name] = seen.get(name, 0) + 1
            table.setdefault((name, again), [None] * count)[k] = finite(y)
    return [(name, values) for (name, _), values in table.items()]


def _bar_axis(plot: Mapping[str, Any], ticks: int) -> Axis:
    values = (y for _, row in _categories(plot) for y in row)
    return axis(values, ticks=ticks, from_zero=True, decades=_BAR_DECADES)


def _bars(plot: Mapping[str, Any], width: int) -> tuple[list[str], float]:
    """Bars that lie, so that names of any length can be read."""
    rows = _categories(plot)
    widest = max((text_width(name) for name, _ in rows), default=0.0)
    beside = widest <= 0.3 * width
    left = widest + 12 if beside else 2.0
    shown = [y for _, row in rows for y in row]
    labels = max((text_width(number(y)) for y in shown), default=0.0) + 10
    negative = any(y is not None and y < 0 for y in shown)
    start, end = left + (labels if negative else 0.0), width - max(labels, 24.0)
    along = _fitting(lambda count: _bar_axis(plot, count), end - start)
    foot = start + max(0.0, along.at(0.0)) * (end - start)
    thick, gap = (18.0, 12.0) if len(plot["series"]) > 1 else (22.0, 12.0)
    head = quantity(*plot["x"])
    y = 26.0 if head else 6.0
    drawn: list[str] = []
    spans: list[tuple[float, float]] = []
    for name, row in rows:
        if not beside:
            drawn.append(_text(2, y + 14, shortened(name, width - 4), kind="name"))
            y += 20
        else:
            middle = y + len(row) * thick / 2 + 5
            drawn.append(_text(left - 10, middle, name, "end", "name"))
        spans.append((y - 2, y + len(row) * thick + 2))
        for k, value in enumerate(row):
            drawn.extend(_bar(k, value, y, thick, foot, start, end, along))
            y += thick
        y += gap
    bottom = y - gap + 6
    if beside:  # no name stands in the way
        spans = [(spans[0][0], bottom)] if spans else []
    grid: list[str] = []
    for tick in along.ticks:
        x = start + tick.at * (end - start)
        grid.extend(_line(x, y1, x, y2, "grid") for y1, y2 in spans)
        half = text_width(tick.label) / 2
        place = min(max(x, half + 1), width - half - 1)
        grid.append(_text(place, bottom + 18, tick.label, "middle", "tick"))
    grid.extend(_line(foot, y1, foot, y2, "base") for y1, y2 in spans)
    if head:
        grid.append(_text(2, 16, shortened(head, width - 4), kind="axis"))
    name = shortened(quantity(*plot["y"]), width - 4)
    half = text_width(name) / 2
    place = min(max((start + end) / 2, half + 2), width - half - 2)
    grid.append(_text(place, bottom + 40, name, "middle", "axis"))
    return grid + drawn, bottom + 48


def _bar_kind(k: int) -> str:
    """The style of a series of bars: where there are no more colours, they are hollow."""
    return f"bar s{k % _COLOURS}" + (" hollow" if k // _COLOURS % 2 else "")


def _bar(
    k: int,
    value: float | None,
    y: float,
    thick: float,
    foot: float,
    start: float,
    end: float,
    along: Axis,
) -> list[str]:
    """One bar and its value beside its end."""
    middle = y + thick / 2 + 5
    if value is None:
        return [_text(foot + 6, middle, MISSING, kind="value")]
    tip = start + along.at(value) * (end - start)
    out = []
    if abs(tip - foot) > 0.05:
        x, long = min(tip, foot), abs(tip - foot)
        out.append(
            f'<rect class="{_bar_kind(k)}" x="{_px(x)}" y="{_px(y + 1)}" '
            f'width="{max(long, 1.0):.1f}" height="{_px(thick - 3)}" rx="1.5"/>'
        )
    if value < 0:
        out.append(_text(tip - 6, middle, signed(number(value)), "end", "value"))
    else:
        out.append(_text(max(tip, foot) + 6, middle, number(value), kind="value"))
    return out
