"""People who lie and sit on foam: pressures, areas and shares of the weight at the end."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from evidence.interface_pressures import MIDDLE
from evidence.model import Outcome
from evidence.runs import playing
from halfphysics.bench.soft import BED, SEAT, story
from halfphysics.motion.motion import Motion
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.results.layer_pressure import SHOWN
from halfphysics.simulation.sequence import Sequence

if TYPE_CHECKING:
    from halfphysics.results.result import Result

#: Parts of the body by region.
PELVIS = ("pelvis", "left_hip", "right_hip")
HEELS = ("left_ankle", "right_ankle", "left_foot", "right_foot")
BACK = ("spine2", "spine3", "left_collar", "right_collar", "left_shoulder", "right_shoulder")
#: How long the last pose is held before anything is measured [s]: foam comes to rest in half of it.
HELD = 1.5
#: Frames at the end over which forces and pressures are averaged.
LAST = 5


def measure(posture: str) -> Outcome:
    """Lie or sit down, and measure the last frames."""
    told = story(BED if posture == "lying" else SEAT)
    told = Sequence(held(told.motions[0]), told.scene, told.bodies[0])
    result = playing.run(told, {})
    return Outcome(values=lying(result) if posture == "lying" else sitting(result))


def held(motion: Motion) -> Motion:
    """A motion whose last pose is held for `HELD` more: it comes to rest."""
    more = round(HELD * motion.fps)
    translation, rotations = (
        np.concatenate([values, np.repeat(values[-1:], more, axis=0)])
        for values in (motion.translation, motion.rotations)
    )
    return motion.with_frames(translation, rotations)


def lying(result: Result) -> dict[str, float]:
    """Measures of lying, by the names of `interface_pressures`."""
    rows = _last(result)
    return {
        "mean pressure": rows.mean(),
        "area": rows.area_over(SHOWN),
        "peak of the pelvis": rows.peak(PELVIS),
        "peak of the heels": rows.peak(HEELS),
        "peak of the upper back": rows.peak(BACK),
        "share of the weight": 100.0 * rows.load() / _weight(result),
    }


def sitting(result: Result) -> dict[str, float]:
    """Measures of sitting, by the names of `interface_pressures`."""
    seat, support = _last(result, "seat"), result.people[0].support
    # With friction, which has a vertical part where a layer is askew (9 % of the weight).
    carried = sum(support.surface(name)[0][-LAST:, 2].mean() for name in ("seat", "rest"))
    return {
        "share of the weight on seat and rest": 100.0 * float(carried) / _weight(result),
        "mean pressure of the seat": seat.mean(),
        "peak of the seat": seat.peak(),
        "area of the seat": seat.area_over(SHOWN),
        "area of the seat over 4 kPa": seat.area_over(MIDDLE),
    }


def _weight(result: Result) -> float:
    parts = result.people[0].body.variant.parts
    return float(np.linalg.norm(result.scene.gravity) * sum(part.mass for part in parts))


class _Rows:
    """Samples under pressure in the last frames: pressure [Pa], area [m^2], the upward share of
    the normal, part."""

    def __init__(self, result: Result, layer: str | None) -> None:
        rows = result.soft_contacts
        assert rows is not None
        kept = rows.frame >= len(result) - LAST
        if layer is not None:
            kept &= rows.layer == result.names.index(layer)
        self.pressure, self.area = rows.pressure[kept], rows.area[kept]
        self.up, self.part = rows.normal[kept, 2], rows.part[kept]

    def load(self) -> float:
        """Upward force of the pressures [N]."""
        return float((self.pressure * self.area * self.up).sum()) / LAST

    def area_over(self, least: float) -> float:
        """Area under at least this pressure [cm^2]."""
        return 1e4 * float(self.area[self.pressure >= least].sum()) / LAST

    def mean(self) -> float:
        """Mean pressure where a mat would read one [kPa]."""
        felt = self.pressure >= SHOWN
        area = float(self.area[felt].sum())
        return 0.001 * float((self.pressure * self.area)[felt].sum()) / max(area, 1e-12)

    def peak(self, parts: tuple[str, ...] | None = None) -> float:
        """Largest pressure, of these parts of the body [kPa]."""
        kept = np.ones(len(self.part), dtype=bool)
        if parts is not None:
            kept = np.isin(self.part, [JOINT_INDEX[name] for name in parts])
        return 0.001 * float(self.pressure[kept].max(initial=0.0))


def _last(result: Result, layer: str | None = None) -> _Rows:
    return _Rows(result, layer)
