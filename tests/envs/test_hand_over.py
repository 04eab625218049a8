"""HandOver: the cup is handed over, dropped, or pressed against somebody."""

import numpy as np
import pytest

from halfphysics.envs import policies
from halfphysics.envs.hand_over import COMFORT, DROPPED, RADIUS, HandOver
from halfphysics.envs.robots import ARM


def run(policy, episodes=1, seed=5):
    """The task after its episodes are over, and what they were rewarded with."""
    task = HandOver(episodes)
    for i in range(episodes):
        task.seed(i, seed + i)
        task.begin(i)
    sums = {}
    while not task.over.all():
        active = ~task.over
        outcome, _ = task.step(policy(task.observe()))
        for name, values in outcome.info.items():
            sums[name] = sums.get(name, 0.0) + np.where(active, values, 0.0)
    return task, sums


def test_the_script_hands_the_cup_over():
    """By physics: the person bears the cup, the fingers are off it, nobody was hurt."""
    task, sums = run(policies.scripted("HandOver"), 3)
    assert (sums["done"] == 5.0).all()
    assert (sums["take"] == 1.0).all()
    assert (sums["hurt"] == 0.0).all()
    for i in range(3):
        assert task.worlds.holds(i, "cup")
    assert (task.worlds.load("cup", "fingers") == 0.0).all()
    palm = task._seen["palm"] - task._seen["cup"]
    assert (np.linalg.norm(palm, axis=1) < 0.13).all()


def test_the_cup_stays_between_the_fingers():
    """Friction alone holds it while the arm swings: it turns between the fingers, two lines of
    contact, and slips by 2 cm (19.3 mm)."""

    def swing(seen):
        time = 10.0 * seen[:, 30:31]
        return np.hstack([np.sin(5 * time), np.cos(7 * time), np.sin(4 * time), -1.0 + 0 * time])

    task = HandOver(1, steps=45)
    task.seed(0, 1)
    task.begin(0)
    first = (task._seen["cup"] - task._seen["middle"])[0]
    while not task.over[0]:
        task.step(swing(task.observe()), np.array([[0.0, 0.0, 0.0, -1.0]]))
    last = (task._seen["cup"] - task._seen["middle"])[0]
    assert np.linalg.norm(last - first) < 0.022
    assert task._seen["cup"][0, 2] > DROPPED
    assert task.worlds.load("cup", "fingers")[0] > 0.0


def test_an_open_hand_drops_the_cup():
    _, sums = run(lambda seen: np.tile([0.0, 0.0, 0.0, 1.0], (len(seen), 1)))
    assert sums["dropped"][0] == -3.0
    assert sums["done"][0] == 0.0


def test_a_person_who_is_pushed_hard_is_noticed():
    """The arm drives into the person: forces, and a push that ends the episode."""

    def charge(seen):
        return np.tile([-1.0, 0.0, 0.0, -1.0], (len(seen), 1))

    task = HandOver(1)
    task.seed(0, 3)
    task.begin(0)
    # The same, but for a person who stands much nearer than usual.
    pose = task.people.start(0, np.array([0.15, 0.05]), 0.0)
    angles = dict(zip(ARM.joints, ARM.reach(task._point)[0], strict=True))
    joints = {f"robot/{name}": float(angle) for name, angle in angles.items()}
    joints |= {"robot/left": RADIUS + 0.0015, "robot/right": RADIUS + 0.0015}
    task.worlds.start(0, [pose], joints, {"cup": (task._seen["cup"][0], (1, 0, 0, 0))})
    worst = 0.0
    while not task.over[0]:
        outcome, _ = task.step(charge(task.observe()), np.zeros((1, 4)))
        worst = max(worst, float(outcome.info["force_on_person"][0]))
    assert worst > 20.0


def test_the_person_comes_only_for_what_is_offered():
    """A cup held far away is not taken; the hand goes back down."""
    task = HandOver(1, steps=60)
    task.seed(0, 4)
    task.begin(0)
    while not task.over[0]:
        task.step([[0.0, 0.0, 0.0, -1.0]])
    away = task._distance()[0]
    assert away > 0.22
    assert task.people.wrist[0] == pytest.approx(task.people.hangs, abs=0.02)
    assert COMFORT[2] > task.people.hangs[2]


def test_a_person_who_is_hurt_in_the_last_step_is_no_success(monkeypatch):
    """The cup is handed over, and the push that ends the episode comes in the same step."""
    task, script = HandOver(1), policies.scripted("HandOver")
    monkeypatch.setattr("halfphysics.envs.hand_over.HURT", -1.0)
    task.seed(0, 3)
    task.begin(0)
    for _ in range(120):
        outcome, _ = task.step(script(task.observe()))
        if outcome.info["done"][0]:
            break
        task._episodes.over[0] = False
    assert outcome.info["done"][0] == 5.0
    assert outcome.info["hurt"][0] == -3.0
    assert outcome.info["success"][0] == 0.0
