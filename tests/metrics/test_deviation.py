"""Deviation from the intent, in and out of contact, by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

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
