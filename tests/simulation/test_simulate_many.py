"""Many motions at once give what `simulate` gives, in their order, with any number of threads."""

from __future__ import annotations

import dataclasses
import warnings

import numpy as np
import pytest

import halfphysics as hp
from halfphysics import scenarios
from support.as_it_is import as_it_is
from support.results.bits import bits

#: What meets what: a person and a wall, an object in two hands, a drawer, two people, a bed.
STORIES = ["walk_into_wall", "lift_suitcase", "open_drawer", "shake_hands", "sit_on_bed"]
FRAMES = 25


def cut(story):
    motions = tuple(motion[:FRAMES] for motion in story.motions)
    return dataclasses.replace(story, motion=motions)


@pytest.fixture(scope="module")
def stories():
    return [cut(scenarios.load(name)) for name in STORIES]


@pytest.fixture(scope="module")
def one_by_one(stories):
    return [
        bits(hp.simulate(list(s.motions), s.scene, body=list(s.bodies), settings=s.settings))
        for s in stories
    ]


@pytest.mark.parametrize("threads", [1, 2, 4, 7])
def test_the_bits_of_simulate(stories, one_by_one, threads):
    order = np.random.default_rng(threads).permutation(2 * len(stories)) % len(stories)
    results = hp.simulate_many([stories[i] for i in order], threads=threads)
    assert [bits(result) for result in results] == [one_by_one[i] for i in order]


def test_jobs_that_share_a_mesh():
    """Its tree is one for all threads; people are kept out of themselves, and skinned."""
    walk = scenarios.load("walk_into_wall").motion[:FRAMES]
    rng = np.random.default_rng(2)
    lumps = rng.uniform((0.2, -1.0, 0.0), (0.6, 1.0, 2.0), size=(60, 1, 3))
    corners = (lumps + rng.normal(scale=0.05, size=(60, 3, 3))).reshape(-1, 3)
    scene = hp.Scene()
    scene.add_static("lumps", hp.Mesh(corners, np.arange(180).reshape(-1, 3)))
    jobs = [walk[k:] for k in range(6)]
    settings = [hp.Settings(self_contact=k % 2 == 0) for k in range(6)]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        alone = [hp.simulate(m, scene, settings=s) for m, s in zip(jobs, settings, strict=True)]
        many = hp.simulate_many(jobs, scene, settings=settings, threads=4)
    assert any(len(result.contacts.part) for result in alone)
    assert [bits(result) for result in many] == [bits(result) for result in alone]


def test_arguments_for_all_and_for_each():
    walk = scenarios.load("walk_into_wall").motion[:FRAMES]
    wall = scenarios.load("walk_into_wall").scene
    over_time = np.linspace(0.5, 2.0, FRAMES)
    limp, firm = hp.Settings(stiffness=0.2), hp.Settings(record="substeps")
    tall = hp.Body.default(stature=1.85)
    beside = walk.with_frames(walk.translation + np.array([0.0, 2.0, 0.0]), walk.rotations)
    pair = [hp.Body.default(), hp.Body.default(stature=1.7)]
    mine = hp.simulate_many(
        [walk, [walk, beside]],
        [None, wall],
        body=[tall, pair],
        settings=[limp, firm],
        stiffness=[over_time, None],
        threads=2,
    )
    theirs = [
        hp.simulate(walk, body=tall, settings=limp, stiffness=over_time),
        hp.simulate([walk, beside], wall, body=pair, settings=firm),
    ]
    assert [bits(r) for r in mine] == [bits(r) for r in theirs]
    assert mine[1].scene is wall
    assert mine[1].settings is firm
    assert len(mine[1].substeps.motions[0]) == len(theirs[1].substeps.motions[0])
    shared = hp.simulate_many((walk, walk), wall, settings=limp, stiffness=3.0)
    assert len({bits(r) for r in shared}) == 1
    assert bits(shared[0]) == bits(hp.simulate(walk, wall, settings=limp, stiffness=3.0))


def test_a_motion_brings_its_own_firmness():
    """As factors on the settings': by `simulate`, `simulate_many` and step by step, equal bits."""
    walk = scenarios.load("walk_into_wall").motion[::2]
    wall = scenarios.load("walk_into_wall").scene
    settings = hp.Settings(stiffness=0.5)
    scale = np.random.default_rng(0).uniform(0.5, 8.0, (len(walk), 55))
    tensed = dataclasses.replace(walk, stiffness_scale=scale)
    expected = hp.simulate(walk, wall, settings=settings, stiffness=0.5 * scale)
    assert len(expected.contacts.part)
    got = hp.simulate(tensed, wall, settings=settings)
    many = hp.simulate_many([tensed, tensed], wall, settings=settings, threads=2)
    assert [bits(r) for r in (got, *many)] == [bits(expected)] * 3
    assert bits(hp.simulate(walk, wall, settings=settings)) != bits(expected)
    assert bits(hp.simulate(tensed, wall, settings=settings, stiffness=2.0)) == bits(
        hp.simulate(walk, wall, settings=settings, stiffness=2.0)
    )
    simulator = hp.Simulator(wall, settings=settings, fps=walk.fps)
    simulator.reset(tensed[0])
    for t in range(1, len(walk)):
        pose = simulator.step(tensed[t]).pose
        assert np.array_equal(pose.rotations, expected.people[0].motion.rotations[t])
    # Between frames it is as firm as it is without a scale.
    plain = hp.Simulator(wall, settings=settings, fps=walk.fps)
    plain.set_state(simulator.get_state())
    last = simulator.step(walk[-1]).pose
    assert np.array_equal(last.rotations, plain.step(walk[-1]).pose.rotations)


def test_baselines_of_another_engine():
    walk = scenarios.load("walk_into_wall").motion[:FRAMES]
    settings = [hp.baselines.EngineKinematic(), hp.baselines.Kinematic(), None]
    mine = hp.simulate_many([walk] * 3, settings=settings)
    assert [bits(r) for r in mine] == [bits(hp.simulate(walk, settings=s)) for s in settings]


def test_nothing_to_do():
    assert hp.simulate_many([]) == []
    assert hp.simulate_many([], threads=np.int64(2)) == []


def test_what_fails_is_named():
    walk = scenarios.load("walk_into_wall").motion[:FRAMES]
    jobs = [walk, walk, [walk, walk[:10]], walk]
    with pytest.raises(hp.errors.InputError, match=r"^jobs\[2\]: motion: person 1 has 10 frames"):
        hp.simulate_many(jobs)
    came = hp.simulate_many(jobs, errors="return")
    assert [isinstance(one, hp.Result) for one in came] == [True, True, False, True]
    assert isinstance(came[2], hp.errors.InputError)
    assert bits(came[3]) == bits(hp.simulate(walk))


class Broken(hp.Scene):
    @property
    def statics(self):
        raise RuntimeError("no statics today")


def test_other_errors_have_a_note():
    walk = scenarios.load("walk_into_wall").motion[:FRAMES]
    with pytest.raises(RuntimeError, match="no statics today") as raised:
        hp.simulate_many([walk, walk], [None, Broken()])
    assert raised.value.__notes__ == ["in jobs[1] of simulate_many"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"jobs": scenarios.load("walk_into_wall").motion}, "jobs: found Motion"),
        ({"jobs": 3}, "jobs: found 3, expected a list"),
        ({"jobs": [], "threads": 0}, "threads: found 0, expected a whole number"),
        ({"jobs": [], "errors": "ignore"}, "errors: found 'ignore', expected 'raise' or"),
        ({"jobs": [None], "scenes": []}, "scenes: found 0 for 1 jobs"),
        ({"jobs": [None]}, r"jobs\[0\]: motion: found None"),
    ],
)
def test_impossible_arguments(arguments, words):
    with pytest.raises(hp.errors.InputError, match=words):
        hp.simulate_many(**arguments)


def test_warnings_name_the_job_and_the_caller():
    walk = scenarios.load("walk_into_wall").motion[:FRAMES]
    sunken = hp.Scene()
    sunken.add_static("floor", hp.Plane(offset=0.1))
    with pytest.warns(hp.HalfPhysicsWarning, match=r"^jobs\[1\]: the start is not clear") as found:
        hp.simulate_many([walk, walk], [None, sunken], settings=as_it_is())
    assert [warning.filename for warning in found] == [__file__]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        came = hp.simulate_many([walk, walk], [None, sunken], settings=as_it_is(), errors="return")
    assert isinstance(came[1], hp.HalfPhysicsWarning)


def test_an_interrupt_ends_the_threads(monkeypatch):
    walk = scenarios.load("walk_into_wall").motion
    from halfphysics.simulation import simulate_many as module

    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(module, "recorded_result", interrupted)
    with pytest.raises(KeyboardInterrupt):
        hp.simulate_many([walk] * 8, scenarios.load("walk_into_wall").scene, threads=2)


def test_a_walker_who_is_behind_at_the_end_was_not_at_the_start():
    """Its clock and corrections are those of `simulate`, the first frame's too."""
    story = scenarios.load("walk_into_wall")
    motion = story.motion[:80]
    one = hp.simulate(motion, story.scene, body=story.body)
    (many,) = hp.simulate_many([motion], story.scene, body=story.body)
    assert one.people[0].clock[-1] < 79 / motion.fps - 0.1  # it is blocked
    np.testing.assert_array_equal(many.people[0].clock, one.people[0].clock)
    np.testing.assert_array_equal(many.people[0].corrected, one.people[0].corrected)
