"""The result of a run: the core's numbers in terms of people, objects and names."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.results.contacts import Contacts
from halfphysics.results.result import (
    DIAGNOSTICS,
    ObjectTrack,
    PersonResult,
    Result,
)
from halfphysics.results.simulated_scene import SimulatedScene
from halfphysics.results.substeps import Substeps, at_substeps
from halfphysics.simulation.core_rows import breach_rows, contact_rows, inside_rows
from halfphysics.simulation.soft_rows import soft_rows

if TYPE_CHECKING:
    from halfphysics.motion.motion import Motion
    from halfphysics.settings import Settings
    from halfphysics.simulation.coordinates import Person
    from halfphysics.simulation.recording import Recording, Rows
    from halfphysics.simulation.world import World

Array = NDArray[np.float64]


def recorded_result(world: World, motions: Sequence[Motion], run: Recording) -> Result:
    """The result of a world that was run after motions, one per person."""
    settings = world.settings
    return Result(
        people=tuple(
            PersonResult(
                motion=_followed(motion, person, run.qpos, settings),
                reference=motion,
                body=person.body,
                name=person.name,
                torque=run.torque[:, i],
                clock=np.arange(len(run.lag)) / motion.fps - run.lag[:, i],
                corrected=run.corrected[:, i],
            )
            for i, (motion, person) in enumerate(zip(motions, world.people, strict=True))
        ),
        objects=_tracks(world, run.qpos),
        joints={joint.name: joint.values(run.qpos) for joint in world.joints},
        scene=SimulatedScene(world.scene, world.made_of),
        names=world.names,
        contacts=_contacts(world, run.contacts),
        clearance=run.clearance,
        lost_time=run.lost_time,
        settings=settings,
        substeps=_substeps(world, motions, run) if settings.record == "substeps" else None,
        diagnostics=dict(zip(DIAGNOSTICS, run.diagnostics.T, strict=True)),
        inside=inside_rows(world, run.inside.rows, run.inside.frame),
        breaches=breach_rows(world, run.breaches.rows, run.breaches.frame),
        soft_contacts=soft_rows(world, run.soft.rows, run.soft.frame),
    )


def _followed(motion: Motion, person: Person, qpos: Array, settings: Settings) -> Motion:
    """What became of a motion: by coordinates (T, nq), or itself where it sets the pose."""
    if settings.drive.poses:
        return motion.with_frames(motion.translation, motion.rotations)
    return motion.with_frames(*person.pose(qpos, motion.axes))


def _contacts(world: World, found: Rows) -> Contacts:
    if not len(found.rows):
        return Contacts.none()
    columns, row = contact_rows(world, found.rows)
    return Contacts(frame=found.frame[row], **vars(columns))


def _tracks(world: World, qpos: Array) -> dict[str, ObjectTrack]:
    """Poses of objects and links at coordinates (T, nq)."""
    tracks = {}
    for place in world.tracked:
        position, quaternion = place.pose(qpos)
        tracks[place.name] = ObjectTrack(position=position, quaternion=quaternion)
    return tracks


def _substeps(world: World, motions: Sequence[Motion], run: Recording) -> Substeps:
    """Every committed pose, the start first."""
    fps = motions[0].fps * world.settings.substeps_for(run.dt)
    return Substeps(
        motions=tuple(
            at_substeps(m, *person.pose(run.substeps, m.axes), fps)
            for m, person in zip(motions, world.people, strict=True)
        ),
        objects=_tracks(world, run.substeps),
    )
