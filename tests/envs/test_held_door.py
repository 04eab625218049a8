"""HeldDoor: the door is pulled open, pushed, or held shut."""

import numpy as np
import pytest

from halfphysics.envs import policies
from halfphysics.envs.held_door import LOST, THROUGH, HeldDoor


def run(task, policy):
    """Terms of the last step, and the largest opening of the door and force on the person."""
    most = np.zeros(2)
    while not task.over[0]:
        outcome, _ = task.step(policy(task.observe()))
        info = outcome.info
        most = np.maximum(most, [info["opening"][0], info["force_on_person"][0]])
    return outcome.info, most


def begun(seed=2, **options):
    task = HeldDoor(1, **options)
    task.seed(0, seed)
    task.begin(0)
    return task


def test_the_script_lets_the_person_through():
    task = begun()
    info, (opening, force) = run(task, policies.scripted("HeldDoor"))
    assert info["success"][0] == 1.0
    assert task.people.place[0, 0] > THROUGH
    assert opening > 1.2
    assert force < 30.0
    assert np.linalg.norm(task._in_fork()[0]) < LOST  # the handle is still in the fork


def test_a_robot_that_stands_still_holds_the_door_against_a_person_who_pushes():
    """Contact carries the push through door and handle to the robot: it gives a little."""
    task = begun()
    task._pushes[:] = True
    _, (opening, force) = run(task, lambda seen: np.zeros((1, 3)))
    assert force > 30.0
    assert opening < 0.3
    assert task.people.place[0, 0] < 0.1


def test_a_person_who_waits_stays_before_a_shut_door():
    task = begun(steps=240)
    task._pushes[:] = False
    _, (opening, force) = run(task, lambda seen: np.zeros((1, 3)))
    assert opening < 0.1
    assert force < 30.0
    assert task.people.place[0, 0] < -0.3


def test_the_door_closes_when_the_robot_lets_it():
    """Pulled open, then back: the closer's spring and the robot bring it home."""
    task = begun(steps=200)
    policy = policies.scripted("HeldDoor")
    for _ in range(70):
        task.step(policy(task.observe()), [[-1.0, 0.0, -1.0]])  # nobody comes
    seen = task.observe()
    assert seen[0, 0] == pytest.approx(task._angle[0], abs=1e-6)
    far = np.array(seen)
    far[0, 11] = -3.0  # as if the person were far
    while not task.over[0]:
        far = np.array(task.observe())
        far[0, 11] = -3.0
        task.step(policy(far), [[-1.0, 0.0, -1.0]])
    assert task._angle[0] < 0.15
