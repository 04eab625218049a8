"""Clearance, speed, contact force and support over time, with a line at the present time."""

from __future__ import annotations

import html
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.motion.skeleton import JOINT_INDEX

if TYPE_CHECKING:
    from halfphysics.results.result import Result

Array = NDArray[np.float64]

#: Colours of lines, one per result or person; the recorded motion is grey and dashed.
COLORS = ("#1f6fd6", "#d9480f", "#2b8a3e", "#9c36b5", "#0b7285", "#c2255c")
_ASKED = "#8a94a0"
_WARNING = "#f03e3e"

#: Points whose speed can be plotted, beside objects: label -> joint.
POINTS = {"pelvis": "pelvis", "left hand": "left_wrist", "right hand": "right_wrist"}

# Size of a plot [pixels]: height, width of the left axis, padding on the right.
_HEIGHT, _LEFT, _RIGHT = 92, 44, 14
_AXIS, _TOP, _LABEL = 24, 6, 14
# Most points of a line; a panel has fewer pixels across.
_POINTS = 600


@dataclass(frozen=True, kw_only=True, eq=False)
class Line:
    """One line of a plot.

    Attributes:
        label: Name of the line.
        time: (T,) [s].
        value: (T,); nan where there is no value.
        dashed: Draw dashed and grey: the recorded motion.
        warning: Draw wide and red: what should not be.
    """

    label: str
    time: Array
    value: Array
    dashed: bool = False
    warning: bool = False


def clearance(results: Sequence[Result], labels: Sequence[str]) -> list[Line]:
    """Minimum distance to static geometry [mm], a line per result; nan beyond its range."""
    lines = []
    for result, label in zip(results, labels, strict=True):
        value = 1e3 * np.asarray(result.clearance, dtype=np.float64)
        value = np.where(np.isfinite(value), value, np.nan)
        lines.append(Line(label=label, time=_times(result), value=value))
    return lines


def force(results: Sequence[Result], labels: Sequence[str]) -> list[Line]:
    """Sum of the magnitudes of all forces on people [N], one line per result."""
    lines = []
    for result, label in zip(results, labels, strict=True):
        contacts = result.contacts
        mine = np.asarray(contacts.person) >= 0
        size = np.linalg.norm(np.asarray(contacts.impulse)[mine], axis=1) * result.fps
        value = np.zeros(len(result.motion))
        np.add.at(value, np.asarray(contacts.frame)[mine], size)
        lines.append(Line(label=label, time=_times(result), value=value))
    return lines


def speed(results: Sequence[Result], labels: Sequence[str], what: str) -> list[Line]:
    """Speed of a point of the people (see `POINTS`) or of an object [m/s].

    One line per result and person, and the recorded motion of the people of the first result.
    """
    lines = []
    for index, (result, label) in enumerate(zip(results, labels, strict=True)):
        if what not in POINTS:
            if what in result.objects:
                track = np.asarray(result.objects[what].position)
                lines.append(_speed(label, result, track))
            continue
        joint = JOINT_INDEX[POINTS[what]]
        asked = []
        for person in result.people:
            name = label if len(result.people) == 1 else f"{label} {person.name}".strip()
            lines.append(_speed(name, result, person.body.joints(person.motion)[:, joint]))
            if index == 0:
                track = person.body.joints(person.recorded)[:, joint]
                asked.append(_speed("reference", result, track, dashed=True))
        lines += asked
    return lines


def support(results: Sequence[Result], labels: Sequence[str]) -> list[Line]:
    """What holds people up, and what does not though it is needed [% of the weight].

    Two lines per result and person: the upward force of everything on them, and, in frames in which
    they are held up by nothing (`Support.unsupported`), the upward force that is missing.
    """
    lines = []
    for result, label in zip(results, labels, strict=True):
        for person in result.people:
            name = label if len(result.people) == 1 else f"{label} {person.name}".strip()
            found, time = person.support, _times(result)
            lines.append(Line(label=name, time=time, value=found.weight_percent))
            missing = np.where(found.unsupported, found.residual_percent, np.nan)
            lines.append(Line(label="by nothing", time=time, value=missing, warning=True))
    return lines


def items(results: Sequence[Result]) -> list[str]:
    """Choices for `speed`: points of people and names of objects."""
    return [*POINTS, *dict.fromkeys(name for result in results for name in result.objects)]


def _speed(label: str, result: Result, track: Array, *, dashed: bool = False) -> Line:
    if len(track) > 1:
        value = np.linalg.norm(np.gradient(track, 1.0 / result.fps, axis=0), axis=1)
    else:
        value = np.zeros(len(track))
    return Line(label=label, time=_times(result), value=value, dashed=dashed)


def _times(result: Result) -> Array:
    return np.arange(len(result.motion)) / result.fps


def aligned(lines: Sequence[Line], duration: float) -> tuple[Array, ...]:
    """Times and the values of all lines at these times, in the form of a plot's data.

    A line with more frames than times keeps the largest value of each interval, so that no peak
    is lost.
    """
    count = min(max((len(line.time) for line in lines), default=2), _POINTS)
    time = np.linspace(0.0, duration, max(count, 2))
    columns = []
    for line in lines:
        if len(line.time) > len(time):
            slot = np.round(line.time / duration * (len(time) - 1)).astype(int)
            column = np.full(len(time), np.nan)
            np.fmax.at(column, np.minimum(slot, len(time) - 1), line.value)
        else:
            column = _interpolated(time, line)
        columns.append(column)
    return (time, *columns)


def _interpolated(time: Array, line: Line) -> Array:
    """Values of a line at other times: nan where the nearest frame's is, and after its end."""
    there = np.isfinite(line.value)
    if not there.any():
        return np.full(len(time), np.nan)
    value = np.interp(time, line.time[there], line.value[there])
    spacing = line.time[1] - line.time[0] if len(line.time) > 1 else 1.0
    nearest = np.round(time / spacing).astype(int)
    ended = nearest >= len(there)
    missing = ended | ~there[np.minimum(nearest, len(there) - 1)]
    return np.where(missing, np.nan, value)


class Plots:
    """Plots in the panel, one below the other, with a line at the present time.

    The plots are sent once; the line is a separate small element over each plot.

    Args:
        gui: viser's GUI, within the folder or tab of the plots.
        results: The results to plot.
        labels: Names of the results.
        duration: Length of the time axis [s].
    """

    def __init__(
        self, gui: Any, results: Sequence[Result], labels: Sequence[str], duration: float
    ) -> None:
        self._gui = gui
        self._results, self._duration = results, max(duration, 1e-3)
        names = list(labels) if len(results) > 1 else ["body"]
        self._names = names
        self._cursors: list[Any] = []
        self.has_support = False
        self._at = ""
        self.heads: dict[str, Any] = {}
        self.charts: dict[str, Any] = {}
        self._add("clearance", "Clearance of people [mm]", clearance(results, names))
        self._add("force", "Force on people [N]", force(results, names))
        self.choice = gui.add_dropdown("Speed of", tuple(items(results)), initial_value="pelvis")
        self.choice.on_update(lambda _: self._choose(self.choice.value))
        self._add("speed", "Speed of pelvis [m/s]", speed(results, names, "pelvis"), last=True)

    def _add(self, name: str, title: str, lines: Sequence[Line], *, last: bool = False) -> None:
        bottom: dict[str, Any] = {"size": _AXIS, "space": 46, **_LOOK}
        if last:
            bottom |= {"label": "Time [s]", "labelSize": _LABEL, "labelFont": _FONT, "labelGap": 0}
        self.heads[name] = self._gui.add_html(_head(title, lines))
        self._cursors.append(self._gui.add_html(""))
        self.charts[name] = self._gui.add_uplot(
            aligned(lines, self._duration),
            _series(lines),
            height=_HEIGHT + (_LABEL if last else 0),
            legend={"show": False},
            cursor={"drag": {"x": False, "y": False, "setScale": False}},
            scales={
                "x": {"time": False, "range": (0.0, self._duration)},
                "y": {"range": _range(lines)},
            },
            axes=(bottom, {"size": _LEFT, "space": 24, **_LOOK}),
            padding=(_TOP, _RIGHT, 0, 0),
        )

    def _choose(self, what: str) -> None:
        lines = speed(self._results, self._names, what)
        chart = self.charts["speed"]
        self.heads["speed"].content = _head(f"Speed of {what} [m/s]", lines)
        chart.series = _series(lines)
        chart.scales = {**chart.scales, "y": {"range": _range(lines)}}
        chart.data = aligned(lines, self._duration)

    def add_support(self) -> None:
        """Add the plot of what holds people up, within the same folder or tab."""
        lines = support(self._results, self._names)
        self._add("support", "Held up [% of the weight]", lines, last=True)
        self.has_support, self._at = True, ""

    def show(self, time: float) -> None:
        """Move the time lines to a time [s]."""
        share = min(max(time / self._duration, 0.0), 1.0)
        at = f"{share:.4f}"
        if at == self._at:
            return
        self._at = at
        for cursor in self._cursors:
            cursor.content = _cursor(at)


_FONT = "11px system-ui, sans-serif"
_LOOK = {"font": _FONT, "gap": 3, "ticks": {"size": 4, "width": 1, "stroke": "#ced4da"}}


def _cursor(share: str) -> str:
    """A time line over the next plot, as an element of zero height."""
    return (
        f'<div style="position:relative;height:0;z-index:2;pointer-events:none">'
        f'<div style="position:absolute;top:{12 + _TOP}px;height:{_HEIGHT - _TOP - _AXIS}px;'
        f"width:2px;background:#e03131;margin-left:-1px;"
        f'left:calc({_LEFT + 11}px + {share}*(100% - {_LEFT + _RIGHT + 22}px))"></div></div>'
    )


def _series(lines: Sequence[Line]) -> tuple[Any, ...]:
    series: list[Any] = [{"label": "time [s]"}]
    for line, color in zip(lines, _colors(lines), strict=True):
        one = {"label": line.label, "stroke": color, "width": 1.5, "points": {"show": False}}
        if line.dashed:
            one["dash"] = (4.0, 3.0)
        if line.warning:
            one["width"] = 3.0
        series.append(one)
    return tuple(series)


def _colors(lines: Sequence[Line]) -> list[str]:
    own = iter(COLORS * len(lines))
    return [_ASKED if line.dashed else _WARNING if line.warning else next(own) for line in lines]


def _range(lines: Sequence[Line]) -> tuple[float, float]:
    """From 0, or just below the smallest negative value, to just above the largest value."""
    values = np.concatenate([line.value for line in lines]) if lines else np.zeros(0)
    values = values[np.isfinite(values)]
    if not len(values):
        return 0.0, 1.0
    low, high = min(0.0, float(values.min())), float(values.max())
    room = 0.08 * max(high - low, 1e-3)
    return (low - room if low < 0.0 else 0.0), high + room


def _head(title: str, lines: Sequence[Line]) -> str:
    keys = (
        ""
        if len(lines) == 1
        else "".join(
            f'<span style="white-space:nowrap;margin-left:10px;color:#495057">'
            f'<span style="display:inline-block;width:16px;border-top:2px '
            f"{'dashed' if line.dashed else 'solid'} {color};vertical-align:middle;"
            f'margin-right:4px"></span>{html.escape(line.label)}</span>'
            for line, color in _keys(lines)
        )
    )
    return (
        f'<div style="font-size:12px;line-height:1.35;margin:8px 11px -6px 11px">'
        f"<b>{html.escape(title)}</b>{keys}</div>"
    )


def _keys(lines: Sequence[Line]) -> list[tuple[Line, str]]:
    """Lines with their colours, without warnings that never occur or repeat others."""
    out: list[tuple[Line, str]] = []
    for line, color in zip(lines, _colors(lines), strict=True):
        known = any(other.warning for other, _ in out)
        if not line.warning or (np.isfinite(line.value).any() and not known):
            out.append((line, color))
    return out
