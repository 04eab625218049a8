"""A motion alone as a result: nobody touches it, it has a body, a floor and its objects."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.errors import FileError, InputError
from halfphysics.results.result import ObjectTrack
from halfphysics.viewer.motions import as_result, is_untouched, open_result
from support.people import along_x


@pytest.fixture(scope="module")
def motion():
    return along_x(1.0, 12, 0.0, z=1.2)


def test_a_motion_is_shown_as_it_is(motion):
    result = as_result(motion)
    (person,) = result.people
    assert person.motion is motion
    assert person.recorded is motion
    assert is_untouched(result)
    assert len(result) == 12
    assert (result.names, list(result.scene.statics)) == (("ground", "person"), ["ground"])
    assert isinstance(result.scene.statics["ground"].shape, hp.Plane)
    assert len(result.contacts.frame) == 0
    assert np.isinf(result.clearance).all()
    body = hp.Body.default()
    np.testing.assert_array_equal(person.body.rest_vertices, body.rest_vertices)


def test_a_sequence_is_shown_with_its_bodies_and_things(motion):
    scene = hp.Scene()
    scene.add_static("stage", hp.Plane())
    scene.add_object("ball", hp.Sphere(0.1), mass=1.0, position=(2.0, 0.0, 0.1))
    scene.add_object("cup", hp.Sphere(0.05), mass=0.2, position=(1.0, 0.0, 1.0))
    moved = ObjectTrack(
        position=np.linspace([1.0, 0.0, 1.0], [1.5, 0.0, 1.0], 12),
        quaternion=np.tile([1.0, 0.0, 0.0, 0.0], (12, 1)),
    )
    small = hp.Body.default(stature=1.5)
    given = hp.Sequence((motion, motion), scene, (small, None), recorded={"cup": moved})
    result = as_result(given)
    assert result.names == ("stage", "ball", "cup", "person_0", "person_1")
    assert result.people[0].body is small
    assert result.people[1].body.mass != small.mass
    np.testing.assert_array_equal(result.objects["cup"].position, moved.position)
    np.testing.assert_array_equal(
        result.objects["ball"].position, np.tile([2.0, 0.0, 0.1], (12, 1))
    )


def test_a_result_stays_and_other_things_are_refused(motion):
    result = as_result(motion)
    assert as_result(result) is result
    with pytest.raises(InputError, match=r"result 2: found 'walk.npz'.*expected a Result.*Motion"):
        as_result("walk.npz", "result 2")


def test_files_of_both_kinds_are_opened(motion, tmp_path):
    motion.save(tmp_path / "walk.npz")
    walk = open_result(tmp_path / "walk.npz")
    assert is_untouched(walk)
    np.testing.assert_allclose(walk.people[0].motion.rotations, motion.rotations, atol=1e-6)
    simulated = hp.simulate(motion, settings=hp.Settings(contact="parts"))
    simulated.save(tmp_path / "result.npz")
    found = open_result(tmp_path / "result.npz")
    assert not is_untouched(found)
    np.testing.assert_array_equal(
        found.people[0].motion.rotations, simulated.people[0].motion.rotations
    )
    (tmp_path / "notes.txt").write_text("no motion")
    with pytest.raises(FileError, match=r"notes\.txt"):
        open_result(tmp_path / "notes.txt")


def test_the_body_of_a_file_may_be_another_one(motion, tmp_path):
    motion.save(tmp_path / "walk.npz")
    tall = hp.Body.default(stature=1.95)
    result = open_result(tmp_path / "walk.npz", body=lambda own, motion: tall)
    assert result.people[0].body is tall
