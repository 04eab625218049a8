"""Events: holds, slips and drops, against closed forms and on the built-in scenarios."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.errors import InputError
from halfphysics.labels.event_kinds import Limits
from halfphysics.labels.events import events
from halfphysics.motion.skeleton import JOINT_INDEX, JOINT_NAMES
from support.results.handled import WRIST, G, Handled

HIGH = 1.2  # of the box while it is held [m]


def fallen(fps=30.0, height=0.8, hold=1.0, velocity=(0.0, 0.0, 0.0), **options):
    """A box that is held, released in a frame, falls by a height onto the floor and stays there."""
    first = round(hold * fps)
    # It lands between frames, and lies still from the next one on.
    time = np.sqrt(2.0 * height / G) if not velocity[2] else 10.0
    landed = first + int(np.ceil(time * fps))
    count = landed + round(0.5 * fps)
    since = np.maximum(np.arange(count) - first, 0) / fps
    box = np.array([0.0, 0.0, HIGH]) + since[:, None] * velocity
    box[:, 2] -= 0.5 * G * since**2
    box[landed:] = box[landed - 1]
    box[landed:, 2] = HIGH - height
    case = Handled(fps, box, **options)
    case.push(range(1, first + 1), 1.0, 5.0)
    case.rest(range(landed, count))
    return case, first, landed


def slid(fps=30.0, speed=0.12, way=0.06, **options):
    """A box that is held, slides a distance along the palm at a speed, and is held again."""
    time = np.arange(round(3.0 * fps)) / fps
    box = np.tile([0.0, 0.0, HIGH], (len(time), 1))
    box[:, 2] -= speed * np.clip(time - 1.0, 0.0, way / speed)
    case = Handled(fps, box, **options)
    case.push(range(1, len(time)), 1.0, 5.0)
    return case


def test_a_fall_is_a_drop_of_its_height_and_speed():
    case, first, landed = fallen()
    found = events(case.result())
    (drop,) = found.drops
    assert (drop.object, drop.people, drop.parts) == ("box", ("person",), ("right_wrist",))
    assert (drop.released, drop.landed, drop.onto) == (first, landed, "floor")
    assert drop.height == pytest.approx(0.8, abs=1e-12)
    assert drop.speed == pytest.approx(np.sqrt(2.0 * G * 0.8), abs=1e-9)
    (hold,) = found.holds
    assert (hold.first, hold.last, hold.ending) == (0, first, "dropped")
    assert (hold.start, hold.end) == (0.0, pytest.approx(1.0))
    assert found.slips == ()
    assert found.lost == 1


def test_what_falls_until_the_end_has_not_landed():
    case, first, landed = fallen()
    case.box, case.rows = case.box[:landed], [row for row in case.rows if row[0] < landed]
    (drop,) = events(case.result()).drops
    assert (drop.landed, drop.landing, drop.onto) == (None, None, None)
    fell = 0.5 * G * ((landed - 1 - first) / 30.0) ** 2
    assert drop.height == pytest.approx(fell, abs=1e-12)
    assert drop.speed == pytest.approx(np.sqrt(2.0 * G * fell), abs=1e-9)


@pytest.mark.parametrize("velocity", [(0.0, 0.0, 1.0), (2.0, 0.0, 0.0)])
def test_what_is_thrown_is_not_dropped(velocity):
    case, *_ = fallen(velocity=velocity)
    found = events(case.result())
    assert found.drops == ()
    assert [hold.ending for hold in found.holds] == ["thrown"]


def test_what_is_let_go_while_walking_is_dropped():
    """At the person's speed: relative to the person it falls straight down."""
    case, *_ = fallen(velocity=(2.0, 0.0, 0.0))
    since = np.arange(len(case.box)) / case.fps
    case.walk = np.stack([2.0 * since, 0.0 * since, 1.0 + 0.0 * since], axis=1)
    assert [hold.ending for hold in events(case.result()).holds] == ["dropped"]


def test_a_kick_is_neither_a_hold_nor_a_drop():
    case, *_ = fallen()
    kicked = [(f, *rest) for f, *rest in case.rows if (f < 28 and rest[0] < 0) or f in (29, 30)]
    case.rows = kicked
    case.rest(range(1, 29))
    found = events(case.result())
    assert (found.holds, found.drops, found.slips) == ((), (), ())


def test_what_is_set_down_is_placed():
    case, first, _ = fallen(height=0.0)
    case.rest(range(first + 1, len(case.box)), on="table")
    found = events(case.result())
    assert [hold.ending for hold in found.holds] == ["placed"]
    assert found.drops == ()
    assert found.lost == 0


def test_a_small_fall_onto_the_table_is_placing():
    case, *_ = fallen(height=0.03)
    assert [hold.ending for hold in events(case.result()).holds] == ["placed"]


def test_what_is_caught_is_lost_and_not_dropped():
    case, first, _ = fallen()
    caught = first + 8  # 0.27 s later: it has fallen 0.35 m
    case.rows = [row for row in case.rows if row[1] == 0]
    case.box[caught:] = case.box[caught]
    case.push(range(caught + 1, len(case.box)), 1.0, 5.0, part=JOINT_INDEX["left_wrist"])
    found = events(case.result())
    assert [hold.ending for hold in found.holds] == ["lost", "kept"]
    assert [hold.parts for hold in found.holds] == [("right_wrist",), ("left_wrist",)]
    assert found.drops == ()
    assert found.lost == 1


def test_what_is_handed_over_is_one_hold_of_two_people():
    case = slid(speed=0.01, people=2)
    case.rows = [row for row in case.rows if row[0] < 50]
    case.push(range(48, len(case.box)), 1.0, 5.0, person=1, part=JOINT_INDEX["left_wrist"])
    (hold,) = events(case.result()).holds
    assert hold.people == ("person", "person1")
    assert set(hold.parts) == {"left_wrist", "right_wrist"}
    assert hold.ending == "kept"


def test_a_slip_is_that_of_the_person_whose_hands_slide():
    case = slid(people=2)
    case.push(range(1, len(case.box)), 0.5, 2.0, person=1)
    # Both stand still while the box goes down: it slides in the hands of both.
    assert [slip.person for slip in events(case.result()).slips] == ["person", "person1"]


def test_short_gaps_and_bumps_do_not_end_a_hold():
    case = slid(speed=0.01)
    case.rows = [row for row in case.rows if row[0] not in (30, 31, 32)]
    case.rest([50, 51], on="table", up=8.0)
    (hold,) = events(case.result()).holds
    assert (hold.first, hold.last, hold.ending) == (0, len(case.box) - 1, "kept")


def test_what_stands_on_a_table_under_a_hand_is_not_carried():
    case = slid(speed=0.01)
    case.rest(range(len(case.box)), on="table", up=0.5)
    assert events(case.result()).holds == ()


def test_a_faint_touch_carries_nothing():
    case = Handled(30.0, np.tile([0.0, 0.0, HIGH], (60, 1)))
    case.push(range(1, 60), 0.05)
    assert events(case.result()).holds == ()


def test_something_that_brushes_past_does_not_save_it():
    case, first, _ = fallen()
    case.rest([first + 1], on="table", up=0.3)
    (drop,) = events(case.result()).drops
    assert drop.onto == "floor"
    assert drop.released == first + 1
    fell = 0.5 * G / 30.0**2
    assert drop.height == pytest.approx(0.8 - fell, abs=1e-12)


def test_a_slide_is_a_slip_of_its_distance():
    found = events(slid(speed=0.12, way=0.06).result())
    (slip,) = found.slips
    assert (slip.object, slip.person, slip.parts) == ("box", "person", ("right_wrist",))
    assert (slip.first, slip.last) == (31, 45)
    assert (slip.start, slip.end) == (pytest.approx(1.0), pytest.approx(1.5))
    assert slip.distance == pytest.approx(0.06, abs=1e-12)
    assert slip.speed == pytest.approx(0.12, abs=1e-12)
    assert [hold.ending for hold in found.holds] == ["kept"]


@pytest.mark.parametrize(
    "changes", [{"speed": 0.019}, {"way": 0.009}, {"speed": 0.5}], ids=["slow", "short", "brief"]
)
def test_what_is_under_a_limit_is_no_slip(changes):
    """Slower than 0.02 m/s, less than 10 mm, or for less than 0.2 s (0.06 m at 0.5 m/s)."""
    assert events(slid(**changes).result()).slips == ()


def test_limits_are_what_one_gives():
    result = slid(speed=0.5).result()
    (slip,) = events(result, Limits(slide_time=0.1)).slips
    assert slip.distance == pytest.approx(0.06, abs=1e-12)
    assert events(result, Limits(slide_time=0.1, slide=0.061)).slips == ()
    assert events(result, Limits(hold=3.1)).holds == ()


def test_what_moves_along_the_normal_does_not_slide():
    case = slid()
    case.box = case.box[:, [2, 1, 0]] - [HIGH, 0.0, -HIGH]
    assert events(case.result()).slips == ()


def test_what_turns_and_walks_with_the_hand_does_not_slide():
    """Turned by 5 rad and moved by 4 m together with the person."""
    time = np.arange(90) / 30.0
    box = np.stack([time, 0.5 * time**2, HIGH + 0.1 * np.sin(time)], axis=1)
    case = Handled(30.0, box, walk=box + np.array([0.3, 0.2, 0.0]), spin=0.6 * time**2)
    case.push(range(1, 90), 1.0, 5.0, at=(0.1, 0.05, -0.02))
    found = events(case.result(), Limits(slide_speed=1e-9, slide=0.0, slide_time=0.0))
    assert found.slips == ()
    assert len(found.holds) == 1


def test_pushing_along_the_floor_is_no_slip():
    case = slid()
    case.rows = []
    case.push(range(1, len(case.box)), 0.0, 5.0)
    case.rest(range(1, len(case.box)))
    assert events(case.result()).slips == ()


def test_a_slip_is_that_of_the_parts_that_slide_by_their_force():
    """One of two parts, with a third of the force, at the middle of the parts that move with it."""
    case = slid()
    case.push(range(1, len(case.box)), 0.5, 2.5, part=JOINT_INDEX["right_index3"])
    case.push(range(1, len(case.box)), 0.001, 0.01, part=JOINT_INDEX["right_thumb3"])
    (slip,) = events(case.result()).slips
    assert slip.parts == ("right_wrist", "right_index3")  # the thumb bears almost no load
    assert slip.distance == pytest.approx(0.06, abs=1e-12)


FINGERS = [p for p, name in enumerate(JOINT_NAMES) if name.startswith(("left_i", "left_m"))]


@pytest.mark.parametrize(
    ("parts", "limits"),
    [
        ([WRIST, JOINT_INDEX["left_wrist"]], Limits(load=0.6)),
        ([*FINGERS, *(p + 15 for p in FINGERS)], Limits()),
    ],
    ids=["two hands", "twelve parts"],
)
def test_a_grip_of_which_no_part_has_the_share_is_that_of_the_strongest(parts, limits):
    fallen_case, slid_case = fallen()[0], slid()
    for case in (fallen_case, slid_case):
        pushes = [row for row in case.rows if row[1] == 0]
        case.rows = [row for row in case.rows if row[1] != 0]
        for frame, *_ in pushes:
            for part in parts:
                case.push([frame], 1.0 / len(parts), 5.0 / len(parts), part=part)
    found = events(fallen_case.result(), limits)
    (hold,), (drop,) = found.holds, found.drops
    for event in (hold, drop):
        assert event.people == ("person",)
        assert set(event.parts) == {JOINT_NAMES[p] for p in parts}  # all are as strong
    (slip,) = events(slid_case.result(), limits).slips
    assert set(slip.parts) == {JOINT_NAMES[p] for p in parts}
    assert slip.distance == pytest.approx(0.06, abs=1e-12)


def test_nobody_holds_what_nobody_touches():
    """With a limit of nothing too."""
    case, first, _ = fallen()
    (hold,) = events(case.result(), Limits(load=0.0, gap=0.0)).holds
    assert (hold.last, hold.people) == (first, ("person",))


def test_without_gravity_there_is_no_drop():
    case, *_ = fallen(gravity=0.0)
    found = events(case.result())
    assert found.drops == ()
    assert len(found.holds) == 1


ANGLE = st.floats(-np.pi, np.pi)
METRES = st.floats(-50.0, 50.0)


@settings(max_examples=15, deadline=None)
@given(
    turn=ANGLE, shift=st.tuples(METRES, METRES, METRES), fps=st.sampled_from([24.0, 30.0, 59.94])
)
def test_where_in_the_world_does_not_matter(turn, shift, fps):
    for case in (fallen(fps)[0], slid(fps)):
        here, there = (events(case.result(*at)) for at in ((), (turn, shift)))
        assert [s[:1] for s in _shown(here)] == [s[:1] for s in _shown(there)]
        for a, b in zip(_shown(here), _shown(there), strict=True):
            np.testing.assert_allclose(a[1], b[1], rtol=0.0, atol=1e-9)


def _shown(found):
    """Names and integers of every event, and its lengths and speeds."""
    every = (*found.holds, *found.slips, *found.drops)
    rows = []
    for event in every:
        values = vars(event)
        lengths = {k for k in values if k in ("distance", "speed", "height")}
        rows.append(
            ({k: v for k, v in values.items() if k not in lengths}, [values[k] for k in lengths])
        )
    return rows


@settings(max_examples=15, deadline=None)
@given(fps=st.floats(20.0, 480.0), height=st.floats(0.2, 1.1), way=st.floats(0.05, 0.2))
def test_the_frame_rate_does_not_matter(fps, height, way):
    """The frames leave a tolerance: the time of release, and the start of the slide."""
    found = events(fallen(fps, height)[0].result())
    (drop,) = found.drops
    assert drop.height == pytest.approx(height, abs=1e-9)
    assert drop.speed == pytest.approx(np.sqrt(2.0 * G * height), rel=1e-6)
    assert drop.time == pytest.approx(1.0, abs=1.0 / fps)
    assert drop.landing == pytest.approx(1.0 + np.sqrt(2.0 * height / G), abs=2.0 / fps)
    (slip,) = events(slid(fps, 0.12, way).result()).slips
    # The first and the last step may be slower than the sliding threshold.
    assert slip.distance == pytest.approx(way, abs=2 * 0.02 / fps)
    assert slip.start == pytest.approx(1.0, abs=1.001 / fps)
    assert slip.end == pytest.approx(1.0 + way / 0.12, abs=1.001 / fps)


def test_they_are_plain_values_for_a_file():
    case, *_ = fallen()
    found = events(case.result()).document()
    assert json.loads(json.dumps(found, allow_nan=False)) == found
    assert found["drops"][0]["people"] == ["person"]


def test_a_result_from_a_file_has_the_same(tmp_path):
    for case in (fallen()[0], slid()):
        result = case.result()
        result.save(tmp_path / "r.npz")
        assert events(hp.Result.load(tmp_path / "r.npz")) == events(result)


def test_what_is_no_result_and_what_are_no_limits():
    with pytest.raises(InputError, match="result: expected"):
        events(None)
    with pytest.raises(InputError, match="limits: expected"):
        events(slid().result(), {"gap": 0.1})
    with pytest.raises(InputError, match=r"Limits\.gap"):
        Limits(gap=-0.1)


# -- the built-in scenarios ----------------------------------------------------------------


def played(name, **options):
    told = hp.scenarios.load(name, **options)
    return hp.simulate(told.motions, told.scene, body=told.body, settings=told.settings)


def suitcase(**options):
    return events(played("lift_suitcase", carry=1.0, shake=1.0, **options))


def test_a_suitcase_between_two_palms_is_held():
    found = suitcase(mass=5.0, friction=0.8)
    (hold,) = found.holds
    assert hold.ending == "kept"
    assert {"left_wrist", "right_wrist"} <= set(hold.parts)
    assert 1.0 < hold.start < 1.3  # it is lifted from 1 s on
    assert (found.slips, found.drops) == ((), ())


def test_a_smooth_suitcase_slips():
    found = suitcase(friction=0.1)
    (slip,) = found.slips
    assert {"left_wrist", "right_wrist"} <= set(slip.parts)
    assert 0.2 < slip.distance < 0.35  # the palms rise by 0.35 m
    assert (found.holds, found.drops) == ((), ())


def test_a_suitcase_of_200_kg_stays():
    found = suitcase(mass=200.0)
    assert (found.holds, found.drops) == ((), ())
    assert len(found.slips) == 1  # of the palms, along it


def test_a_slip_in_the_shake_is_how_far_the_suitcase_sank_in_the_hands():
    """Friction that holds the box at rest but not when shaken."""
    result = played("lift_suitcase", friction=0.3, carry=1.0, shake=2.0)
    found = events(result)
    assert [hold.ending for hold in found.holds] == ["kept"]
    assert not found.drops
    shaken = [slip for slip in found.slips if slip.start > 5.0]
    positions, turns = result.people[0].body.joint_frames(result.motion)
    first, last = shaken[0].first - 1, shaken[-1].last
    wrist = rot.rotate(
        rot.conjugate(turns[:, WRIST]), result.objects["suitcase"].position - positions[:, WRIST]
    )
    sunk = np.linalg.norm(wrist[last] - wrist[first])
    assert sum(slip.distance for slip in shaken) == pytest.approx(sunk, rel=0.15)


@pytest.mark.slow
def test_a_glass_that_is_let_go_is_dropped():
    """The paper's Figure 5b: the table is removed."""
    found = events(played("place_glass"))
    (drop,) = found.drops
    (hold,) = found.holds
    assert hold.ending == "dropped"
    assert drop.onto == "floor"
    assert found.slips == ()
    assert 0.9 < drop.height < 1.05  # it is held 1.05 m over the floor
    assert drop.landing - drop.time == pytest.approx(np.sqrt(2.0 * drop.height / G), abs=2.0 / 30.0)
    assert drop.speed == pytest.approx(np.sqrt(2.0 * G * drop.height), rel=0.02)


@pytest.mark.slow
def test_a_glass_that_is_set_down_is_placed():
    found = events(played("place_glass", table=True))
    assert [hold.ending for hold in found.holds] == ["placed"]
    assert (found.drops, found.slips) == ((), ())


@pytest.mark.slow
def test_a_grasped_glass_is_held_through_everything_until_the_hand_opens():
    found = events(played("grasp_glass"))
    (hold,) = found.holds
    assert hold.end - hold.start > 12.0
    assert hold.ending == "dropped"
    assert found.slips == ()
    assert len(found.drops) == 1


@pytest.mark.parametrize("options", [{}, {"speed": 12.0}, {"mass": 200.0}, {"fps": 10.0}])
def test_a_kicked_ball_is_not_held(options):
    """Nor does it slip where a frame takes a tenth of a second and two frames show the kick."""
    found = events(played("kick_ball", **options))
    assert (found.holds, found.slips, found.drops) == ((), (), ())
