"""Impossible commands to a playground are reported and change nothing, from any page."""

from __future__ import annotations

import math
import random
import threading
import time

import numpy as np
import pytest

from halfphysics.errors import InputError
from halfphysics.viewer import session as do
from halfphysics.viewer.catalog import OWN, Catalog, Choice
from halfphysics.viewer.knobs import STRENGTHS, Knobs
from halfphysics.viewer.session import Session
from support.sessions import KICK, ball, playing, run, simulated, standing

WRONG = [
    do.Turn("masses", math.nan, "ball"),
    do.Turn("masses", -1.0, "ball"),
    do.Turn("masses", "heavy", "ball"),
    do.Turn("frictions", math.inf, "ball"),
    do.Turn("stiffness", math.nan),
    do.Turn("stiffness", -1.0),
    do.Turn("substeps", 0),
    do.Turn("substeps", math.nan),
    do.Turn("drive_time", math.nan),
    do.Turn("strength", "elephant"),
    do.Turn("colour", 1.0),
    do.Change("speed", math.nan),
    do.Change("speed", 0.0),
    do.Change("loop", 3),
    do.Choose(Choice("nowhere")),
    do.Choose(Choice("kick_ball", "nobody")),
    do.Choose(Choice("kick_ball", OWN, {"speed": math.nan})),
    do.Choose(Choice("kick_ball", OWN, {"speed": 99.0})),
    do.Choose(Choice("kick_ball", OWN, {"colour": 1.0})),
    do.Grab(1, "ball", (math.nan, 0.0, 0.0), (0.0, 0.0, 0.0)),
]


@pytest.mark.slow
@pytest.mark.parametrize("command", WRONG, ids=str)
def test_what_cannot_be_done_is_said_and_changes_nothing(command):
    session, plain = Session(Catalog(), KICK), Session(Catalog(), KICK)
    run(session, 3), run(plain, 3)
    session.post(command)
    frame = session.advance()
    assert session.trouble
    assert "expected" in session.trouble
    assert (session.knobs, session.story, session.speed) == (Knobs(), 0, 1.0)
    assert frame.pose.rotations.tobytes() == plain.advance().pose.rotations.tobytes()
    session.post(do.Play())
    session.advance()
    assert not session.trouble


def test_a_pull_to_nowhere_is_said_and_the_object_stays():
    sequence, _ = standing()
    session = playing(sequence)
    start = tuple(session.frame.objects["ball"][0])
    session.post(do.Grab(1, "ball", start, start))
    session.post(do.Pull(1, (math.nan, 0.0, 0.0)))
    frame = session.advance()
    assert "pointer" in session.trouble
    assert np.linalg.norm(frame.objects["ball"][0] - start) < 0.01


def test_the_first_choice_must_be_there():
    with pytest.raises(InputError, match="expected one of"):
        Session(Catalog(), Choice("nowhere"))


def test_commands_at_random_from_many_threads():
    session = Session(Catalog(), KICK)
    stop = threading.Event()
    point = (1.0, 0.0, 0.5)

    def commands(rng):
        who = rng.randrange(3)
        return rng.choice(
            [
                do.Turn("masses", rng.choice([0.1, 40.0, math.nan]), "ball"),
                do.Turn("frictions", rng.random(), rng.choice(["ball", "floor", "sofa"])),
                do.Turn("stiffness", rng.choice([0.0, 1.0, 7.0, math.nan])),
                do.Turn("substeps", rng.choice([1, 8, 0])),
                do.Turn("paper", rng.random() < 0.5),
                do.Turn("strength", rng.choice(list(STRENGTHS))),
                do.Untouched(),
                do.Play(rng.random() < 0.9),
                do.Step(),
                do.Restart(),
                do.Change("loop", rng.random() < 0.5),
                do.Change("frozen", rng.random() < 0.5),
                do.Grab(who, rng.choice(["ball", "gone"]), point, point),
                do.Pull(who, tuple(rng.uniform(-3.0, 3.0) for _ in range(3))),
                do.LetGo(who),
                do.Choose(Choice(rng.choice(["kick_ball", "crawl_under_table", "nowhere"]))),
            ]
        )

    def meddle(seed):
        rng = random.Random(seed)
        while not stop.wait(rng.uniform(0.0, 0.1)):
            session.post(commands(rng))

    meddlers = [threading.Thread(target=meddle, args=(seed,)) for seed in range(4)]
    for thread in meddlers:
        thread.start()
    made = 0
    try:
        deadline = time.monotonic() + 60.0
        while made < 150:
            assert time.monotonic() < deadline
            frame = session.advance()
            if frame is None:
                session.post(do.Play())
            else:
                made += 1
                assert np.isfinite(frame.pose.rotations).all()
                assert all(np.isfinite(at).all() for at, _ in frame.objects.values())
    finally:
        stop.set()
        for thread in meddlers:
            thread.join()
    session.obey()
    # After all of that the simulation is unchanged.
    for command in (do.Choose(KICK), do.Untouched(), do.Change("frozen", False), do.Play()):
        session.post(command)
    session.post(do.Restart())
    session.obey()
    result = simulated(KICK)
    session.loop = False
    at = ball(run(session, len(result) - 1))
    assert at.tobytes() == result.objects["ball"].position[1:].tobytes()
