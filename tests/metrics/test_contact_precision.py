"""Contact labels against geometry, including wrong labels."""

from __future__ import annotations

import dataclasses
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.spatial import ConvexHull

import halfphysics as hp
from halfphysics import metrics, scenarios
from halfphysics.bench.clips import straight
from halfphysics.errors import InputError
from halfphysics.results.contacts import Contacts
from halfphysics.results.result import Result
from support.as_it_is import as_it_is
from support.references.mesh_queries import closest_reference


@cache
def kick(contact: str = "skin", record: str = "substeps") -> Result:
    """A ball on a floor, kicked away: the scenario, from shortly before the kick."""
    story = scenarios.load("kick_ball")
    motion = story.motions[0][60:110]
    settings = as_it_is(contact=contact, record=record)  # type: ignore[arg-type]
    return hp.simulate(motion, story.scene, body=story.bodies[0], settings=settings)


@cache
def walled(contact: str = "skin", mesh: bool = False) -> Result:
    """A T-pose that glides against a wall."""
    wall = hp.Box((0.1, 3.0, 3.0))
    scene = hp.Scene()
    scene.add_static("wall", hp.Mesh(*wall.triangles()) if mesh else wall, position=(0.3, 0.0, 0.0))
    settings = as_it_is(contact=contact)  # type: ignore[arg-type]
    return hp.simulate(straight(1.5, 0.6, -0.6), scene, settings=settings)


def _changed(result: Result, **columns: Any) -> Result:
    """The result with other columns in its contacts."""
    old = {name: getattr(result.contacts, name) for name in Contacts.columns()}
    return dataclasses.replace(
        result, scene=result.scene, contacts=Contacts(**(old | columns)), people=result.people
    )


def _hull_triangles(points: np.ndarray) -> np.ndarray:
    """The hull of points as triangles (F, 3, 3), by qhull."""
    return points[ConvexHull(points).simplices]


def _from_ball(result: Result, row: int) -> float:
    """Distance of a contact's part to the ball: its hulls' triangles, in numpy."""
    contacts, body = result.contacts, result.people[0].body
    frame = int(contacts.frame[row])
    skin = body.vertices(result.motion, frame)
    centre, hulls, found = result.objects["ball"].position[frame], body.skin_hulls, np.inf
    for h in np.flatnonzero(hulls.part == contacts.part[row]):
        corners = _hull_triangles(skin[hulls.vertex[hulls.first[h] : hulls.first[h + 1]]])
        faces = np.arange(3 * len(corners)).reshape(-1, 3)
        found = min(found, closest_reference(centre[None], corners.reshape(-1, 3), faces)[0][0])
    return float(found) - result.scene.objects["ball"].shape.radius  # type: ignore[attr-defined]


def test_labels_are_borne_out() -> None:
    result = kick()
    report = metrics.contact_precision(result)
    hit = result.contacts.strength > 0.0
    assert report.contacts == hit.sum() > 20
    assert report.precision_percent == 100.0
    assert np.isnan(report.distance[~hit]).all()
    assert report.distance[hit].max() <= result.settings.clearance + 1e-3


def test_distances_are_those_of_the_hulls() -> None:
    """Every row between the foot and the ball, against qhull and numpy."""
    frames = kick(record="frames")
    report = metrics.contact_precision(frames, margin=1.0)  # earlier poses have no effect
    ball = frames.names.index("ball")
    rows = np.flatnonzero((frames.contacts.other == ball) & (frames.contacts.strength > 0.0))
    assert len(rows) > 0
    for row in rows:
        assert report.distance[row] == pytest.approx(_from_ball(frames, row), abs=1e-9)
    assert report.at_frame_percent == report.precision_percent == 100.0


@pytest.mark.parametrize("contact", ["skin", "parts"])
def test_labels_of_a_body_elsewhere_are_refuted(contact: str) -> None:
    """The same contacts, the body 5 mm away from the wall: every distance is 5 mm larger."""
    result = walled(contact)
    person = result.people[0]
    back = result.motion.with_frames(
        result.motion.translation - [5e-3, 0, 0], person.motion.rotations
    )
    moved = dataclasses.replace(person, motion=back, body=person.body)
    away = dataclasses.replace(result, people=(moved,), scene=result.scene)
    here, there = (metrics.contact_precision(r, margin=0.05) for r in (result, away))
    assert here.contacts > 10
    np.testing.assert_allclose(there.distance, here.distance + 5e-3, atol=1e-12)
    assert metrics.contact_precision(result).precision_percent == 100.0
    assert metrics.contact_precision(away).precision_percent == 0.0


def test_labels_of_a_part_that_is_elsewhere_are_refuted() -> None:
    result = kick()
    head = np.full(len(result.contacts), hp.JOINT_NAMES.index("head"))
    wrong = _changed(result, part=np.where(result.contacts.person >= 0, head, -1))
    report = metrics.contact_precision(wrong)
    of_body = (result.contacts.person >= 0) & (result.contacts.strength > 0.0)
    assert np.isinf(report.distance[of_body]).all()
    assert report.precision_percent == pytest.approx(100.0 * (1 - of_body.sum() / report.contacts))


def test_a_mesh_and_a_box_bear_out_the_same() -> None:
    """A wall as a box and as its triangles, the contacts of one measured in the other."""
    result, mesh = walled(), walled(mesh=True)
    other = dataclasses.replace(result, scene=mesh.scene, people=result.people)
    a, b = (metrics.contact_precision(r).distance for r in (result, other))
    np.testing.assert_allclose(a, b, atol=1e-7)
    assert metrics.contact_precision(mesh).precision_percent == 100.0


def test_precision_without_contacts_and_of_something_else() -> None:
    quiet = _changed(kick(), impulse=np.zeros((len(kick().contacts), 3)))
    report = metrics.contact_precision(quiet)
    assert (report.contacts, report.precision_percent) == (0, 100.0)
    with pytest.raises(InputError, match=r"result: expected a halfphysics\.Result"):
        metrics.contact_precision(kick().motion)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="margin"):
        metrics.contact_precision(kick(), margin=-1.0)
