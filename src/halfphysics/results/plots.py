"""Charts of a result over time: clearance, forces, offsets, support."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.optional_package import optional
from halfphysics.base.short_repr import counted
from halfphysics.base.validation import shown
from halfphysics.errors import InputError

if TYPE_CHECKING:
    from halfphysics.results.result import Result

Array = NDArray[np.float64]

#: Width of a figure and height of each of its charts [inches].
_WIDTH, _HEIGHT = 8.0, 2.1
#: Things whose forces are drawn one by one; the rest are left out.
MOST = 6


def plot(result: Result, what: str | Sequence[str], ax: Any) -> Any:
    """The work behind `Result.plot`."""
    one = isinstance(what, str) or not isinstance(what, Iterable)
    names: tuple[Any, ...] = (what,) if one else tuple(what)
    unknown = [name for name in names if not isinstance(name, str) or name not in CHARTS]
    if unknown or not names:
        raise InputError(f"plot: found {shown(what)}, expected some of {', '.join(CHARTS)}")
    pyplot = optional("matplotlib.pyplot", "plots", "notebook")
    if ax is None:
        size = (_WIDTH, _HEIGHT * len(names) + 0.6)
        figure, axes = pyplot.subplots(
            len(names), sharex=True, squeeze=False, figsize=size, layout="constrained"
        )
        charts = list(axes[:, 0])
    else:
        charts = list(np.atleast_1d(np.asarray(ax, dtype=object)).ravel())
        strange = [one for one in charts if not hasattr(one, "axhline")]
        if strange:
            raise InputError(f"plot: ax: found {shown(strange[0])}, expected axes of matplotlib")
        if len(charts) != len(names):
            raise InputError(
                f"plot: found {counted(len(charts), 'axis', 'axes')} for {len(names)} charts "
                f"({', '.join(names)}), expected one each"
            )
        figure = charts[0].figure
    time = np.arange(len(result)) / result.fps
    for name, chart in zip(names, charts, strict=True):
        CHARTS[name](result, chart, time)
        chart.grid(alpha=0.25, linewidth=0.6)
        chart.margins(x=0.0)
        for side in ("top", "right"):
            chart.spines[side].set_visible(False)
        if chart.get_legend_handles_labels()[0]:
            place: dict[str, Any] = {"loc": "best"}
            if ax is None:  # beside the lines, where a figure of our own has room
                place = {"loc": "center left", "bbox_to_anchor": (1.0, 0.5)}
            chart.legend(fontsize="small", frameon=False, **place)
    charts[-1].set_xlabel("time [s]")
    if ax is None and "inline" in pyplot.get_backend().lower():
        pyplot.close(figure)  # a notebook shows what a cell returns: not twice
    return figure


def _clearance(result: Result, chart: Any, time: Array) -> None:
    beyond = result.settings.clearance_range
    distance = np.where(np.isfinite(result.clearance), result.clearance, np.nan)
    chart.plot(time, 1000.0 * distance, label="to statics")
    least = 1000.0 * result.settings.clearance
    chart.axhline(least, linewidth=0.8, linestyle=":", color="0.4", label="kept clear")
    if not np.isfinite(distance).any():
        note = f"farther than {1000.0 * beyond:g} mm in all frames"
        chart.text(0.5, 0.5, note, transform=chart.transAxes, ha="center", va="center")
    chart.set_ylim(bottom=min(0.0, 1000.0 * _least(distance)))
    chart.set_ylabel("clearance [mm]")


def _least(values: Array) -> float:
    known = values[np.isfinite(values)]
    return float(known.min()) if len(known) else 0.0


def _forces(result: Result, chart: Any, time: Array) -> None:
    """Sizes of the contact forces between each person and each thing: impulses over a frame."""
    contacts = result.contacts
    lines = []
    for index, person in enumerate(result.people):
        own = contacts[contacts.person == index]
        earlier = len(result.names) - len(result.people) + np.arange(index)
        for other in np.setdiff1d(own.other, earlier):  # their pair is there already
            rows = own[own.other == other]
            vector = np.zeros((len(result), 3))
            np.add.at(vector, rows.frame, rows.impulse * result.fps)
            whose = f"{person.name}: " if len(result.people) > 1 else ""
            lines.append((np.linalg.norm(vector, axis=1), f"{whose}{result.names[other]}"))
    lines.sort(key=lambda line: -line[0].max())
    for force, label in lines[:MOST]:
        chart.plot(time, force, label=label)
    if len(lines) > MOST:
        chart.plot([], [], " ", label=f"and {len(lines) - MOST} more")
    chart.set_ylim(bottom=0.0)
    chart.set_ylabel("contact force [N]")


def _offsets(result: Result, chart: Any, time: Array) -> None:
    """Distances of the joints from the motion as recorded, in the world."""
    for index, person in enumerate(result.people):
        distance = 1000.0 * person.joint_errors()[1]
        whose = f"{person.name}: " if len(result.people) > 1 else ""
        mean = chart.plot(time, distance.mean(axis=1), label=f"{whose}mean of joints")[0]
        color = mean.get_color()
        chart.plot(time, distance.max(axis=1), "--", color=color, label=f"{whose}largest")
        chart.fill_between(time, distance.max(axis=1), alpha=0.08, color=color, zorder=index)
    chart.set_ylim(bottom=0.0)
    chart.set_ylabel("offset [mm]")


def _support(result: Result, chart: Any, time: Array) -> None:
    """Upward force of all that holds a person up, of the weight."""
    for person in result.people:
        label = person.name if len(result.people) > 1 else "supports"
        chart.plot(time, person.support.weight_percent, label=label)
    chart.axhline(100.0, linewidth=0.8, linestyle=":", color="0.4", label="weight")
    chart.set_ylabel("support [% of weight]")


#: What can be drawn, by its name.
CHARTS: dict[str, Callable[[Any, Any, Array], None]] = {
    "clearance": _clearance,
    "forces": _forces,
    "offsets": _offsets,
    "support": _support,
}
