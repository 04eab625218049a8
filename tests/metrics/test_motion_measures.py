"""Success, jerk, foot skate, deviation and sums over sequences: by hand and by closed forms."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from halfphysics import metrics
from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.errors import InputError
from halfphysics.geometry.shapes import Plane
from halfphysics.motion.joint_groups import JOINT_GROUPS
from halfphysics.motion.motion import Motion
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.results.contacts import Contacts
from halfphysics.results.result import PersonResult, Result
from halfphysics.scene.scene import Scene
from halfphysics.settings import Settings
from support.point_bodies import Cloud, Drift

FEET = [JOINT_INDEX["left_foot"], JOINT_INDEX["right_foot"]]


class Puppet:
    """A body whose joints (T, 55, 3) are given."""

    def __init__(self, joints: np.ndarray) -> None:
        self.given = joints

    def joints(self, motion: Any) -> np.ndarray:
        return self.given


def _clip(frames: int, fps: float = 30.0) -> Drift:
    return Drift(np.zeros((frames, 3)), fps)


# -- success ---------------------------------------------------------------------------------


def test_success_is_every_frame_finite_at_the_rate_asked() -> None:
    asked = _clip(9)
    assert metrics.success(_clip(9), asked)
    assert not metrics.success(None, asked)
    assert not metrics.success(_clip(8), asked)
    assert not metrics.success(_clip(9, 60.0), asked)
    for wrong in (np.nan, np.inf):
        broken = _clip(9)
        broken.translation[4, 1] = wrong
        assert not metrics.success(broken, asked)
    with pytest.raises(InputError, match=r"asked: expected a halfphysics\.Motion"):
        metrics.success(_clip(9), None)
    with pytest.raises(InputError, match=r"motion: expected a halfphysics\.Motion"):
        metrics.success(3, asked)


# -- jerk ------------------------------------------------------------------------------------


@given(
    st.lists(st.floats(-3.0, 3.0), min_size=3, max_size=3),
    st.sampled_from([20.0, 30.0, 120.0]),
    st.integers(4, 40),
)
@settings(max_examples=30, deadline=None)
def test_jerk_of_cubics_is_exact(third: list[float], fps: float, frames: int) -> None:
    """x = a t^3 / 6 + 0.4 t^2 - t + 1 has jerk |a| at every rate."""
    t = np.arange(frames)[:, None] / fps
    path = np.array(third) * t**3 / 6.0 + 0.4 * t**2 - t + 1.0
    found = metrics.jerk(Drift(path, fps), Cloud(np.zeros((55, 3))))
    # Rounding of positions of about 1 m, times fps^3.
    assert found == pytest.approx(float(np.linalg.norm(third)), abs=1e-14 * fps**3, rel=1e-9)


def test_jerk_is_the_mean_over_joints() -> None:
    joints = np.zeros((5, 55, 3))
    joints[:, 7, 0] = np.arange(5) ** 3  # third difference 6
    assert metrics.jerk(_clip(5, 10.0), Puppet(joints)) == pytest.approx(6.0 * 1000.0 / 55)
    with pytest.raises(InputError, match="jerk takes at least 4 frames, found 3"):
        metrics.jerk(_clip(3), Puppet(joints[:3]))
    with pytest.raises(InputError, match="body: expected"):
        metrics.jerk(_clip(5), None)


# -- foot skate ------------------------------------------------------------------------------


def _feet(steps: list[tuple[float, float]], heights: list[tuple[float, float]]) -> Puppet:
    """Feet that move so far [m] along x from frame to frame, at these heights [m]."""
    joints = np.full((len(heights), 55, 3), 1.0)
    joints[:, FEET, 0] = np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])
    joints[:, FEET, 2] = heights
    return Puppet(joints)


def test_foot_skate_by_hand() -> None:
    """Four steps at 20 fps: slide of 30 mm, of 10 mm, one in the air, both feet slide."""
    low, high = 0.03, 0.2
    puppet = _feet(
        [(0.03, 0.0), (0.0, 0.01), (0.5, 0.0), (0.04, 0.05)],
        [(low, low), (low, low), (high, low), (low, low), (low, low)],
    )
    report = metrics.foot_skate(_clip(5, 20.0), puppet)
    # The left foot is down in steps 1 and 4 (in 2 and 3 it is up at one end), the right in all.
    assert report.steps == 6
    assert report.mean_mm == pytest.approx((30 + 40 + 0 + 10 + 0 + 50) / 6)
    assert report.mean_speed == pytest.approx(0.02 * report.mean_mm)
    assert report.share_percent == pytest.approx(50.0)  # steps 1 and 4: over 25 mm a frame
    slow = metrics.foot_skate(_clip(5, 20.0), puppet, speed=0.1)
    assert slow.share_percent == pytest.approx(75.0)
    sunk = metrics.foot_skate(_clip(5, 20.0), puppet, ground=-0.05)
    assert (sunk.steps, sunk.mean_mm, sunk.share_percent) == (0, 0.0, 0.0)


@given(st.floats(0.0, 3.0), st.sampled_from([20.0, 60.0]), st.floats(-1.0, 1.0))
@settings(max_examples=25, deadline=None)
def test_a_body_that_glides_skates_at_its_speed(speed: float, fps: float, ground: float) -> None:
    path = np.arange(6)[:, None] * [0.6 * speed / fps, 0.8 * speed / fps, 0.0] + [0, 0, ground]
    report = metrics.foot_skate(Drift(path, fps), Cloud(np.zeros((55, 3))), ground=ground)
    assert report.mean_speed == pytest.approx(speed, abs=1e-12)
    if abs(speed - 0.5) > 1e-9:
        assert report.share_percent == (100.0 if speed > 0.5 else 0.0)


@pytest.mark.parametrize(
    "wrong", [{"height": 0.0}, {"speed": -1.0}, {"ground": np.nan}, {"height": "5 cm"}], ids=str
)
def test_impossible_limits_of_skating(wrong: dict[str, Any]) -> None:
    with pytest.raises(InputError, match=next(iter(wrong))):
        metrics.foot_skate(_clip(5), Puppet(np.zeros((5, 55, 3))), **wrong)


# -- over sequences --------------------------------------------------------------------------


def test_over_sequences_by_hand() -> None:
    """A sequence of 2 frames and 4 points, one of 4 frames and 2: who counts how often."""
    scene = Scene()
    scene.add_static("floor", Plane())
    first = metrics.penetration(
        Drift(np.array([[0, 0, 0.0], [0, 0, -0.53]])),
        Cloud(np.array([[0, 0, 0.5], [0, 0, 1.0], [0, 0, 0.52], [0, 0, 2.0]])),
        scene,
    )
    second = metrics.penetration(
        Drift(np.array([[0, 0, 0.0], [0, 0, -0.3], [0, 0, -0.4], [0, 0, 0.0]])),
        Cloud(np.array([[0, 0, 0.2], [0, 0, 1.0]])),
        scene,
    )
    both = metrics.over_sequences([first, second])
    assert (both.sequences, both.frames) == (2, 6)
    assert both.rate_percent == pytest.approx((0 + 50 + 0 + 50 + 50 + 0) / 6)
    assert both.depth_mean_mm == pytest.approx((0 + 30 + 0 + 100 + 200 + 0) / 6)
    assert both.depth_max_mm == pytest.approx((30 + 200) / 2)
    assert both.depth_penetrating_mm == pytest.approx((30 + 10 + 100 + 200) / 4)
    assert both.worst_mm == pytest.approx(200.0)
    alone = metrics.over_sequences([second])
    assert alone.depth_max_mm == second.depth_max_mm
    assert alone.depth_penetrating_mm == pytest.approx(second.depth_penetrating_mm)
    clear = metrics.over_sequences([metrics.penetration(_clip(3), Cloud(np.ones((3, 3))), scene)])
    assert (clear.rate_percent, clear.depth_max_mm, clear.depth_penetrating_mm) == (0.0, 0.0, 0.0)
    with pytest.raises(InputError, match="reports: found none"):
        metrics.over_sequences([])
    with pytest.raises(InputError, match="reports: expected those of"):
        metrics.over_sequences([first, 3])  # type: ignore[list-item]


# -- deviation from the intent -----------------------------------------------------------------


def _stopped(contacts: Contacts | None = None) -> Result:
    """12 frames at 10 fps: touched in frame 4, then the root 120 mm aside and an elbow bent."""
    frames, elbow = 12, JOINT_INDEX["left_elbow"]
    rotations = 0.3 * np.random.default_rng(0).normal(size=(frames, 55, 3))
    reference = Motion(np.zeros((frames, 3)), rotations, 10.0)
    moved, bent = np.zeros((frames, 3)), np.array(rotations)
    moved[4:, 1] = 0.12
    turn = rot.multiply(rot.exp(bent[4:6, elbow]), rot.exp([0.3, 0.0, 0.0]))
    bent[4:6, elbow] = rot.log(turn)
    scene = Scene()
    scene.add_static("floor", Plane())
    motion = reference.with_frames(moved, bent)
    touch: dict[str, Any] = {name: [0] for name in Contacts.columns()}
    touch |= {name: [[0.0, 1.0, 0.0]] for name in Contacts.VECTORS}
    touch |= {"frame": [4], "part": [elbow], "subject": [-1], "other_part": [-1]}
    return Result(
        people=(
            PersonResult(name="person", motion=motion, reference=reference, body=Body.default()),
        ),
        objects={},
        scene=scene,
        names=("floor", "person"),
        contacts=Contacts(**touch) if contacts is None else contacts,
        clearance=np.full(frames, np.inf),
        lost_time=np.zeros(frames),
        settings=Settings(),
    )


def test_deviation_in_and_out_of_contact() -> None:
    result = _stopped()
    report = metrics.deviation(result, settle=0.2)
    # Frames 4 to 6 are touched (settle: two frames after).
    assert (report.whole.frames, report.free.frames, report.touched.frames) == (12, 9, 3)
    assert report.touched.root_mm == pytest.approx(120.0)
    assert report.free.root_mm == pytest.approx(120.0 * 5 / 9)
    assert report.whole.root_mm == pytest.approx(120.0 * 8 / 12)
    assert report.touched.root_deg == pytest.approx(0.0, abs=1e-9)
    # One of 40 joints of the arms, in two of three frames.
    arms = len(JOINT_GROUPS["arms"])
    assert report.touched.angle_deg["arms"] == pytest.approx(np.rad2deg(0.3) * 2 / 3 / arms)
    assert report.touched.angle_deg["legs"] == pytest.approx(0.0, abs=1e-9)
    assert report.touched.local_mm["arms"] > 1.0
    assert report.free.local_mm["all"] == pytest.approx(0.0, abs=1e-9)
    local = 1000.0 * result.people[0].joint_errors()[0]
    assert report.whole.local_mm["all"] == pytest.approx(local[:, 1:].mean())


def test_without_contact_nothing_is_touched() -> None:
    free = _stopped(Contacts.none())
    report = metrics.deviation(free)
    assert (report.free.frames, report.touched.frames) == (12, 0)
    assert report.touched.root_mm == report.touched.local_mm["all"] == 0.0
    assert report.free.root_mm == report.whole.root_mm


def test_deviation_of_something_else() -> None:
    with pytest.raises(InputError, match=r"result: expected a halfphysics\.Result"):
        metrics.deviation(None)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="person: found 1"):
        metrics.deviation(_stopped(), 1)
    with pytest.raises(InputError, match="settle"):
        metrics.deviation(_stopped(), settle=-1.0)
