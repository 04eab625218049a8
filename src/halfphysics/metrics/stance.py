"""Stance: where a reference rests its heels and toes, and how far they slide in a result."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.short_repr import short_repr
from halfphysics.metrics.airborne import airborne, free_fall
from halfphysics.metrics.argument_checks import Array, check_result
from halfphysics.metrics.asked import asked_motion
from halfphysics.metrics.scene_solids import known_tracks
from halfphysics.metrics.surface_gaps import Gaps, carrying_gaps
from halfphysics.motion.skeleton import JOINT_INDEX

if TYPE_CHECKING:
    from halfphysics.results.result import PersonResult, Result

#: The patches of the soles, in this order.
PATCHES = ("left_heel", "left_toe", "right_heel", "right_toe")
#: Skin within this of a foot's lowest vertex at rest is its sole [m].
SOLE = 0.015
#: Share of a sole's length, from behind, that is the heel.
HEEL = 0.3
#: A patch rests below this speed [m/s], this low above a surface or above the lowest patch [m].
SLOW, LOW = 0.25, 0.03
#: A patch farther than this above all surfaces rests on none, even if it is the lowest [m]: feet
#: that dangle, and clips that float by more.
FAR = 0.1
#: A foot that is lifted by more than this, heel and toe, while the other one stands steps [m].
LIFTED = 0.01


@dataclass(frozen=True, kw_only=True)
class Slide:
    """Horizontal displacement of resting patches from frame to frame [mm]; 0 if none rests."""

    mean_mm: float
    p95_mm: float
    max_mm: float


@dataclass(frozen=True, kw_only=True, eq=False)
class StanceReport:
    """Sliding of heels and toes while they rest in the reference.

    Attributes:
        simulated: Slide of the result, relative to what the patch stands on.
        asked: Slide of the reference in the same steps, in the world.
        steps: Number of (step, patch) pairs that count.
        slide: Displacement of each patch in the result (T - 1, 4) [m], `PATCHES`; nan where it does
            not rest.
    """

    simulated: Slide
    asked: Slide
    steps: int
    slide: Array

    __repr__ = short_repr


def sole_patches(body: Any) -> NDArray[np.intp]:
    """Patch of every vertex of a body (V,): an index into `PATCHES`, or -1.

    The sole of a foot is its skin within 15 mm of its lowest vertex at rest; the toe patch is what
    of it belongs to the joint "left_foot" (the ball and the toes), the heel what of it belongs to
    the ankle and lies in the rear 30 % of the whole sole's length.
    """
    part, rest = body.weights.argmax(axis=1), body.rest_vertices
    patch = np.full(len(rest), -1)
    for k, side in enumerate(("left", "right")):
        ankle, toes = (part == JOINT_INDEX[f"{side}_{joint}"] for joint in ("ankle", "foot"))
        foot = ankle | toes
        if not foot.any():
            continue
        sole = foot & (rest[:, 1] < rest[foot, 1].min() + SOLE)
        back, front = rest[sole, 2].min(), rest[sole, 2].max()
        patch[sole & ankle & (rest[:, 2] < back + HEEL * (front - back))] = 2 * k
        patch[sole & toes] = 2 * k + 1
    return patch


def patch_centres(motion: Any, body: Any, patch: NDArray[np.integer]) -> tuple[Array, Array]:
    """Centres of the patches (T, 4, 3) [m], and the height of their lowest vertices (T, 4) [m]."""
    found, lowest = np.zeros((len(motion), 4, 3)), np.full((len(motion), 4), np.inf)
    for k in range(4):
        vertices = body.vertices(motion, indices=np.flatnonzero(patch == k))
        found[:, k], lowest[:, k] = vertices.mean(axis=1), vertices[..., 2].min(axis=1)
    return found, lowest


def in_stance(
    centres: Array, lowest: Array, gaps: Array, in_air: NDArray[np.bool_], fps: float
) -> NDArray[np.bool_]:
    """Whether each patch of a reference rests, in each frame (T, P).

    It rests where it is slow (under 0.25 m/s) and low: within 3 cm of a surface that can carry it,
    or within 10 cm of one and 3 cm above the lowest patch, and the person is not airborne.

    Args:
        centres: Of the patches (T, P, 3) [m].
        lowest: Height of their lowest vertices (T, P) [m].
        gaps: Their distances from surfaces that can carry them (T, P) [m].
        in_air: Airborne frames (T,).
        fps: Frames per second.
    """
    speed = np.linalg.norm(np.gradient(centres, axis=0), axis=-1) * fps
    lowest_of_all = lowest.min(axis=1, keepdims=True)
    low = (gaps < LOW) | ((gaps < FAR) & (lowest < lowest_of_all + LOW))
    resting: NDArray[np.bool_] = (speed < SLOW) & low & ~in_air[:, None]
    return resting


def stance_slide(result: Result, person: int = 0) -> StanceReport:
    """Sliding of a person's heels and toes while they rest in the reference.

    A patch counts in the steps from frame to frame at both ends of which the reference's patch
    rests (`in_stance`), but those in which the foot is in the air while the other one stands: who
    is off the path puts a foot elsewhere with a step. A person who floats with both feet slides.
    Its displacement in the result is that of its centre, relative to the object or link within
    3 cm under it, which may move, in the horizontal plane.

    Args:
        result: The result of a simulation.
        person: Index of the person.

    Raises:
        InputError: No result, or no such person.
        FileError: In a result from a file: the body or a mesh of the scene has gone.
    """
    check_result(result)
    result._check_person(person)
    subject, scene = result.people[person], result.scene
    objects = known_tracks(scene, result.objects)
    patch = sole_patches(subject.body)
    asked, got = (
        carrying_gaps(
            motion, subject.body, scene, patch, objects=objects, reach=2.0 * FAR, visible=True
        )
        for motion in (asked_motion(subject), subject.motion)
    )
    in_air = airborne(asked_motion(subject), subject.body, free_fall(scene))
    return stance_from(subject, patch, (asked, got), objects, in_air)


def stance_from(
    subject: PersonResult,
    patch: NDArray[np.intp],
    gaps: tuple[Gaps, Gaps],
    objects: Mapping[str, Any],
    in_air: NDArray[np.bool_],
) -> StanceReport:
    """The report, where the gaps of the patches are known.

    Args:
        subject: A person of a result.
        patch: `sole_patches` of the body.
        gaps: Of the reference and of the result; their first groups are the patches.
        objects: Tracks by name.
        in_air: Airborne frames of the reference (T,).
    """
    fps = float(subject.motion.fps)
    centres, lowest = patch_centres(asked_motion(subject), subject.body, patch)
    rests = in_stance(centres, lowest, gaps[0].gap[:, :4], in_air, fps)
    steps = rests[1:] & rests[:-1]
    lifted = stepping(gaps[1].gap[:, :4])
    steps &= ~(lifted[1:] | lifted[:-1])
    asked = np.linalg.norm(np.diff(centres[..., :2], axis=0), axis=-1)
    mine = patch_centres(subject.motion, subject.body, patch)[0]
    slide = np.linalg.norm((mine[1:] - _carried(mine, gaps[1], objects))[..., :2], axis=-1)
    slide[~steps] = np.nan
    slide.setflags(write=False)
    return StanceReport(
        simulated=_slide(slide[steps]),
        asked=_slide(asked[steps]),
        steps=int(steps.sum()),
        slide=slide,
    )


def stepping(gaps: Array) -> NDArray[np.bool_]:
    """Whether each patch belongs to a foot that is in the air while the other one stands (T, 4).

    Args:
        gaps: Distances of `PATCHES` from surfaces that can carry them (T, 4) [m].
    """
    low: NDArray[np.bool_] = np.any((gaps < LIFTED).reshape(-1, 2, 2), axis=2)
    return np.repeat(~low & low[:, ::-1], 2, axis=1)


def _carried(centres: Array, gaps: Gaps, objects: Mapping[str, Any]) -> Array:
    """Where what they stand on takes the centres (T, P, 3) by the next frame (T - 1, P, 3)."""
    moved = centres[:-1].copy()
    for k, name in enumerate(gaps.names):
        if name not in objects:
            continue
        on = (gaps.item[:-1, :4] == k) & (gaps.gap[:-1, :4] < LOW)
        t, p = np.nonzero(on)
        place, turn = objects[name].position, rot.normalize(objects[name].quaternion)
        local = rot.rotate(rot.conjugate(turn[t]), centres[t, p] - place[t])
        moved[t, p] = rot.rotate(turn[t + 1], local) + place[t + 1]
    return moved


def _slide(values: Array) -> Slide:
    if not len(values):
        return Slide(mean_mm=0.0, p95_mm=0.0, max_mm=0.0)
    values = 1000.0 * values
    return Slide(
        mean_mm=float(values.mean()),
        p95_mm=float(np.percentile(values, 95.0)),
        max_mm=float(values.max()),
    )
