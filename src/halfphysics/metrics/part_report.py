"""PartReport: clearance, contact, force and displacement, per frame and part of one person."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.copying import ReadOnly
from halfphysics.base.short_repr import short_repr
from halfphysics.errors import FileError
from halfphysics.motion.skeleton import N_JOINTS
from halfphysics.results.records import SceneRecord
from halfphysics.simulation.build_world import build_world

if TYPE_CHECKING:
    from halfphysics.results.result import Result
    from halfphysics.simulation.world import World

Array = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, kw_only=True, eq=False)
class PartReport(ReadOnly):
    """Measures of every part of a person: arrays (T, 55), columns as `JOINT_NAMES`.

    Attributes:
        clearance: Distance of the part from static geometry [m]; inf beyond
            `Settings.clearance_range`, and for a part without a shape. Negative inside a
            surface: the depth; and inside or beyond a solid without touching its surface
            (`Result.inside`): the distance to the exit.
        nearest: Index into `Result.names` of the static at `clearance`, -1 where that is inf.
        contact: Whether the part carried an impulse during (t-1, t], from static geometry, an
            object, another person or another part of its own.
        force: Sum of the sizes of its contacts' impulses in that time, over its length [N].
        displacement: Distance of its joint from where it was recorded [m].
        rotation: Angle between the joint's rotation, in its parent's frame, and the recorded
            one [rad]; of the pelvis in the world.
    """

    clearance: Array
    nearest: Ints
    contact: NDArray[np.bool_]
    force: Array
    displacement: Array
    rotation: Array

    __repr__ = short_repr

    def __post_init__(self) -> None:
        for column in fields(self):
            getattr(self, column.name).setflags(write=False)

    def __len__(self) -> int:
        """Number of frames."""
        return len(self.clearance)


def part_reports(result: Result) -> tuple[PartReport, ...]:
    """The work behind `Result.parts`: one report a person."""
    measured = clearances(result)
    statics = len(result.names) - len(result.objects) - len(result.people)
    reports = []
    for index, person in enumerate(result.people):
        clearance, nearest = measured[0][index], measured[1][index]
        inside = result.inside[(result.inside.person == index) & (result.inside.other < statics)]
        # Beyond the surface the distance grows again: the depth replaces it.
        swallowed = clearance[inside.frame, inside.part] > 0.0
        for row in np.flatnonzero(swallowed & ~inside.no_way_out):
            at = inside.frame[row], inside.part[row]
            if -inside.depth[row] < clearance[at]:
                clearance[at], nearest[at] = -inside.depth[row], inside.other[row]
        contacts = result.contacts[result.contacts.person == index]
        force = np.zeros((len(result), N_JOINTS))
        np.add.at(force, (contacts.frame, contacts.part), contacts.strength * result.fps)
        reports.append(
            PartReport(
                clearance=clearance,
                nearest=nearest,
                contact=force > 0.0,
                force=force,
                displacement=person.joint_errors()[1],
                rotation=rot.angles(person.recorded.rotations, person.motion.rotations),
            )
        )
    return tuple(reports)


def clearances(result: Result, frames: slice = slice(None)) -> tuple[Array, Ints]:
    """Distances of all parts from static geometry at the poses of a result.

    Returns:
        Clearance (people, T, 55) [m] and nearest (people, T, 55), as in `PartReport`, but
        without depths.

    Raises:
        FileError: A body or a mesh of the scene is missing.
    """
    world = _world(result)
    count = len(range(len(result))[frames])
    qpos = np.tile(world.joined.qpos0, (count, 1))  # only static geometry matters
    for place, person in zip(world.people, result.people, strict=True):
        motion = person.motion
        qpos[:, place.qpos : place.qpos + place.count] = place.coordinates(
            motion.translation[frames], motion.rotations[frames], motion.axes
        )
    static = np.empty((count, len(world.shape_name)), dtype=np.int32)
    dist = world.stepper.clearances(qpos, result.settings.clearance_range, static)
    first_person = len(world.names) - len(world.people)
    best = np.full((len(world.people), count, N_JOINTS), np.inf)
    nearest = np.full(best.shape, -1)
    # One more entry for index -1.
    name_of = np.append(world.static_name, -1)
    for shape, (name, part) in enumerate(zip(world.shape_name, world.shape_part, strict=True)):
        if name < first_person:
            continue
        at = name - first_person, slice(None), part
        nearer = dist[:, shape] < best[at]
        best[at] = np.where(nearer, dist[:, shape], best[at])
        nearest[at] = np.where(nearer, name_of[static[:, shape]], nearest[at])
    return best, nearest


def _world(result: Result) -> World:
    """The people and the scene of a result, compiled again."""
    held = vars(result)["_scene"]
    lost = held.missing() if isinstance(held, SceneRecord) else {}
    if lost:
        gone = "; ".join(f"{name} ({why})" for name, why in lost.items())
        raise FileError(
            f"{held.origin}: the clearance of parts cannot be measured, the scene is not whole: "
            f"{gone}. Put the files back, or pass scene= to Result.load"
        )
    scene = result.scene
    known = result.names[: -len(result.people)]
    found: tuple[str, ...] = (*scene.statics, *scene.objects)
    found += tuple(n for item in scene.articulated.values() for n in item.link_names)
    if known != found:
        raise FileError(
            "the clearance of parts cannot be measured, the scene is another one: found "
            f"{', '.join(found) or 'nothing'} in it, expected {', '.join(known) or 'nothing'}"
        )
    return build_world([person.body for person in result.people], scene, result.settings)
