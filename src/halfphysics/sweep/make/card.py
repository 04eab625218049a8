"""The card of a sample: its sources, the checks of its simulation, and its events.

A card has plain JSON values, equal for the same simulation on every machine: no time of day, no
folder of a machine, and null for every number that is not finite.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.baselines import options_of
from halfphysics.results.layer_pressure import pressures
from halfphysics.sweep.make.provenance import versions
from halfphysics.sweep.make.source_name import source_name
from halfphysics.sweep.plan.plan import OF_SUPPORT

if TYPE_CHECKING:
    from halfphysics.labels.event_kinds import Events
    from halfphysics.motion.motion import Motion
    from halfphysics.results.result import PersonResult, Result
    from halfphysics.settings import Settings
    from halfphysics.sweep.plan.plan import Plan
    from halfphysics.sweep.plan.variants import Variant

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

#: Version of the card's layout.
VERSION = 1
#: The checks that a successful simulation passes, see `checks`.
CHECKS = ("whole", "finite", "clear", "in_time")


class Made(Protocol):
    """The part of `vary.Ready` that the card reads."""

    @property
    def motions(self) -> tuple[Motion, ...]:
        """The reference motion of each person."""

    @property
    def settings(self) -> Settings:
        """The settings of the simulation."""

    @property
    def sources(self) -> tuple[Mapping[str, str], ...]:
        """ "path" and "sha256" of every source file."""


class Labelled(Protocol):
    """The part of `labels.ContactLabels` that the card reads."""

    @property
    def threshold_m(self) -> float:
        """Largest distance at which a vertex touches an object [m]."""


@dataclass(frozen=True)
class Checks:
    """The checks of a simulation; a success passes all four.

    Attributes:
        whole: The result has as many frames as the reference motion.
        finite: Every number of people, objects and contacts is finite.
        clear: No new overlap appears after the first frame without overlap: frame 0, or
            the frame in which all initial overlaps are resolved. A body that stays inside
            fails.
        in_time: No blocked step was shortened.
    """

    whole: bool
    finite: bool
    clear: bool
    in_time: bool

    @property
    def failed(self) -> list[str]:
        """Names of the failed checks."""
        return [name for name in CHECKS if not getattr(self, name)]


def checks(result: Result, motions: Iterable[Motion]) -> Checks:
    """The checks of a simulation; see docs/sweeps.md.

    Args:
        result: The result of the simulation.
        motions: The reference motion of each person.
    """
    asked = [len(motion) for motion in motions]
    return Checks(
        whole=[len(person.motion) for person in result.people] == asked,
        finite=_finite(result),
        clear=_stays_clear(result),
        in_time=not result.lost_time.any(),
    )


def _finite(result: Result) -> bool:
    arrays = [
        *(a for p in result.people for a in (p.motion.translation, p.motion.rotations)),
        *(a for t in result.objects.values() for a in (t.position, t.quaternion)),
        *result.joints.values(),
        *(getattr(result.contacts, name) for name in ("position", "normal", "impulse")),
        result.lost_time,
    ]
    return all(bool(np.isfinite(array).all()) for array in arrays)


def _stays_clear(result: Result) -> bool:
    clear = result.clearance >= 0.0
    clear[result.inside.frame] = False
    return bool(clear.any() and clear[clear.argmax() :].all())


def card_of(
    plan: Plan, variant: Variant, ready: Made, result: Result, labels: Labelled, events: Events
) -> dict[str, Any]:
    """The card of one sample. What holds people up is in it if the plan's outputs have it.

    Args:
        plan: The plan of the sweep.
        variant: The variant that was simulated.
        ready: The input of the simulation.
        result: The result of the simulation.
        labels: Its contact labels.
        events: Its holds, slips and drops.

    Returns:
        JSON values; docs/sweeps.md explains each.
    """
    return {
        "card": VERSION,
        **_made_from(plan, variant, ready),
        **_outcome(ready, result),
        **_happened(result, labels, events),
        **(_support(result) if plan.outputs.support else dict.fromkeys(OF_SUPPORT)),
    }


def _made_from(plan: Plan, variant: Variant, ready: Made) -> dict[str, Any]:
    """The part of a card about the sources of the sample."""
    return {
        "number": variant.number,
        "plan": plan.identity,
        "seed": plan.seed,
        "input": variant.input.name,
        "body": variant.body.name,
        "scene": variant.scene.name,
        "factors": plain(variant.factors),
        "settings": plain(options_of(ready.settings)),
        "sources": [_source(source, variant, plan.base) for source in ready.sources],
        "versions": versions(),
    }


def _outcome(ready: Made, result: Result) -> dict[str, Any]:
    """The part of a card about the checks and errors of the simulation."""
    found = checks(result, ready.motions)
    local, everywhere = _deviation(result.people)
    reach = result.settings.clearance_range
    statics = len(result.names) - len(result.objects) - len(result.people)
    return {
        "success": not found.failed,
        "checks": plain(found),
        "frames": len(result),
        "fps": result.fps,
        "seconds": (len(result) - 1) / result.fps,
        "lost_time": _number(result.lost_time.sum()),
        "clearance_min": _number(np.minimum(result.clearance, reach).min()) if statics else reach,
        "started_inside": int(np.count_nonzero(result.inside.frame == 0)),
        "joint_error_mean_mm": _number(1000.0 * everywhere.mean()),
        "joint_error_max_mm": _number(1000.0 * everywhere.max()),
        "pose_error_mean_mm": _number(1000.0 * local.mean()),
    }


def _happened(result: Result, labels: Labelled, events: Events) -> dict[str, Any]:
    """The part of a card about events: contacts, holds, slips, drops, travel."""
    slips = events.slips
    strength = result.contacts.strength
    by_people = result.contacts.person >= 0
    objects = {name: _travel(result, name) for name in result.objects}
    return {
        "contacts": int(np.count_nonzero(strength)),
        "threshold_m": float(labels.threshold_m),
        "impulse": _number(strength[by_people].sum()),
        "force_max": _number(strength[by_people].max(initial=0.0) * result.fps),
        "holds": len(events.holds),
        "held_seconds": sum(hold.end - hold.start for hold in events.holds),
        "lost_grasps": events.lost,
        "slips": len(slips),
        "slid": sum(slip.distance for slip in slips),
        "drops": len(events.drops),
        "held": plain(list(result.holds)),
        "objects": objects,
        "travel_max": max((its["travel"] or 0.0 for its in objects.values()), default=0.0),
        **_pressed(result),
        "events": events.document(),
    }


def _pressed(result: Result) -> dict[str, float | None]:
    """The part of a card about soft things: of the pair that is largest."""
    found = pressures(result)
    columns = {"pressure_max": "peak", "pressure_mean": "mean", "pressure_area": "area"}
    return {
        name: _number(max((getattr(its, column).max() for its in found), default=0.0))
        for name, column in columns.items()
    }


def _support(result: Result) -> dict[str, float | None]:
    """The part of a card about what holds people up: of the person for whom each is largest."""
    supports = [person.support for person in result.people]
    carried = [support.weight_percent.max() / 100.0 for support in supports]
    return {
        "unsupported_percent": _number(max(support.unsupported_percent for support in supports)),
        "carried_max": _number(max(carried)),
    }


def _deviation(people: Iterable[PersonResult]) -> tuple[Array, Array]:
    """Distances of all joints from the record [m]: relative to the pelvis, and in the world."""
    pairs = [person.joint_errors() for person in people]
    return np.stack([p[0] for p in pairs]), np.stack([p[1] for p in pairs])


def _travel(result: Result, name: str) -> dict[str, float | None]:
    """Motion of an object: path length [m], largest distance [m] and turn [rad] from its start."""
    track = result.objects[name]
    turns = rot.normalize(track.quaternion)
    turned = np.linalg.norm(rot.log(rot.multiply(rot.conjugate(turns[0]), turns)), axis=1)
    away = np.linalg.norm(track.position - track.position[0], axis=1)
    return {
        "travel": _number(np.linalg.norm(np.diff(track.position, axis=0), axis=1).sum()),
        "away_max": _number(away.max()),
        "turn_max": _number(turned.max()),
    }


def _source(source: Mapping[str, str], variant: Variant, base: Path) -> dict[str, str]:
    """A source file: its path as in the plan, or its name if the plan has no path of it."""
    path = source_name(source["path"], base)
    said = {
        source_name(where, base): name
        for where, name in (
            (variant.input.path, variant.input.name),
            (variant.scene.path, variant.scene.file),
            (variant.body.path, variant.body.model),
        )
        if where is not None and name is not None
    }
    name = said.get(path, os.path.basename(path) if os.path.isabs(path) else path)
    return {"path": name, "sha256": source["sha256"]}


def plain(value: Any) -> Any:
    """Dataclasses, mappings, paths and numpy's numbers as JSON values."""
    if is_dataclass(value) and not isinstance(value, type):
        return {field.name: plain(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, Mapping):
        return {str(key): plain(its) for key, its in value.items()}
    if isinstance(value, list | tuple):
        return [plain(each) for each in value]
    if isinstance(value, np.generic | np.ndarray):
        return plain(value.tolist())
    if isinstance(value, Path):
        return value.as_posix()
    return _number(value) if isinstance(value, float) else value


def _number(value: float | np.floating[Any]) -> float | None:
    """A number for JSON; None if it is not finite."""
    return float(value) if math.isfinite(value) else None
