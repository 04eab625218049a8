"""Hooked fingers that pull a drawer: found, free of it, and behind its bar."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.adaptation import handles
from halfphysics.adaptation.grips import places
from halfphysics.adaptation.hands import SIDES, Hand
from halfphysics.adaptation.recorded_holds import recorded_holds
from halfphysics.adaptation.thing import Thing
from halfphysics.motion.skeleton import JOINT_INDEX
from support.carries.drawer import BAR, OUT, DrawerCase, drawer
from support.carries.takes import PARTS

#: Skin of the hand that stands for it leaves gaps of this size to all of it [m].
DEEP = 4e-3


@pytest.fixture(scope="module")
def take():
    return drawer(DrawerCase(0.25, True, "aside", fingers=False))


@pytest.fixture(scope="module")
def hold(take):
    body = take.bodies[0]
    thing = Thing.of(take.sequence().scene.objects["drawer"], take.track)
    hands = [Hand.of(body, side) for side in SIDES]
    (found,) = recorded_holds(take.motions[0], body, hands, thing)
    return found


@pytest.fixture(scope="module")
def hook(take, hold):
    (place,) = places(take.motions[0], take.bodies[0], hold, 0.8)
    return handles.hook_of(take.bodies[0], hold, place)


def test_a_drawer_slides_and_a_glass_does_not(hold, grasp):
    assert handles.slides(hold)
    thing = Thing.of(grasp.scene.objects["glass"], grasp.recorded["glass"])
    hands = [Hand.of(grasp.body, side) for side in SIDES]
    (lifted,) = recorded_holds(grasp.motion, grasp.body, hands, thing)
    assert not handles.slides(lifted)


def test_the_hook_is_near_and_pulls_out(hook):
    assert hook is not None
    assert np.linalg.norm(hook.shift) < 0.06
    assert hook.way == pytest.approx([-1.0, 0.0, 0.0], abs=0.05)
    assert abs(hook.out @ hook.way) < 1e-9
    assert 0.0 <= hook.play < 0.05


def test_fingers_are_behind_the_bar_and_not_in_it(take, hold, hook, monkeypatch):
    monkeypatch.setattr(handles, "_SQUEEZE", 0.0)  # targets that press are beyond the surface
    motion, away = handles.held(take.motions[0], take.bodies[0], hold, hook, hold.arrives[0])
    assert away < 0.06
    body, frame = take.bodies[0], hold.first + 20
    part = np.argmax(body.weights, axis=1)
    own = np.isin(part, [JOINT_INDEX[name] for name in PARTS["right_wrist"]])
    skin = body.vertices(motion, frames=[frame], indices=np.flatnonzero(own))[0]
    local = (skin - hold.thing.position[frame]) @ hold.thing.turn[frame]
    assert hold.thing.gaps(local).min() > -DEEP
    behind = (np.abs(local[:, 0] + OUT - 2.0 * BAR) < BAR) & (np.abs(local[:, 2]) < BAR)
    assert behind.sum() > 3


def test_only_the_arm_and_its_fingers_move(take, hold, hook):
    was = take.motions[0]
    motion, _ = handles.held(was, take.bodies[0], hold, hook, hold.arrives[0])
    changed = np.flatnonzero((motion.rotations != was.rotations).any(axis=(0, 2)))
    names = ("right_shoulder", "right_elbow", *PARTS["right_wrist"])
    assert set(changed) <= {JOINT_INDEX[name] for name in names}
    assert np.array_equal(motion.translation, was.translation)


def test_recorded_fingers_are_kept_and_pull_at_once():
    """A hand that was recorded 2 cm too far in: without the hook the drawer is late by 5 cm."""
    known = drawer(DrawerCase(0.3, False, "inside"))
    sequence = known.sequence()
    made = hp.adapt(known.motions[0], sequence.scene, known.bodies[0], sequence.recorded)
    assert [held.parts for held in made.holds] == [("right_wrist",)]
    assert made.holds[0].moved[0] > 0.02
    got = hp.simulate(made.motion, sequence.scene, body=known.bodies[0]).objects["drawer"]
    assert 0.85 * 0.3 < got.position[0, 0] - got.position[:, 0].min() < 1.1 * 0.3


def test_it_is_pulled_without_recorded_fingers(take):
    sequence = take.sequence()
    made = hp.adapt(take.motions[0], sequence.scene, take.bodies[0], sequence.recorded)
    got, bare = (
        hp.simulate(m, sequence.scene, body=take.bodies[0]).objects["drawer"].position[:, 0]
        for m in (made.motion, take.motions[0])
    )
    assert got[0] - got.min() > 0.9 * 0.25
    assert bare[0] - bare.min() < 0.8 * 0.25
    assert got[0] - got[-1] < 0.03  # and pushed back
