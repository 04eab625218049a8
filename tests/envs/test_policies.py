"""Policies without learning, and scores."""

import numpy as np
import pytest

from halfphysics.envs import policies
from halfphysics.envs.policies import score
from halfphysics.envs.tasks import names, task_class
from halfphysics.errors import InputError


@pytest.mark.parametrize("task", names())
def test_actions_are_in_their_ranges(task):
    made = task_class(task)
    seen = np.random.default_rng(3).uniform(
        made.observed.low, made.observed.high, (50, made.observed.size)
    )
    for policy in (policies.random(task, seed=2), policies.scripted(task)):
        actions = np.asarray(policy(seen.astype(np.float32)))
        assert actions.shape == (50, made.actions.size)
        assert (actions >= made.actions.low - 1e-12).all()
        assert (actions <= made.actions.high + 1e-12).all()


@pytest.mark.parametrize("task", names())
def test_no_row_of_a_script_depends_on_the_others(task):
    made, policy = task_class(task), policies.scripted(task)
    seen = np.random.default_rng(3).uniform(
        made.observed.low, made.observed.high, (9, made.observed.size)
    )
    seen = seen.astype(np.float32)
    assert np.array_equal(policy(seen)[4:5], policy(seen[4:5]))


def test_a_score_does_not_depend_on_what_is_side_by_side():
    given = {"episodes": 3, "seed": 50}
    one = score("HandOver", policies.scripted("HandOver"), worlds=1, **given)
    assert one == score("HandOver", policies.scripted("HandOver"), worlds=2, threads=2, **given)
    assert one.success == 1.0
    assert one.mean > 4.0
    assert "success 100 %" in str(one)


def test_chance_does_worse():
    given = {"episodes": 3, "seed": 50, "worlds": 3}
    assert score("HandOver", policies.random("HandOver"), **given).mean < 0.0


def test_mistakes():
    with pytest.raises(InputError, match="task: found"):
        policies.scripted("HandOvr")
    with pytest.raises(InputError, match="episodes: found 0"):
        score("HandOver", policies.random("HandOver"), episodes=0)


@pytest.mark.parametrize(
    ("actions", "words"),
    [
        (lambda n: np.zeros((n, 3)), r"(?s)policy: actions: found .*shape \(2, 4\)"),
        (lambda n: np.zeros(4), "policy: actions: found"),
        (lambda n: np.full((n, 4), np.nan), "expected finite numbers"),
        (lambda n: None, "policy: actions: found None"),
    ],
)
def test_policies_that_give_no_actions_have_no_score(actions, words):
    """Such as a network that has diverged: its NaN were scored as zeros."""
    with pytest.raises(InputError, match=words):
        score("HandOver", lambda seen: actions(len(seen)), episodes=2, worlds=2)


def test_numpys_whole_numbers_are_counts():
    policy, two = policies.scripted("HandOver"), np.int64(2)
    numbers = {"episodes": two, "seed": 0, "worlds": np.int32(1), "threads": np.uint8(1)}
    found = score("HandOver", policy, **numbers)
    assert found == score("HandOver", policy, episodes=2, seed=0, worlds=1)
    assert type(found.episodes) is int


@pytest.mark.parametrize("seed", [-1, 1.5, "one", None, True])
def test_impossible_seeds(seed):
    with pytest.raises(InputError, match="seed: found"):
        policies.random("HandOver", seed=seed)
    with pytest.raises(InputError, match="seed: found"):
        score("HandOver", policies.scripted("HandOver"), episodes=1, seed=seed)
    with pytest.raises(InputError, match="seed: found"):
        task_class("HandOver")(1).seed(0, seed)
