"""The report per frame and part: each column by another method, in memory and from a file."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.errors import FileError, InputError
from halfphysics.geometry.shapes import Box, Mesh, Plane, Sphere
from halfphysics.metrics import part_report
from halfphysics.motion.skeleton import JOINT_INDEX, JOINT_NAMES
from halfphysics.results.contacts import Contacts
from halfphysics.results.inside import Inside
from halfphysics.results.result import PersonResult, Result
from halfphysics.scene.scene import Scene
from halfphysics.settings import Settings
from halfphysics.simulation.simulate import simulate
from support.people import along_x
from support.results.random_result import make_result, touching

SAME = 1e-9  # poses go through axis-angle vectors and back: rounding [m]
COLUMNS = ("clearance", "nearest", "contact", "force", "displacement", "rotation")
HEAD, FOOT = JOINT_INDEX["head"], JOINT_INDEX["left_foot"]


@pytest.fixture(scope="module")
def body():
    return Body.default()


@pytest.fixture(scope="module")
def pair(body):
    """Two people walk into a wall each; one meets a ball on the way."""
    scene = Scene()
    scene.add_static("ceiling", Plane(normal=(0.0, 0.0, -1.0), offset=-5.0))
    scene.add_static("wall", Box((0.01, 8.0, 6.0)), position=(0.5, 0.0, 0.0))
    scene.add_object("ball", Sphere(0.1), mass=1.0, position=(0.25, 0.1, 0.3))
    motions = [along_x(1.5, 40, start=-0.3)]
    path = motions[0].translation * [0.5, 1.0, 1.0] + [0.0, 3.0, 0.0]
    motions.append(motions[0].with_frames(path, motions[0].rotations))
    return simulate(motions, scene, body=[body, body])


def test_clearance_is_that_of_the_result(pair):
    reports = [pair.parts(0), pair.parts(1)]
    both = np.minimum(*(r.clearance.min(axis=1) for r in reports))
    np.testing.assert_allclose(both, pair.clearance, atol=SAME)
    wall = pair.names.index("wall")
    for report in reports:
        assert len(report) == 40
        assert np.isfinite(report.clearance).any()
        np.testing.assert_array_equal(
            report.nearest, np.where(np.isfinite(report.clearance), wall, -1)
        )
    # The second walks at half the speed.
    first = [np.isfinite(r.clearance).any(axis=1).argmax() for r in reports]
    assert first[0] < first[1]


def test_contact_and_force_are_those_of_the_contacts(pair):
    for index in range(2):
        report, mine = pair.parts(index), pair.contacts[pair.contacts.person == index]
        expected = np.zeros((len(pair), 55))
        for frame, part, impulse in zip(mine.frame, mine.part, mine.impulse, strict=True):
            expected[frame, part] += np.linalg.norm(impulse) * pair.fps
        np.testing.assert_allclose(report.force, expected, rtol=1e-12)
        np.testing.assert_array_equal(report.contact, expected > 0.0)
        assert report.contact.any()
        # A part in contact with the wall is near it.
        wall = mine[mine.other == pair.names.index("wall")]
        touching_now = np.zeros_like(report.contact)
        touching_now[wall.frame, wall.part] = True
        assert touching_now.any()
        assert report.clearance[touching_now].max() < 0.05


def test_displacement_and_rotation(pair, body):
    for index, person in enumerate(pair.people):
        report = pair.parts(index)
        apart = body.joints(person.motion) - body.joints(person.reference)
        np.testing.assert_allclose(report.displacement, np.linalg.norm(apart, axis=-1))
        a = rot.rotvec_to_matrix(person.motion.rotations)
        b = rot.rotvec_to_matrix(person.reference.rotations)
        cosine = 0.5 * (np.einsum("tjab,tjab->tj", a, b) - 1.0)
        # arccos has small angles only to the square root of its rounding.
        np.testing.assert_allclose(
            report.rotation, np.arccos(np.clip(cosine, -1.0, 1.0)), atol=1e-7
        )
        assert report.rotation.max() > 0.1


def test_worked_out_once_and_not_to_be_changed(pair):
    assert pair.parts(1) is pair.parts(1)
    for column in COLUMNS:
        array = getattr(pair.parts(), column)
        assert array.shape == (40, len(JOINT_NAMES))
        with pytest.raises(ValueError, match="read-only"):
            array[0, 0] = 1
    for person in (2, -1, 1.0, "me", True):
        with pytest.raises(InputError, match=r"person: found .*, expected 0 to 1"):
            pair.parts(person)


def test_the_same_from_a_file(tmp_path, pair):
    pair.save(tmp_path / "r.npz")
    loaded = Result.load(tmp_path / "r.npz")
    for index in range(2):
        for column in COLUMNS:
            np.testing.assert_array_equal(
                getattr(loaded.parts(index), column), getattr(pair.parts(index), column)
            )


def test_a_scene_that_is_not_whole_is_said(tmp_path, body):
    (tmp_path / "tetra.obj").write_text(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    )
    scene = Scene()
    scene.add_static("floor", Plane(offset=-2.0))
    scene.add_static("rock", tmp_path / "tetra.obj", position=(1, 2, 3))
    result = simulate(along_x(0.0, 3, start=0.0), scene, body=body)
    result.save(tmp_path / "r.npz")
    (tmp_path / "tetra.obj").unlink()
    lost = Result.load(tmp_path / "r.npz")
    with pytest.raises(FileError, match=r"r\.npz: .*not whole: rock \(.*is not there.*scene="):
        lost.parts()
    again = Result.load(tmp_path / "r.npz", scene=scene)
    np.testing.assert_array_equal(again.parts().clearance, result.parts().clearance)
    other = Result.load(tmp_path / "r.npz", scene=Scene())
    with pytest.raises(FileError, match="found nothing in it, expected floor, rock"):
        other.parts()


def test_what_a_surface_hides_has_the_way_that_it_has_to_go(body):
    """A head within a mesh is some distance from its triangles: that is no clearance."""
    settings = Settings(contact="parts")
    motion = along_x(0.0, 3, start=0.0)
    top = body.joints(motion)[0, HEAD]
    scene = Scene()
    scene.add_static(
        "hall", Mesh(*Box((9.0, 9.0, 9.0)).triangles()), position=top + np.array([4.4, 0.0, 0.0])
    )
    inside = Inside(
        frame=[1, 1, 2],
        person=[0, 0, 0],
        part=[HEAD, FOOT, FOOT],
        subject=[-1] * 3,
        other=[0] * 3,
        depth=[0.3, 0.0, 0.2],
    )
    person = PersonResult(name="person", motion=motion, reference=motion, body=body)
    result = Result(
        people=[person],
        objects={},
        scene=scene,
        names=("hall", "person"),
        contacts=Contacts.none(),
        clearance=np.zeros(3),
        lost_time=np.zeros(3),
        settings=settings,
    )
    measured = result.parts()
    told = dataclasses.replace(result, inside=inside).parts()
    assert measured.clearance[1, HEAD] > 0.0  # the distance of the visible surface
    expected = measured.clearance.copy()
    expected[1, HEAD], expected[2, FOOT] = -0.3, -0.2  # frame 1's foot is unknown
    np.testing.assert_array_equal(told.clearance, expected)
    assert told.nearest[1, HEAD] == told.nearest[2, FOOT] == 0


def test_the_nearest_of_several_shapes_of_a_part(body, monkeypatch):
    """Two shapes of the head, one of a foot, and an object, which belongs to no person."""
    inf = np.inf
    dist = np.array([[0.02, 0.01, inf, np.nan], [0.03, inf, 0.04, np.nan]])
    static = np.array([[0, 1, -1, -1], [1, -1, 0, -1]])

    class Stepper:
        def clearances(self, qpos, reach, nearest):
            nearest[:] = static
            return dist

    result = make_result(body, frames=2, contacts=touching([1], [FOOT], [0], [[0.0, 3.0, 4.0]]),
                         inside=Inside.none())  # fmt: skip
    world = SimpleNamespace(
        names=result.names,
        people=[
            SimpleNamespace(qpos=0, count=3, coordinates=lambda t, r, axes: np.zeros((len(t), 3)))
        ],
        joined=SimpleNamespace(qpos0=np.zeros(3)),
        stepper=Stepper(),
        shape_name=np.array([4, 4, 4, 2]),
        shape_part=np.array([HEAD, HEAD, FOOT, -1]),
        static_name=np.array([1, 0]),
    )
    monkeypatch.setattr(part_report, "_world", lambda result: world)
    report = result.parts()
    expected = np.full((2, 55), inf)
    expected[:, HEAD], expected[1, FOOT] = [0.01, 0.03], 0.04
    nearest = np.full((2, 55), -1)
    nearest[:, HEAD], nearest[1, FOOT] = [0, 0], 1
    np.testing.assert_array_equal(report.clearance, expected)
    np.testing.assert_array_equal(report.nearest, nearest)
    assert report.force[1, FOOT] == pytest.approx(5.0 * result.fps)
    assert report.contact.sum() == 1
