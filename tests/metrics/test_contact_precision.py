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
from halfphysics.results.result import ObjectTrack, Result
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


def _lying(shape: hp.Box | hp.Mesh, soft: hp.Soft | None) -> hp.Scene:
    scene = hp.Scene()
    scene.add_static("bed", shape, position=(0.0, 0.0, 0.2), soft=soft)
    return scene


def test_distances_from_soft_things_are_those_from_their_unloaded_surface() -> None:
    """Somebody sinks 9 cm into foam: of a box as from the hard box, inside a mesh 0 or less."""
    box = hp.Box((2.4, 2.4, 0.4))
    lying = hp.Motion(np.tile([0.0, 0.0, 0.49], (4, 1)), np.zeros((4, 55, 3)), 30.0)
    soft = hp.Soft(thickness=0.12, stiffness=3e4)
    result = hp.simulate(lying, _lying(box, soft))
    report = metrics.contact_precision(result)
    assert report.contacts > 20
    assert report.precision_percent == 100.0
    hard = dataclasses.replace(result, scene=_lying(box, None), people=result.people)
    np.testing.assert_array_equal(report.distance, metrics.contact_precision(hard).distance)
    # Hands and heads are under the surface as a whole: a mesh has them inside.
    mesh = _lying(hp.Mesh(*box.triangles()), soft)
    other = dataclasses.replace(result, scene=mesh, people=result.people)
    found = metrics.contact_precision(other)
    assert found.precision_percent == 100.0
    assert (report.distance <= 0.0).any()
    assert np.array_equal(found.distance <= 0.0, report.distance <= 0.0)


def test_what_a_soft_mesh_surrounds_as_a_whole_touches_it() -> None:
    """A hand in the middle of a block, 15 cm from its triangles."""
    result = kick()
    body, contacts = result.people[0].body, result.contacts
    kicks = (contacts.person == 0) & (contacts.other == result.names.index("ball"))
    row = np.flatnonzero(kicks & (contacts.strength > 0.0))[0]
    part, frame = contacts.part[row], contacts.frame[row]
    place = body.vertices(result.motion, frame)[body.weights.argmax(axis=1) == part].mean(axis=0)
    block = hp.Mesh(*hp.Box((0.8, 0.8, 0.8)).triangles())
    for soft, apart in ((hp.Soft(thickness=0.1, stiffness=1e4), False), (None, True)):
        scene = hp.Scene()
        scene.add_static("ball", block, position=place, soft=soft)
        moved = dataclasses.replace(result, scene=scene, people=result.people, objects={})
        impulse = np.eye(len(contacts))[row][:, None] * [0.0, 0.0, 1.0]
        one = _changed(moved, impulse=impulse)
        found = metrics.contact_precision(one).distance[row]
        assert np.isinf(found) if apart else found == 0.0


def _angle() -> hp.Mesh:
    """An L of 10 cm, lying: around its inner corner, vertex 0."""
    outline = np.array([[0, 0], [0, 0.3], [-0.3, 0.3], [-0.3, -0.3], [0.3, -0.3], [0.3, 0]])
    low, high = (np.column_stack([outline, np.full(6, z)]) for z in (-0.1, 0.1))
    cap = np.array([[0, k, k + 1] for k in range(1, 5)])
    sides = [[k, (k + 1) % 6, k + 6] for k in range(6)]
    sides += [[(k + 1) % 6, (k + 1) % 6 + 6, k + 6] for k in range(6)]
    return hp.Mesh(np.concatenate([low, high]), np.concatenate([cap[:, ::-1], cap + 6, sides]))


@pytest.mark.parametrize("shape", [hp.Box((0.6, 0.6, 0.2)), _angle()])
@pytest.mark.parametrize("floor", [hp.Plane(), hp.Box((9.0, 9.0, 0.2))])
def test_distances_of_soft_objects_are_from_their_unloaded_surface(
    shape: hp.Shape, floor: hp.Shape
) -> None:
    """A cushion on a floor, and a ball on it: of a ball all is known in closed form."""
    if isinstance(shape, hp.Mesh):
        pytest.importorskip("coacd")
        assert shape.closed
        assert not shape.is_convex
    scene = hp.Scene()
    thick = 0.0 if isinstance(floor, hp.Plane) else 0.2
    scene.add_static("floor", floor, position=(0.0, 0.0, -0.5 * thick))
    soft = hp.Soft(thickness=0.06, stiffness=2e4)
    scene.add_object("cushion", shape, mass=1.0, position=(2.0, 0.0, 0.099), soft=soft)
    scene.add_object("ball", hp.Sphere(0.1), mass=2.0, position=(1.85, 0.0, 0.29))
    still = hp.Motion(np.tile([0.0, 0.0, 1.0], (8, 1)), np.zeros((8, 55, 3)), 30.0)
    result = hp.simulate(still, scene, settings=hp.Settings(weight=False, record="frames"))
    report = metrics.contact_precision(result, margin=1.0)  # earlier poses have no effect
    contacts, places = result.contacts, {n: t.position for n, t in result.objects.items()}
    ball = result.names.index("ball")
    seen = [0, 0]
    for row in np.flatnonzero(contacts.strength > 0.0):
        frame = contacts.frame[row]
        if ball in (contacts.subject[row], contacts.other[row]):
            gap = places["ball"][frame, 2] - places["cushion"][frame, 2] - 0.2
            seen[0] += 1
        else:
            gap = places["cushion"][frame, 2] - 0.1
            seen[1] += 1
        assert report.distance[row] == pytest.approx(gap, abs=2e-3) or (
            report.distance[row] <= 0.0 and gap <= 0.0
        )
    assert min(seen) > 0


def test_a_soft_mesh_is_measured_where_it_has_come_to() -> None:
    """A soft object in any pose as a static mesh there, by a foot beside and in it."""
    pytest.importorskip("coacd")
    result = kick(record="frames")
    body, contacts = result.people[0].body, result.contacts
    kicks = (contacts.person == 0) & (contacts.other == result.names.index("ball"))
    row = np.flatnonzero(kicks & (contacts.strength > 0.0))[0]
    skin = body.vertices(result.motion, contacts.frame[row])
    foot = skin[body.weights.argmax(axis=1) == contacts.part[row]].mean(axis=0)
    turn = np.array([0.7, 0.4, -0.5, 0.2]) / np.linalg.norm([0.7, 0.4, -0.5, 0.2])
    impulse = np.eye(len(contacts))[row][:, None] * [0.0, 0.0, 1.0]
    seen = []
    for away in (0.0, 0.15, 0.3):
        place, soft = foot + away * np.eye(3)[0], hp.Soft(thickness=0.06, stiffness=2e4)
        still, moves = hp.Scene(), hp.Scene()
        still.add_static("ball", _angle(), position=place, quaternion=turn)
        moves.add_object("ball", _angle(), mass=1.0, soft=soft)
        count = len(result)
        track = ObjectTrack(
            position=np.tile(place, (count, 1)), quaternion=np.tile(turn, (count, 1))
        )
        found = [
            metrics.contact_precision(
                _changed(
                    dataclasses.replace(result, scene=scene, people=result.people, objects=objects),
                    impulse=impulse,
                ),
                margin=1.0,
            ).distance[row]
            for scene, objects in ((still, {}), (moves, {"ball": track}))
        ]
        assert found[0] == pytest.approx(found[1], abs=1e-9)
        seen.append(found[0])
    assert min(seen) < 0.0 < max(seen) < 0.1


def test_precision_without_contacts_and_of_something_else() -> None:
    quiet = _changed(kick(), impulse=np.zeros((len(kick().contacts), 3)))
    report = metrics.contact_precision(quiet)
    assert (report.contacts, report.precision_percent) == (0, 100.0)
    with pytest.raises(InputError, match=r"result: expected a halfphysics\.Result"):
        metrics.contact_precision(kick().motion)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="margin"):
        metrics.contact_precision(kick(), margin=-1.0)
