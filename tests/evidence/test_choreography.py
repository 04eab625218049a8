"""Motions generated from a seed: the same every time, human, and as fast as real dances."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import halfphysics as hp
from evidence.motions import dancer
from evidence.motions.choreography import (
    CLIPS,
    FPS,
    SECONDS,
    STYLES,
    dance,
    style_of,
)
from evidence.motions.daily import KINDS, daily
from evidence.motions.dancer import Score, danced
from halfphysics.base.rotations import rotvec_to_matrix
from halfphysics.formats.speed_check import JOINT_SPEED, ROOT_SPEED
from halfphysics.motion.skeleton import JOINT_INDEX

#: Of the dances and jumps of shared/data/motion (a dance, a dab, jumping, jumping jacks), least and
#: most of each measure of `measured`, rounded outward; the embedded motions lie within them.
REAL = {
    "root": (0.5, 0.7),
    "joints": (0.7, 1.3),
    "joints, 95th percentile": (2.0, 3.9),
    "acceleration": (6.0, 21.0),
    "acceleration, 95th percentile": (21.0, 59.0),
}
REAL_CLIPS = ("jesse_dance", "dab", "jumping", "jumping_jacks")
#: Fastest joint of any embedded clip [m/s]: the wrist of a whirling arm. Real: 8.6.
FASTEST = 13.0
ROUNDING = 1e-9


@pytest.fixture(scope="module")
def body():
    return hp.Body.default()


@pytest.fixture(scope="module")
def dances(body):
    return [dance(number, body=body) for number in range(CLIPS)]


def measured(motion, body):
    """Speeds [m/s] and accelerations [m/s^2] of the root and 22 joints, no fingers or face."""
    joints = body.joints(motion)[:, :22]
    speed = np.linalg.norm(np.diff(joints, axis=0), axis=2) * motion.fps
    change = np.linalg.norm(np.diff(joints, 2, axis=0), axis=2) * motion.fps**2
    return {
        "root": speed[:, 0].mean(),
        "joints": speed.mean(),
        "joints, 95th percentile": np.percentile(speed, 95),
        "acceleration": change.mean(),
        "acceleration, 95th percentile": np.percentile(change, 95),
    }


def content(motion):
    return motion.translation.tobytes() + motion.rotations.tobytes()


def lowest(body, motion):
    """Height of the lowest skin in every frame [m]."""
    parts = [motion[i : i + 60] for i in range(0, len(motion), 60)]
    return np.concatenate([body.vertices(part)[..., 2].min(axis=1) for part in parts])


@pytest.mark.parametrize("make", [dance, daily])
def test_the_same_seed_the_same_bytes_another_seed_another_clip(make, body):
    for number in (0, 7):
        first = content(make(number, seed=3, seconds=2.0, body=body))
        assert content(make(number, seed=3, seconds=2.0)) == first
        assert content(make(number, seed=4, seconds=2.0)) != first
        assert content(make(number + 10, seed=3, seconds=2.0)) != first


@pytest.mark.slow
def test_as_many_frames_as_asked_for_and_a_beginning_is_a_beginning(dances, body):
    assert {len(motion) for motion in dances} == {round(SECONDS * FPS)}
    for number in range(len(STYLES)):
        short = dance(number, seconds=3.0, body=body)
        assert len(short) == 180
        assert np.abs(short.rotations - dances[number].rotations[:180]).max() < ROUNDING
        assert np.abs(short.translation - dances[number].translation[:180]).max() < ROUNDING


def test_all_styles_come_in_turn(dances):
    assert [style_of(number) for number in range(len(STYLES))] == list(STYLES)
    assert len({content(motion) for motion in dances}) == CLIPS


def bend(motion, body, near, middle, far):
    """How far a limb is from straight [rad], by its joint positions."""
    joints = body.joints(motion)
    places = [joints[:, JOINT_INDEX[name]] for name in (near, middle, far)]
    a, b = places[1] - places[0], places[2] - places[1]
    cosine = np.sum(a * b, axis=1) / np.linalg.norm(a, axis=1) / np.linalg.norm(b, axis=1)
    return np.arccos(np.clip(cosine, -1.0, 1.0))


def test_joints_stay_within_human_ranges(dances, body):
    """Tested on the poses themselves, not on the channels that make them."""
    most = {"elbow": 0.0, "knee": 0.0}
    for motion in dances:
        assert np.isfinite(motion.rotations).all()
        for side in ("left", "right"):
            elbow = bend(motion, body, *(f"{side}_{n}" for n in ("shoulder", "elbow", "wrist")))
            knee = bend(motion, body, *(f"{side}_{n}" for n in ("hip", "knee", "ankle")))
            most["elbow"] = max(most["elbow"], elbow.max())
            most["knee"] = max(most["knee"], knee.max())
            # Knees bend about one axis and backward only.
            turn = motion.rotations[:, JOINT_INDEX[f"{side}_knee"]]
            assert np.abs(turn[:, 1:]).max() < ROUNDING
            assert turn[:, 0].min() > 0.0
            ankle = motion.rotations[:, JOINT_INDEX[f"{side}_ankle"], 0]
            assert np.degrees(ankle).min() >= dancer.ANKLE[0]
            assert np.degrees(ankle).max() <= dancer.ANKLE[1]
        spine = sum(
            np.linalg.norm(motion.rotations[:, JOINT_INDEX[f"spine{k}"]], axis=1) for k in (1, 2, 3)
        )
        assert np.degrees(spine).max() < 85.0
        for joint in ("neck", "head"):
            turn = np.linalg.norm(motion.rotations[:, JOINT_INDEX[joint]], axis=1)
            assert np.degrees(turn).max() < 45.0
    # A rest pose already bends them a little: about 10 degrees.
    assert np.degrees(most["elbow"]) < 140.0 + 10.0
    assert np.degrees(most["knee"]) < 125.0 + 2.0 * 12.0 + 10.0
    assert min(most.values()) > np.radians(90.0), "nobody bends anything"


def test_a_channel_ends_at_its_range_and_no_faster_than_it_can():
    score = Score(0.5)
    score.to(0.0, 0.1, left_elbow=400.0)
    score.to(0.05, 0.2, left_elbow=-50.0)  # during another movement: it starts then, not at once
    times = np.arange(4000) / 2000.0
    elbow = score.sampled(times)["left_elbow"]
    low, high = dancer.bounds("left_elbow")
    assert elbow.max() == pytest.approx(high)
    assert elbow[-1] == pytest.approx(low)
    assert elbow.min() >= low - ROUNDING
    rate = np.abs(np.diff(elbow)).max() * 2000.0
    assert 0.9 * dancer.FASTEST_ARM < rate <= dancer.FASTEST_ARM * (1.0 + 1e-6)


def test_as_fast_as_real_dances(dances, body):
    found = [measured(motion, body) for motion in dances]
    for name, (least, most) in REAL.items():
        assert least <= np.mean([one[name] for one in found]) <= most, name


def test_what_real_dances_have(shared_data, body):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", hp.HalfPhysicsWarning)
        real = [
            measured(hp.Motion.load(shared_data / f"motion/animdraw_{name}.bvh"), body)
            for name in REAL_CLIPS
        ]
    for name, (least, most) in REAL.items():
        values = [one[name] for one in real]
        assert least <= min(values) < max(values) <= most, name
        assert min(values) < 1.1 * least, name
        assert max(values) > 0.9 * most, name


def test_nothing_is_faster_than_people_are(dances, body):
    for motion in [*dances, *(daily(number, body=body) for number in range(len(KINDS)))]:
        joints = body.joints(motion)[:, :22]
        speed = np.linalg.norm(np.diff(joints, axis=0), axis=2) * motion.fps
        assert speed.max() < FASTEST < JOINT_SPEED
        assert speed[:, 0].max() < 4.0 < ROOT_SPEED


@pytest.mark.slow
@pytest.mark.parametrize("number", range(len(STYLES)))
def test_no_jump_in_velocity(number, body):
    """In smooth motion twice the frame rate finds the same accelerations, else doubled ones."""

    def sharpest(fps):
        motion = dance(number, seconds=4.0, fps=fps, body=body)
        turns = rotvec_to_matrix(motion.rotations)
        change = np.abs(np.diff(turns, 2, axis=0)).max() * fps**2
        return change, np.abs(np.diff(motion.translation, 2, axis=0)).max() * fps**2

    for slow, fast in zip(sharpest(480.0), sharpest(960.0), strict=True):
        assert fast < 1.25 * slow


def test_feet_stand_on_the_floor_and_do_not_slide(dances, body):
    for number, motion in enumerate(dances[: len(STYLES)]):
        height = lowest(body, motion)
        assert height.min() > -0.045, style_of(number)
        if style_of(number) not in ("jumps", "jazz"):
            assert height.max() < 0.06, style_of(number)
        feet = body.joints(motion)[:, [JOINT_INDEX["left_foot"], JOINT_INDEX["right_foot"]]]
        path = np.linalg.norm(np.diff(feet[..., :2], axis=0), axis=2) * motion.fps
        # The slower foot, in frames in which both are down: a standing foot does not slide.
        assert np.median(path.min(axis=1)) < 0.15, style_of(number)


def test_dancers_jump_turn_around_kick_and_go_down(dances, body):
    at = {style: list(STYLES).index(style) for style in STYLES}
    assert lowest(body, dances[at["jumps"]]).max() > 0.15
    pelvis = rotvec_to_matrix(dances[at["spins"]].rotations[:, 0])
    ahead = pelvis[..., 2]  # z at rest
    turned = np.unwrap(np.arctan2(ahead[:, 1], ahead[:, 0]))
    assert np.ptp(turned) > 2.0 * np.pi
    kicks = body.joints(dances[at["kicks"]])
    ankles = kicks[:, [JOINT_INDEX["left_ankle"], JOINT_INDEX["right_ankle"]], 2]
    assert ankles.max() > 0.6
    assert body.joints(dances[at["floor"]])[:, 0, 2].min() < 0.6


def test_a_score_of_nothing_stands_still(body):
    motion = danced(body, Score(0.5), 1.0, 60.0)
    assert np.abs(np.diff(motion.translation, axis=0)).max() < ROUNDING
    assert np.abs(np.diff(motion.rotations, axis=0)).max() < ROUNDING
    assert abs(lowest(body, motion)[0]) < 0.045


@pytest.mark.parametrize("number", range(len(KINDS)))
def test_daily_motions_are_slow_and_on_the_floor(number, body):
    motion = daily(number, body=body)
    assert 4.0 < motion.duration < 9.0
    assert lowest(body, motion).min() > -0.005
    assert measured(motion, body)["joints"] < 1.5
    assert measured(motion, body)["joints"] > 0.03
    short = daily(number, seconds=1.0, body=body)
    assert content(short) == content(motion[: len(short)])


def test_the_feet_of_a_tall_dancer_are_on_the_floor_too(body):
    tall = hp.Body.default(stature=1.95)
    motion, usual = dance(4, seconds=2.0, body=tall), dance(4, seconds=2.0, body=body)
    assert lowest(tall, motion).min() > -0.05
    assert lowest(tall, motion).max() < 0.07
    assert tall.joints(motion)[0, 0, 2] > body.joints(usual)[0, 0, 2] + 0.05
