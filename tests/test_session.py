"""The playground without a browser: commands in, frames out, the numbers of `simulate`."""

from __future__ import annotations

import math
import random
import threading
import time
from dataclasses import replace

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.errors import InputError
from halfphysics.sequence import Sequence
from halfphysics.shapes import Box, Plane, Sphere
from halfphysics.viewer import session as do
from halfphysics.viewer.catalog import OWN, Catalog, Choice, options
from halfphysics.viewer.knobs import STRENGTHS, Knobs, mass_of, movable
from halfphysics.viewer.session import Session, bodies_of

KICK = Choice("kick_ball")


def standing(*, frames=90, fps=30.0, wall=None):
    """A person who stands still, a ball beside them, half a metre away."""
    story = hp.scenarios.load("kick_ball")
    first = story.motion[0]
    motion = hp.Motion(
        np.repeat(first.translation[None], frames, axis=0),
        np.repeat(first.rotations[None], frames, axis=0),
        fps,
    )
    scene = hp.Scene()
    scene.add_static("floor", Plane())
    pelvis = np.asarray(story.body.joints(first))[0]
    at = np.add(pelvis, [0.8, 0.0, 0.0])
    scene.add_object("ball", Sphere(0.11), mass=0.43, position=(at[0], at[1], 0.11))
    if wall is not None:
        scene.add_static("wall", Box((0.1, 4.0, 3.0)), position=(at[0] + wall, at[1], 1.5))
    return Sequence(motion, scene, story.body), pelvis


def playing(sequence):
    return Session(Catalog({"here": lambda: sequence}), Choice("here"))


def run(session, frames):
    """Frames of the session, one after the other."""
    return [session.advance() for _ in range(frames)]


def ball(frames):
    return np.array([frame.objects["ball"][0] for frame in frames])


def simulated(choice, **changes):
    """What `simulate` makes of a scenario with other settings."""
    story = Catalog().load(choice)
    settings = replace(story.settings, **changes)
    return hp.simulate(story.motion, story.scene, body=story.body, settings=settings)


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
        ("strength", "human", {"strength": "human"}),
        ("paper", True, {"drive_time": None}),
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
    assert np.linalg.norm(frames[-1].objects["ball"][0] - start) < 0.5
    assert session.simulator.world.scene.objects["ball"].mass == 200.0


def test_a_heavier_ball_is_the_scenario_built_with_that_mass():
    session = Session(Catalog(), KICK)
    session.post(do.Turn("masses", 5.0, "ball"))
    session.post(do.Turn("frictions", 0.2, "ball"))
    result = simulated(Choice("kick_ball", OWN, {"mass": 5.0, "friction": 0.2}))
    at = ball(run(session, len(result) - 1))
    # The inertia is scaled instead of worked out: the same but for rounding.
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
    # One frame on, nobody is far from where they were: it went on, it did not start again.
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


# -- dragging --------------------------------------------------------------------------------


def test_a_dragged_ball_follows_the_pointer_and_stays_with_it():
    sequence, _ = standing()
    session = playing(sequence)
    start = session.frame.objects["ball"][0]
    goal = np.add(start, [0.5, 0.7, 0.9])
    session.post(do.Grab("me", "ball", tuple(np.add(start, [0.0, 0.0, 0.11])), tuple(start)))
    session.post(do.Pull("me", tuple(np.add(goal, [0.0, 0.0, 0.11]))))
    at = ball(run(session, 30))
    assert np.linalg.norm(at[-1] - goal) < 0.005
    # Critically damped: hardly beyond, and there within half a second.
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
    assert np.allclose(before[:2], [0.0, 3.0], atol=0.4)  # as fast as the pointer was
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
    session.post(do.Pull("one", (9.0, 9.0, 9.0)))  # late: the pointer does not know yet
    session.post(do.LetGo("two"))
    frames = run(session, 10)
    assert not session.drags
    assert not session.trouble
    assert np.linalg.norm(frames[-1].objects["ball"][0] - start) < 0.01


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
    # Said by a page that has not seen the change yet.
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


# -- mistakes --------------------------------------------------------------------------------

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
    # After all of that it is the same simulation as ever.
    for command in (do.Choose(KICK), do.Untouched(), do.Change("frozen", False), do.Play()):
        session.post(command)
    session.post(do.Restart())
    session.obey()
    result = simulated(KICK)
    session.loop = False
    at = ball(run(session, len(result) - 1))
    assert at.tobytes() == result.objects["ball"].position[1:].tobytes()


def test_bodies_are_the_default_one_where_a_source_names_none():
    sequence, _ = standing()
    assert len(bodies_of(replace(sequence, body=None))) == 1
