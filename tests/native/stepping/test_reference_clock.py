"""Who is blocked waits: the reference's clock, and the force on a root with ground under it."""

import numpy as np
import pytest

import halfphysics as hp

BODY = hp.Body.default()
STANDS_FIRM = hp.Settings()


def walk(frames=150, fps=30.0, speed=1.2, stop=4.0):
    """The package's own gait, from standing: `scenarios.acting`."""
    from halfphysics.scenarios.acting.gait import Walk
    from halfphysics.scenarios.acting.gait import walk as gait

    return gait(BODY, Walk(distance=stop, speed=speed), fps)[:frames]


def room(**statics):
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    for name, (shape, position) in statics.items():
        scene.add_static(name, shape, position=position)
    return scene


WALL = {"wall": (hp.Box((0.1, 4.0, 2.5)), (1.6, 0.0, 1.25))}


def forces(result):
    """Net force of everything but the floor on the person (T, 3) [N]."""
    contacts = result.contacts
    row = contacts.other != result.names.index("floor")
    total = np.zeros((len(result), 3))
    np.add.at(total, contacts.frame[row], contacts.impulse[row] * result.fps)
    return total


def test_nothing_in_the_way_the_clock_is_that_of_the_frames():
    result = hp.simulate(walk(), room(), body=BODY, settings=STANDS_FIRM)
    assert np.array_equal(result.clock, np.arange(len(result)) / result.fps)


def test_who_walks_into_a_wall_waits_and_stands_still():
    result = hp.simulate(walk(), room(**WALL), body=BODY, settings=STANDS_FIRM)
    clock = result.clock
    assert (np.diff(clock) >= -1e-12).all()
    assert (np.diff(clock) <= 1.0 / result.fps + 1e-12).all()
    still = np.flatnonzero(np.diff(clock) < 1e-9)
    assert len(still) > 1.0 * result.fps  # it waits for three seconds at most, of five
    feet = [hp.JOINT_NAMES.index(f"{side}_ankle") for side in ("left", "right")]
    moved = np.linalg.norm(np.diff(BODY.joints(result.motion)[:, feet], axis=0), axis=2).max(axis=1)
    # Both feet are put down, step as the first blow moves the body, and then stand.
    slid = hp.metrics.stance_slide(result).slide[still]
    assert np.nanmean(slid) < 1e-3  # [m] a frame
    assert np.median(moved[still]) < 1e-3
    assert moved[still][-10:].max() < 3e-4
    low = BODY.vertices(result.motion[-1])
    bone = BODY.weights.argmax(axis=1)
    for foot in feet:
        assert low[bone == foot, 2].min() < 0.02  # also the one that was in the air
    assert np.abs(forces(result)[still]).max() < 400.0  # as it comes to lean on the wall
    assert np.linalg.norm(forces(result)[still].mean(axis=0)) < 100.0


@pytest.mark.parametrize("x", [1.5, 1.55, 1.6, 1.65, 1.7, 1.75])
def test_a_clock_that_slows_down_throws_nobody_back(x):
    """A walker whom a wall stops keeps what momentum the wall has left it, and steps back a little.

    With the clock's loss of velocity taken from the body as well: 0.38 m, at 1.4 m/s, with nothing
    that pushed.
    """
    result = hp.simulate(
        walk(), room(wall=(WALL["wall"][0], (x, 0.0, 1.25))), body=BODY, settings=STANDS_FIRM
    )
    way = result.motion.translation[:, 0]
    assert (np.maximum.accumulate(way) - way).max() < 0.15
    back = -np.diff(way).min() * result.fps
    assert back < 0.7  # [m/s]; it walked at 1.2


@pytest.mark.parametrize("x", [1.6, 1.8, 2.0])
def test_who_goes_on_against_a_wall_is_not_thrown_back(x):
    """Past its patience and round: what the way back to the path loses of its speed pushes nobody.

    With the reference's change of velocity given to the body: 0.4 to 1.6 m, at 1.5 to 3 m/s,
    with nothing that pushed.
    """
    result = hp.simulate(
        walk(frames=255, stop=9.0),
        room(wall=(WALL["wall"][0], (x, 0.0, 1.25))),
        body=BODY,
        settings=STANDS_FIRM,
    )
    assert result.clock[-1] < len(result) / result.fps - 3.0  # it has waited, and has gone on
    assert np.diff(result.clock)[-15:].min() > 0.9 / result.fps
    way = result.motion.translation[:, 0]
    assert (np.maximum.accumulate(way) - way).max() < 0.3
    back = -np.diff(way).min() * result.fps
    assert back < 1.0  # [m/s]
    beside = forces(result)[np.linalg.norm(forces(result), axis=1) > 0.0]
    assert np.linalg.norm(beside, axis=1).mean() < 400.0


def test_a_state_saved_while_going_round_a_wall_resumes_to_the_bit():
    motion = walk(frames=200, stop=9.0)
    simulator = hp.Simulator(room(**WALL), body=BODY, fps=motion.fps)
    simulator.reset(motion[0])
    for k in range(1, 190):
        simulator.step(motion[k])
    saved = simulator.get_state()

    def poses():
        frames = [simulator.step(motion[k]) for k in range(190, 200)]
        return np.array([frame.poses[0].translation for frame in frames])

    once = poses()
    simulator.set_state(saved)
    assert np.array_equal(poses(), once)


def test_continue_walks_on_the_spot_as_the_paper_does():
    settings = hp.Settings(blocked="continue")
    result = hp.simulate(walk(), room(**WALL), body=BODY, settings=settings)
    assert np.array_equal(result.clock, np.arange(len(result)) / result.fps)


@pytest.mark.parametrize(("mass", "moves"), [(20.0, True), (200.0, False)])
def test_a_person_pushes_what_its_feet_can(mass, moves):
    scene = room()
    scene.add_object(
        "box", hp.Box((0.5, 0.8, 1.2)), mass=mass, friction=0.3, position=(1.5, 0.0, 0.6)
    )
    result = hp.simulate(walk(), scene, body=BODY, settings=STANDS_FIRM)
    way = result.objects["box"].position[-1, 0] - 1.5
    if not moves:
        assert abs(way) < 0.02
        return
    # 59 N of friction, of 240 N that feet transmit: it walks its four metres, the box ahead.
    assert way > 2.85
    assert (walk().translation - result.motion.translation)[-1, 0] < 0.01


def test_saved_and_loaded_with_its_clock(tmp_path):
    result = hp.simulate(walk(90), room(**WALL), body=BODY, settings=STANDS_FIRM)
    result.save(tmp_path / "wait.npz")
    loaded = hp.Result.load(tmp_path / "wait.npz")
    assert np.array_equal(loaded.clock, result.clock)
    assert np.array_equal(loaded.people[0].corrected, result.people[0].corrected)
    assert loaded.settings == result.settings


LATE, LATEST, CATCH_UP = 10.0, 20.0, 1.25  # tuning::footing: kLate, kLatest, kCatchUp


def against_the_wall(times, stands, fps=15.0):
    """Into a wall and back, so many times, and then so many frames of standing."""
    motion = walk(frames=1000, fps=fps, stop=3.0)
    there = np.arange(len(motion))
    every = np.r_[np.tile(np.r_[there, there[-2:0:-1]], times), np.zeros(stands, dtype=int)]
    return hp.Motion(motion.translation[every], motion.rotations[every], fps)


def test_who_is_blocked_again_and_again_is_late_by_a_bounded_time():
    """And comes back in time where nothing is in the way: no pose is left out."""
    result = hp.simulate(against_the_wall(9, 450), room(**WALL), body=BODY)
    lag = np.arange(len(result)) / result.fps - result.clock
    assert LATEST - 1.0 < lag.max() <= LATEST + 1e-9
    rate = np.diff(result.clock) * result.fps
    assert rate.min() > -1e-9
    assert rate.max() == pytest.approx(CATCH_UP)
    assert np.diff(lag[-150:]) == pytest.approx((1.0 - CATCH_UP) / result.fps)
    # Where it was on time it did not hurry: the clock is over 1 only where the lag is over kLate.
    assert lag[1:][rate > 1.0 + 1e-9].min() > LATE - 1.0


def test_the_state_of_an_endless_simulation_is_bounded():
    """Poses that wait: not more than kLatest of them, whatever is asked for how long."""
    motion = against_the_wall(9, 0)
    simulator = hp.Simulator(room(**WALL), body=BODY, fps=motion.fps)
    simulator.reset(motion[0])
    empty = len(simulator.get_state().numbers)
    for k in range(1, len(motion)):
        simulator.step(motion[k])
    waiting = len(simulator.get_state().numbers) - empty
    one = 8 * (simulator.world.nq + 1)  # a pose and its time [bytes]
    assert waiting < (LATEST * motion.fps + 2) * one + 50_000  # contacts of the moment: 20 kB
