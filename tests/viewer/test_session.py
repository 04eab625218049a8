"""The playground without a browser: commands in, frames out, the numbers of `simulate`."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.scene.changed import mass_of, movable
from halfphysics.settings import AS_IT_IS
from halfphysics.viewer import session as do
from halfphysics.viewer.catalog import OWN, Catalog, Choice, options
from halfphysics.viewer.knobs import STRENGTHS, Knobs
from halfphysics.viewer.session import Session, bodies_of
from support.sessions import KICK, ball, run, simulated, standing


@pytest.mark.slow
@pytest.mark.parametrize("name", ["kick_ball", "push_door", "meet"])
def test_untouched_it_is_simulate_to_the_last_bit_and_in_the_second_loop_again(name):
    session, result = Session(Catalog(), Choice(name)), simulated(Choice(name))
    for _ in range(2):
        frames = [session.frame, *run(session, len(result) - 1)]
        for k, person in enumerate(result.people):
            translation = np.array([frame.poses[k].translation for frame in frames])
            rotations = np.array([frame.poses[k].rotations for frame in frames])
            assert translation.tobytes() == person.motion.translation.tobytes()
            assert rotations.tobytes() == person.motion.rotations.tobytes()
        for thing, track in result.objects.items():
            at = np.array([frame.objects[thing][0] for frame in frames])
            assert at.tobytes() == track.position.tobytes()
        assert session.at_end
        assert session.advance() is session.frame  # the loop's first frame
        assert session.index == session.made == 0


@pytest.mark.parametrize(
    ("knob", "value", "changes"),
    [
        ("stiffness", 0.2, {"stiffness": 0.2}),
        ("substeps", 3, {"substeps": 3}),
        ("drive_time", 0.2, {"drive_time": 0.2}),
        ("strength", "unlimited", {"strength": None}),
        ("paper", True, {"drive_time": None, **AS_IT_IS}),
    ],
)
def test_a_knob_turned_at_the_start_is_that_setting_to_the_last_bit(knob, value, changes):
    session, result = Session(Catalog(), KICK), simulated(KICK, **changes)
    session.post(do.Turn(knob, value))
    frames = run(session, len(result) - 1)
    assert not session.trouble
    assert ball(frames).tobytes() == result.objects["ball"].position[1:].tobytes()
    rotations = np.array([frame.pose.rotations for frame in frames])
    assert rotations.tobytes() == result.motion.rotations[1:].tobytes()


@pytest.mark.parametrize("when", [0, 40])
def test_a_heavier_ball_does_not_fly(when):
    session, light = Session(Catalog(), KICK), simulated(KICK)
    run(session, when)
    session.post(do.Turn("masses", 200.0, "ball"))
    frames = run(session, len(light) - 1 - when)
    assert not session.trouble
    start, end = light.objects["ball"].position[[0, -1]]
    assert np.linalg.norm(end - start) > 10.0
    assert np.linalg.norm(frames[-1].objects["ball"][0] - start) < 1.0
    assert session.simulator.world.scene.objects["ball"].mass == 200.0


def test_a_heavier_ball_is_the_scenario_built_with_that_mass():
    session = Session(Catalog(), KICK)
    session.post(do.Turn("masses", 5.0, "ball"))
    session.post(do.Turn("frictions", 0.2, "ball"))
    result = simulated(Choice("kick_ball", OWN, {"mass": 5.0, "friction": 0.2}))
    at = ball(run(session, len(result) - 1))
    # The inertia is scaled instead of recomputed: the same but for rounding.
    np.testing.assert_allclose(at, result.objects["ball"].position[1:], atol=1e-6)


def test_a_heavier_door_opens_less():
    opened = {}
    for mass in (5.0, 500.0):
        session = Session(Catalog(), Choice("push_door"))
        session.post(do.Turn("masses", mass, "door"))
        opened[mass] = abs(float(run(session, 60)[-1].joints["door/hinge"]))
        door = session.simulator.world.scene.articulated["door"]
        assert mass_of(door) == pytest.approx(mass)
    assert opened[500.0] < 0.9 * opened[5.0]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("knob", "value"),
    [("stiffness", 0.0), ("substeps", 2), ("drive_time", 0.3), ("strength", "very weak")],
)
def test_a_knob_turned_on_the_way_goes_on_from_there_and_changes_what_comes(knob, value):
    wall = Choice("walk_into_wall")
    session, plain = Session(Catalog(), wall), Session(Catalog(), wall)
    before = run(session, 50)
    assert [f.pose.rotations.tobytes() for f in before] == [
        f.pose.rotations.tobytes() for f in run(plain, 50)
    ]
    session.post(do.Turn(knob, value))
    first, same = session.advance(), plain.advance()
    assert not session.trouble
    assert session.index == plain.index == 51
    # One frame later every body is near its last pose: the run went on, it did not restart.
    assert np.abs(first.pose.translation - same.pose.translation).max() < 0.05
    after, others = run(session, 30), run(plain, 30)
    apart = [
        np.abs(a.pose.rotations - b.pose.rotations).max()
        for a, b in zip(after, others, strict=True)
    ]
    assert max(apart) > 1e-3


def test_firmness_turned_on_the_way_is_set_stiffness():
    wall = Choice("walk_into_wall")
    session, story = Session(Catalog(), wall), Catalog().load(wall)
    simulator = hp.Simulator(story.scene, body=story.body, fps=story.motion.fps)
    simulator.reset(story.motion[0])
    run(session, 60)
    for k in range(1, 61):
        simulator.step(story.motion[k])
    session.post(do.Turn("stiffness", 0.1))
    simulator.set_stiffness(0.1)
    for k in range(61, 90):
        frame = simulator.step(story.motion[k])
        assert session.advance().pose.rotations.tobytes() == frame.pose.rotations.tobytes()


def test_after_a_knob_on_the_way_a_restart_is_simulate_with_it():
    session, result = Session(Catalog(), KICK), simulated(KICK, stiffness=0.3, substeps=5)
    run(session, 20)
    session.post(do.Turn("stiffness", 0.3))
    run(session, 5)
    session.post(do.Turn("substeps", 5))
    session.post(do.Restart())
    session.obey()
    at = ball(run(session, len(result) - 1))
    assert at.tobytes() == result.objects["ball"].position[1:].tobytes()


def test_as_the_scenario_has_it_again():
    session, result = Session(Catalog(), KICK), simulated(KICK)
    session.post(do.Turn("masses", 50.0, "ball"))
    session.post(do.Turn("strength", "weak"))
    run(session, 10)
    session.post(do.Untouched())
    session.post(do.Restart())
    session.obey()
    assert session.knobs == Knobs()
    at = ball(run(session, len(result) - 1))
    assert at.tobytes() == result.objects["ball"].position[1:].tobytes()


# -- playing ---------------------------------------------------------------------------------


def test_pause_step_freeze_and_the_end():
    session = Session(Catalog(), Choice("walk_into_wall"))
    session.post(do.Play(False))
    assert session.advance() is None
    session.post(do.Step())
    assert session.advance() is not None
    assert session.index == 1
    assert session.advance() is None
    session.post(do.Play())
    session.post(do.Change("frozen", True))
    run(session, 5)
    assert (session.index, session.made) == (1, 6)
    session.post(do.Change("frozen", False))
    session.post(do.Change("loop", False))
    run(session, session.frames + 10)
    assert session.at_end
    assert session.made == session.frames + 16  # physics goes on with the last pose
    session.post(do.Change("loop", True))
    session.advance()
    assert session.index == 0


# -- choosing --------------------------------------------------------------------------------


def test_one_motion_in_the_scene_of_another():
    session = Session(Catalog(), Choice("kick_ball", "walk_into_wall"))
    assert set(session.sequence.scene.objects) == {"ball"}
    assert session.frames == len(hp.scenarios.load("walk_into_wall").motion)
    run(session, 20)
    assert str(session.choice) == "walk_into_wall in kick_ball"


def test_another_scenario_keeps_the_person_and_forgets_the_things():
    session = Session(Catalog(), KICK)
    session.post(do.Turn("masses", 3.0, "ball"))
    session.post(do.Turn("stiffness", 0.5))
    session.post(do.Choose(Choice("doorway")))
    run(session, 2)
    assert not session.trouble
    assert session.knobs == Knobs(stiffness=0.5)
    assert session.simulator.settings.stiffness == 0.5
    assert session.story == 1
    # A command of a page that has not seen the change yet.
    session.post(do.Turn("masses", 3.0, "suitcase"))
    start = (0.0, 0.0, 0.0)
    session.post(do.Grab(1, "suitcase", start, start))
    session.post(do.Grab(1, "floor", start, start))
    run(session, 2)
    assert not session.trouble
    assert not session.drags


def test_an_option_of_a_scenario_builds_it_anew():
    session = Session(Catalog(), KICK)
    flew = {}
    for speed in (2.0, 10.0):
        session.post(do.Choose(Choice("kick_ball", OWN, {"speed": speed})))
        session.obey()
        assert session.index == 0
        at = ball(run(session, session.frames - 1))
        flew[speed] = np.linalg.norm(at[-1] - at[0])
    assert flew[10.0] > 2.0 * flew[2.0] > 0.5


@pytest.mark.slow
@pytest.mark.parametrize("name", [n for n in hp.scenarios.names() if options(n)])
def test_every_end_of_every_slider_of_a_scenario_can_be_played(name):
    for option in options(name):
        assert option.low < option.high
        assert option.low <= option.value <= option.high
        for value in (option.low, option.high) if "glass" not in name else (option.high,):
            story = Catalog().load(Choice(name, OWN, {option.name: value}))
            assert len(story.motions[0]) > 1


@pytest.mark.parametrize("name", ["close_drawer", "meet", "reach_past_monitor", "sit_on_bed"])
def test_a_scenario_can_be_played_with_every_knob_turned(name):
    session = Session(Catalog(), Choice(name))
    run(session, 2)
    for strength in STRENGTHS:
        session.post(do.Turn("strength", strength))
    for knob, value in (("stiffness", 2.0), ("drive_time", 0.05), ("substeps", 4)):
        session.post(do.Turn(knob, value))
    for thing in movable(session.sequence.scene):
        session.post(do.Turn("masses", 2.0, thing))
        session.post(do.Turn("frictions", 0.1, thing))
    assert session.advance() is not None
    assert not session.trouble
    assert session.index == 3
    assert session.simulator.settings.substeps == 4
    for thing in movable(session.simulator.world.scene).values():
        assert mass_of(thing) == pytest.approx(2.0)
        assert thing.friction == 0.1


def test_of_a_slider_that_is_moved_only_the_last_place_is_worked_out():
    session = Session(Catalog(), KICK)
    run(session, 3)
    built = []
    session.turn = lambda knobs: built.append(knobs.masses)
    for mass in range(1, 100):
        session.post(do.Turn("masses", float(mass), "ball"))
    session.post(do.Turn("frictions", 0.3, "ball"))
    session.obey()
    assert built == [{"ball": 99.0}, {}]


def test_bodies_are_the_default_one_where_a_source_names_none():
    sequence, _ = standing()
    assert len(bodies_of(replace(sequence, body=None))) == 1


def test_what_is_varied_is_the_choice_of_then():
    """A browser posts faster than scenarios load, and knows the choice of before."""
    session = Session(Catalog(), KICK)
    session.post(do.Vary(options={"radius": 0.2}, scenario="kick_ball"))
    session.post(do.Vary(options={"speed": 9.0}, scenario="kick_ball"))
    session.obey()
    assert session.choice.options == {"radius": 0.2, "speed": 9.0}
    session.post(do.Choose(Choice("walk_into_wall")))
    session.post(do.Vary(options={"radius": 0.1}, scenario="kick_ball"))  # a slider that is gone
    session.post(do.Vary(motion="kick_ball"))
    session.obey()
    assert not session.trouble
    assert (session.choice.scenario, session.choice.motion) == ("walk_into_wall", "kick_ball")
    assert session.choice.options == {}


def test_of_values_that_follow_each_other_the_last_is_loaded():
    session = Session(Catalog(), KICK)
    story = session.story
    for radius in (0.1, 0.15, 0.2):
        session.post(do.Vary(options={"radius": radius}, scenario="kick_ball"))
    session.obey()
    assert session.story == story + 1
    assert session.choice.options == {"radius": 0.2}
