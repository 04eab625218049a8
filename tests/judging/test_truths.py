"""The truth of each person: by name, of results by place, and never another person's."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import trimesh

import halfphysics as hp
from halfphysics.cli.judge import Options
from halfphysics.errors import InputError
from halfphysics.formats import registry, save_people
from halfphysics.formats.loading import MotionOptions
from halfphysics.judging.judge import judge_one
from halfphysics.judging.tasks import Task, tasks_of
from halfphysics.judging.truths import reference_of, truth_of
from halfphysics.results.contacts import Contacts
from halfphysics.results.object_track import ObjectTrack
from support.made_clips import walk

#: Files keep float32 [mm].
EXACT = 1e-2


@pytest.fixture
def pair(tmp_path):
    """A result of two people and a ball, in a file."""
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    scene.add_object("ball", hp.Sphere(0.1), mass=1.0, position=(2.0, 0.0, 0.1))
    one, other = walk()[:8], walk(1)[:8]
    far = np.array([0.0, 3.0, 0.0])
    other = other.with_frames(other.translation + far, other.rotations)
    path = tmp_path / "pair.npz"
    hp.simulate([one, other], scene).save(path)
    return path


def errors(path, truth):
    return [one.verdict["mpjpe_global_mm"] for one in hp.judge(path, truth=truth, jobs=1)]


def test_a_result_of_two_people_is_its_own_truth(pair):
    for error in errors(pair, pair):
        assert error < EXACT
    for one in hp.judge(pair, truth=pair, jobs=1):
        assert one.verdict["contact_precision"] in (0.0, 1.0)


def test_people_of_a_file_are_their_own_truth(tmp_path):
    people = [walk()[:8], walk(1)[:8]]
    (path,) = save_people(people, tmp_path / "pair.pkl", [hp.Body.default()] * 2, format="romp")
    found = hp.judge(path, truth=path, jobs=1)
    assert len(found) == 2
    for one in found:
        assert one.verdict["mpjpe_global_mm"] < EXACT


def test_people_of_a_result_may_have_other_names_in_the_truth(pair):
    result = hp.Result.load(pair)
    for index, person in enumerate(result.people):
        found = truth_of(pair, MotionOptions(), "somebody", index=index, count=2)
        assert np.array_equal(found.motion.translation, person.motion.translation)
        assert set(found.objects) == {"ball"}
        swapped = truth_of(pair, MotionOptions(), person.name, index=1 - index, count=2)
        assert np.array_equal(swapped.motion.translation, person.motion.translation)


def test_of_several_people_none_is_taken_for_somebody_else(pair, tmp_path):
    walk()[:8].save(tmp_path / "alone.npz")
    (one,) = judge_one((Task(tmp_path / "alone.npz", truth=pair), Options()))
    assert one.verdict is None
    assert "holds 2 (person0, person1)" in one.error
    with pytest.raises(InputError, match="found none of the name 'anne' to judge"):
        truth_of(pair, MotionOptions(), "anne", index=0, count=3)
    named = truth_of(pair, MotionOptions(clip="person1"), None)
    second = hp.Result.load(pair).people[1].motion
    assert np.array_equal(named.motion.translation, second.translation)


def test_a_truth_of_one_person_is_that_of_all_clips(library):
    assert truth_of(library / "a.npz", MotionOptions(), "anne").objects is None


def test_of_several_people_one_has_a_truth_of_one_person(pair, tmp_path):
    """Who has its name; in a motion without names nobody has."""
    walk(1)[:8].save(tmp_path / "alone.npz")
    for one in hp.judge(pair, truth=tmp_path / "alone.npz", jobs=1):
        assert one.verdict is None
        assert "alone.npz holds one person, and the result 2" in one.error
    result = hp.Result.load(pair)
    second = dataclasses.replace(
        result,
        people=result.people[1:],
        names=("floor", "ball", "person1"),
        contacts=Contacts.none(),
    )
    second.save(tmp_path / "second.npz")
    first, other = hp.judge(pair, truth=tmp_path / "second.npz", jobs=1)
    assert (first.name, first.verdict) == (f"{pair}:person0", None)
    assert "second.npz holds one person" in first.error
    assert other.verdict["mpjpe_global_mm"] < EXACT


def test_of_several_people_of_a_file_none_has_a_truth_of_one_person(tmp_path):
    people = [walk()[:8], walk(1)[:8]]
    (path,) = save_people(people, tmp_path / "pair.pkl", [hp.Body.default()] * 2, format="romp")
    people[0].save(tmp_path / "alone.npz")
    for one in hp.judge(path, truth=tmp_path / "alone.npz", jobs=1):
        assert "alone.npz holds one person, and the clip 2" in one.error
    (task,) = tasks_of([path], tmp_path / "alone.npz")
    named = hp.judge(path, jobs=1)[0].name.rpartition(":")[2]
    (one,) = judge_one((task, Options(motion_file=MotionOptions(clip=named))))
    assert one.verdict is not None  # whom the user named


def test_objects_of_a_data_set_are_read_where_they_are_asked_for(library, monkeypatch):
    track = ObjectTrack(
        position=np.zeros((40, 3)), quaternion=np.tile([1.0, 0.0, 0.0, 0.0], (40, 1))
    )
    real = registry.load_sequence

    def recorded(*arguments, **options):
        return dataclasses.replace(real(*arguments, **options), recorded={"ball": track})

    monkeypatch.setattr(registry, "load_sequence", recorded)
    assert truth_of(library / "a.npz", MotionOptions(), None).objects is None
    found = truth_of(library / "a.npz", MotionOptions(), None, objects=True)
    assert set(found.objects) == {"ball"}


def test_references_of_several_people_are_each_ones_own(pair, tmp_path):
    result = hp.Result.load(pair)
    for index, person in enumerate(result.people):
        found = reference_of(pair, person.name, index=index, count=2)
        assert np.array_equal(found.translation, person.motion.translation)
    walk()[:8].save(tmp_path / "alone.npz")
    with pytest.raises(InputError, match="holds one person, and the result 2"):
        reference_of(tmp_path / "alone.npz", "person0", index=0, count=2)
    assert len(reference_of(tmp_path / "alone.npz", "person", index=0, count=1)) == 8


def test_a_scene_that_is_given_has_the_meshes_that_the_result_lost(tmp_path):
    mesh, scene = tmp_path / "ball.stl", hp.Scene()
    trimesh.creation.icosphere(subdivisions=2, radius=0.15).export(mesh)
    scene.add_static("floor", hp.Plane())
    scene.add_object("ball", mesh, mass=1.0, position=(2.0, 0.0, 0.15))
    hp.simulate(walk()[:8], scene).save(tmp_path / "result.npz")
    moved = tmp_path / "moved.stl"
    mesh.rename(moved)
    given = hp.Scene()
    given.add_static("ground", hp.Plane())  # of another name, too
    given.add_object("ball", moved, mass=1.0, position=(2.0, 0.0, 0.15))
    given.save(tmp_path / "scene.yaml")
    (one,) = hp.judge(tmp_path / "result.npz", scene=tmp_path / "scene.yaml", jobs=1)
    assert one.warnings == ()
    assert one.verdict["hand_contact_percent"] == 0.0
