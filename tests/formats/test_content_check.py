"""No file is read lying, upside down, mirrored or a hundred times too large without a word."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.base.axes import AXES, axes_of
from halfphysics.errors import HalfPhysicsWarning
from halfphysics.formats import FORMATS, content_check, registry
from halfphysics.formats.format import Format, Options
from halfphysics.formats.motion_builder import motion_of
from halfphysics.formats.people import Track
from halfphysics.results.result import ObjectTrack
from support.calls import calls
from support.carries.files import LAYOUTS
from support.carries.files.written import at_rate
from support.carries.recordings import Case, Recording
from support.files.layouts import quiet
from support.files.trumans_files import release
from support.files.wrong_axes import (
    TOLD,
    TRANSLATIONS,
    heights,
    mirrored,
    rescaled,
    turned,
    walker,
    written,
)

#: Heights of joints that went through a file [m]: single precision, and angles of a BVH.
SAME = 2e-5
#: InterMimic's and BVH's bones are measured, those of a BVH with four digits.
MEASURED = 1e-3
WRITERS = [name for name, format in FORMATS.items() if format.save is not None]
OTHERS = [up for up in AXES if up != "z"]
#: What estimators' files never say is told of each, whatever is in it.
NOT_SAID = "not in the file, and taken as"
#: Rotations are told by how joints bend; of positions a mirror image is told by the toes
#: (tests/formats/positions).
TURNING = [name for name in WRITERS if name not in ("joints", "mdm")]
#: Formats that find the axis up by themselves, without this check: SLAHMR's floor has a direction.
BY_THEMSELVES = ("bvh", "slahmr")


def read(path, name="", **options) -> tuple[hp.Motion, list[str]]:
    """A file's motion, and what was warned of."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        motion = hp.Motion.load(path, **{**TOLD.get(name, {}), **options})
    return motion, [str(each.message) for each in caught]


def checked(motion: hp.Motion, **options) -> tuple[hp.Motion, list[str]]:
    """What the check makes of a file that would be read as this motion, with z up."""

    def as_read(given: Options) -> hp.Motion:
        axes = axes_of(given.up or "z")
        turns = np.array(motion.rotations)
        turns[:, 0] = rot.log(rot.multiply(rot.from_matrix(axes), rot.exp(turns[:, 0])))
        return hp.Motion(motion.translation @ axes.T, turns, motion.fps, axes=axes)

    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        found = content_check.checked(
            "file", Options(**options), as_read, lambda one: (one,), lambda one: False
        )
    return found, [str(each.message) for each in caught]


@pytest.mark.parametrize("name", WRITERS)
def test_a_right_file_is_read_as_it_is(tmp_path, name):
    motion, told = read(written(name, walker(), tmp_path), name, fps=30.0)
    found = [line for line in told if NOT_SAID not in line]
    assert not any("up=" in line or "wrong way" in line or "floor=" in line for line in found)
    assert np.abs(heights(motion) - heights(walker())).max() < MEASURED


@pytest.mark.parametrize("up", OTHERS)
@pytest.mark.parametrize("name", WRITERS)
def test_who_stands_is_read_upright_in_every_format(tmp_path, name, up):
    path = written(name, turned(walker(), up), tmp_path)
    motion, told = read(path, name, fps=30.0)
    assert np.abs(heights(motion) - heights(walker())).max() < MEASURED
    lines = [line for line in told if "the person stands along" in line]
    assert len(lines) == 1 or name in BY_THEMSELVES
    # What the caller says counts.
    rule = FORMATS[name].up or "z"
    if name not in BY_THEMSELVES:
        own, told = read(path, name, fps=30.0, up=rule)
        assert np.array_equal(own.axes, axes_of(rule))
        assert len([line for line in told if f"up={rule!r}: it is right" in line]) == 1
        assert np.abs(heights(own) - heights(walker())).max() > 0.5


@pytest.mark.parametrize("factor", [100.0, 1000.0])
@pytest.mark.parametrize("name", TRANSLATIONS)
def test_other_units_are_read_in_metres(tmp_path, name, factor):
    path = written(name, walker(), tmp_path)
    rescaled(name, path, factor)
    motion, told = read(path, name, fps=30.0)
    assert np.abs(heights(motion) - heights(walker())).max() < SAME * factor**0.5
    lines = [line for line in told if "translations are in" in line]
    assert len(lines) == 1
    assert ("centimetres" if factor == 100.0 else "millimetres") in lines[0]
    # It is written back in the unit of its file.
    again = tmp_path / f"b{path.suffix}"
    motion.save(again)
    assert any("translations are in" in line for line in read(again, name, fps=30.0)[1])


@pytest.mark.parametrize("name", TURNING)
def test_a_mirrored_person_is_told(tmp_path, name):
    _, told = read(written(name, mirrored(walker()), tmp_path), name, fps=30.0)
    lines = [line for line in told if "joints bend the wrong way: left elbow" in line]
    assert len(lines) == 1


def test_inverse_rotations_are_told_and_not_believed():
    motion = walker()
    found, told = checked(hp.Motion(motion.translation, -motion.rotations, motion.fps))
    assert np.array_equal(found.axes, np.eye(3))
    assert any("left knee" in line and "inverse" in line for line in told)


def test_a_mirrored_translation_is_told_by_the_feet():
    motion = walker()
    _, told = checked(hp.Motion(motion.translation * [-1, 1, 1], motion.rotations, motion.fps))
    assert [line for line in told if "planted feet go along x" in line] == told


def carried(up: str) -> Recording:
    """The walker with a table that floats along, as a data set with z up has it of such a file."""
    motion, turn = walker(), axes_of(up).T
    ahead = np.array([1.0, 0.2, 0.1])
    spin = rot.exp(np.linspace(0.0, 1.0, len(motion))[:, None] * [0.2, 0.1, 0.5])
    track = ObjectTrack(
        position=(motion.translation + ahead) @ turn.T,
        quaternion=rot.multiply(rot.from_matrix(turn), spin),
    )
    return Recording(
        case=Case("smalltable"), body=hp.Body.default(), motion=turned(motion, up), track=track,
        stands={}, hold=(0, 1), bend=np.zeros(len(motion)),
    )  # fmt: skip


@pytest.mark.parametrize("up", ["y", "-z", "x"])
@pytest.mark.parametrize("layout", ["behave", "grab", "core4d", "omomo"])
def test_things_and_people_turn_together(tmp_path, layout, up):
    module, fps = LAYOUTS[layout]
    right, wrong = at_rate(carried("z"), fps), at_rate(carried(up), fps)
    file = module.write(wrong, tmp_path)
    found = quiet(file.path, adapt=False, objects="replayed")
    assert np.abs(heights(found.motions[0]) - heights(right.motion)).max() < SAME
    (thing,) = found.recorded.values()
    place = thing.position + rot.rotate(thing.quaternion, file.middle)
    assert np.abs(place[:, 2] - right.track.position[:, 2]).max() < SAME
    corners = hp.Mesh(right.thing.mesh.vertices, right.thing.mesh.faces).vertices
    middle = corners.mean(axis=0)
    high = rot.rotate(right.track.quaternion[:, None], corners[None] - middle)[..., 2]
    seen = rot.rotate(thing.quaternion[:, None], corners[None] - middle)[..., 2]
    assert np.abs(np.sort(high) - np.sort(seen)).max() < 1e-4


@pytest.mark.parametrize("up", ["-y", "z"])
def test_a_release_in_a_folder_is_told(tmp_path, up):
    """TRUMANS: y up; clips of less than a second say nothing for sure."""
    folder = release(tmp_path / "trumans", objects=False)
    turn = axes_of(up).T @ axes_of("y")
    orient, places = (np.load(folder / f"human_{name}.npy") for name in ("orient", "transl"))
    turns = rot.log(rot.multiply(rot.from_matrix(turn), rot.exp(orient)))
    np.save(folder / "human_orient.npy", turns.astype(np.float32))
    np.save(folder / "human_transl.npy", (places @ turn.T).astype(np.float32))
    with pytest.warns(HalfPhysicsWarning, match=f"Then say up='{up}'"):
        hp.Motion.load(folder, clip="walk@1 again")


def test_things_in_centimetres_come_along(tmp_path):
    module, _ = LAYOUTS["behave"]
    path = module.write(carried("z"), tmp_path).path
    right = quiet(path, adapt=False, objects="replayed")
    for name in ("smpl_fit_all.npz", "object_fit_all.npz"):
        with np.load(path / name) as old:
            fields = dict(old)
        np.savez(path / name, **(fields | {"trans": 100.0 * fields["trans"]}))
    with pytest.warns(HalfPhysicsWarning, match="translations are in centimetres") as caught:
        found = hp.load_sequence(path, adapt=False, objects="replayed")
    assert len(caught) == 1
    assert np.abs(found.motion.translation - right.motion.translation).max() < SAME
    (thing,), (same,) = found.recorded.values(), right.recorded.values()
    assert np.abs(thing.position - same.position).max() < SAME


def test_people_of_one_file_are_looked_at_together(tmp_path, monkeypatch):
    """One of them hardly moves: with the other it is clear which axis is up."""
    people = {"a": turned(walker(), "x"), "b": turned(walker(), "x")[:50]}

    def load(source, options: Options) -> hp.Motion:
        motion = people[options.clip]
        return motion_of(
            "two", options, format="two", translation=motion.translation[options.frames],
            rotations=motion.rotations[options.frames], fps=30.0, up="z", model="smplx",
            gender="neutral",
        )  # fmt: skip

    format = Format(
        name="two", expects="two", sniff=lambda source: source.head == b"two", load=load,
        people=lambda source: [Track("a", 0, 90), Track("b", 30, 80)],
    )  # fmt: skip
    monkeypatch.setitem(registry.FORMATS, "two", format)
    (tmp_path / "two").write_bytes(b"two")
    with pytest.warns(HalfPhysicsWarning, match="read with x up") as caught:
        found = hp.load_sequence(tmp_path / "two").motions
    assert len(caught) == 1
    truth = heights(walker())
    for motion, asked in zip(found, (truth[30:80], truth[:50]), strict=True):
        assert np.abs(heights(motion) - asked).max() < SAME


def lying() -> hp.Motion:
    """On the back along y, arms and legs moving a little over the floor, five seconds."""
    t = np.arange(150)[:, None] / 30.0
    turns = np.zeros((150, 55, 3))
    turns[:, [16, 17, 1, 2]] = 0.3 * np.sin(t + np.arange(4))[:, :, None] * [1.0, 0.0, 0.0]
    turns[:, [1, 2, 16, 17], 0] = -np.abs(turns[:, [1, 2, 16, 17], 0])
    return hp.Motion(np.tile([0.0, 0.0, 0.12], (150, 1)), turns, 30.0)


def handstand() -> hp.Motion:
    """On straight arms, head down, legs moving, five seconds."""
    t = np.arange(150) / 30.0
    turns = np.zeros((150, 55, 3))
    turns[:, 0] = [-np.pi / 2, 0.0, 0.0]
    turns[:, 16] = [0.0, 0.0, 1.4]
    turns[:, 17] = [0.0, 0.0, -1.4]
    turns[:, 1, 2] = 0.3 * np.abs(np.sin(2.0 * t))
    turns[:, 2, 0] = -0.6 * np.abs(np.sin(t))
    return hp.Motion(np.zeros((150, 3)), turns, 30.0).grounded(hp.Body.default())


def cartwheel() -> hp.Motion:
    """Three turns sideways, and two seconds on the feet before and after."""
    t = np.arange(210) / 30.0
    angle = 6.0 * np.pi * np.clip((t - 2.0) / 3.0, 0.0, 1.0)
    turns = np.zeros((210, 55, 3))
    spin = rot.exp(angle[:, None] * [0.0, 1.0, 0.0])
    turns[:, 0] = rot.log(rot.multiply(spin, rot.exp([np.pi / 2, 0.0, 0.0])))
    places = np.zeros((210, 3))
    places[:, 0] = 0.9 * angle
    motion = hp.Motion(places, turns, 30.0)
    low = hp.Body.default().vertices(motion)[..., 2].min(axis=1)
    return hp.Motion(places - low[:, None] * [0.0, 0.0, 1.0], turns, 30.0)


@pytest.mark.parametrize("make", [lying, handstand, cartwheel])
def test_floor_work_stays_as_it_is(make):
    motion = make()
    found, _ = checked(motion)
    assert np.array_equal(found.axes, np.eye(3))


def test_what_is_not_clear_is_told_with_the_way_out():
    short = turned(walker(), "y")[:20]
    found, told = checked(short)
    assert np.array_equal(found.axes, np.eye(3))
    assert len(told) == 1
    assert "lying, or is another axis up? Then say up='y' (up='z': it is right)" in told[0]
    assert checked(short, up="z")[1] == []
    assert np.array_equal(checked(short, up="y")[0].axes, axes_of("y"))


def test_who_crawls_is_told_where_something_else_bears_them():
    crawl = hp.scenarios.load("crawl_under_table").motion
    _, told = checked(turned(hp.Motion(crawl.translation, crawl.rotations, crawl.fps), "-z"))
    (line,) = told
    assert "something bears the person along -z rather than along it" in line


def test_scenarios_are_right_without_a_word():
    for name in ("crawl_under_table", "climb_onto_bed", "stretch_on_bed", "sit_on_sofa"):
        for motion in hp.scenarios.load(name).motions:
            _, told = checked(hp.Motion(motion.translation, motion.rotations, motion.fps))
            assert told == [], name


def test_real_clips_are_right_without_a_word(shared_data):
    for path in sorted((shared_data / "motion").glob("*.npz")):
        _, told = read(path)
        assert told == [], path.name
    for path in sorted((shared_data / "motion").glob("*.bvh")):
        (line,) = read(path)[1]
        assert "put on the default body by joint names" in line


def test_results_are_not_looked_at_again(tmp_path):
    motion = lying()[:4]
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    hp.simulate(motion, scene, settings=hp.Settings.paper()).save(tmp_path / "r.npz")
    assert read(tmp_path / "r.npz")[1] == []


def test_a_long_clip_takes_no_more_steps_than_a_short_one():
    """What is looked at is chosen, and done at once: no loop runs over the frames."""

    def steps(frames: int) -> int:
        there_and_back = np.abs(np.arange(frames) % 178 - 89)
        who = walker()
        motion = hp.Motion(who.translation[there_and_back], who.rotations[there_and_back], 30.0)
        checked(motion)  # what is imported late
        return calls(lambda: checked(motion))

    assert steps(3000) == steps(300)
