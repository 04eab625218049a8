"""The face of PettingZoo: its test, two policies, mistakes."""

import numpy as np
import pytest
from pettingzoo.test import parallel_api_test

from halfphysics.envs import parallel_env
from halfphysics.envs.tasks import names
from halfphysics.errors import InputError


@pytest.mark.parametrize("task", names())
def test_pettingzoo_has_nothing_to_say(task):
    parallel_api_test(parallel_env(task, steps=25), num_cycles=40)


def test_the_human_is_moved_by_its_policy():
    env = parallel_env("HandOver", steps=20)
    seen, _ = env.reset(seed=2)
    start = seen["human"][:3]
    hold = {"robot": np.array([0.0, 0.0, 0.0, -1.0]), "human": np.array([0.3, 0.0, 0.8, -1.0])}
    while env.agents:
        seen, rewards, ended, late, infos = env.step(hold)
    assert late == {"robot": True, "human": True}
    assert not any(ended.values())
    assert set(rewards) == set(infos) == {"robot", "human"}
    assert seen["human"][2] - start[2] > 0.15  # it raised its hand


def test_the_same_seed_is_the_same_episode():
    def run():
        env = parallel_env("Corridor", steps=10)
        env.reset(seed=6)
        said = []
        while env.agents:
            told = {"robot": np.array([1.0, 0.2]), "human": np.array([0.6, -0.4])}
            seen = env.step(told)[0]
            said += [seen["robot"].tobytes(), seen["human"].tobytes()]
        return said

    assert run() == run()


def test_mistakes():
    env = parallel_env("Corridor", steps=5)
    with pytest.raises(InputError, match="call reset"):
        env.step({})
    env.reset(seed=0)
    with pytest.raises(InputError, match="found robot"):
        env.step({"robot": np.zeros(2)})
    with pytest.raises(InputError, match="step: action"):
        env.step({"robot": np.zeros(2), "human": np.zeros(3)})


@pytest.mark.parametrize("seed", [-1, 1.5, "one"])
def test_impossible_seeds(seed):
    with pytest.raises(InputError, match="seed: found"):
        parallel_env("Corridor").reset(seed=seed)
