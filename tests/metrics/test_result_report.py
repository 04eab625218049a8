"""The summary: every number by another method, and unknown values are named."""

from __future__ import annotations

import dataclasses
import re

import numpy as np
import pytest

from halfphysics import scenarios
from halfphysics.body.body import Body
from halfphysics.geometry.shapes import Box, Plane, Sphere
from halfphysics.motion.skeleton import JOINT_INDEX, JOINT_NAMES
from halfphysics.results.contacts import Contacts
from halfphysics.results.inside import Inside
from halfphysics.results.result import ObjectTrack, PersonResult, Result
from halfphysics.scene.scene import Scene
from halfphysics.settings import Settings
from halfphysics.simulation.simulate import simulate
from support.people import along_x
from support.results.random_result import touching

FRAMES, FPS = 60, 30.0
WRIST, HAND, FOOT = (JOINT_INDEX[f"left_{name}"] for name in ("wrist", "index1", "foot"))
EYE = np.tile([1.0, 0.0, 0.0, 0.0], (FRAMES, 1))


@pytest.fixture(scope="module")
def body():
    return Body.default()


@pytest.fixture
def quiet(body):
    """A person 0.3 m before a wall, a resting ball and a resting cup; no contact occurs."""
    scene = Scene()
    scene.add_static("floor", Plane(offset=-3.0))
    scene.add_static("wall", Box((0.2, 8.0, 8.0)), position=(0.6, 0.0, 0.0))
    for name in ("ball", "cup"):
        scene.add_object(name, Sphere(0.1), mass=1.0, position=(5.0, 0.0, 0.0))
    motion = along_x(0.0, FRAMES, start=0.0)
    still = ObjectTrack(position=np.tile([5.0, 0.0, 0.0], (FRAMES, 1)), quaternion=EYE)
    return Result(
        people=[PersonResult(name="person", motion=motion, reference=motion, body=body)],
        objects={"ball": still, "cup": still},
        scene=scene,
        names=("floor", "wall", "ball", "cup", "person"),
        contacts=Contacts.none(),
        clearance=np.full(FRAMES, np.inf),
        lost_time=np.zeros(FRAMES),
        settings=Settings(contact="parts"),
        diagnostics={"residual": np.zeros(FRAMES)},
    )


def moved(result, translation=None, rotations=None):
    person = result.people[0]
    motion = person.reference.with_frames(
        person.reference.translation + (0.0 if translation is None else translation),
        person.reference.rotations + (0.0 if rotations is None else rotations),
    )
    return dataclasses.replace(result, people=(dataclasses.replace(person, motion=motion),))


def test_nothing_happened(quiet):
    assert quiet.summary().splitlines() == [
        "60 frames at 30 fps (1.97 s), 1 person, 2 statics, 2 objects",
        "person:",
        "  followed exactly: no joint farther than 0 mm from where the motion has it, in any frame",
        "  touched nothing",
        "did not move (less than 1 mm, 1°): ball, cup",
        "no static within 50 mm of the body (rigid parts) at any frame",
        "no time lost",
    ]


def test_contacts_in_newtons(quiet):
    """Impulses of frames 10, 11 and 13; 2 N s in 1/30 s are 60 N. One row has no impulse."""
    contacts = touching(
        [9, 10, 10, 11, 13, 20],
        [FOOT, WRIST, HAND, WRIST, WRIST, FOOT],
        [1, 1, 1, 1, 1, 0],
        [[0, 0, 0], [0, 1.2, 1.6], [0, 0, 4], [0, 0, 1], [0, 0, 9], [0, 0, 0.05]],
    )
    lines = dataclasses.replace(quiet, contacts=contacts).summary().splitlines()
    assert (
        "  touched wall in 3 frames from 10 to 13 (0.33 to 0.43 s) with left_wrist, left_index1; "
        "160 N mean, 270 N peak in frame 13"
    ) in lines
    assert (
        "  touched floor in frame 20 (0.67 s) with left_foot; 1.5 N mean, 1.5 N peak in frame 20"
    ) in lines
    assert not any("touched nothing" in line for line in lines)


def test_a_contact_with_oneself_counts_once(quiet):
    """4 N s in a frame of 1/30 s between two parts, each of which has a row: 120 N."""
    contacts = touching([10, 10], [WRIST, FOOT], [4, 4], [[0, 0, 4], [0, 0, -4]])
    contacts = dataclasses.replace(contacts, other_part=np.array([FOOT, WRIST]))
    lines = dataclasses.replace(quiet, contacts=contacts).summary().splitlines()
    assert (
        "  touched person in frame 10 (0.33 s) with left_wrist, left_foot; 120 N mean, 120 N peak "
        "in frame 10"
    ) in [line.replace("left_foot, left_wrist", "left_wrist, left_foot") for line in lines]


def test_how_exactly_it_was_followed(quiet, body):
    contacts = touching([20], [WRIST], [1], [[0.0, 0.0, 1.0]])
    shift = np.zeros((FRAMES, 3))
    shift[20:, 1] = 0.25
    turn = np.zeros((FRAMES, 55, 3))
    turn[20:23, JOINT_INDEX["left_shoulder"], 1] = 0.5
    result = moved(dataclasses.replace(quiet, contacts=contacts), shift, turn)
    local, everywhere = result.people[0].joint_errors()
    text = result.summary()
    # Free: frames 0 to 19, and 36 to 59, 15 frames after the contact and later.
    said = re.search(
        r"free of contact \(for 0.5 s\) in 44 of 60 frames: (.*) there, no joint", text
    )
    assert said
    assert said[1] == "motion followed exactly"  # the root's offset has its own line
    assert f"MPJPE {1000 * local.mean():.3g} mm, MPJPE-g {1000 * everywhere.mean():.3g} mm" in text
    frame, joint = np.unravel_index(everywhere.argmax(), everywhere.shape)
    assert 20 <= frame < 23
    assert re.search(rf"largest left_\w+ {1000 * everywhere[frame, joint]:.3g} mm in frame 2", text)
    assert (
        "root off its path by 250 mm at most, in frame 20 (0.67 s), and 250 mm at the end" in text
    )
    # An untouched deviation of a millimetre is not "exactly".
    shift[50:, 0] = 0.0
    turn[50, JOINT_INDEX["left_shoulder"], 1] = 0.01
    bent = moved(dataclasses.replace(quiet, contacts=contacts), shift, turn)
    worst = bent.people[0].joint_errors()[0][50].max()
    assert 0.001 < worst < 0.01
    assert (
        f"motion not followed exactly there, no joint off by more than {1000 * worst:.3g} mm"
        in (bent.summary())
    )
    always = touching(range(FRAMES), [WRIST] * FRAMES, [1] * FRAMES, [[0, 0, 1.0]] * FRAMES)
    assert "  never free of contact\n" in dataclasses.replace(bent, contacts=always).summary()


def test_objects_that_moved(quiet):
    """The ball moves 3 m and back 1 m at up to 6 m/s, the cup turns in place."""
    position = np.tile([5.0, 0.0, 0.0], (FRAMES, 1))
    position[10:25, 0] += 0.2 * np.arange(1, 16)
    position[25:, 0] += 3.0
    position[40:50, 0] -= 0.1 * np.arange(1, 11)
    position[50:, 0] -= 1.0
    angle = np.linspace(0.0, np.pi / 2, FRAMES)
    turned = np.stack([np.cos(angle / 2), 0 * angle, 0 * angle, np.sin(angle / 2)], axis=1)
    lines = (
        dataclasses.replace(
            quiet,
            objects={
                "ball": ObjectTrack(position=position, quaternion=EYE),
                "cup": ObjectTrack(position=quiet.objects["cup"].position, quaternion=turned),
            },
        )
        .summary()
        .splitlines()
    )
    at = next(i for i, line in enumerate(lines) if line.startswith("ball"))
    ball = lines[at]
    assert ball.startswith("ball: moved 2.00 m from start to end (4.00 m of path), turned 0°; ")
    assert re.search(r"fastest 6\.00 m/s before frame \d+", ball)
    assert lines[at + 1].startswith("cup: moved 0 mm from start to end (0 mm of path), turned 90°")
    assert not any("did not move" in line for line in lines)


def inside_of(depths):
    """Rows of (part, object, static): depths from frame 0 on."""
    rows = [
        (t, -1 if part < 0 else 0, part, subject, other, depth)
        for (part, subject, other), values in depths.items()
        for t, depth in values.items()
    ]
    names = ("frame", "person", "part", "subject", "other", "depth")
    return Inside(**{n: list(c) for n, c in zip(names, zip(*rows, strict=True), strict=True)})


def test_what_was_inside(quiet):
    """A foot that is out by frame 3, a wrist that stays, a cup; an overlap that began later."""
    depths = {
        (FOOT, -1, 0): {0: 0.034, 1: 0.02, 2: 0.01},
        (WRIST, -1, 1): dict.fromkeys(range(FRAMES), 0.05),
        (HAND, -1, 1): {0: 0.004},
        (JOINT_INDEX["jaw"], -1, 1): {0: 0.002, 1: 0.001},
        (JOINT_INDEX["head"], -1, 1): {30: 0.001},
        (-1, 3, 0): {0: 0.0},
    }
    lines = dataclasses.replace(quiet, inside=inside_of(depths)).summary().splitlines()
    assert (
        "  initial overlaps: left_wrist 50 mm inside wall, still 50 mm at the end; left_foot 34 mm "
        "inside floor, out by frame 3 (0.10 s); left_index1 4.0 mm inside wall, out by frame 1 "
        "(0.03 s) and 1 more"
    ) in lines
    assert "  1 of these 4 still inside at the end" in lines
    assert "  later overlaps: head 1.0 mm inside wall, out by frame 31 (1.03 s)" in lines
    assert (
        "initial overlaps: cup inside floor (no way out found), out by frame 1 (0.03 s)"
    ) in lines
    depths[WRIST, -1, 1] = {0: 0.05, 1: 0.04, 2: 0.03, 3: 0.02, 4: 0.01}
    text = dataclasses.replace(quiet, inside=inside_of(depths)).summary()
    assert "left_wrist 50 mm inside wall, out by frame 5 (0.17 s)" in text
    assert "  all 4 out by frame 5 (0.17 s)\n" in text


@pytest.mark.parametrize("gap", [0.004, -0.006])
def test_the_nearest_part_and_thing(quiet, body, gap):
    """The foremost vertex of the skin is a corner of its part: it has the part's distance."""
    vertices = body.vertices(quiet.motion[0])
    foremost = vertices[:, 0].argmax()
    name = JOINT_NAMES[body.weights[foremost].argmax()]
    shift = np.zeros((FRAMES, 3))
    shift[40, 0] = 0.5 - vertices[foremost, 0] - gap
    clearance = np.full(FRAMES, np.inf)
    clearance[40] = gap
    text = dataclasses.replace(moved(quiet, shift), clearance=clearance).summary()
    assert (
        f"minimum distance to static geometry (rigid parts): {name} 4 mm from wall, in frame 40 "
        "(1.33 s); clearance set to 1 mm\n"
        if gap > 0.0
        else f"deepest in static geometry (rigid parts): {name} 6 mm in wall, in frame 40 "
        "(1.33 s)\n"
    ) in text
    assert moved(quiet, shift).parts().clearance.min() == pytest.approx(gap, abs=1e-9)


def test_the_smallest_distance_is_that_of_frames_with_nobody_inside(quiet):
    """A start inside does not hide the minimum distance of the later frames."""
    clearance = np.full(FRAMES, np.inf)
    clearance[:6] = -0.03, -0.01, 0.0002, 0.009, 0.004, 0.02
    inside = inside_of({(FOOT, -1, 0): {0: 0.03, 1: 0.01, 2: 0.001}})
    text = dataclasses.replace(quiet, clearance=clearance, inside=inside).summary()
    assert (
        "deepest in static geometry (rigid parts): 30 mm in something, in frame 0 (0.00 s)\n"
        in text
    )
    assert (
        "minimum distance to static geometry (rigid parts, nobody inside: 57 frames): 4 mm from "
        "something, in frame 4 (0.13 s); clearance set to 1 mm\n"
    ) in text
    clearance[:] = -0.03
    text = dataclasses.replace(quiet, clearance=clearance, inside=inside).summary()
    assert "minimum distance" not in text


def test_lost_time_and_the_solver(quiet):
    lost, residual = np.zeros(FRAMES), np.zeros(FRAMES)
    lost[[3, 30]] = 0.001, 0.0113
    residual[12] = 2e-5
    result = dataclasses.replace(quiet, lost_time=lost, diagnostics={"residual": residual})
    assert result.summary().splitlines()[-1] == (
        "lost 0.012 s where steps were blocked, in 2 frames, most in frame 30 (1.00 s); "
        "largest solver residual 0.02 mm, in frame 12 (0.40 s)"
    )
    assert dataclasses.replace(quiet, diagnostics={}).summary().endswith("no time lost")
    missed, tolerances = np.zeros(FRAMES), np.zeros(FRAMES)
    missed[[7, 12]], tolerances[[7, 12]] = (0.001, 0.5), (4.9, 2000.0)
    friction = {"friction_residual": missed, "friction_tolerances": tolerances}
    assert (
        dataclasses.replace(quiet, diagnostics=friction)
        .summary()
        .endswith(
            "no time lost; largest friction residual 0.5 m/s, in frame 12 (0.40 s), "
            "over 5 tolerances of the solver in 1 frame"
        )
    )


def test_what_a_file_does_not_know_any_more_is_said(tmp_path, quiet):
    """A body without a file, a missing mesh: the rest is reported all the same."""
    (tmp_path / "rock.obj").write_text(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    )
    quiet.scene.add_static("rock", tmp_path / "rock.obj")
    person = quiet.people[0]
    made = dataclasses.replace(person.body, model="smplx", source=None)
    clearance = np.full(FRAMES, np.inf)
    clearance[7] = 0.0031
    dataclasses.replace(
        quiet,
        people=(dataclasses.replace(person, body=made),),
        names=("floor", "wall", "rock", "ball", "cup", "person"),
        clearance=clearance,
    ).save(tmp_path / "r.npz")
    (tmp_path / "rock.obj").unlink()
    text = Result.load(tmp_path / "r.npz").summary()  # and no warning
    assert "joints not compared with the reference: " in text
    assert "body came from no file" in text
    assert "root off its path by 0 mm at most" in text
    assert "3.1 mm from something, in frame 7 (0.23 s); clearance set to 1 mm" in text


def test_two_people_are_told_apart(body):
    scene = Scene()
    scene.add_static("floor", Plane(offset=-3.0))
    pair = [along_x(1.0, 30, start=-0.6), along_x(-1.0, 30, start=0.6)]
    result = simulate(pair, scene, body=[body, body])
    text = result.summary()
    first, second = text.split("person1:")
    assert "person0:" in first
    assert "touched person1 in" in first
    assert "touched person0 in" in second


def test_the_demo_story_fits_a_screen():
    story = scenarios.load("doorway")
    result = simulate(story.motion, story.scene, body=story.body, settings=story.settings)
    lines = result.summary().splitlines()
    assert 10 <= len(lines) <= 20
    assert max(map(len, lines)) <= 180
    text = "\n".join(lines)
    assert "motion followed exactly there" in text
    assert re.search(r"ball: moved \d+\.\d+ m .* fastest 5\.\d+ m/s", text)
    assert "minimum distance to static geometry" in text
