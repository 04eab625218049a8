"""Settings, gravity and limits of strength, handed to the core."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics._native import tuning
from halfphysics.body.footing_points import SIDES, footing_points
from halfphysics.body.joint_ranges import JointRanges
from halfphysics.body.strength import limits_of
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.settings import HALF_PHYSICS

if TYPE_CHECKING:
    from halfphysics.settings import Settings
    from halfphysics.simulation.coordinates import Person

Array = NDArray[np.float64]

#: Least clearance that the core is given [m].
LEAST_CLEARANCE = tuning.least_clearance


def set_settings(core: Any, settings: Settings, gravity: Array) -> None:
    """Give the core its settings and gravity (3,) [m/s^2]."""
    s, drive = settings, settings.drive
    core.set_drive(
        time_constant=0.0 if drive.torque_frequency else float(s.drive_time or 0.0),
        recovery_rate=float(s.recovery_rate),
        recover_root=s.root == "recover",
        root_speed=float(s.root_speed),
    )
    core.set_contact(
        clearance=max(float(s.clearance), LEAST_CLEARANCE),
        clearance_range=float(s.clearance_range),
        depenetration_speed=float(s.depenetration_speed),
        tolerance=float(s.tolerance),
        max_sweeps=s.max_sweeps,
        gravity=np.array(gravity, dtype=np.float64),
    )
    core.set_baselines(
        internal_forces=drive.internal_forces,
        joint_damping=float(drive.joint_damping),
        torque_frequency=float(drive.torque_frequency),
        torque_damping=float(drive.torque_damping),
    )


def set_limits(core: Any, settings: Settings, people: Sequence[Person]) -> None:
    """Give the core, after its `finish`, limits of what people exert and of how far joints go."""
    _set_strength(core, settings, people)
    _set_joint_ranges(core, settings, people)


def _set_strength(core: Any, settings: Settings, people: Sequence[Person]) -> None:
    """Give the core what the people's drives can exert, where `Settings.strength` limits it."""
    if settings.strength is None:
        return
    for index, person in enumerate(people):
        force, torque = limits_of(settings.strength, person.body)
        core.set_strength(index, np.concatenate([[force], torque[person.balls]]))


def _set_joint_ranges(core: Any, settings: Settings, people: Sequence[Person]) -> None:
    """Give the core the ranges of people's joints, if `Settings.joint_limits`: not of baselines."""
    if not settings.joint_limits or settings.drive != HALF_PHYSICS:
        return
    for index, person in enumerate(people):
        ranges = JointRanges.of(person.body)
        axes, lower, upper = (
            np.ascontiguousarray(v[person.balls]).ravel()
            for v in (ranges.axes, ranges.lower, ranges.upper)
        )
        core.set_joint_ranges(index, axes=axes, lower=lower, upper=upper)


def set_footing(core: Any, settings: Settings, people: Sequence[Person]) -> None:
    """Have people wait and stand as `Settings.blocked` and `weight` say, after the core's `finish`.

    Those of baselines do neither.
    """
    if settings.drive != HALF_PHYSICS:
        return
    core.set_waiting(settings.blocked == "wait")
    if not settings.weight:
        return
    legs = [[JOINT_INDEX[f"{side}_{joint}"] for joint in _LEG] for side in SIDES]
    for index, person in enumerate(people):
        points = footing_points(person.body)
        if min(points.soles) == 0:
            continue  # a model without feet
        core.set_footing(
            person=index,
            joints=np.ascontiguousarray(person.bodies[legs], dtype=np.int32),
            soles=np.array(points.soles, dtype=np.int32),
            hands=points.hands,
            body=np.ascontiguousarray(person.bodies[points.joints], dtype=np.int32).ravel(),
            weight=np.ascontiguousarray(points.weights).ravel(),
            local=np.ascontiguousarray(points.local.reshape(-1, 3)),
            normal=np.ascontiguousarray(points.normals),
        )


_LEG = ("hip", "knee", "ankle")
