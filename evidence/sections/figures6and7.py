"""Figures 6 and 7: a body without physics, and poses that are forced into a simulation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from evidence.model import (
    Content,
    Figure,
    Options,
    Picture,
    Plot,
    Row,
    Section,
    Series,
    Task,
    at_least,
    at_most,
)
from evidence.runs import choices

Values = Mapping[str, Any]

#: The ragdoll goes limp this long before a kick and is simulated for this long [s].
BEFORE, WATCHED = 0.3, 1.0
#: Balls that are kicked [kg].
MASSES = (0.1, 0.5, 5.0, 200.0, 1000.0)
QUICK_MASSES = (0.1, 1000.0)
#: Blind to mass: the heaviest ball leaves as fast as the lightest, within this fraction.
#: Half-physics: it gets at most this fraction of its speed.
BLIND, SEEING = 0.01, 0.2
#: Forced poses: smallest depth in wall, suitcase and ball [mm]; the suitcase "barely moves" up to
#: this rise [mm]; ours follows the hands within this [mm].
DEEP, BARELY, BEHIND = 10.0, 50.0, 20.0
#: Smallest fall of the pelvis of a ragdoll, largest fall of that of half-physics [m].
FALLS, STAYS = 0.3, 0.01


@dataclass(frozen=True)
class Way:
    """A method to move a body: its name, its settings, and the claims of the paper about it.

    `through`: it walks through the wall; `forced`: it penetrates the objects that it handles, and
    they barely move; `blind`: mass has no effect. None: the paper makes no claim.
    """

    name: str
    choice: choices.Choice
    through: bool | None = None
    forced: bool | None = None
    blind: bool | None = None


#: Methods by the end of the key of a task.
WAYS = {
    "half-physics": Way("half-physics", choices.OURS, False, False, False),
    "kinematic": Way("poses set, nothing responds", {"mode": "kinematic"}, True, True),
    "positions": Way("poses forced, at 30 Hz", {"mode": "positions"}, True, True, True),
    "interpolated-240": Way(
        "poses interpolated, at 240 Hz", {"mode": "interpolated", "substeps": 8}, True, True, True
    ),
    "interpolated-1000": Way(
        "poses interpolated, at 1,020 Hz",
        {"mode": "interpolated", "substeps": 34},
        True,
        True,
        True,
    ),
    "engine-kinematic": Way(
        "MuJoCo, kinematic bodies", {"mode": "engine_kinematic"}, True, True, True
    ),
    "engine-velocity": Way("MuJoCo, velocities set", {"mode": "engine_velocity"}),
    "torque": Way("joint torques (PD)", {"mode": "torque"}, False),
    "paper": Way("half-physics, stiffness 1", choices.FIRM, False, None, False),
}
#: Methods that a quick report leaves out, and methods with a picture.
_SLOW = ("paper", "interpolated-240", "torque")
_PICTURED = {
    "wall": ("half-physics", "kinematic"),
    "lift": ("half-physics", "positions"),
}
_QUICKLY = {"wall": ("half-physics",), "lift": ("positions",)}


def _ways(options: Options) -> list[tuple[str, Way]]:
    return [(k, way) for k, way in WAYS.items() if not (options.quick and k in _SLOW)]


def _pictured(what: str, key: str, quick: bool) -> bool:
    return key in (_QUICKLY if quick else _PICTURED)[what]


def tasks(options: Options) -> list[Task]:
    """Every method at a wall, a suitcase and balls."""
    masses = list(QUICK_MASSES if options.quick else MASSES)
    found = []
    for key, way in _ways(options):
        for what in ("wall", "lift"):
            arguments = {
                "choice": way.choice,
                "strip": _pictured(what, key, options.quick),
                "quick": options.quick,
            }
            found.append(
                Task(
                    key=f"{what}/{key}",
                    function=f".runs.forcing:{what}",
                    arguments=arguments,
                    seconds=0.5 if options.quick else 1.5,
                )
            )
        found.append(
            Task(
                key=f"kick/{key}",
                function=".runs.forcing:kick",
                arguments={"choice": way.choice, "masses": masses},
                seconds=0.5 if options.quick else 2.5,
            )
        )
    found.append(
        Task(
            key="ragdoll",
            function=".runs.forcing:limp",
            arguments={"before": BEFORE, "watched": WATCHED},
            seconds=1.0,
        )
    )
    return found


def content(options: Options, values: Values) -> Content:
    """Rows by experiment and method; positions over time, speeds over mass."""
    rows: list[Row] = []
    pictures = []
    for what, data, figures in (
        ("wall", "walk_into_wall thickness=0.1", _at_wall),
        ("lift", "lift_suitcase carry=1 shake=0", _lifted),
        ("kick", "kick_ball, floating", _kicked),
    ):
        for key, way in _ways(options):
            found = values.get(f"{what}/{key}")
            if found is None:
                continue
            title = f"{_TITLES[what]}: {way.name}"
            rows.append(
                Row(
                    name=title,
                    data=data,
                    setting=choices.said(way.choice),
                    figures=tuple(figures(way, found)),
                )
            )
            if what in _PICTURED and _pictured(what, key, options.quick):
                caption = f"{title}. Blue: reference."
                pictures.append(Picture(caption=caption, task=f"{what}/{key}", name="strip"))
    if "ragdoll" in values:
        rows += _limp(values["ragdoll"])
    return Content(rows=tuple(rows), plots=_plots(options, values), pictures=tuple(pictures))


_TITLES = {
    "wall": "Figure 6, a walk into a wall",
    "lift": "Figure 7, a suitcase",
    "kick": "blindness to mass, a kick",
}


def _at_wall(way: Way, found: Values) -> list[Figure]:
    beyond = Figure(name="pelvis beyond the wall", unit="m", ours=found["beyond"])
    deepest = Figure(name="deepest", unit="mm", ours=found["deepest"])
    rate = Figure(name="penetration rate", unit="%", ours=found["rate"])
    if way.through:
        beyond = at_least(0.0, beyond.ours, name=beyond.name, unit="m")
        deepest = at_least(DEEP, deepest.ours, name=deepest.name, unit="mm")
    elif way.through is False:
        beyond = at_most(0.0, beyond.ours, name=beyond.name, unit="m")
        deepest = at_most(0.0, deepest.ours, name=deepest.name, unit="mm")
    return [beyond, rate, deepest]


def _lifted(way: Way, found: Values) -> list[Figure]:
    into = Figure(name="skin in the suitcase", unit="mm", ours=found["into_suitcase"])
    rise = Figure(name="rise", unit="mm", ours=found["rise"])
    rest = [
        Figure(name="penetration rate", unit="%", ours=found["rate"]),
        Figure(name="hands rise", unit="mm", ours=found["hands"]),
        Figure(name="the suitcase at its fastest", unit="m/s", ours=found["fastest"]),
    ]
    if way.forced:
        into = at_least(DEEP, into.ours, name=into.name, unit="mm")
        rise = at_most(BARELY, rise.ours, name=rise.name, unit="mm")
    elif way.forced is False:
        into = at_most(0.0, into.ours, name=into.name, unit="mm")
        behind = abs(found["rise"] - found["hands"])
        rest.append(at_most(BEHIND, behind, name="rise, less that of the hands", unit="mm"))
    return [into, rise, *rest]


def _kicked(way: Way, found: Values) -> list[Figure]:
    figures = [
        Figure(name=f"speed of {mass:g} kg", unit="m/s", ours=speed)
        for mass, speed in zip(found["masses"], found["speeds"], strict=True)
    ]
    low, high = found["speeds"][0], found["speeds"][-1]
    share = high / low if low > 0.0 else None
    name = f"speed of {found['masses'][-1]:g} kg, of that of {found['masses'][0]:g} kg"
    if way.blind:
        # If no ball moves, the ratio has no value, and the figure is missing.
        fastest, slowest = max(found["speeds"]), min(found["speeds"])
        spread = (fastest - slowest) / fastest if fastest > 0.0 else None
        figures.append(Figure(name=name, ours=share))
        figures.append(at_most(BLIND, spread, name="spread of the speeds"))
    elif way.blind is False:
        figures.append(at_most(SEEING, share, name=name))
    else:
        figures.append(Figure(name=name, ours=share))
    into = max(found["depths"])
    if way.blind is False:
        figures.append(at_most(0.0, into, name="skin in the ball", unit="mm"))
    elif way.blind:
        figures.append(at_least(DEEP, into, name="skin in the ball", unit="mm"))
    else:
        figures.append(Figure(name="skin in the ball", unit="mm", ours=into))
    return figures


def _limp(found: Values) -> list[Row]:
    ours, doll = found["ours"], found["ragdoll"]
    drop, errors = "pelvis lower than the reference", "joints from their place, MPJPE-g"
    data = f"kick_ball, from {BEFORE:g} s before the kick on, {WATCHED:g} s"
    return [
        Row(
            name="a ragdoll: half-physics",
            data=data,
            setting=choices.said(choices.OURS),
            figures=(
                at_most(STAYS, abs(ours["drop"]), name=drop, unit="m"),
                Figure(name=errors, unit="mm", ours=ours["mpjpe_g"]),
            ),
        ),
        Row(
            name="a ragdoll: MuJoCo, nothing drives the body",
            data=data,
            setting="no setting: evidence/runs/ragdoll.py",
            figures=(
                at_least(FALLS, doll["drop"], name=drop, unit="m"),
                Figure(name=errors, unit="mm", ours=doll["mpjpe_g"]),
            ),
            note="gravity acts on the body, and what it was doing is lost",
        ),
    ]


def _plots(options: Options, values: Values) -> tuple[Plot, ...]:
    """Charts of the three experiments and of the ragdoll, as far as they have values."""

    def over_time(what: str, field: str) -> tuple[Series, ...]:
        lines = []
        for key, way in _ways(options):
            found = values.get(f"{what}/{key}")
            if found is not None:
                times = [round(t / found["fps"], 6) for t in range(len(found[field]))]
                lines.append(Series(way.name, times, found[field]))
        return tuple(lines)

    plots = [
        Plot(
            title="Figure 6: where the pelvis is",
            x=("time", "s"),
            y=("way", "m"),
            series=over_time("wall", "way"),
        ),
        Plot(
            title="Figure 7: how high the suitcase is",
            x=("time", "s"),
            y=("height", "mm"),
            series=over_time("lift", "heights"),
        ),
        Plot(
            title="How fast a ball is kicked",
            x=("mass", "kg"),
            y=("speed", "m/s"),
            series=tuple(
                Series(way.name, found["masses"], found["speeds"])
                for key, way in _ways(options)
                if (found := values.get(f"kick/{key}")) is not None
            ),
        ),
    ]
    doll = values.get("ragdoll")
    if doll is not None:
        plots.append(_ragdoll(doll))
    return tuple(plot for plot in plots if plot.series)


def _ragdoll(doll: Values) -> Plot:
    times = [round(t / doll["fps"], 6) for t in range(len(doll["asked"]))]
    heights = {
        "reference": doll["asked"],
        "half-physics": doll["ours"]["heights"],
        "ragdoll": doll["ragdoll"]["heights"],
    }
    return Plot(
        title="A ragdoll: how high the pelvis is",
        x=("time since it went limp", "s"),
        y=("height", "m"),
        series=tuple(Series(name, times, y) for name, y in heights.items()),
    )


SECTION = Section(
    key="figures6and7",
    title="Figures 6 and 7: against forced poses",
    about="A body that is only moved walks through walls. Where its poses are forced into a "
    "simulation, once a frame or interpolated, it goes into what it handles, and light and heavy "
    "things answer alike. Half-physics is stopped, holds, and has mass its say.",
    tasks=tasks,
    content=content,
)
