"""Result files as motion files: everybody is read as in the result, whatever was simulated."""

from __future__ import annotations

import dataclasses
import warnings

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.base.axes import axes_of, turned
from halfphysics.errors import HalfPhysicsError, HalfPhysicsWarning, InputError
from halfphysics.results.result import PersonResult
from support.command_line import run
from support.files.wrong_axes import walker
from support.results.random_result import make_result

#: To the axes and the unit of the file and back, through axis-angles [m, rad].
ROUNDING = 1e-9
FRAMES = 24
ASIDE = np.array([0.25, 0.0, 0.0])


@pytest.fixture(scope="module")
def body():
    return hp.Body.default()


def saved(path, body, *motions):
    """A result file of people who moved 25 cm aside of what they should."""
    people = tuple(
        PersonResult(
            name=f"person{number}",
            motion=motion.with_frames(motion.translation + ASIDE, motion.rotations),
            reference=motion,
            body=body,
        )
        for number, motion in enumerate(motions)
    )
    result = make_result(body, frames=FRAMES, people=len(people))
    result = dataclasses.replace(result, people=people)
    result.save(path)
    return result


def read(path, **options):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", HalfPhysicsWarning)
        return hp.Motion.load(path, **options)


def same(a, b):
    assert np.abs(a.translation - b.translation).max() < ROUNDING
    assert np.abs(rot.exp(a.rotations) - rot.exp(b.rotations)).max() < ROUNDING
    assert np.array_equal(a.axes, b.axes)
    assert (a.fps, a.gender, a.model) == (b.fps, b.gender, b.model)


@pytest.fixture
def pair(tmp_path, body):
    """A result of two people, in a file."""
    first = walker()[:FRAMES]
    second = first.with_frames(first.translation + 6 * ASIDE, first.rotations)
    second = dataclasses.replace(second, gender="male", betas=np.array([0.5, -1.0]))
    return saved(tmp_path / "pair.npz", body, first, second), tmp_path / "pair.npz"


def test_everybody_is_read_together(pair):
    result, path = pair
    found = hp.load_sequence(path).motions
    assert len(found) == 2
    for motion, person in zip(found, result.people, strict=True):
        same(motion, person.motion)
    assert np.array_equal(found[1].betas, [0.5, -1.0])


def test_one_person_is_read_by_name_and_unasked_the_first_with_a_word(pair):
    result, path = pair
    for person in result.people:
        same(hp.Motion.load(path, clip=person.name), person.motion)  # a warning would be an error
    same(
        hp.Motion.load(path, clip="person1", frames=(3, 9), fps=60.0, gender="female"),
        dataclasses.replace(result.people[1].motion[3:9], fps=60.0, gender="female"),
    )
    with pytest.warns(HalfPhysicsWarning, match=r"of 2 people 'person0' is read.*'person1'"):
        same(hp.Motion.load(path), result.motion)
    with pytest.raises(InputError, match="no 'anna', expected one of its 2 people"):
        hp.Motion.load(path, clip="anna")


def test_a_result_of_several_is_read_whole_without_a_word(pair):
    _, path = pair
    assert [p.name for p in hp.Result.load(path).people] == ["person0", "person1"]


def test_the_command_line_converts_one_of_them(pair, tmp_path, capsys):
    result, path = pair
    assert run("convert", path, tmp_path / "one.npz", "--clip", "person1") == 0
    assert "warning" not in capsys.readouterr().err
    same(read(tmp_path / "one.npz"), result.people[1].motion)


def fields(motion, up="z", unit=1.0):
    """Fields of an AMASS file with another axis up, in another unit."""
    trans, turns = turned(motion.translation / unit, motion.rotations, axes_of(up).T)
    joints = [*range(22), *range(25, 55)]
    return {
        "trans": trans,
        "poses": turns[:, joints].reshape(len(motion), 156),
        "gender": np.array("male"),
        "mocap_framerate": np.array(motion.fps),
    }


@pytest.mark.parametrize(("up", "unit"), [("z", 0.01), ("y", 1.0), ("-y", 1.0), ("y", 0.001)])
def test_a_result_of_a_file_with_other_axes_or_units_is_upright_and_in_metres(
    tmp_path, body, up, unit
):
    np.savez(tmp_path / "in.npz", **fields(walker(), up, unit))
    given = {} if up == "z" else {"up": up}
    motion = read(tmp_path / "in.npz", **given)[:FRAMES]
    assert np.array_equal(motion.axes, axes_of(up))
    result = saved(tmp_path / "out.npz", body, motion)
    again = hp.Motion.load(tmp_path / "out.npz")
    same(again, result.motion)
    same(hp.Result.load(tmp_path / "out.npz").motion, result.motion)
    same(hp.load_sequence(tmp_path / "out.npz").motion, result.motion)
    # Written again it is in the axes and the unit of the file that was simulated.
    again.save(tmp_path / "again.npz")
    with np.load(tmp_path / "again.npz") as file, np.load(tmp_path / "out.npz") as out:
        assert np.abs(file["trans"] - out["trans"]).max() < ROUNDING / unit


def test_fingers_about_a_mean_hand_are_those_of_the_result(tmp_path, body):
    motion = walker()[:FRAMES]
    mean = np.linspace(-0.3, 0.3, 90).reshape(30, 3)
    np.savez(tmp_path / "in.npz", **fields(motion))
    motion = read(tmp_path / "in.npz")
    bent = motion.rotations.copy()
    bent[:, 25:] += mean
    own = dataclasses.replace(motion.origin, fields={**motion.origin.fields, "hands_mean": mean})
    motion = dataclasses.replace(motion.with_frames(motion.translation, bent), origin=own)
    result = saved(tmp_path / "out.npz", body, motion)
    same(hp.Motion.load(tmp_path / "out.npz"), result.motion)


def test_a_motion_on_top_that_was_changed_is_read_as_it_is(tmp_path, body):
    motion = walker()[:FRAMES]
    saved(tmp_path / "out.npz", body, motion)
    with np.load(tmp_path / "out.npz") as file:
        content = dict(file)
    content["poses"] = content["poses"] + 0.01
    np.savez(tmp_path / "out.npz", **content)
    found = hp.Motion.load(tmp_path / "out.npz")
    assert np.abs(found.poses.reshape(FRAMES, -1) - content["poses"]).max() < ROUNDING


def edited(path, **changes):
    """The file with other fields; a function makes a field of what it was."""
    with np.load(path) as file:
        content = dict(file)
    for key, change in changes.items():
        content[key] = change(content[key]) if callable(change) else change
    np.savez(path, **content)


@pytest.mark.parametrize("up", ["z", "y", "-y"])
def test_a_motion_on_top_that_was_changed_is_upright_whatever_was_simulated(tmp_path, body, up):
    # Of a file with other axes and no fields of its own: on top it is z up.
    motion = dataclasses.replace(walker()[:FRAMES], axes=axes_of(up), origin=None)
    result = saved(tmp_path / "out.npz", body, motion)
    edited(tmp_path / "out.npz", poses=lambda poses: poses + 1e-3)
    found = read(tmp_path / "out.npz")
    turn = rot.multiply(rot.conjugate(rot.exp(result.motion.rotations)), rot.exp(found.rotations))
    assert np.linalg.norm(rot.log(turn), axis=-1).max() < 3e-3


@pytest.mark.parametrize("up", ["z", "y"])
def test_a_motion_on_top_that_was_moved_is_read_where_it_is(tmp_path, body, up):
    motion = dataclasses.replace(walker()[:FRAMES], axes=axes_of(up), origin=None)
    saved(tmp_path / "out.npz", body, motion)
    before = read(tmp_path / "out.npz").rebased(body).translation
    edited(tmp_path / "out.npz", trans=lambda trans: trans + 0.25)
    assert np.abs(read(tmp_path / "out.npz").translation - before - 0.25).max() < ROUNDING


def test_a_motion_in_centimetres_that_was_changed_is_in_metres(tmp_path, body):
    np.savez(tmp_path / "in.npz", **fields(walker(), unit=0.01))
    motion = read(tmp_path / "in.npz")[:FRAMES]
    result = saved(tmp_path / "out.npz", body, motion)
    edited(tmp_path / "out.npz", trans=lambda trans: np.add(trans, [1.0, 0.0, 0.0]))
    found = read(tmp_path / "out.npz")
    assert np.abs(found.translation - result.motion.translation - [0.01, 0, 0]).max() < ROUNDING


def test_everybody_is_where_they_were_with_any_body(tmp_path):
    """Of a file with y up, the pelvis at rest of the body is in the places on top."""
    tall, up = hp.Body.default(stature=1.95), axes_of("y")
    first = dataclasses.replace(walker()[:FRAMES], axes=up, origin=None)
    second = first.with_frames(first.translation + 6 * ASIDE, first.rotations)
    result = saved(tmp_path / "out.npz", tall, first, second)
    for found, person in zip(
        hp.load_sequence(tmp_path / "out.npz").motions, result.people, strict=True
    ):
        same(found, person.motion)


@pytest.mark.parametrize("option", [{"up": "y"}, {"hands": "flat"}])
def test_what_the_result_says_of_everybody_is_not_asked(pair, option):
    _, path = pair
    with pytest.raises(InputError, match=rf"{next(iter(option))}: .*all its people. Leave it out"):
        hp.load_sequence(path, **option)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"trans": np.array(0.0)}, "trans"),
        ({"meta/people": lambda p: p.replace('"axes": [[1.0', '"axes": [["x"')}, "axes"),
    ],
)
def test_damaged_results_are_one_message(pair, changes, said):
    _, path = pair
    for key, change in changes.items():
        if callable(change):
            changes = {key: lambda old, change=change: np.array(change(str(old.reshape(-1)[0])))}
    edited(path, **changes)
    for load in (read, hp.load_sequence):
        with pytest.raises(HalfPhysicsError, match=said):
            load(path)
