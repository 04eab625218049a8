"""Dragged objects of a playground: they follow the pointer, and collide."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.viewer import session as do
from support.sessions import ball, playing, run, standing


def test_a_dragged_ball_follows_the_pointer_and_stays_with_it():
    sequence, _ = standing()
    session = playing(sequence)
    start = session.frame.objects["ball"][0]
    goal = np.add(start, [0.5, 0.7, 0.9])
    session.post(do.Grab("me", "ball", tuple(np.add(start, [0.0, 0.0, 0.11])), tuple(start)))
    session.post(do.Pull("me", tuple(np.add(goal, [0.0, 0.0, 0.11]))))
    at = ball(run(session, 30))
    assert np.linalg.norm(at[-1] - goal) < 0.005
    # Critically damped: hardly any overshoot, and settled within half a second.
    way = (at - start) @ (goal - start) / np.linalg.norm(goal - start) ** 2
    assert way.max() < 1.03
    assert way[14] > 0.97


def test_a_dragged_ball_meets_the_person_and_does_not_get_in():
    sequence, pelvis = standing()
    session = playing(sequence)
    start = session.frame.objects["ball"][0]
    session.post(do.Grab("me", "ball", tuple(start), tuple(start)))
    chest = np.add(pelvis, [0.0, 0.0, 0.25])
    session.post(do.Pull("me", tuple(np.add(chest, [0.6, 0.0, 0.0]))))
    run(session, 20)
    session.post(do.Pull("me", tuple(chest)))
    frames = run(session, 25)
    names = list(session.simulator.names)
    touched = [
        f for f in frames if (f.contacts.other[f.contacts.person == 0] == names.index("ball")).any()
    ]
    assert touched
    # The pointer is in the middle of the chest, the ball stays outside.
    skin = sequence.body.vertices(frames[-1].pose)
    away = np.linalg.norm(skin - frames[-1].objects["ball"][0], axis=1).min()
    assert 0.11 - 0.001 < away < 0.13
    assert np.linalg.norm(frames[-1].objects["ball"][0] - chest) > 0.15


def test_let_go_it_keeps_its_velocity():
    sequence, _ = standing()
    session = playing(sequence)
    start = session.frame.objects["ball"][0]
    session.post(do.Grab(1, "ball", tuple(start), tuple(start)))
    for k in range(15):
        session.post(do.Pull(1, tuple(start + np.array([0.0, 0.1, 0.06]) * k)))
        session.advance()
    session.post(do.LetGo(1))
    session.obey()
    before = session.simulator.velocity("ball")[0]
    assert np.allclose(before[:2], [0.0, 3.0], atol=0.4)  # at the pointer's speed
    session.advance()
    after = session.simulator.velocity("ball")[0]
    assert np.allclose(after - before, [0.0, 0.0, -9.81 / 30.0], atol=1e-6)


def test_a_wall_is_in_the_way_of_a_dragged_ball():
    sequence, _ = standing(wall=0.5)
    session = playing(sequence)
    start = session.frame.objects["ball"][0]
    session.post(do.Grab(1, "ball", tuple(start), tuple(start)))
    session.post(do.Pull(1, tuple(np.add(start, [3.0, 0.0, 0.5]))))
    at = ball(run(session, 40))
    assert at[:, 0].max() < start[0] + 0.5 - 0.05 - 0.11 + 1e-3
    assert at[-1, 2] == pytest.approx(start[2] + 0.5, abs=0.03)


def test_two_pointers_and_a_restart_while_dragging():
    sequence, _ = standing()
    session = playing(sequence)
    start = tuple(session.frame.objects["ball"][0])
    session.post(do.Grab("one", "ball", start, start))
    session.post(do.Grab("two", "ball", start, start))
    session.obey()
    assert set(session.drags) == {"one", "two"}
    session.post(do.Restart())
    session.post(do.Pull("one", (9.0, 9.0, 9.0)))  # late: the page does not know yet
    session.post(do.LetGo("two"))
    frames = run(session, 10)
    assert not session.drags
    assert not session.trouble
    assert np.linalg.norm(frames[-1].objects["ball"][0] - start) < 0.01


def test_nothing_starts_again_in_the_middle_of_a_drag():
    sequence, _ = standing(frames=5)
    session = playing(sequence)
    start = tuple(session.frame.objects["ball"][0])
    session.post(do.Grab(1, "ball", start, start))
    run(session, 12)
    assert session.made == 12
    session.post(do.LetGo(1))
    session.advance()
    assert session.made == 0
