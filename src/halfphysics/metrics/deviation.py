"""Deviation of a simulated motion from what was recorded, in and out of contact."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.copying import FrozenMapping
from halfphysics.base.short_repr import short_repr
from halfphysics.base.validation import number
from halfphysics.metrics.argument_checks import check_result
from halfphysics.motion.joint_groups import JOINT_GROUPS
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.results.result import SETTLE

if TYPE_CHECKING:
    from halfphysics.results.result import Result

#: The groups of `JOINT_GROUPS` for which deviations are reported.
GROUPS = ("trunk", "head", "arms", "hands", "legs", "feet", "all")


@dataclass(frozen=True, kw_only=True, eq=False)
class Deviation:
    """Mean deviation from what was recorded over some frames; all 0 if there are none.

    Attributes:
        frames: Number of frames.
        root_mm: Distance of the root from that of the record, in the world [mm].
        root_deg: Angle between its rotation and that of the record [deg].
        local_mm: Distance of a group's joints from the record's, both relative to their pelvis
            without a rotation [mm]; by group.
        angle_deg: Angle between the rotations of a group's joints, in their parents' frames, and
            the record's [deg]; by group.
    """

    frames: int
    root_mm: float
    root_deg: float
    local_mm: Mapping[str, float]
    angle_deg: Mapping[str, float]

    __repr__ = short_repr


@dataclass(frozen=True, kw_only=True, eq=False)
class IntentReport:
    """Deviation of a person's motion from what was recorded (`PersonResult.recorded`).

    Attributes:
        whole: Over all frames.
        free: Over frames in which nothing acts on the person (`Result.free_frames`).
        touched: Over the others: in contact, or shortly after.
    """

    whole: Deviation
    free: Deviation
    touched: Deviation

    __repr__ = short_repr


def deviation(result: Result, person: int = 0, *, settle: float = SETTLE) -> IntentReport:
    """Deviation of a person's simulated motion from what was recorded, by group of joints.

    Hands that were adapted to what they hold deviate by that too, also where nothing touches.

    Args:
        result: The result of a simulation.
        person: Index of the person.
        settle: Time after a contact in which frames still count as touched [s].

    Raises:
        InputError: No result, no such person, or an impossible time.
        FileError: In a result from a file: the body has gone.
    """
    check_result(result)
    settle = number(settle, "settle", least=0.0, unit="s")
    free = result.free_frames(person, settle)
    simulated = result.people[person]
    local = 1000.0 * simulated.joint_errors()[0]
    angle = np.rad2deg(rot.angles(simulated.recorded.rotations, simulated.motion.rotations))
    shift = simulated.motion.translation - simulated.recorded.translation
    root = 1000.0 * np.linalg.norm(shift, axis=-1)

    def over(frames: NDArray[np.bool_]) -> Deviation:
        def mean(values: NDArray[np.float64]) -> float:
            return float(values[frames].mean()) if frames.any() else 0.0

        joints = {g: [JOINT_INDEX[name] for name in JOINT_GROUPS[g]] for g in GROUPS}
        return Deviation(
            frames=int(frames.sum()),
            root_mm=mean(root),
            root_deg=mean(angle[:, 0]),
            local_mm=FrozenMapping({g: mean(local[:, its]) for g, its in joints.items()}),
            angle_deg=FrozenMapping({g: mean(angle[:, its]) for g, its in joints.items()}),
        )

    return IntentReport(whole=over(np.ones_like(free)), free=over(free), touched=over(~free))
