"""Policies without learning, for every task: by chance, and scripted by hand; and their scores.

A policy takes the observations of N robots (N, O), as docs/envs.md has them, and gives their
actions (N, A).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.base.suggestions import did_you_mean
from halfphysics.base.validation import is_whole, shown
from halfphysics.envs.channels import checked_actions
from halfphysics.envs.task import checked_seed
from halfphysics.envs.tasks import task_class
from halfphysics.errors import InputError

Array = NDArray[np.float64]
Policy = Callable[[NDArray[np.float32]], ArrayLike]


def random(task: str, seed: int = 0) -> Policy:
    """Actions by chance, each uniform over its range.

    Raises:
        InputError: A task that there is not, a seed that is no whole number from 0 on.
    """
    actions, chance = task_class(task).actions, np.random.default_rng(checked_seed(seed))

    def policy(seen: NDArray[np.float32]) -> Array:
        return chance.uniform(actions.low, actions.high, (len(seen), actions.size))

    return policy


def scripted(task: str) -> Policy:
    """What a person would write by hand for a task.

    Raises:
        InputError: A task that there is not.
    """
    task_class(task)
    if task not in _SCRIPTS:
        raise InputError(
            f"scripted: found {shown(task)}{did_you_mean(task, list(_SCRIPTS), form=repr)}"
        )
    return _SCRIPTS[task]


@dataclass(frozen=True)
class Score:
    """How a policy did.

    Attributes:
        episodes: Number of episodes.
        mean: Sum of rewards of an episode, mean.
        spread: Standard deviation of that.
        success: Part of the episodes that ended well, 0 to 1.
        length: Steps of an episode, mean.
    """

    episodes: int
    mean: float
    spread: float
    success: float
    length: float

    def __str__(self) -> str:
        return (
            f"{self.mean:.2f} (spread {self.spread:.2f}), success {100.0 * self.success:.0f} %, "
            f"{self.length:.0f} steps, {self.episodes} episodes"
        )


def score(
    task: str,
    policy: Policy,
    *,
    episodes: int = 64,
    seed: int = 1000,
    worlds: int = 16,
    threads: int = 1,
) -> Score:
    """The score of a policy over episodes of seeds `seed` to `seed` + `episodes` - 1.

    Args:
        task: Its name.
        policy: From observations (N, O) to actions (N, A).
        episodes: Number of episodes.
        seed: Of the first one.
        worlds: Episodes side by side; no score of a policy that treats rows alike depends on it.
        threads: Number of threads; no number depends on it.

    Raises:
        InputError: An impossible number, a task that there is not, actions of another shape or
            that are not finite.
    """
    for name, value in (("episodes", episodes), ("worlds", worlds)):
        if not is_whole(value, least=1, plain=False):
            raise InputError(f"{name}: found {shown(value)}, expected a whole number from 1 on")
    seed, episodes, count = checked_seed(seed), int(episodes), int(min(worlds, episodes))
    run = task_class(task)(count, threads=threads)
    which = np.arange(count)
    sums, lengths, won = np.zeros(episodes), np.zeros(episodes), np.zeros(episodes)
    for i in range(count):
        run.seed(i, seed + i)
        run.begin(i)
    following = count
    while not run.over.all():
        active = ~run.over
        given = policy(run.observe())
        outcome, _ = run.step(checked_actions(given, (count, run.actions.size), "policy: actions"))
        sums[which[active]] += outcome.reward[active]
        lengths[which[active]] += 1
        for i in map(int, np.flatnonzero(run.over & active)):
            won[which[i]] = outcome.info["success"][i]
            if following < episodes:
                which[i] = following
                run.seed(i, seed + following)
                run.begin(i)
                following += 1
    return Score(
        episodes, float(sums.mean()), float(sums.std()), float(won.mean()), float(lengths.mean())
    )


# -- scripts ---------------------------------------------------------------------------------


def _hand_over(seen: NDArray[np.float32]) -> Array:
    """To the comfortable place, slowly at the end; wait; open; draw back."""
    opening, to_place = seen[:, 8].astype(float), seen[:, 24:27].astype(float)
    held = seen[:, 27] > 0.5
    away = held & (opening > 0.047)
    velocity = np.where(held[:, None], 0.0, 3.0 * to_place / 0.8)
    velocity = np.where(away[:, None], [0.5, 0.0, 0.2], velocity)
    size = np.sqrt(np.sum(velocity * velocity, axis=1))
    velocity = velocity * np.minimum(1.0, 0.5 / np.maximum(size, 1e-9))[:, None]
    return np.concatenate([velocity, np.where(held, 1.0, -1.0)[:, None]], axis=1)


def _corridor(seen: NDArray[np.float32]) -> Array:
    """Along the corridor, past the person on the side that has more room."""
    s = seen.astype(float)
    goal, heading = s[:, 0:2], np.arctan2(s[:, 3], s[:, 2])
    y = s[:, 4]
    c, sn = np.cos(heading), np.sin(heading)
    ahead = c * s[:, 8] - sn * s[:, 9]
    beside = sn * s[:, 8] + c * s[:, 9]
    near = (ahead > -0.4) & (ahead < 3.0)
    side = np.where(beside <= -0.15, 1.0, -1.0)
    lane = np.where(near, np.clip(y + beside + side, -0.8, 0.8), 0.0)
    to_goal = np.stack([c * goal[:, 0] - sn * goal[:, 1], sn * goal[:, 0] + c * goal[:, 1]], axis=1)
    way = np.stack([np.full(len(s), 0.9), lane - y], axis=1)
    way = np.where(np.abs(to_goal[:, :1]) < 1.0, to_goal, way)
    turn = (np.arctan2(way[:, 1], way[:, 0]) - heading + np.pi) % (2.0 * np.pi) - np.pi
    speed = 0.9 * np.cos(np.clip(turn, -1.5, 1.5))
    return np.stack([speed, np.clip(turn, -1.0, 1.0)], axis=1)


def _held_door(seen: NDArray[np.float32]) -> Array:
    """Pulls the door along its arc, the fork around the handle: open when a person comes who faces
    it, shut again once the person is clear of it."""
    s = seen.astype(float)
    opening, off, heading = s[:, 0], s[:, 2:4], np.arctan2(s[:, 5], s[:, 4])
    before, faces = s[:, 11], s[:, 14] > 0.7
    comes = (before > -2.2) & (before < 1.5) & (faces | (before > -0.4))
    wanted = np.where(comes, 1.45, 0.0)
    rate = np.clip(2.0 * (wanted - opening), -0.7, 0.7)
    # The fork's arc about the hinge, in the robot's frame, and back to the handle where it is off.
    velocity = rate[:, None] * [-0.78, -0.53] + 3.0 * off
    turn = rate + 2.0 * np.sin(opening - heading)
    out: Array = np.clip(np.concatenate([velocity / 0.6, turn[:, None]], axis=1), -1.0, 1.0)
    return out


_SCRIPTS: dict[str, Policy] = {
    "HandOver": _hand_over,
    "Corridor": _corridor,
    "HeldDoor": _held_door,
}
