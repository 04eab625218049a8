"""What became of holds, by sums that are counted by hand."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.geometry.shapes import Box
from halfphysics.motion.adapted_hold import AdaptedHold
from halfphysics.motion.skeleton import JOINT_INDEX, JOINT_NAMES
from halfphysics.results.contacts import Contacts
from halfphysics.results.held import LET_GO, joints_of
from halfphysics.results.result import ObjectTrack, PersonResult, Result
from halfphysics.scene.scene import Scene
from halfphysics.settings import Settings
from support.people import along_x

FRAMES, FPS, FIRST, LAST = 61, 30.0, 20, 40
#: Normal force [N] of the wrist and of each of its fingers' contacts, and friction on each.
PRESS, RUB, FRICTION = 30.0, 4.0, 0.5


def lifted(height: float) -> np.ndarray:
    """A thing that rises by `height` in frames 20 to 40 and stays there (T, 3) [m]."""
    place = np.zeros((FRAMES, 3))
    place[:, 2] = height * np.clip((np.arange(FRAMES) - FIRST) / (LAST - FIRST), 0.0, 1.0)
    return place


def touching(frames) -> Contacts:
    """In each frame left wrist and index finger are pressed along x, and rubbed along z."""
    rows = [(frame, part) for frame in frames for part in ("left_wrist", "left_index2")]
    n = len(rows)
    return Contacts(
        frame=np.array([frame for frame, _ in rows], dtype=np.int64),
        person=np.zeros(n, dtype=np.int64),
        part=np.array([JOINT_INDEX[part] for _, part in rows], dtype=np.int64),
        other=np.zeros(n, dtype=np.int64),
        position=np.zeros((n, 3)),
        normal=np.tile([1.0, 0.0, 0.0], (n, 1)),
        impulse=np.tile([PRESS / FPS, 0.0, RUB / FPS], (n, 1)),
        subject=np.full(n, -1),
        other_part=np.full(n, -1),
    )


def result(contacts, height=0.5, clock=None, **changes) -> Result:
    """A person who is to hold a box with both hands, of which the left one does."""
    motion = along_x(0.0, FRAMES, start=0.0)
    hold = AdaptedHold(
        "box", ("left_wrist", "right_wrist"), FIRST, LAST, 80.0, (0.01, 0.02),
        lifted(0.8), np.tile([1.0, 0.0, 0.0, 0.0], (FRAMES, 1)),
    )  # fmt: skip
    reference = dataclasses.replace(motion, holds=(hold,), recorded=motion)
    angle = np.zeros((FRAMES, 3))
    angle[:, 2] = np.where(np.arange(FRAMES) == 30, 0.2, 0.0)
    scene = Scene()
    scene.add_object("box", Box((0.3, 0.3, 0.3)), mass=1.0)
    scene.friction("person", "box", FRICTION)
    said = {
        "people": [
            PersonResult(
                name="ann", motion=motion, reference=reference, body=Body.default(), clock=clock
            )
        ],
        "objects": {"box": ObjectTrack(position=lifted(height), quaternion=rot.exp(angle))},
        "scene": scene,
        "names": ("box", "ann"),
        "contacts": contacts,
        "clearance": np.full(FRAMES, np.inf),
        "lost_time": np.zeros(FRAMES),
        "settings": Settings(),
    }
    return Result(**said | changes)


def test_forces_friction_and_the_thing():
    left, right = result(touching(range(15, 50))).holds
    assert (left.object, left.person, left.part) == ("box", "ann", "left_wrist")
    assert (left.start, left.end) == pytest.approx((FIRST / FPS, LAST / FPS))
    assert left.asked == right.asked == 80.0
    assert left.reached == pytest.approx(2.0 * PRESS)
    assert left.margin == pytest.approx(FRICTION * PRESS / RUB)
    assert left.touched == 1.0
    assert (right.part, right.reached, right.margin, right.touched) == ("right_wrist", 0, 0, 0)
    for hand in (left, right):
        assert (hand.rise, hand.recorded_rise) == pytest.approx((0.5, 0.8))
        assert hand.away == pytest.approx(0.3)
        assert hand.end_away == pytest.approx(0.3)
        assert hand.turned_deg == pytest.approx(np.rad2deg(0.2))
        assert hand.lost is None


def test_forces_are_the_median_over_the_hold():
    """Before and after nothing counts; half of the hold without touch leaves half of the time."""
    some = result(touching(range(FIRST, FIRST + 5)))
    left = some.holds[0]
    assert left.touched == pytest.approx(5 / 21)
    assert left.reached == 0.0
    assert left.margin == pytest.approx(FRICTION * PRESS / RUB)  # of frames that touch


def test_a_thing_is_lost_when_no_hand_touches_it_any_more():
    last = LAST - round(LET_GO * FPS)
    assert result(touching(range(FIRST, last + 1))).holds[0].lost is None
    for hand in result(touching(range(FIRST, last))).holds:
        assert hand.lost == pytest.approx(last / FPS)
    gap = [*range(FIRST, 25), *range(33, LAST)]  # a pause does not count
    assert result(touching(gap)).holds[0].lost is None
    never = result(Contacts.none()).holds[0]
    assert never.lost == pytest.approx(FIRST / FPS)
    assert (never.reached, never.margin, never.touched) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("after", "late"),
    [
        ([], 0.0),
        ([1], 1 / FPS),
        ([1, 2, 3, 9, 20], 9 / FPS),  # six frames are 0.2 s
        ([1, 8], 1 / FPS),
        ([7], 0.0),
        (range(1, 21), 20 / FPS),
    ],
)
def test_hands_that_touch_on_let_go_late(after, late):
    frames = [*range(FIRST, LAST + 1), *(LAST + k for k in after)]
    for hand in result(touching(frames)).holds:
        assert hand.late == pytest.approx(late)


def test_who_waited_holds_later():
    """The clock stands still for ten frames: all is ten frames later, the record too."""
    frames = np.arange(FRAMES)
    clock = np.where(frames < 10, frames, np.maximum(frames - 10, 10)) / FPS
    late = np.concatenate([np.zeros((10, 3)), lifted(0.8)[:-10]])
    still = np.tile([1.0, 0.0, 0.0, 0.0], (FRAMES, 1))
    track = ObjectTrack(position=late, quaternion=still)
    found = result(touching(range(30, 51)), clock=clock, objects={"box": track}).holds[0]
    assert (found.start, found.end) == pytest.approx((30 / FPS, 50 / FPS))
    assert found.touched == 1.0
    assert found.away == pytest.approx(0.0, abs=1e-12)
    assert found.rise == pytest.approx(found.recorded_rise)


def test_who_waits_for_ever_never_holds_it():
    clock = np.minimum(np.arange(FRAMES), 10) / FPS
    found = result(touching(range(20, 30)), clock=clock).holds[0]
    assert (found.start, found.end) == pytest.approx((FIRST / FPS, LAST / FPS))
    assert (found.touched, found.reached, found.rise, found.away) == (0.0, 0.0, 0.0, 0.0)
    assert found.lost == found.start


def test_nothing_to_hold():
    person = result(Contacts.none()).people[0]
    bare = dataclasses.replace(person, reference=person.reference.bare())
    assert result(Contacts.none(), people=[bare]).holds == ()
    other = Scene()
    other.add_object("ball", Box((0.3, 0.3, 0.3)), mass=1.0)
    track = result(Contacts.none()).objects["box"]
    around = {"scene": other, "names": ("ball", "ann"), "objects": {"ball": track}}
    assert result(Contacts.none(), **around).holds == ()


def test_what_a_part_stands_for():
    def names(part):
        return {JOINT_NAMES[joint] for joint in joints_of(part)}

    fingers = {f"left_{f}{k}" for f in ("index", "middle", "pinky", "ring", "thumb") for k in "123"}
    assert names("left_wrist") == {"left_wrist"} | fingers
    assert names("right_ankle") == {"right_ankle", "right_foot"}
    assert names("pelvis") == {"pelvis", "left_hip", "right_hip"}


def test_measures_compare_with_what_was_recorded():
    """The reference is what is followed; the record is 5 cm away and turned."""
    given = result(Contacts.none())
    person = given.people[0]
    assert given.recorded is person.recorded is person.reference.recorded
    rotations = np.array(person.motion.rotations)
    rotations[:, JOINT_INDEX["left_wrist"]] = [0.3, 0.0, 0.0]
    aside = person.motion.translation + np.array([0.0, 0.05, 0.0])
    aside = person.motion.with_frames(aside, rotations)
    reference = dataclasses.replace(person.reference, recorded=aside)
    changed = dataclasses.replace(given, people=[dataclasses.replace(person, reference=reference)])
    (who,) = changed.people
    assert who.joint_errors(driven=True)[1].max() == 0.0
    assert np.allclose(who.joint_errors()[1][:, 0], 0.05)
    assert np.allclose(changed.parts().rotation[:, JOINT_INDEX["left_wrist"]], 0.3)
    assert np.allclose(changed.parts().displacement[:, 0], 0.05)
    assert who.motion.holds == ()
    assert who.motion.recorded is None
    alone = dataclasses.replace(who, reference=who.reference.bare())
    assert alone.recorded is alone.reference
