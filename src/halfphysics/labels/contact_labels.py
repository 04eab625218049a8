"""Contact labels of a result, from its geometry and the solver's impulses."""

from __future__ import annotations

import logging

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.stopwatch import Stopwatch
from halfphysics.base.validation import number
from halfphysics.errors import InputError
from halfphysics.labels.bounding_spheres import part_balls
from halfphysics.labels.item_solids import ItemSolids, item_solids
from halfphysics.labels.proximity import Near, Target, near
from halfphysics.labels.sampling import surface_of
from halfphysics.labels.solver_contacts import solver_contacts
from halfphysics.labels.tables import ContactLabels, PersonLabels
from halfphysics.metrics.argument_checks import check_result
from halfphysics.motion.skeleton import N_JOINTS
from halfphysics.results.result import Result

logger = logging.getLogger(__name__)

#: A vertex touches an item up to this distance beyond the clearance [m].
MARGIN = 1e-3


def contact_labels(
    result: Result, *, threshold: float | None = None, reach: float = 0.05
) -> ContactLabels:
    """Label the vertices and parts in contact, with their forces, in every frame of a result.

    A vertex of the skin touches an item if its distance from the item's collision geometry (an
    object's convex pieces, a static's own shape, exact) is at most `threshold`; a vertex of an
    object, if its distance from the triangles of the skin is. Pairs that the scene ignores are
    not labelled.

    Args:
        result: The result of a simulation.
        threshold: Largest distance [m]; None: the clearance of the result's settings plus 1 mm,
            which is also the upper limit.
        reach: Largest distance that exporters may request [m], computed on request.

    Raises:
        InputError: No result, or an impossible threshold or reach.
        FileError: In a result from a file: a body or the scene is missing.
    """
    check_result(result)
    most = result.settings.clearance + MARGIN
    if threshold is None:
        threshold = most
    clock = Stopwatch(logger)
    threshold = number(threshold, "threshold", least=0.0, unit="m")
    if threshold > most * (1.0 + 1e-12):
        raise InputError(
            f"threshold: found {threshold:g} m, expected at most {most:g} m, the clearance and "
            "1 mm: farther is no contact. What other data sets call one is in "
            "halfphysics.labels: behave, omomo, chois, arctic"
        )
    reach = max(number(reach, "reach", least=0.0, unit="m"), threshold)
    scene = result.scene
    items = item_solids(scene, result.objects)
    surfaces = {t.name: surface_of(scene, t) for t in items if not t.stands}
    targets = [Target(t, threshold, surfaces.get(t.name)) for t in items]
    kinds = _kinds(result, items)
    people = [
        _person(result, i, items, near(person.body, person.motion, targets), kinds)
        for i, person in enumerate(result.people)
    ]
    clock.done("labelled the contacts of %d frames", len(result), count=len(result))
    return ContactLabels(
        threshold_m=threshold,
        reach=reach,
        fps=result.fps,
        people=tuple(people),
        objects=tuple(surfaces.values()),
        names=result.names,
        contacts=solver_contacts(result),
        result=result,
    )


_STANDS, _MOVES, _PERSON = 0, 1, 2


def _kinds(result: Result, items: tuple[ItemSolids, ...]) -> NDArray[np.int64]:
    """The kind of every name of a result: static, moving item or person."""
    stands = {item.name for item in items if item.stands}
    people = {person.name for person in result.people}
    return np.array(
        [
            _PERSON
            if name in people
            else _MOVES
            if name in result.objects and name not in stands
            else _STANDS
            for name in result.names
        ]
    )


def _person(
    result: Result,
    index: int,
    items: tuple[ItemSolids, ...],
    found: list[tuple[Near, Near]],
    kinds: NDArray[np.int64],
) -> PersonLabels:
    person = result.people[index]
    part = part_balls(person.body).part
    frames = len(person.motion)
    parts = np.zeros((3, frames, N_JOINTS), dtype=bool)
    for item, (rows, _) in zip(items, found, strict=True):
        kind = _STANDS if item.stands else _MOVES
        parts[kind, rows.frame, part[rows.vertex]] = True
    contacts = result.contacts
    pushed = contacts[(contacts.person == index) & (contacts.strength > 0.0)]
    where = (kinds[pushed.other], pushed.frame, pushed.part)
    parts[where] = True
    force = np.zeros((3, frames, N_JOINTS, 3))
    np.add.at(force, where, pushed.impulse * result.fps)
    moving = [pair for item, pair in zip(items, found, strict=True) if not item.stands]
    return PersonLabels(
        name=person.name,
        vertex_part=part.astype(np.int8),
        body_near=tuple(body for body, _ in moving),
        object_near=tuple(surface for _, surface in moving),
        scene_near=_once([b for t, (b, _) in zip(items, found, strict=True) if t.stands]),
        human_parts=parts[_MOVES],
        scene_parts=parts[_STANDS],
        people_parts=parts[_PERSON],
        force=force.sum(axis=0),
        force_objects=force[_MOVES],
    )


def _once(rows: list[Near]) -> Near:
    """Merge the rows of several items: every vertex once per frame, with its minimum distance."""
    every = Near.joined(rows)
    order = np.lexsort((every.distance, every.vertex, every.frame))
    frame, vertex = every.frame[order], every.vertex[order]
    first = np.ones(len(order), dtype=bool)
    first[1:] = (np.diff(frame) != 0) | (np.diff(vertex) != 0)
    order = order[first]
    return Near(every.frame[order], every.vertex[order], every.distance[order])
