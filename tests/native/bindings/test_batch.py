"""Jobs on the core's threads: what is taken too early, twice, or of nobody."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics import _native
from halfphysics.results.argument_checks import checked_scene, checked_settings
from halfphysics.simulation.build_world import build_world

#: Longest that a ball may take to fall, on the busiest machine [s].
PATIENCE = 60.0
#: Frames of a job that goes on for longer than anybody waits for here.
ENDLESS = 1_000_000


class Falling:
    """A ball that falls for a number of frames, and what a job of it takes."""

    def __init__(self, frames: int) -> None:
        scene = hp.Scene()
        scene.add_object("ball", hp.Sphere(0.1), mass=1.0, position=(0, 0, 5))
        self.world = build_world([], checked_scene(scene), checked_settings(None))
        self.qpos, self.qvel = self.world.start([])[:2]
        self.out = np.zeros((frames, self.world.nq))

    def submit(self, batch: _native.Batch, key: int, **other) -> None:
        arguments = {
            "qpos": self.qpos,
            "qvel": self.qvel,
            "lambda_": np.zeros(0),
            "targets": np.zeros((len(self.out), 0)),
            "stiffness": np.zeros((len(self.out), 0)),
        }
        RUNNING.append(self)
        batch.submit(
            key=key,
            stepper=self.world.stepper,
            **(arguments | other),
            dt=1 / 30,
            substeps=4,
            record=False,
            out=self.out,
        )


#: What the threads of a batch may be working on: the core takes arrays as they lie.
RUNNING: list[Falling] = []


@pytest.fixture
def batch():
    made = _native.Batch(1)
    yield made
    made.close()
    RUNNING.clear()


def test_a_job_is_taken_once_and_only_when_it_has_ended(batch):
    endless, short = Falling(ENDLESS), Falling(3)
    short.submit(batch, 2)
    endless.submit(batch, 1)  # after the other: there is one thread
    assert batch.ended(PATIENCE) == [2]
    for key in (1, 3):
        with pytest.raises(ValueError, match="no such job, or it goes on"):
            batch.take(key)
    assert batch.take(2)["frames"] == 3
    assert (np.diff(short.out[:, 2]) < 0.0).all()
    with pytest.raises(ValueError, match="no such job"):
        batch.take(2)
    assert batch.ended(0.0) == []


def test_a_key_is_of_one_job_and_none_comes_after_the_end(batch):
    balls = [Falling(ENDLESS), Falling(2)]
    balls[0].submit(batch, 1)
    with pytest.raises(ValueError, match="known already"):
        balls[1].submit(batch, 1)
    batch.close()
    with pytest.raises(ValueError, match="the batch is closed"):
        balls[1].submit(batch, 2)


@pytest.mark.parametrize("wrong", [{"qpos": np.zeros(3)}, {"lambda_": np.zeros(55)}])
def test_arrays_of_another_length_are_refused(batch, wrong):
    with pytest.raises(ValueError, match="submit: bad length"):
        Falling(2).submit(batch, 1, **wrong)
    assert batch.ended(0.0) == []


def test_a_batch_has_threads():
    with pytest.raises(ValueError, match="at least one thread"):
        _native.Batch(0)
