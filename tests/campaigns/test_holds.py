"""A sample of `campaigns.holds`: recordings are right, figures measure what they say."""

from __future__ import annotations

import json
import sys
import warnings
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import halfphysics as hp
from campaigns.holds import MIXED, campaign, layouts, main, run
from halfphysics.base import rotations as rot
from halfphysics.errors import HalfPhysicsWarning
from halfphysics.motion.skeleton import PARENTS
from support.carries.acting import hand_joints, parts_of
from support.carries.cases import all_cases
from support.carries.figures import (
    Carry,
    angle_deg,
    carry_figures,
    carry_of,
    change_figures,
    untouched,
)
from support.carries.files import LAYOUTS
from support.carries.files.omomo import ASIDE, SCALE, omomo_clip, write_omomo
from support.carries.files.written import at_rate
from support.carries.limits import LIMITS, comparison, failed, held, summary, table
from support.carries.loaded import MEMORY, loaded
from support.carries.people import offsets_of, person
from support.carries.recordings import (
    CLEAR,
    NOISE,
    Case,
    is_hand,
    recording,
    stand_distance,
    surface_points,
)
from support.carries.things import MOST, REST, THINGS

#: A palm touches: nearer than this [m].
TOUCHES = 1e-3
EXACT = 1e-9
PLAIN = (Case("glass"), Case("bowl", "back", "air", stature=1.62))


@pytest.fixture(scope="module", params=PLAIN, ids=lambda case: case.thing)
def made(request):
    return recording(request.param)


def hands_of(made, side):
    return [n for n in set(parts_of(made.body)) if is_hand(n) and n.startswith(side)]


def test_palms_touch_the_thing_while_it_is_held(made):
    frames = np.arange(made.hold[0], made.hold[1] + 1, 3)
    for side in made.thing.grasps:
        nearest = made.distances(hands_of(made, side), frames).min(axis=1)
        assert np.abs(nearest).max() < TOUCHES
    # The thing moves exactly with each wrist.
    places, turns = made.body.joint_frames(made.motion)
    for side in made.thing.grasps:
        wrist = 20 if side == "left" else 21
        first, last = made.hold
        away = made.track.position - places[:, wrist]
        local = rot.rotate(rot.conjugate(turns[:, wrist]), away)[first : last + 1]
        assert np.ptp(local, axis=0).max() < EXACT


def test_the_thing_rests_on_what_it_stands_on(made):
    low = surface_points(made)[..., 2].min(axis=1)
    top = max((2.0 * at[2] for _, at, _ in made.stands.values()), default=0.0)
    first, last = made.hold
    rests = [slice(0, first)] + ([slice(last, None)] if made.case.ends == "down" else [])
    for rest in rests:
        assert np.abs(low[rest] - top - REST).max() < EXACT
    assert np.ptp(made.track.position[:first], axis=0).max() == 0.0
    for stand in made.stands.values():
        assert stand_distance(stand, surface_points(made)).min() > 0.5 * REST
    assert np.ptp(low) >= 0.14


def test_the_body_is_clear_and_stands_on_the_floor(made):
    own = [n for n in set(parts_of(made.body)) if not is_hand(n) and not n.endswith("_elbow")]
    frames = np.arange(0, len(made.motion), 5)
    assert made.distances(own, frames).min() > 0.5 * CLEAR
    assert made.distances(list(set(parts_of(made.body))), [0]).min() > CLEAR
    low = made.body.vertices(made.motion, frames=frames)[..., 2].min(axis=1)
    assert low.min() > -1e-3
    assert low.max() < 0.03
    joints = made.body.joints(made.motion)
    speed = np.linalg.norm(np.diff(joints, axis=0), axis=-1) * made.motion.fps
    assert speed.max() < 4.0


def test_a_seed_gives_the_same_recording():
    case = Case("mug", "turn", "air", "gap", seed=3)
    first, again, other = recording(case), recording(case), recording(replace(case, seed=4))
    assert np.array_equal(first.motion.rotations, again.motion.rotations)
    assert np.array_equal(first.track.position, again.track.position)
    assert not np.array_equal(first.track.position, other.track.position)


@pytest.mark.parametrize("noise", ["gap", "aside", "inside"])
def test_noise_shifts_the_thing_against_the_hand(noise):
    exact = recording(Case("mug", "turn", "down"))
    off = recording(Case("mug", "turn", "down", noise, fingers=False))

    def palm(made):
        at = made.body.joints(made.motion)[:, 21:22]
        frames = np.arange(len(at))
        return made.in_thing(at, frames)[made.hold[0] : made.hold[1] + 1, 0]

    shift = palm(off) - palm(exact)
    size = np.linalg.norm(shift, axis=1)
    low, high = NOISE[1]
    assert size.min() > low - EXACT
    assert size.max() < high + EXACT
    assert np.ptp(size) > 1e-3
    if noise != "aside":
        outward = -np.asarray(THINGS["mug"].grasps["right"].facing)
        assert (np.sign(shift @ outward) == (1.0 if noise == "gap" else -1.0)).all()
    assert not off.motion.rotations[:, hand_joints("right")].any()
    rest = off.track.position[: off.hold[0]]
    assert np.ptp(rest, axis=0).max() == 0.0
    gap = off.distances(hands_of(off, "right"), [0]).min()
    assert gap > CLEAR


def test_cases_are_many_and_differ():
    cases = all_cases()
    assert len(cases) >= 40
    assert len({case.id for case in cases}) == len(cases)
    assert {case.thing for case in cases} == set(THINGS)
    for thing in THINGS.values():
        assert 0.0 < thing.mass <= MOST[len(thing.grasps)]
        own = [case for case in cases if case.thing == thing.name]
        assert {case.fingers for case in own} == {True, False}
        assert len({case.noise for case in own}) >= 3


def test_people_have_the_size_asked_for():
    for case in all_cases():
        body = person(case.stature, case.arms)
        assert 1.55 <= case.stature <= 1.95
        assert 0.9 <= case.arms <= 1.1
        length = np.linalg.norm(offsets_of(body)[[18, 19, 20, 21]], axis=1)
        assert length.min() > 0.18
        assert length.max() < 0.36


def test_a_bare_recording_does_not_carry(tmp_path):
    cases = [Case("glass", "turn", "air", "gap", fingers=False)]
    log = tmp_path / "rows.jsonl"
    (row,) = campaign(cases, log)
    assert campaign(cases, log, seconds=-1.0) == [row]
    assert json.loads(json.dumps(row)) == row
    assert {limit.figure for limit in LIMITS} <= set(row)
    assert not row["held"]
    assert row["breaches"] == 0
    assert row["hands_mm"] == row["elsewhere_mm"] == 0.0
    assert row["untouched_equal"]
    assert row["id"] in table([row])
    assert "held" in summary([row])
    assert comparison([row], [row]).splitlines()[0].startswith("1 cases")


def test_bare_is_as_recorded():
    made = recording(Case("glass"))
    its = loaded(made, MEMORY, "bare")
    assert its.motion is its.recorded is made.motion
    assert its.size_mm == 0.0
    sequence = its.sequence
    assert sequence.recorded["glass"] is made.track
    assert np.array_equal(sequence.scene.objects["glass"].position, made.track.position[0])


def test_adapted_is_what_adapt_makes_of_the_recording(monkeypatch):
    """`adapt` is given the motion, the scene, the body and the tracks, and its motion is used."""
    made, given = recording(Case("glass")), []
    other = made.motion.with_frames(made.motion.translation + 0.001, made.motion.rotations)

    def adapt(*arguments):
        given.extend(arguments)
        return SimpleNamespace(motion=other)

    monkeypatch.setitem(sys.modules, "halfphysics.adaptation.adapt", SimpleNamespace(adapt=adapt))
    assert loaded(made, MEMORY, "adapted").motion is other
    motion, scene, body, recorded = given
    assert (motion, body) == (made.motion, made.body)
    assert list(scene.objects) == list(recorded) == ["glass"]


#: Joints may be so far from the recorded ones where a layout tells no size in metres [m].
NO_SIZE = 5e-3
#: Layouts that hold the fingers exactly, and those whose hands bend with the joints' positions.
FINGERS = ("intermimic", "grab", "arctic", "behave")


@pytest.mark.filterwarnings("ignore::halfphysics.errors.HalfPhysicsWarning")
@pytest.mark.parametrize("layout", LAYOUTS)
def test_files_of_every_layout_hold_the_same_recording(layout):
    """Poses of the thing and the person's joints are read with nothing else known."""
    made = recording(Case("mug", "back", "air", "gap", stature=1.62, arms=0.95))
    its = loaded(made, layout, "bare")  # raises where the thing is not where it was recorded
    fps = LAYOUTS[layout][1]
    assert its.recorded.fps == fps
    slow = at_rate(made, fps)
    assert len(its.motion) == len(slow.motion) == len(its.made.track)
    away = its.body.joints(its.motion) - slow.body.joints(slow.motion)
    assert np.abs(away[:, :22]).max() < (NO_SIZE if layout == "behave" else 1e-3)
    assert its.size_mm < 1000.0 * NO_SIZE
    fingers = its.motion.rotations[:, 25:] - slow.motion.rotations[:, 25:]
    if layout in FINGERS:
        assert np.abs(fingers).max() < 1e-5
    else:
        assert its.motion.rotations[:, 25:].any() == (layout == "core4d")
    if layout == "core4d":
        assert len(its.sequence.motions) == len(its.sequence.body) == 2
        assert np.abs(away[:, 25:]).max() < 1e-3
    stands = {"grab": {"table", "ground"}}.get(layout, {"ground", *made.stands})
    assert set(its.sequence.scene.statics) == stands


def test_a_recording_at_another_rate():
    made = recording(Case("mug", "turn", "down"))
    for fps in (15.0, 120.0):
        other = at_rate(made, fps)
        first, last = other.hold
        assert abs(first / fps - made.hold[0] / 30.0) <= 1.0 / min(fps, 30.0)
        assert first / fps >= made.hold[0] / 30.0 - 1e-9
        assert last / fps <= made.hold[1] / 30.0 + 1e-9
        step = 4 if fps == 120.0 else 1
        old = made.track.position[:: 1 if fps == 120.0 else 2]
        new = other.track.position[::step]
        count = min(len(old), len(new))
        assert count >= len(old) - 1
        assert np.abs(old[:count] - new[:count]).max() < EXACT
        turned = angle_deg(other.track.quaternion[::step][:count], rot.exp(np.zeros(3)))
        asked = angle_deg(
            made.track.quaternion[:: 1 if fps == 120.0 else 2][:count], rot.exp(np.zeros(3))
        )
        assert np.abs(turned - asked).max() < 1e-6


def test_layouts_in_turn():
    cases = all_cases()
    assert set(layouts(cases).values()) == set(LAYOUTS)
    assert set(layouts(cases, "grab").values()) == {"grab"}
    mixed = layouts(cases, MIXED)
    for thing in THINGS:
        own = [mixed[case.id] for case in cases if case.thing == thing]
        assert len(set(own)) == len(own)


def test_rows_of_layouts_are_kept_apart(tmp_path):
    cases = [Case("glass", "turn", "air", "none")]
    log = tmp_path / "rows.jsonl"
    (memory,) = campaign(cases, log)
    (row,) = campaign(cases, log, layout=layouts(cases, "behave"))
    assert (memory["layout"], row["layout"]) == (MEMORY, "behave")
    assert len(log.read_text().splitlines()) == 2
    assert campaign(cases, log, seconds=-1.0) == [memory]
    heads = summary([memory, row]).splitlines()[0].split()
    assert heads[-2:] == ["behave", "memory"]


def test_every_case_in_each_layout(tmp_path, monkeypatch, capsys):
    log = tmp_path / "rows.jsonl"
    words = ["holds", "--layout", "each", "--only", "mug-turn-air", "--log", str(log)]
    monkeypatch.setattr(sys, "argv", words)
    main()
    rows = [json.loads(line) for line in log.read_text().splitlines()]
    assert [row["layout"] for row in rows] == [MEMORY, *LAYOUTS]
    assert len({row["id"] for row in rows}) == 1
    assert "size mm <= 5" in capsys.readouterr().out


@pytest.mark.parametrize("layout", ["grab", "core4d"])
def test_a_file_of_another_rate_is_carried(layout):
    """Frames of 120 and of 15 a second, a table of its own, a second person who stands aside."""
    row = run(Case("largebox", "back", "air", "none", stature=1.7), "adapted", layout)
    assert row["lifted"]
    assert row["breaches"] == 0
    assert row["size_mm"] < 1.0


def read(path, **options):
    """The sequence of a file, and what was said as it was read."""
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always", HalfPhysicsWarning)
        sequence = hp.load_sequence(path, **options)
    return sequence, "\n".join(str(each.message) for each in found)


def test_omomo_files_hold_the_same_recording(tmp_path):
    exact = [recording(Case("mug", "back", "air")), recording(Case("bowl", "back", "air"))]
    path = write_omomo(exact, tmp_path)
    for number, made in enumerate(exact):
        name = made.case.thing
        clip = f"sub1_{name}_{number:03}"
        sequence, said = read(path, clip=clip, adapt=False)
        assert "nothing says what" in said
        motion, track = sequence.motion, sequence.recorded[name]
        assert np.abs(motion.translation - made.motion.translation).max() < EXACT
        assert np.abs(motion.rotations[:, :22] - made.motion.rotations[:, :22]).max() < EXACT
        assert not motion.rotations[:, 22:].any()
        vertices = sequence.scene.objects[name].mesh()[0] - SCALE * ASIDE
        assert np.abs(vertices.min(axis=0) - made.thing.mesh.bounds[0]).max() < 1e-6
        assert np.abs(vertices.max(axis=0) - made.thing.mesh.bounds[1]).max() < 1e-6
        assert angle_deg(track.quaternion, made.track.quaternion).max() < 1e-5
        # The data set's mesh is not centred: its middle is where the recording has it.
        middle = track.position + rot.rotate(track.quaternion, SCALE * ASIDE)
        assert np.abs(middle - made.track.position).max() < EXACT
        # Its bones are those of the recorded person: the same wrists follow from them.
        fields = omomo_clip(made)
        joints = np.asarray(made.body.rest_joints)
        rest = fields["rest_offsets"]
        for joint in range(1, 22):
            assert np.allclose(rest[joint], joints[joint] - joints[PARENTS[joint]])
        root = made.motion.translation - fields["trans2joint"]
        assert np.abs(root - made.body.joints(made.motion)[:, 0]).max() < EXACT


def test_a_file_of_omomo_is_carried(tmp_path):
    """One call reads it, with the person's bones and hands that hold; the thing is lifted."""
    made = recording(Case("smalltable", "walk", "air", noise="gap", fingers=False))
    path = write_omomo([made], tmp_path)
    sequence, said = read(path)
    assert "adapted to what is held: smalltable" in said
    result = hp.simulate(sequence.motion, sequence.scene, body=sequence.body)
    heights = [track.position[:, 2] for track in (result.objects["smalltable"], made.track)]
    got, recorded = (float(height.max() - height[0]) for height in heights)
    assert got > 0.9 * recorded
    assert np.array_equal(result.recorded.translation, sequence.motion.translation)
    assert not np.array_equal(result.recorded.rotations, sequence.motion.rotations)
    for hand in result.holds:
        assert (hand.object, hand.asked > 20.0, hand.touched > 0.5) == ("smalltable", True, True)
        assert hand.rise == pytest.approx(got, abs=0.01)


FPS = 10.0


def by_hand(**changes):
    """Two hands lift a thing by 0.5 m in frames 10 to 30, pressing with 20 N each."""
    frames = np.arange(41)
    position = np.zeros((41, 3))
    position[:, 2] = 0.5 * np.clip((frames - 10) / 10.0, 0.0, 1.0)
    still = np.tile([1.0, 0.0, 0.0, 0.0], (41, 1))
    hands = position[:, None] + np.array([[0.0, 0.2, 0.0], [0.0, -0.2, 0.0]])
    touched = np.repeat(np.arange(10, 31), 2)
    hand = np.tile([0, 1], 21)
    normal = np.where(hand[:, None] == 0, [[0.0, 1.0, 0.0]], [[0.0, -1.0, 0.0]])
    columns = {
        "fps": FPS, "hold": (10, 30), "position": position, "quaternion": still,
        "recorded_position": position, "recorded_quaternion": still, "hand": hand,
        "frame": touched, "normal": normal, "impulse": 2.0 * normal + [0.0, 0.0, -1.0],
        "hand_position": hands, "hand_quaternion": np.tile(still[:, None], (1, 2, 1)),
    }  # fmt: skip
    return Carry(**columns | changes)


def test_figures_of_a_perfect_carry():
    row = carry_figures(by_hand())
    assert row["lifted"]
    assert (row["carried"], row["carried_share"]) == (True, 1.0)
    assert (row["away_mm"], row["away_deg"], row["end_mm"]) == (0.0, 0.0, 0.0)
    assert row["rise_mm"] == row["recorded_rise_mm"] == pytest.approx(500.0)
    assert row["released_s"] == pytest.approx(0.0)
    assert row["mean_n"] == pytest.approx([20.0, 20.0])
    assert row["peak_n"] == pytest.approx(20.0)
    assert row["opposition"] == pytest.approx(1.0)
    assert row["slip_mm"] == pytest.approx(0.0, abs=1e-9)
    assert row["early_mm"] == row["pushed_mm"] == 0.0
    assert failed(row) == []
    assert held(row)


def test_places_are_those_of_the_middle_of_the_thing():
    """Whatever the frame of its mesh is."""
    middle, turn = np.array([0.3, -0.2, 0.1]), rot.exp([0.0, 0.0, np.pi / 2])
    thing = SimpleNamespace(position=np.zeros((3, 3)), quaternion=np.tile(turn, (3, 1)))
    made = recording(Case("glass"))
    rows = SimpleNamespace(part=np.zeros(0, int), person=np.zeros(0, int), other=np.zeros(0, int))
    for name in ("frame", "normal", "impulse"):
        setattr(rows, name, np.zeros((0, 3)))
    person = SimpleNamespace(body=made.body, motion=made.motion)
    result = SimpleNamespace(
        people=[person], contacts=rows, names=("glass",), objects={"glass": thing}, fps=30.0
    )
    found = carry_of(result, made, middle).position
    assert np.abs(found - [0.2, 0.3, 0.1]).max() < EXACT
    assert np.abs(carry_of(result, made).position).max() == 0.0


def test_figures_of_a_thing_that_stays():
    plain = by_hand()
    none = {"hand": plain.hand[:0], "frame": plain.frame[:0]}
    none |= {"normal": plain.normal[:0], "impulse": plain.impulse[:0]}
    row = carry_figures(by_hand(position=np.zeros((41, 3)), **none))
    assert not row["lifted"]
    # Of the tenths of the hold, at frames 12, 14, ...: 0.1 m at the first.
    assert row["carried_share"] == pytest.approx(0.1)
    assert row["away_mm"] == pytest.approx(500.0)
    assert row["released_s"] is None
    assert row["opposition"] is None
    assert row["slip_mm"] is None
    assert row["peak_n"] == 0.0
    assert not held(row)


def test_figures_of_a_thing_that_is_dropped_slips_and_turns():
    plain = by_hand()
    early = plain.frame <= 20
    dropped = {name: getattr(plain, name)[early] for name in ("hand", "frame", "normal", "impulse")}
    row = carry_figures(by_hand(**dropped))
    assert row["released_s"] == pytest.approx(-1.0)
    # A touch after the drop does not count, one lost frame is no release.
    again = dict(dropped, frame=np.where(dropped["frame"] == 20, 30, dropped["frame"]))
    assert carry_figures(by_hand(**again))["released_s"] == pytest.approx(-1.1)
    gap = plain.frame != 20
    kept = {name: getattr(plain, name)[gap] for name in ("hand", "frame", "normal", "impulse")}
    assert carry_figures(by_hand(**kept))["released_s"] == pytest.approx(0.0)
    # It sinks by 30 mm in the hands.
    sunk = plain.position.copy()
    sunk[25:, 2] -= 0.03
    assert carry_figures(by_hand(position=sunk))["slip_mm"] == pytest.approx(30.0)
    turned = plain.quaternion.copy()
    turned[29:] = rot.exp([0.0, 0.0, np.radians(20.0)])
    row = carry_figures(by_hand(quaternion=turned))
    assert row["away_deg"] == pytest.approx(20.0)
    assert row["carried_share"] == pytest.approx(0.9)
    # Turned with the hands: it is carried askew, and does not slip.
    both = np.tile(turned[:, None], (1, 2, 1))
    hands = plain.position[:, None] + rot.rotate(both, np.array([[0, 0.2, 0], [0, -0.2, 0]]))
    row = carry_figures(by_hand(quaternion=turned, hand_position=hands, hand_quaternion=both))
    assert row["slip_mm"] == pytest.approx(0.0, abs=1e-9)
    # It moves by 40 mm before the hold: untouched, then pushed.
    moved = plain.position.copy()
    moved[:8, 0] = -0.04
    moved[0, 0] = 0.0
    row = carry_figures(by_hand(position=moved))
    assert row["early_mm"] == row["pushed_mm"] == pytest.approx(40.0)
    pushed = dict(frame=np.r_[1, plain.frame[1:]])
    row = carry_figures(by_hand(position=moved, **pushed))
    assert (row["early_mm"], row["pushed_mm"]) == (0.0, pytest.approx(40.0))


def test_one_hand_alone_does_not_oppose():
    plain = by_hand()
    one = plain.hand == 0
    kept = {name: getattr(plain, name)[one] for name in ("hand", "frame", "normal", "impulse")}
    row = carry_figures(by_hand(**kept))
    assert row["opposition"] == pytest.approx(0.0)
    assert row["mean_n"] == pytest.approx([20.0, 0.0])


def test_the_change_of_a_motion():
    frames = np.arange(60) / 30.0
    recorded = np.zeros((60, 3, 3))
    recorded[..., 0] = (np.sin(3.0 * frames))[:, None]
    changed = recorded.copy()
    changed[20:40, 0, 1] += 0.02
    hand = np.array([True, False, False])
    told = change_figures(recorded, changed, 30.0, (20, 39), hand)
    assert told["hands_mm"] == pytest.approx(20.0)
    assert (told["elsewhere_mm"], told["most_mm"]) == (0.0, pytest.approx(20.0))
    assert told["jerk_ratio"] > 5.0
    assert change_figures(recorded, recorded, 30.0, (20, 39), hand)["jerk_ratio"] == 1.0


def test_untouched_frames_are_exactly_equal():
    made = recording(Case("glass"))
    motion, first = made.motion, made.hold[0]
    for frame, same in ((first - 31, False), (first, True), (first - 30, True)):
        rotations = motion.rotations.copy()
        rotations[frame, 5] += 1e-12
        other = motion.with_frames(motion.translation, rotations)
        assert untouched(motion, other, made.hold) is same
