"""Lines of `Result.summary` about standing: floating, slide in stance, net force, way back."""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING

import numpy as np

from halfphysics.errors import HalfPhysicsError
from halfphysics.metrics.airborne import airborne, free_fall
from halfphysics.metrics.asked import asked_motion
from halfphysics.metrics.floating import MOST, FloatReport, floating_from
from halfphysics.metrics.net_force import net_force
from halfphysics.metrics.path_offset import path_of
from halfphysics.metrics.range_violations import TOLERANCE, range_violations
from halfphysics.metrics.scene_solids import known_tracks
from halfphysics.metrics.stance import stance_slide
from halfphysics.metrics.surface_gaps import carrying_gaps
from halfphysics.metrics.unsupported import unsupported_weight
from halfphysics.results.result import ObjectTrack

if TYPE_CHECKING:
    from halfphysics.motion.motion import Motion
    from halfphysics.results.result import PersonResult, Result

#: Floating is measured in this many frames, evenly spread, of a longer result; support and slide in
#: results of up to so many frames: the summary takes no second.
SAMPLED, STANCE = 150, 1000
#: An offset and a tilt at the end that are less than these are not reported [mm, deg].
EXACT_MM, EXACT_DEG = 1.0, 0.1


def standing(result: Result, index: int) -> list[str]:
    """How a person stands, in up to six lines; missing files leave lines out."""
    person = result.people[index]
    lines = []
    with suppress(HalfPhysicsError):  # named where the joints are compared
        floats = _floats(result, person)
        lines += floats
        if floats:  # there is a floor
            lines += _carried(result, index)
        lines += [*_slides(result, index), *_pushed(result, index), *_ranges(result, index)]
    path = path_of(person)
    if path.end_offset_mm > EXACT_MM or path.end_tilt_deg > EXACT_DEG:
        side = "above" if path.end_height_mm >= 0.0 else "below"
        lines.append(
            f"ends {_length(path.end_offset_mm)} beside its path and "
            f"{_length(abs(path.end_height_mm))} {side}, tilted by {path.end_tilt_deg:.1f}°; "
            f"tilted by {path.max_tilt_deg:.1f}° at most"
        )
    return lines


def _floats(result: Result, person: PersonResult) -> list[str]:
    reference = asked_motion(person)
    in_air = airborne(reference, person.body, free_fall(result.scene))
    step = max(1, -(-len(result) // SAMPLED))
    tracks = {
        name: ObjectTrack(position=track.position[::step], quaternion=track.quaternion[::step])
        for name, track in known_tracks(result.scene, result.objects).items()
    }
    if len(in_air[::step]) < 2:
        return []

    def measured(motion: Motion) -> FloatReport:
        every = np.zeros(len(person.body.rest_vertices), dtype=np.intp)
        gaps = carrying_gaps(
            motion[::step],
            person.body,
            result.scene,
            every,
            objects=tracks,
            reach=MOST,
            visible=True,
        )
        return floating_from(gaps.whole, in_air[::step].copy())

    got = measured(person.motion)
    if (got.gap >= MOST).all():
        return []  # nothing below in any frame: no floor
    asked = measured(reference)
    words = f"floats in {got.percent:.0f} % of the frames"
    if in_air.any():
        words += f" that are not airborne ({100.0 * in_air.mean():.0f} % are)"
    return [f"{words}, by {_length(got.max_mm)} at most; reference: {asked.percent:.0f} %"]


def _carried(result: Result, index: int) -> list[str]:
    if len(result) > STANCE:
        return []
    weight = unsupported_weight(result, index)
    if not weight.unsupported.any():
        return []
    return [
        f"held up by nothing in {weight.percent:.0f} % of the frames, by "
        f"{weight.missing[weight.unsupported].max():.0f} % of the weight at most"
    ]


def _slides(result: Result, index: int) -> list[str]:
    if len(result) > STANCE:
        return []
    stance = stance_slide(result, index)
    if not stance.steps:
        return []
    return [
        f"feet in stance slide {stance.simulated.mean_mm:.2f} mm a frame, "
        f"{stance.simulated.max_mm:.1f} mm at most; reference: {stance.asked.mean_mm:.2f} mm"
    ]


def _pushed(result: Result, index: int) -> list[str]:
    force = net_force(result, index)
    if force.peak == 0.0:
        return []
    return [
        f"net force of contacts {force.peak_weights:.2f} body weights at most, "
        f"{force.sustained_weights:.2f} held for 50 ms"
    ]


def _ranges(result: Result, index: int) -> list[str]:
    ranges = range_violations(result, index)
    if ranges.max_deg < TOLERANCE:
        return []
    return [
        f"{ranges.joint} {ranges.max_deg:.0f}° beyond its range at most, in frame {ranges.frame}; "
        f"over {TOLERANCE:g}° in {ranges.percent:.0f} % of the frames"
    ]


def _length(mm: float) -> str:
    """Millimetres, or metres from one on."""
    return f"{mm / 1000.0:.2f} m" if mm >= 999.5 else f"{mm:.3g} mm"
