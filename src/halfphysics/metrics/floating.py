"""Floating: a person in the air whose motion is not, and PhysDiff's physical errors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import validation
from halfphysics.base.short_repr import short_repr
from halfphysics.base.validation import number, shown
from halfphysics.errors import InputError
from halfphysics.metrics.airborne import airborne, free_fall
from halfphysics.metrics.argument_checks import Array, check_motion
from halfphysics.metrics.skating import foot_skate
from halfphysics.metrics.skins import batches, frames_of, skin
from halfphysics.metrics.surface_gaps import carrying_gaps

if TYPE_CHECKING:
    from halfphysics.scene.scene import Scene

#: What counts as touching, as in PhysDiff (Yuan et al. 2023, section 4) [m].
TOLERANCE = 0.005
#: Gaps beyond this, and frames with nothing below, count as this [m].
MOST = 1.0


@dataclass(frozen=True, kw_only=True, eq=False)
class FloatReport:
    """Floating over T frames.

    Attributes:
        percent: Share of the frames that are not airborne in which the person floats [%].
        mean_mm: Mean over the frames that are not airborne of the gap where it floats, else 0 [mm].
        max_mm: Largest gap of those frames [mm].
        gap: Minimum distance of the skin from a surface that can carry it (T,) [m]: negative
            inside one; at most 1 m.
        airborne: Frames in which the motion is airborne by itself (T,).
        floats: Frames in which the person floats (T,).
    """

    percent: float
    mean_mm: float
    max_mm: float
    gap: Array
    airborne: NDArray[np.bool_]
    floats: NDArray[np.bool_]

    __repr__ = short_repr


def floating(
    motion: Any,
    body: Any,
    scene: Scene,
    *,
    objects: Mapping[str, Any] | None = None,
    reference: Any = None,
    tolerance: float = TOLERANCE,
) -> FloatReport:
    """Frames in which no skin is near a surface that can carry it, though the person does not jump.

    The gap is the minimum distance of any skin (soles, seat, back, hands) from a surface of a
    static, an object or a link from which the shortest way to the skin rises by at least 30
    degrees: a wall beside a person carries nobody. What is soft carries from the surface that
    nothing presses downwards. A person floats where the gap is over `tolerance` and `reference` is
    not airborne (`halfphysics.metrics.airborne`).

    Args:
        motion: T frames.
        body: The person's body.
        scene: Statics and objects.
        objects: Name -> track of T poses, as in ``result.objects``; those not named are left out.
        reference: The motion that tells which frames are airborne; None: `motion`.
        tolerance: Gap up to which skin touches [m].

    Raises:
        InputError: No motion, body or scene, an impossible tolerance, a reference or a track of
            another length.
    """
    from halfphysics.scene.scene import Scene

    check_motion("motion", motion)
    validation.body(body, "vertices")
    if not isinstance(scene, Scene):
        raise InputError(f"scene: expected a halfphysics.Scene, found {shown(scene)}")
    tolerance = number(tolerance, "tolerance", least=0.0, unit="m")
    reference = motion if reference is None else reference
    check_motion("reference", reference)
    if len(reference) != len(motion):
        raise InputError(
            f"reference: found {len(reference)} frames, expected {len(motion)} as of the motion"
        )
    every = np.zeros(len(body.vertices(motion, slice(0, 1))[0]), dtype=np.intp)
    found = carrying_gaps(motion, body, scene, every, objects=objects, reach=MOST, visible=True)
    return floating_from(found.whole, airborne(reference, body, free_fall(scene)), tolerance)


def floating_from(
    gap: Array, in_air: NDArray[np.bool_], tolerance: float = TOLERANCE
) -> FloatReport:
    """The report of gaps (T,) [m] and of the frames (T,) that are airborne by themselves."""
    gap = np.minimum(gap, MOST)
    floats = (gap > tolerance) & ~in_air
    count = max(int((~in_air).sum()), 1)
    for array in (gap, in_air, floats):
        array.setflags(write=False)
    return FloatReport(
        percent=float(100.0 * floats.sum() / count),
        mean_mm=float(1000.0 * gap[floats].sum() / count),
        max_mm=float(1000.0 * gap[floats].max()) if floats.any() else 0.0,
        gap=gap,
        airborne=in_air,
        floats=floats,
    )


@dataclass(frozen=True, kw_only=True)
class PhysDiffReport:
    """The measures of PhysDiff (Yuan et al. 2023), on level ground.

    Attributes:
        penetrate_mm: Mean over frames of the depth of the lowest vertex under the ground [mm].
        float_mm: Mean over frames of the height of the lowest vertex above it [mm].
        skate_mm: Mean horizontal displacement of feet on the ground [mm/frame]
            (`FootSkate.mean_mm`).
        phys_err_mm: The sum of the three.
    """

    penetrate_mm: float
    float_mm: float
    skate_mm: float
    phys_err_mm: float


def physdiff(motion: Any, body: Any, *, ground: float = 0.0) -> PhysDiffReport:
    """Penetrate, Float, Skate and Phys-Err as PhysDiff defines them, with its tolerance of 5 mm.

    A depth or height up to 5 mm counts as 0. The ground is level; furniture, jumps and stairs are
    not known to these measures.

    Args:
        motion: T >= 2 frames.
        body: The person's body.
        ground: Height of the ground [m].

    Raises:
        InputError: No motion, no body, fewer than 2 frames, an impossible height.
    """
    ground = number(ground, "ground", unit="m")
    skate = foot_skate(motion, body, ground=ground).mean_mm
    lowest = np.concatenate(
        [
            skin(motion, body, part)[..., 2].min(axis=1)
            for part in batches(frames_of(motion), "heights")
        ]
    )
    return physdiff_from(lowest, skate, ground)


def physdiff_from(lowest: Array, skate_mm: float, ground: float = 0.0) -> PhysDiffReport:
    """The report of the heights of the lowest vertex (T,) [m], and of the skate [mm/frame]."""
    height = 1000.0 * (lowest - ground)
    over = 1000.0 * TOLERANCE
    depth = float(np.where(height < -over, -height, 0.0).mean())
    above = float(np.where(height > over, height, 0.0).mean())
    return PhysDiffReport(
        penetrate_mm=depth, float_mm=above, skate_mm=skate_mm, phys_err_mm=depth + above + skate_mm
    )
