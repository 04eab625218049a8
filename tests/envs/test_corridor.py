"""Corridor: the robot passes, waits, or runs into the person."""

import numpy as np
import pytest

from halfphysics.envs import policies
from halfphysics.envs.corridor import GOAL, START, Corridor


def begun(seed=7, **options):
    task = Corridor(1, **options)
    task.seed(0, seed)
    task.begin(0)
    return task


def test_the_script_gets_past_the_person():
    task, policy = begun(), policies.scripted("Corridor")
    assert task.worlds.motors[0, 0, 0] == pytest.approx(START)
    while not task.over[0]:
        outcome, _ = task.step(policy(task.observe()))
    assert outcome.info["success"][0] == 1.0
    assert task.worlds.motors[0, 0, 0] > GOAL - 0.3


def test_the_person_walks_along_the_corridor():
    """At human speed, on its feet, in its lane, while the robot stands at its end."""
    task = begun(steps=90)
    first = task.people.place[0].copy()
    while not task.over[0]:
        task.step(np.zeros((1, 2)))
    way = first[0] - task.people.place[0, 0]
    assert 0.5 * 3.0 < way < 1.4 * 3.0
    assert task.people.place[0, 1] == pytest.approx(task._lane[0], abs=0.15)
    assert 0.75 < task.worlds.place("person/pelvis")[0, 2] < 1.05


def test_a_person_in_the_way_is_pushed_and_that_costs():
    """Robot and person go for the same place, head on: contact forces on the person."""
    task = begun(3)
    task._yields[:] = False
    worst, reward = 0.0, 0.0
    while not task.over[0]:
        # Steer into the person.
        to = task.people.place - task.worlds.motors[:, 0, :2]
        turn = np.clip(2.0 * task.turn_to(to), -1.0, 1.0)
        told = np.stack([np.ones(1), turn], axis=1)
        outcome, _ = task.step(told)
        worst = max(worst, float(outcome.info["force_on_person"][0]))
        reward += float(outcome.info["force"][0] + outcome.info["crowding"][0])
    assert worst > 20.0
    assert reward < -0.5


def test_a_policy_can_walk_the_person():
    task = begun(steps=60)
    place = task.people.place[0].copy()
    while not task.over[0]:
        task.step(np.zeros((1, 2)), [[-1.0, 0.0]])  # stand
    assert task.people.place[0] == pytest.approx(place, abs=0.12)
    task.begin(0)
    place = task.people.place[0].copy()
    while not task.over[0]:
        task.step(np.zeros((1, 2)), [[0.5, -1.0]])  # to its right, which is y
    assert task.people.place[0, 0] < place[0] - 0.5
    assert task.people.place[0, 1] > place[1] + 0.2
