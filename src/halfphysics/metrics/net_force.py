"""Net force on a person, in body weights."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from halfphysics.base.short_repr import short_repr
from halfphysics.metrics.airborne import free_fall
from halfphysics.metrics.argument_checks import Array, check_result

if TYPE_CHECKING:
    from halfphysics.results.result import Result

#: Shorter than this is an impact [s].
IMPACT = 0.05


@dataclass(frozen=True, kw_only=True, eq=False)
class NetForceReport:
    """Sum of all contact forces on a person over T frames.

    Attributes:
        weight: Body weight [N].
        force: Mean over (t-1, t] of the sum of all contact forces (T, 3) [N].
        peak: Largest size [N].
        peak_weights: The same in body weights.
        window_weights: Largest size of the mean over 50 ms [body weights].
        sustained_weights: Largest size that is held for 50 ms [body weights]: the force is at least
            this in each frame of some window that long. Impacts that are shorter do not count.
    """

    weight: float
    force: Array
    peak: float
    peak_weights: float
    window_weights: float
    sustained_weights: float

    __repr__ = short_repr


def net_force(result: Result, person: int = 0) -> NetForceReport:
    """The net force of all contacts on a person: statics, objects and other people.

    A frame's force is its impulse over its length; a window has as many whole frames as 50 ms need
    (two at 30 fps), so that it is never shorter. Self-contact cancels.

    Args:
        result: The result of a simulation.
        person: Index of the person.

    Raises:
        InputError: No result, or no such person.
        FileError: In a result from a file: the body has gone.
    """
    check_result(result)
    result._check_person(person)
    contacts, own = result.contacts, len(result.names) - len(result.people) + person
    rows = (contacts.person == person) & (contacts.other != own)
    force = np.zeros((len(result), 3))
    np.add.at(force, contacts.frame[rows], contacts.impulse[rows] * result.fps)
    weight = free_fall(result.scene) * float(result.people[person].body.variant.mass)
    return net_force_from(force, result.fps, weight)


def net_force_from(force: Array, fps: float, weight: float) -> NetForceReport:
    """The report of forces (T, 3) [N] on a person of a `weight` [N]."""
    size = np.linalg.norm(force, axis=1)
    count = min(max(1, int(np.ceil(IMPACT * fps - 1e-9))), len(force))
    windows = np.lib.stride_tricks.sliding_window_view
    mean = windows(force, count, axis=0).mean(axis=-1)
    held = windows(size, count).min(axis=-1)
    force.setflags(write=False)
    return NetForceReport(
        weight=weight,
        force=force,
        peak=float(size.max()),
        peak_weights=float(size.max()) / weight,
        window_weights=float(np.linalg.norm(mean, axis=1).max()) / weight,
        sustained_weights=float(held.max()) / weight,
    )
