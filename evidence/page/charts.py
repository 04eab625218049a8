"""Charts of the report, drawn by matplotlib: lines over an axis, and bars by name."""

from __future__ import annotations

import math
import unicodedata
import warnings
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import text_to_path
from numpy.typing import NDArray

from evidence.page.chart_scale import finite, linear, logarithmic, over_decades
from evidence.page.chart_svg import COLOURS, FONT, element, figure, style
from evidence.page.wording import MISSING, number, plain, quantity, signed

#: Widths [px]: of a page and of a phone.
WIDE, NARROW = 720, 340

_SERIES = 6  # colours
_DASHES = ("solid", (0, (7, 4)), (0, (2, 4)), (0, (9, 3, 2, 3)), (0, (14, 5)), (0, (5, 2)))
_MARKERS = ("o", "s", "^", "D")
_MARKER_SIZES = (7.0, 6.6, 8.0, 6.6)  # [px]: of the same area to the eye
#: A line of more points has no marks.
_MARKED = 24
#: Bars show at most this many decades: over a longer scale, a negligible value looks large.
_BAR_DECADES = 6
#: Names of bars stand beside them up to this fraction of the width, else above them.
_BESIDE = 0.3


def kind_of(plot: Mapping[str, Any]) -> str:
    """ "lines" or "bars": lines over names instead of numbers are drawn as bars."""
    named = any(isinstance(x, str) for series in plot["series"] for x in series["x"])
    return "bars" if plot["kind"] == "bars" or named else "lines"


def is_empty(plot: Mapping[str, Any]) -> bool:
    """Whether there is no value to draw."""
    return not (_lengths(plot) if kind_of(plot) == "bars" else _along(plot, 1))


def scales(plot: Mapping[str, Any]) -> tuple[str, ...]:
    """What a reader has to know about the scales before reading values off them."""
    if kind_of(plot) == "bars":
        return ("axis logarithmic, zero at its foot",) if over_decades(_lengths(plot)) else ()
    return tuple(
        f"{name} axis logarithmic"
        for axis, name in enumerate(("horizontal", "vertical"))
        if _is_log(_along(plot, axis))
    )


def draw(plot: Mapping[str, Any], width: int) -> str:
    """A chart that is not empty as an SVG element of a width in px."""
    with style():
        made = (_bars if kind_of(plot) == "bars" else _lines)(plot, width)
        return element(made, {"role": "img", "aria-label": plain(plot["title"])})


@cache
def swatch(k: int, kind: str) -> str:
    """The sign of series `k` in a legend."""
    with style():
        made = figure(28, 14, None)
        axes = made.add_axes((0, 0, 1, 1), xlim=(0, 28), ylim=(0, 14))
        axes.set_axis_off()
        if kind == "bars":
            axes.barh([7], [14], height=12, left=7, clip_on=False, **_fill(k))
        else:
            axes.plot([1, 27], [7, 7], clip_on=False, **_stroke(k))
            axes.plot([14], [7], clip_on=False, **_mark(k))
        return element(made, {"class": "swatch", "aria-hidden": "true"})


@cache
def text_width(text: str) -> float:
    """Width of a text in px, as the layout sees it."""
    wide = sum(unicodedata.east_asian_width(letter) in "WF" for letter in text)
    font = FontProperties(family="DejaVu Sans", size=FONT)
    with warnings.catch_warnings(action="ignore"):  # the font of the layout lacks wide letters
        width, _, _ = text_to_path.get_text_width_height_descent(text, font, ismath=False)
    return float(width) + 0.45 * FONT * wide


def shortened(text: str, width: float) -> str:
    """A text cut to a width in px, with an ellipsis where something is left out."""
    if text_width(text) <= width:
        return text
    while text and text_width(text + "…") > width:
        text = text[:-1]
    return text.rstrip() + "…"


# -- lines ---------------------------------------------------------------------------------------


def _lines(plot: Mapping[str, Any], width: int) -> Figure:
    made = figure(width, 340 if width > NARROW else 270, "constrained")
    axes = made.add_subplot()
    for k, series in enumerate(plot["series"]):
        _line(axes, k, series)
    intervals = 7 if width > NARROW else 4
    across, up = _along(plot, 0), _along(plot, 1)
    (logarithmic if _is_log(across) else linear)(axes, "x", intervals)
    (logarithmic if _is_log(up) else linear)(axes, "y", 5)
    if not _is_log(up) and 0 < min(up) <= max(up) / 2:  # zero is near
        axes.update_datalim([(across[0], 0.0)])
    axes.autoscale_view()
    if not _is_log(across) and max(across) > min(across):
        axes.set_xlim(right=max(across))
    axes.grid(axis="y")
    axes.spines[["left", "right", "top"]].set_visible(False)
    axes.tick_params(axis="y", length=0)
    _name(made, axes, quantity(*plot["y"]), quantity(*plot["x"]), width)
    return made


def _line(axes: Axes, k: int, series: Mapping[str, Any]) -> None:
    """One line with gaps; marks where points are few, and where one stands alone."""
    x, y = _points(series)
    axes.plot(x, y, clip_on=False, **_stroke(k))
    known = ~np.isnan(y)
    padded = np.concatenate([[False], known, [False]])
    shown = known if known.sum() <= _MARKED else known & ~padded[:-2] & ~padded[2:]
    if shown.any():
        axes.plot(x[shown], y[shown], clip_on=False, zorder=3, **_mark(k))


def _points(series: Mapping[str, Any]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The points of a line; both coordinates are NaN where one of them is missing."""
    pairs = zip(map(finite, series["x"]), map(finite, series["y"]), strict=False)
    rows = [(math.nan, math.nan) if None in pair else pair for pair in pairs]
    x, y = np.array(rows, dtype=np.float64).reshape(-1, 2).T
    return x, y


def _along(plot: Mapping[str, Any], axis: int) -> list[float]:
    """All coordinates of lines along one axis."""
    return [float(v) for s in plot["series"] for v in _points(s)[axis] if not math.isnan(v)]


def _is_log(values: Sequence[float]) -> bool:
    """Whether lines have a logarithmic scale: one that reaches zero is read at zero."""
    return 0 not in values and over_decades(values)


def _stroke(k: int) -> dict[str, Any]:
    dash = _DASHES[(k + k // _SERIES) % len(_DASHES)]
    return {"color": COLOURS[f"s{k % _SERIES}"], "linestyle": dash, "linewidth": 2}


def _mark(k: int) -> dict[str, Any]:
    """A mark whose shape belongs to the series."""
    return {
        "linestyle": "none",
        "marker": _MARKERS[k % len(_MARKERS)],
        "markersize": _MARKER_SIZES[k % len(_MARKERS)],
        "markerfacecolor": COLOURS[f"s{k % _SERIES}"],
        "markeredgecolor": COLOURS["paper"],
        "markeredgewidth": 1,
    }


# -- bars ----------------------------------------------------------------------------------------


def _bars(plot: Mapping[str, Any], width: int) -> Figure:
    """Horizontal bars, so that names of any length can be read."""
    rows = _categories(plot)
    beside = max(text_width(name) for name, _ in rows) <= _BESIDE * width
    thick = 18.0 if len(plot["series"]) > 1 else 22.0
    head = 0.0 if beside else 20.0
    title = quantity(*plot["x"])
    pitch = head + len(plot["series"]) * thick + 12  # from a name to the next one [px]
    made = figure(width, len(rows) * pitch + (70 if title else 46), "constrained")
    axes = made.add_subplot()
    for j, (name, row) in enumerate(rows):
        if not beside:
            _name_above(axes, j * pitch + 10, shortened(name, width - 8))
        for k, value in enumerate(row):
            _bar(axes, k, value, j * pitch + head + (k + 0.5) * thick, thick - 3)
    lengths = _lengths(plot)
    if over_decades(lengths):
        least, most = min(v for v in lengths if v), max(lengths)
        foot = max(math.floor(math.log10(least)), math.ceil(math.log10(most)) - _BAR_DECADES)
        logarithmic(axes, "x", 7 if width > NARROW else 4, linear_to=10.0**foot)
    else:
        linear(axes, "x", 7 if width > NARROW else 4)
    axes.axvline(0, color=COLOURS["soft"], linewidth=1, clip_on=False)
    axes.autoscale_view()
    middles = [(j + 0.5) * pitch - 6 for j in range(len(rows))] if beside else []
    axes.set_yticks(middles, [name for name, _ in rows][: len(middles)])
    axes.set_ylim(len(rows) * pitch - 6, -4)
    axes.tick_params(axis="y", length=0, labelcolor=COLOURS["ink"])
    axes.tick_params(axis="x", length=0)
    axes.set_axisbelow(True)
    axes.grid(axis="x")
    axes.spines[:].set_visible(False)
    _name(made, axes, title, quantity(*plot["y"]), width)
    return made


def _name_above(axes: Axes, y: float, name: str) -> None:
    """A name above its bars, on the colour of the page: lines of the grid do not cross it."""
    ground = {"facecolor": COLOURS["paper"], "edgecolor": "none", "pad": 1}
    place = axes.get_yaxis_transform()
    axes.text(0, y, name, va="center", transform=place, in_layout=False, bbox=ground)


def _bar(axes: Axes, k: int, value: float | None, y: float, thick: float) -> None:
    """One bar and its value to the right of it."""
    if value:
        axes.barh([y], [value], height=thick, clip_on=False, **_fill(k))
    said = MISSING if value is None else signed(number(value))
    axes.annotate(said, (max(value or 0.0, 0.0), y), (6, 0), textcoords="offset pixels",
                  va="center_baseline", annotation_clip=False)  # fmt: skip


def _fill(k: int) -> dict[str, Any]:
    """The look of a series of bars: hollow where there are no more colours."""
    colour = COLOURS[f"s{k % _SERIES}"]
    hollow = k // _SERIES % 2
    inside = "none" if hollow else colour
    return {"facecolor": inside, "edgecolor": colour, "linewidth": 2 if hollow else 0}


def _categories(plot: Mapping[str, Any]) -> list[tuple[str, list[float | None]]]:
    """The name of each row of bars and the values of all series there, as they come."""
    table: dict[tuple[str, int], list[float | None]] = {}
    for k, series in enumerate(plot["series"]):
        seen: dict[str, int] = {}
        for x, y in zip(series["x"], series["y"], strict=False):
            name = plain(x) if isinstance(x, str) else signed(number(x))
            again = seen[name] = seen.get(name, 0) + 1
            row = table.setdefault((name, again), [None] * len(plot["series"]))
            row[k] = finite(y)
    return [(name, values) for (name, _), values in table.items()]


def _lengths(plot: Mapping[str, Any]) -> list[float]:
    return [y for _, row in _categories(plot) for y in row if y is not None]


# -- both ----------------------------------------------------------------------------------------


def _name(made: Figure, axes: Axes, above: str, below: str, width: int) -> None:
    """The names of both axes: one above at the left, one below in the middle."""
    if above:
        made.suptitle(shortened(above, width - 4), x=2 / width, ha="left", fontsize=FONT,
                      color=COLOURS["soft"])  # fmt: skip
    axes.set_xlabel(shortened(below, 0.75 * width))
