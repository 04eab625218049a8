"""Contact labels against geometry, contact impulses against mechanics; both made wrong too."""

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
from support.references.mesh_queries import closest_reference

LEFT_FOOT = hp.JOINT_NAMES.index("left_foot")


@cache
def kick(contact: str = "skin", record: str = "substeps") -> Result:
    """A ball on a floor, kicked away: the scenario, from shortly before the kick."""
    story = scenarios.load("kick_ball")
    motion = story.motions[0][60:110]
    settings = hp.Settings(contact=contact, record=record)  # type: ignore[arg-type]
    return hp.simulate(motion, story.scene, body=story.bodies[0], settings=settings)


@cache
def walled(contact: str = "skin", mesh: bool = False) -> Result:
    """A T-pose that glides against a wall."""
    wall = hp.Box((0.1, 3.0, 3.0))
    scene = hp.Scene()
    scene.add_static("wall", hp.Mesh(*wall.triangles()) if mesh else wall, position=(0.3, 0.0, 0.0))
    settings = hp.Settings(contact=contact)  # type: ignore[arg-type]
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
    """Distance of a contact's part from the ball: its hulls' triangles, in numpy."""
    contacts, body = result.contacts, result.people[0].body
    frame = int(contacts.frame[row])
    skin = body.vertices(result.motion, frame)
    centre, hulls, found = result.objects["ball"].position[frame], body.skin_hulls, np.inf
    for h in np.flatnonzero(hulls.part == contacts.part[row]):
        corners = _hull_triangles(skin[hulls.vertex[hulls.first[h] : hulls.first[h + 1]]])
        faces = np.arange(3 * len(corners)).reshape(-1, 3)
        found = min(found, closest_reference(centre[None], corners.reshape(-1, 3), faces)[0][0])
    return float(found) - result.scene.objects["ball"].shape.radius  # type: ignore[attr-defined]


# -- contact precision -----------------------------------------------------------------------


def test_labels_are_borne_out() -> None:
    result = kick()
    report = metrics.contact_precision(result)
    hit = result.contacts.strength > 0.0
    assert report.contacts == hit.sum() > 20
    assert report.precision_percent == 100.0
    assert np.isnan(report.distance[~hit]).all()
    assert report.distance[hit].max() <= result.settings.clearance + 1e-3


def test_distances_are_those_of_the_hulls() -> None:
    """Of every row between the foot and the ball, against qhull and numpy."""
    frames = kick(record="frames")
    report = metrics.contact_precision(frames, margin=1.0)  # no look at earlier poses
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
    """A wall as a box and as its triangles, the contacts of the one measured in the other."""
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


# -- plausibility of forces ------------------------------------------------------------------


def test_a_kick_is_plausible_and_balanced() -> None:
    report = metrics.contact_forces(kick())
    assert report.push_percent == report.cone_percent == 100.0
    assert list(report.balance) == ["ball"]
    # Of momenta of a few N s.
    assert report.unbalanced < 1e-11
    assert (
        np.abs(kick().objects["ball"].position[-1] - kick().objects["ball"].position[0]).max() > 1
    )


def test_every_frame_but_no_substeps_leaves_the_balance_open() -> None:
    report = metrics.contact_forces(kick(record="frames"))
    assert report.balance == {}
    assert np.isnan(report.unbalanced)
    assert report.push_percent == 100.0


def test_what_a_wrong_impulse_leaves_out_of_balance() -> None:
    """Half of one impulse on the ball is left out: that much is missing, in that frame."""
    result = kick()
    ball = result.names.index("ball")
    row = int(np.argmax(np.where(result.contacts.other == ball, result.contacts.strength, 0.0)))
    impulse = np.array(result.contacts.impulse)
    impulse[row] *= 0.5
    report = metrics.contact_forces(_changed(result, impulse=impulse))
    missing = 0.5 * result.contacts.strength[row]
    assert missing > 0.1
    assert report.balance["ball"][result.contacts.frame[row]] == pytest.approx(missing, rel=1e-9)
    assert report.unbalanced == pytest.approx(missing, rel=1e-9)
    others = np.delete(report.balance["ball"], result.contacts.frame[row])
    assert others.max() < 1e-11


def test_pull_and_slip_by_hand() -> None:
    """Friction of the ball with the body is 0.6: one impulse pulls, one is 3 N s past its cone."""
    result = kick()
    assert result.scene.friction_of("person/left_foot", "ball") == 0.6
    ball, floor = (result.names.index(n) for n in ("ball", next(iter(result.scene.statics))))
    n = 4
    columns: dict[str, Any] = {
        "frame": np.arange(1, n + 1),
        "person": np.zeros(n, dtype=int),
        "part": np.full(n, LEFT_FOOT),
        "other": np.array([ball, ball, ball, floor]),
        "subject": np.full(n, -1),
        "other_part": np.full(n, -1),
        "position": np.zeros((n, 3)),
        "normal": np.tile([0.0, 0.0, 1.0], (n, 1)),
        "impulse": np.array([[6.0, 0, 10], [9.0, 0, 10], [0, 0, -0.5], [0, 10.0, 10]]),
    }
    report = metrics.contact_forces(_changed(result, **columns))
    assert report.contacts == 4
    assert report.push_percent == 75.0
    assert result.scene.friction_of("person/left_foot", result.names[floor]) >= 1.0
    assert report.cone_percent == 50.0  # what pulls is in no cone
    assert report.pull == pytest.approx(0.5)
    assert report.slip == pytest.approx(3.0)


def test_what_sleeps_is_not_out_of_balance() -> None:
    """A box asleep in the air has no weight to carry until something touches it."""
    scene = hp.Scene()
    scene.add_object(
        "box", hp.Box((0.2, 0.2, 0.2)), mass=2.0, position=(0.4, -0.4, 0.0), start="asleep"
    )
    scene.add_object("high", hp.Sphere(0.1), mass=2.0, position=(9.0, 0, 9.0), start="asleep")
    scene.add_object("falls", hp.Sphere(0.1), mass=2.0, com=(0, 0, 0.05), position=(5.0, 0, 9.0),
                     angular_velocity=(3.0, 0, 0))  # fmt: skip
    result = hp.simulate(straight(1.5, 0.8, -0.6), scene, settings=hp.Settings(record="substeps"))
    report = metrics.contact_forces(result)
    assert np.abs(result.objects["box"].position[-1] - [0.4, -0.4, 0.0]).max() > 0.01
    assert sorted(report.balance) == ["box", "falls", "high"]
    assert report.unbalanced < 1e-9
