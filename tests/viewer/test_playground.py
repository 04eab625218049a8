"""halfphysics play with a server and without a browser: threads, endings, mistakes."""

from __future__ import annotations

import math
import os
import random
import signal
import socket
import subprocess
import sys
import threading
import time
from types import SimpleNamespace
from urllib.request import ProxyHandler, build_opener

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.cli import main
from halfphysics.cli.play import Command
from halfphysics.errors import InputError
from halfphysics.viewer import session as do
from halfphysics.viewer.catalog import OWN, Catalog, Choice
from halfphysics.viewer.knobs import STRENGTHS, Knobs
from halfphysics.viewer.pace import Pace
from halfphysics.viewer.playground import Playground, play

WALL = Choice("walk_into_wall")


def fetched(url):
    with build_opener(ProxyHandler({})).open(url, timeout=20.0) as answer:
        return answer.status


def until(condition, seconds=60.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, f"{seconds:g} s and still not"
        time.sleep(0.01)


@pytest.fixture(scope="module")
def playground():
    with Playground(Catalog(), Choice("kick_ball"), port=0) as running:
        yield running
        assert running._failure is None


def moved(handle, value):
    """Act as viser does when a user moves a control."""
    try:
        handle.value = value
    except RuntimeError as error:
        # viser ignores a user's input to a control that was just removed.
        if "removed" not in str(error):
            raise
        return
    event = SimpleNamespace(client_id=7, client=None, target=handle)
    for callback in handle._impl.update_cb:
        callback(event)


def settled(playground, command):
    """Post a command and wait until the playground's thread has done it."""
    playground.post(command)
    for _ in range(2):  # commands may be on their way after the first task, not after the second
        done = threading.Event()
        playground.do(done.set)
        assert done.wait(60.0)


# -- pace ------------------------------------------------------------------------------------


class Clock:
    def __init__(self):
        self.time = 100.0

    def __call__(self):
        return self.time


def paced(cost, *, period=0.1, frames=100):
    """Frames that take `cost` [s] each; total time and the message about it."""
    clock = Clock()
    pace = Pace(clock)
    for _ in range(frames):
        clock.time += pace.wait()
        pace.made(period)
        clock.time += cost
    return clock.time - 100.0, pace.kept


def test_frames_come_at_their_rate_where_the_machine_can():
    took, kept = paced(0.03)
    assert took == pytest.approx(99 * 0.1 + 0.03)
    assert kept == pytest.approx(1.0)


def test_a_machine_too_slow_plays_in_slow_motion_and_catches_nothing_up():
    took, kept = paced(0.2)
    assert took == pytest.approx(100 * 0.2)
    assert kept == pytest.approx(0.5)
    clock = Clock()
    pace = Pace(clock)
    pace.made(0.1)
    clock.time += 5.0  # other work took long
    hurried = 0
    while pace.wait() == 0.0:
        pace.made(0.1)
        hurried += 1
    assert hurried <= 2


def test_a_rest_is_no_slowness():
    clock = Clock()
    pace = Pace(clock)
    for pause in (0.0, 1000.0):
        clock.time += pause
        pace.rest()
        assert pace.kept is None
        for _ in range(50):
            clock.time += pace.wait()
            pace.made(0.1)
        assert pace.kept == pytest.approx(1.0)


# -- running ---------------------------------------------------------------------------------


def test_it_plays_at_the_motions_own_rate_with_nobody_there(playground):
    settled(playground, do.Restart())
    start, made = time.monotonic(), playground.session.made
    until(lambda: playground.session.made >= made + 45)
    assert time.monotonic() - start > 0.9 * 45 / 30.0
    assert fetched(playground.url) == 200


def test_what_a_hand_does_reaches_the_simulator(playground):
    session, panel = playground.session, playground.panel
    moved(panel.items.mass, 12.0)
    moved(panel.items.friction, 0.3)
    moved(panel.person.stiffness, 0.5)
    moved(panel.person.strength, "weak")
    moved(panel.person.substeps, 5)
    moved(panel.player.speed, 2.0)
    moved(panel.player.loop, False)
    settled(playground, do.Play())
    ball = session.simulator.world.scene.objects["ball"]
    assert (ball.mass, ball.friction) == (12.0, 0.3)
    assert session.knobs == Knobs(
        stiffness=0.5, strength="weak", substeps=5, masses={"ball": 12.0}, frictions={"ball": 0.3}
    )
    assert (session.speed, session.loop) == (2.0, False)
    for callback in panel.person.untouched._impl.update_cb:
        callback(SimpleNamespace(client_id=7, client=None, target=panel.person.untouched))
    settled(playground, do.Change("speed", 1.0))
    assert session.knobs == Knobs()
    settled(playground, do.Change("loop", True))
    # The panel shows it too, once the user lets go.
    until(
        lambda: (
            (panel.items.mass.value, panel.person.substeps.value, panel.player.speed.value)
            == (0.43, 8, 1.0)
        )
    )
    assert (panel.person.strength.value, panel.player.loop.value) == ("human", True)


@pytest.mark.parametrize("value", [math.nan, -5.0])
def test_an_impossible_value_is_said_in_the_page_and_taken_back(playground, value):
    panel = playground.panel
    moved(panel.items.friction, value)
    settled(playground, do.LetGo("nobody"))
    assert "friction of 'ball'" in playground.session.trouble
    until(lambda: panel.trouble.visible and "friction of 'ball'" in panel.trouble.content)
    until(lambda: panel.items.friction.value == 0.6)
    settled(playground, do.Play())
    until(lambda: not panel.trouble.visible)


@pytest.mark.slow
def test_another_scenario_is_another_stage_with_its_own_controls(playground):
    old = playground.stage
    moved(playground.panel.player.place, "meet")
    until(lambda: playground.session.choice.scenario == "meet" and playground.stage is not old)
    settled(playground, do.Play())
    assert len(playground.stage.people) == 2
    assert not playground.panel.items.folder.visible
    names = list(playground.server.scene._handle_from_node_name)
    assert not [name for name in names if name.startswith(old.prefix + "/")]
    moved(playground.panel.player.place, "kick_ball")
    until(lambda: playground.session.choice.scenario == "kick_ball")
    settled(playground, do.Play())
    assert playground.panel.items.folder.visible
    assert playground.panel.items.mass.value == 0.43


def test_cameras_that_follow_do_so_in_the_next_scenario_too(playground):
    moved(playground.panel.follow, True)
    until(lambda: playground.cameras.following)
    before = playground.cameras
    settled(playground, do.Choose(WALL))
    until(lambda: playground.cameras is not before)
    assert playground.cameras.following
    moved(playground.panel.follow, False)
    until(lambda: not playground.cameras.following)
    settled(playground, do.Choose(Choice("kick_ball")))
    until(lambda: playground.stage.prefix == f"/story{playground.session.story}")


def test_the_number_of_controls_and_nodes_does_not_grow(playground):
    def count():
        gui, scene = playground.server.gui, playground.server.scene
        return len(gui._gui_input_handle_from_uuid), len(scene._handle_from_node_name)

    settled(playground, do.Choose(Choice("kick_ball")))
    before = count()
    for speed in (3.0, 4.0, 5.0):
        settled(playground, do.Choose(Choice("kick_ball", OWN, {"speed": speed})))
    settled(playground, do.Choose(Choice("kick_ball")))
    assert count() == before


@pytest.mark.slow
def test_anything_from_any_thread_at_any_time(playground):
    session, panel = playground.session, playground.panel
    stop = threading.Event()
    wrong = []
    point = (1.0, 0.0, 0.5)

    def meddle(seed):
        rng = random.Random(seed)
        try:
            while not stop.wait(rng.uniform(0.0, 0.05)):
                rng.choice(
                    [
                        lambda: moved(panel.items.mass, rng.choice([0.1, 90.0, math.nan])),
                        lambda: moved(panel.items.friction, rng.choice([0.0, 1.0, math.nan])),
                        lambda: moved(panel.person.stiffness, rng.uniform(-0.1, 9.0)),
                        lambda: moved(panel.person.strength, rng.choice(list(STRENGTHS))),
                        lambda: moved(panel.person.paper, rng.random() < 0.5),
                        lambda: moved(panel.player.frozen, rng.random() < 0.3),
                        lambda: playground.post(do.Restart()),
                        lambda: playground.post(do.Play(rng.random() < 0.9)),
                        lambda: playground.post(do.Grab(seed, "ball", point, point)),
                        lambda: playground.post(do.Pull(seed, (rng.random(), math.nan, 0.5))),
                        lambda: playground.post(do.Pull(seed, (rng.random(), 2.0, 0.5))),
                        lambda: playground.post(do.LetGo(seed)),
                        lambda: moved(panel.player.place, rng.choice(["kick_ball", "sit_on_sofa"])),
                    ]
                )()
        except Exception as error:
            wrong.append(error)

    meddlers = [threading.Thread(target=meddle, args=(seed,)) for seed in range(3)]
    made = 0
    for thread in meddlers:
        thread.start()
    time.sleep(4.0)
    stop.set()
    for thread in meddlers:
        thread.join()
    assert not wrong
    assert playground._failure is None
    for command in (do.Choose(Choice("kick_ball")), do.Untouched(), do.Change("frozen", False)):
        settled(playground, command)
    settled(playground, do.Restart())
    settled(playground, do.Play())
    made = session.made
    until(lambda: session.made > made + 5)
    assert np.isfinite(session.frame.pose.rotations).all()
    assert session.knobs == Knobs()


def test_a_failure_of_the_thread_is_raised_where_it_waits():
    playground = Playground(Catalog(), WALL, port=0)

    def fails():
        raise ZeroDivisionError("by test")

    playground.do(fails)
    with pytest.raises(ZeroDivisionError, match="by test"):
        playground.wait()
    assert "stopped" in repr(playground)


def test_without_blocking_it_is_a_context_that_cleans_up(capfd):
    before = set(threading.enumerate())
    with play(Catalog(), WALL, port=0, block=False) as playground:
        assert fetched(playground.url) == 200
        assert f'src="{playground.url}"' in playground._repr_html_()
        assert playground.url in repr(playground)
    playground.stop()
    assert "stopped" in repr(playground)
    assert "iframe" not in playground._repr_html_()
    out, err = capfd.readouterr()
    assert out.startswith("the playground is at http://127.0.0.1:")
    assert err == ""
    until(lambda: not [t for t in set(threading.enumerate()) - before if t.is_alive()], 20.0)


@pytest.mark.slow
def test_it_says_where_it_is_and_ends_with_ctrl_c():
    with socket.socket() as busy:
        busy.bind(("127.0.0.1", 0))
        busy.listen()
        port = busy.getsockname()[1]
        process = subprocess.Popen(
            [sys.executable, "-m", "halfphysics", "play", "walk_into_wall", "--port", str(port)],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            env={**os.environ, "PYTHONUNBUFFERED": "1"},
        )  # fmt: skip
        try:
            lines = [process.stdout.readline() for _ in range(4)]
            assert lines[0].startswith(f"port {port} is in use, taking ")
            taken = int(lines[0].split()[-1])
            assert lines[1] == f"the playground is at http://127.0.0.1:{taken}\n"
            assert f"ssh -L {taken}:127.0.0.1:{taken}" in lines[2]
            assert "Ctrl-C" in lines[3]
            assert fetched(f"http://127.0.0.1:{taken}") == 200
        finally:
            process.send_signal(signal.SIGINT)
            out, err = process.communicate(timeout=30)
    assert process.returncode == 130
    assert (out, err.strip()) == ("", "")


# -- the command -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["kick_bal"], "did you mean kick_ball?"),
        (["kick_ball", "doorway"], "expected one"),
        (["nothing.npz"], "nothing.npz: no such file"),
        (["kick_ball", "--object", "ball=sphere:0.1,mass=1"], "a scene of its own"),
        (["--port", "99999"], "expected a whole number from 0 to 65535"),
        (["--host", "192.0.2.1"], "no address of this machine"),
        ([__file__], "test_playground.py"),
    ],
)
def test_mistakes_end_in_one_message(arguments, said, capfd):
    assert main(["play", *arguments]) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert err.startswith("halfphysics: error: ")
    assert said in err


def test_a_file_is_played_by_itself_or_in_a_scenario(tmp_path, monkeypatch):
    path = tmp_path / "walk.npz"
    hp.scenarios.load("walk_into_wall").motion.save(path)
    played = []
    monkeypatch.setattr(
        "halfphysics.viewer.playground.play", lambda *given, **named: played.append(given)
    )
    main(["play", str(path), "--object", "ball=sphere:0.11,mass=0.43,at=1:0:0.11"])
    main(["play", "kick_ball", str(path)])
    main(["play"])
    alone, inside, nothing = (Session.sequence for Session in (do.Session(*g) for g in played))
    assert set(alone.scene.objects) == {"ball"}
    assert "ground" in alone.scene.statics
    assert len(inside.motion) == len(alone.motion)
    assert set(inside.scene.statics) == {"floor"}
    assert [str(choice) for _, choice in played] == [
        "walk.npz",
        "walk.npz in kick_ball",
        "kick_ball",
    ]
    assert nothing.motion.duration > 5.0
    with pytest.raises(InputError, match="twice"):
        Command(what=(str(path), str(path))).run()
