"""A robot learns to pass a person in a corridor: PPO of stable-baselines3, minutes on two cores.

Needs `pip install 'halfphysics[ppo]'`. Prints the scores of a policy by chance, of one written by
hand, and of PPO before and after; `halfphysics.envs.policies.score` says on the same episodes.

    python examples/08_learn_to_pass.py [STEPS]
"""

from __future__ import annotations

import sys
import time

from halfphysics.envs import policies
from halfphysics.envs.policies import Score

TASK = "Corridor"


def main(steps: int = 100_000, episodes: int = 64, worlds: int = 16) -> dict[str, Score]:
    """Name of a policy -> its score over episodes that nobody learned from."""
    import torch
    from stable_baselines3 import PPO
    from stable_baselines3.common.vec_env import VecNormalize

    from halfphysics.envs.stable_baselines import StableVecEnv

    torch.set_num_threads(1)
    env = VecNormalize(StableVecEnv(TASK, worlds, seed=0), gamma=0.97)
    model = PPO(
        "MlpPolicy",
        env,
        n_steps=64,
        batch_size=256,
        n_epochs=10,
        gamma=0.97,
        learning_rate=1e-3,
        policy_kwargs={"log_std_init": -0.5},
        seed=0,
        device="cpu",
    )

    def learned(seen):
        return model.predict(env.normalize_obs(seen), deterministic=True)[0]

    found = {}

    def say(name, policy):
        found[name] = policies.score(TASK, policy, episodes=episodes, worlds=worlds, threads=2)
        print(f"{name:12} {found[name]}", flush=True)

    say("by chance", policies.random(TASK))
    say("by hand", policies.scripted(TASK))
    say("PPO before", learned)
    begin = time.perf_counter()
    model.learn(steps)
    print(f"learned {model.num_timesteps} steps in {time.perf_counter() - begin:.0f} s")
    say("PPO after", learned)
    return found


if __name__ == "__main__":
    main(*map(int, sys.argv[1:2]))
