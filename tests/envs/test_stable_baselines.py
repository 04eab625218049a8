"""Tasks for stable-baselines3, where it is installed: it needs torch, which no test brings."""

import numpy as np
import pytest

pytest.importorskip("stable_baselines3")

from halfphysics.envs.stable_baselines import StableVecEnv
from halfphysics.errors import InputError


def test_episodes_begin_again_at_once():
    env = StableVecEnv("HandOver", 2, threads=1, seed=3, steps=4)
    first = env.reset()
    act = np.tile([0.0, 0.0, 0.0, -1.0], (2, 1))
    for k in range(4):
        seen, rewards, over, infos = env.step(act)
        assert over.tolist() == [k == 3] * 2
    assert infos[0]["TimeLimit.truncated"]
    assert infos[0]["terminal_observation"][-1] == 1.0
    assert infos[0]["episode"]["l"] == 4
    assert seen[0, -1] == 0.0
    assert rewards.shape == (2,)
    env.seed(3)
    assert np.array_equal(env.reset(), first)


def test_ppo_learns_from_it():
    from stable_baselines3 import PPO

    env = StableVecEnv("HandOver", 2, threads=1, steps=8)
    model = PPO("MlpPolicy", env, n_steps=8, batch_size=16, n_epochs=1, device="cpu")
    model.learn(16)
    assert model.num_timesteps == 16


def test_mistakes():
    with pytest.raises(InputError, match="seed: found 'one'"):
        StableVecEnv("Corridor", 2, threads=1, seed="one")
    env = StableVecEnv("Corridor", 2, threads=1)
    with pytest.raises(InputError, match=r"call reset\(\) first"):
        env.step(np.zeros((2, 2)))
    env.reset()
    env.step(np.zeros((2, 2)))
