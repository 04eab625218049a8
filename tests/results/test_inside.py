"""Overlaps: the table, its text, and the report of a run on a start that is not clear."""

from __future__ import annotations

import dataclasses
import pickle
import re
from types import SimpleNamespace

import numpy as np
import pytest

from halfphysics.base.npz import write_npz
from halfphysics.body.body import Body
from halfphysics.errors import HalfPhysicsWarning, InputError
from halfphysics.geometry.shapes import Box, Plane, Sphere
from halfphysics.metrics import penetration
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.results.inside import Breaches, Depths, Inside
from halfphysics.results.result import Result
from halfphysics.scene.scene import Scene
from halfphysics.simulation.core_rows import inside_rows
from halfphysics.simulation.simulate import simulate
from halfphysics.simulation.simulator import Simulator
from support.as_it_is import as_it_is
from support.people import along_x
from support.results.random_result import make_result

FOOT, ANKLE = JOINT_INDEX["left_foot"], JOINT_INDEX["left_ankle"]
#: Allowed excess of the core's depth over the surface's: it starts 0.2 mm outside, and finds
#: the point to 0.1 mm [m].
OUTSIDE = 3e-4


@pytest.fixture(scope="module")
def body():
    return Body.default()


def table(**changes):
    columns = {
        "frame": [0, 0, 1],
        "person": [0, 0, 0],
        "part": [FOOT, ANKLE, FOOT],
        "subject": [-1, -1, -1],
        "other": [0, 0, 0],
        "depth": [0.034, 0.0125, 0.02],
    }
    return Inside(**(columns | changes))


# -- the table -----------------------------------------------------------------------------


def test_rows_and_frames():
    inside = table()
    assert len(inside) == 3
    assert inside.at(1).depth.tolist() == [0.02]
    assert type(inside.at(0)) is Depths
    assert len(Inside.none()) == len(inside.at(7)) == 0
    assert inside[inside.part == FOOT].frame.tolist() == [0, 1]
    with pytest.raises(ValueError, match="read-only"):
        inside.depth[0] = 1.0


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"depth": [0.1, -0.1, 0.1]}, r"inside\.depth: found -0\.1, expected 0 or more"),
        ({"depth": [0.1, np.nan, 0.1]}, r"inside\.depth: 1 values are NaN"),
        ({"depth": [[0.1] * 3]}, r"inside\.depth: found shape \(1, 3\)"),
        ({"part": [1, 2]}, r"inside\.part: found 2 rows and 3 in inside\.person"),
        ({"frame": [0.5, 0.5, 1.0]}, r"inside\.frame: .*expected whole numbers"),
    ],
)
def test_impossible_columns(changes, message):
    with pytest.raises(InputError, match=message):
        table(**changes)


def test_a_result_refuses_rows_beyond_it(body):
    with pytest.raises(InputError, match=r"inside\.frame: found 0 to 9, expected 0 to 4"):
        make_result(body, inside=table(frame=[0, 1, 9]))
    with pytest.raises(InputError, match=r"inside: found .*expected a halfphysics Inside"):
        make_result(body, inside=[1, 2])


def test_several_shapes_of_a_part_are_one_row_and_the_deepest_counts():
    """Statics 0, 1 have the names 1, 2 (after an item without shape); 5 is a person, 4 an object;
    two shapes of the person are inside it.
    """
    world = SimpleNamespace(
        names=("a", "floor", "wall", "b", "box", "person"),
        people=[None],
        shape_name=np.array([5, 5, 5, 4]),
        shape_part=np.array([FOOT, FOOT, ANKLE, -1]),
        static_name=np.array([1, 2]),
    )
    rows = np.array(
        [
            [3, 1, -1, 0.05],
            [0, 0, -1, 0.01],
            [1, 0, -1, 0.03],
            [1, 1, -1, 0.02],
            [2, 0, -1, 0.001],
            [2, 0, -1, 0.0],  # no way out found: it counts as the deepest
            [1, -1, 3, 0.004],
            [0, -1, 3, 0.006],
            [1, 0, -1, 0.015],
        ]
    )
    inside = inside_rows(world, rows, np.array([3, 3, 3, 3, 3, 3, 3, 3, 4]))
    found = {
        (int(f), int(p), int(part), int(s), int(o)): float(d)
        for f, p, part, s, o, d in zip(
            inside.frame,
            inside.person,
            inside.part,
            inside.subject,
            inside.other,
            inside.depth,
            strict=True,
        )
    }
    assert len(found) == len(inside)
    assert found == {
        (3, -1, -1, 4, 2): 0.05,
        (3, 0, FOOT, -1, 1): 0.03,
        (3, 0, FOOT, -1, 2): 0.02,
        (3, 0, FOOT, -1, 4): 0.006,
        (3, 0, ANKLE, -1, 1): 0.0,
        (4, 0, FOOT, -1, 1): 0.015,
    }
    assert (np.diff(inside.frame) >= 0).all()
    assert inside.no_way_out.sum() == 1
    assert len(inside_rows(world, np.zeros((0, 4)), np.zeros(0, dtype=int))) == 0


def test_in_words_deepest_first():
    names = ("floor", "box", "person0", "person1")
    rows = table(
        person=[1, 0, -1], part=[FOOT, ANKLE, -1], subject=[-1, -1, 1], depth=[0.0042, 0.034, 0.0]
    )
    assert rows.described(names, people=2) == [
        "box inside floor (no way out found)",
        "person0's left_ankle 34 mm inside floor",
        "person1's left_foot 4.2 mm inside floor",
    ]
    assert rows[1].described(("floor", "person")) == ["left_ankle 34 mm inside floor"]


def test_files_of_old_have_no_rows(tmp_path, body):
    result = make_result(body, inside=table())
    result.save(tmp_path / "r.npz")
    loaded = Result.load(tmp_path / "r.npz").inside
    for name in Inside.columns():
        np.testing.assert_array_equal(getattr(loaded, name), getattr(result.inside, name))
    with np.load(tmp_path / "r.npz") as file:
        old = {key: file[key] for key in file if not key.startswith("inside/")}
    write_npz(tmp_path / "old.npz", old)
    assert len(Result.load(tmp_path / "old.npz").inside) == 0


# -- from the core -------------------------------------------------------------------------


@pytest.fixture(scope="module")
def sunken(body):
    """T-pose with both feet some 3 cm in a floor, standing still for a second, as it is."""
    scene = Scene()
    scene.add_static("floor", Plane())
    motion = along_x(0.0, 31, start=0.0).grounded(body, -0.034)
    with pytest.warns(HalfPhysicsWarning) as said:
        result = simulate(motion, scene, body=body, settings=as_it_is())
    return scene, motion, result, said


def test_feet_in_a_floor(body, sunken):
    """Feet, their depth (by the skin's own depth), no increase, and out within half a second."""
    scene, motion, result, _ = sunken
    start = result.inside.at(0)
    assert (start.person == 0).all()
    assert (start.other == 0).all()
    feet = {JOINT_INDEX[f"{side}_{name}"] for side in ("left", "right") for name in ("foot",)}
    assert feet <= set(start.part.tolist())
    truth = 1e-3 * penetration(motion[0], body, scene).depth_max_mm
    assert 0.0 <= start.depth.max() - truth <= OUTSIDE
    assert not result.inside.no_way_out.any()
    for part in set(start.part.tolist()):
        rows = result.inside[result.inside.part == part]
        assert (np.diff(rows.frame) == 1).all()
        assert (np.diff(rows.depth) <= 1e-6).all()
        assert rows.frame.max() < 0.5 * result.fps


def test_the_warning_names_parts_and_things(sunken):
    _, _, result, said = sunken
    assert len(said) == 1
    message = str(said[0].message)
    assert said[0].filename == __file__
    deepest = result.inside.at(0).described(result.names)[0]
    assert re.search(rf"start is not clear: {re.escape(deepest)}, .*grounded\(body\)", message)


def test_frames_say_what_the_result_says(body, sunken):
    scene, motion, result, _ = sunken
    simulator = Simulator(scene, body=body, settings=as_it_is(), fps=motion.fps)
    frames = [simulator.reset(motion[0])]
    frames += [simulator.step(motion[t]) for t in range(1, 6)]
    for t, live in enumerate(frames):
        rows = result.inside.at(t)
        for frame in (live, pickle.loads(pickle.dumps(live))):
            for name in Depths.columns():
                np.testing.assert_array_equal(getattr(frame.inside, name), getattr(rows, name))
    assert len(frames[0].inside) > 0


def test_an_object_that_overlaps_is_named(body):
    scene = Scene()
    scene.add_static("floor", Plane(offset=-2.0))
    scene.add_object("box", Box((0.2, 0.2, 0.2)), mass=1.0, position=(2.0, 0.0, -1.92))
    with pytest.warns(HalfPhysicsWarning, match=r"not clear: box 20 mm inside floor\. ") as said:
        result = simulate(along_x(0.0, 31, start=0.0), scene, body=body)
    assert len(said) == 1
    start = result.inside.at(0)
    assert (start.person.tolist(), start.part.tolist()) == ([-1], [-1])
    assert [result.names[i] for i in (*start.subject, *start.other)] == ["box", "floor"]
    assert 0.0 <= start.depth[0] - 0.02 <= OUTSIDE
    assert result.inside.frame.max() < 0.5 * result.fps


def test_a_part_that_starts_in_an_object_is_named(body):
    """A ball about a hand, in a scene without statics: no clearance, but a depth."""
    motion = along_x(0.0, 31, start=0.0)
    hand = body.joints(motion)[0, JOINT_INDEX["left_middle2"]]
    scene = Scene(gravity=(0.0, 0.0, 0.0))
    scene.add_object("ball", Sphere(0.03), mass=0.2, position=hand)
    with pytest.warns(HalfPhysicsWarning, match=r"not clear: left_\w+ .*inside ball") as said:
        result = simulate(motion, scene, body=body)
    assert len(said) == 1
    start = result.inside.at(0)
    assert {result.names[i] for i in start.other} == {"ball"}
    assert JOINT_INDEX["left_middle2"] in start.part
    assert (start.subject == -1).all()
    # Without statics the distance is infinite, at any depth in an object.
    assert np.isinf(result.parts().clearance).all()
    assert re.search(r"initial overlaps: left_\w+ .* inside ball", result.summary())


def test_a_clear_start_says_nothing(body):
    scene = Scene()
    scene.add_static("floor", Plane())
    result = simulate(along_x(0.0, 5, start=0.0).grounded(body, 0.001), scene, body=body)
    assert len(result.inside) == 0


def test_breaches_are_said(body):
    rows = Breaches(**{name: getattr(table(), name) for name in Inside.columns()})
    result = make_result(body, 1, 1, 3, "z", model="smplx")
    assert "let inside" in result.summary()
    said = dataclasses.replace(result, breaches=rows)
    deepest = f"left_foot 34 mm inside {said.names[0]} at frame 0"
    assert deepest in said.summary()
    none = dataclasses.replace(result, breaches=Breaches.none())
    assert "let inside" not in none.summary()
