"""A task: N episodes side by side, each with a world, a robot, a person and a generator of its own.

The faces of gymnasium and PettingZoo (`single`, `vector`, `parallel`) are thin: all they return is
made here. No number of an episode depends on the others: the same seed gives the same bytes alone
and among many.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.validation import is_whole, shown
from halfphysics.envs.channels import Layout
from halfphysics.envs.worlds import Plan, Worlds
from halfphysics.errors import InputError
from halfphysics.settings import Settings

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class Outcome:
    """What came of one step, of every episode.

    Attributes:
        reward: The robot's (N,).
        human_reward: The person's, where a policy moves it (N,).
        ended: The episode is over (N,).
        info: Name -> numbers (N,): the terms of the reward, and how it ended.
    """

    reward: Array
    human_reward: Array
    ended: Flags
    info: Mapping[str, Array]


@dataclass(frozen=True)
class View:
    """The camera of a task's pictures: where it is and what it looks at, (3,) [m]."""

    position: tuple[float, float, float]
    target: tuple[float, float, float]
    fov: float = 40.0


@dataclass
class Counts:
    """Of every episode: steps so far, and whether it needs to begin again."""

    steps: NDArray[np.int64]
    over: Flags = field(init=False)

    def __post_init__(self) -> None:
        self.over = np.ones(len(self.steps), dtype=bool)


def checked_seed(seed: Any) -> int:
    """A seed as an int.

    Raises:
        InputError: No whole number from 0 on.
    """
    if not is_whole(seed, least=0, plain=False):
        raise InputError(f"seed: found {shown(seed)}, expected a whole number from 0 on")
    return int(seed)


class Task(ABC):
    """N episodes of one task.

    Class attributes: `fps` steps per second; `steps` of the longest episode; `observed`, `actions`
    of the robot; `human_observed`, `human_actions` of the person; `view` of pictures; `rewards`
    the terms of the robot's reward, in words.

    Args:
        count: N.
        threads: Number of threads; no number depends on it.
        steps: Longest episode; None: the task's own.

    Raises:
        InputError: An impossible number.
    """

    fps: ClassVar[int] = 30
    steps: int
    observed: ClassVar[Layout]
    actions: ClassVar[Layout]
    human_observed: ClassVar[Layout]
    human_actions: ClassVar[Layout]
    view: ClassVar[View]
    rewards: ClassVar[Mapping[str, str]]

    def __init__(self, count: int, *, threads: int = 1, steps: int | None = None) -> None:
        steps = type(self).steps if steps is None else steps
        for name, value in (("num_envs", count), ("threads", threads), ("steps", steps)):
            if not is_whole(value, least=1, plain=False):
                raise InputError(f"{name}: found {shown(value)}, expected a whole number from 1 on")
        self.count, self.steps = int(count), int(steps)
        self.worlds = Worlds(
            self.plan(),
            self.count,
            dt=1.0 / self.fps,
            settings=self.settings(),
            threads=int(threads),
        )
        self._episodes = Counts(np.zeros(self.count, dtype=np.int64))
        self._chance = [np.random.default_rng(i) for i in range(self.count)]
        self.prepare()

    # -- what the faces call ---------------------------------------------------------------

    @property
    def over(self) -> Flags:
        """Episodes that have to begin again (N,)."""
        return self._episodes.over

    @property
    def time(self) -> Array:
        """Seconds since the episodes began (N,)."""
        seconds: Array = self._episodes.steps / self.fps
        return seconds

    def seed(self, i: int, seed: int) -> None:
        """All chance of episode `i` comes from this seed from now on.

        Raises:
            InputError: A seed that is no whole number from 0 on.
        """
        self._chance[i] = np.random.default_rng(checked_seed(seed))

    def begin(self, i: int) -> None:
        """Begin episode `i` again."""
        self._episodes.steps[i] = 0
        self._episodes.over[i] = False
        self.start(i, self._chance[i])

    def step(self, actions: Any, commands: Any = None) -> tuple[Outcome, Flags]:
        """One step of all episodes that are not over.

        Args:
            actions: Of the robots (N, A), in their ranges.
            commands: Of the people (N, H); None: they act by themselves.

        Returns:
            The outcome, and which episodes have reached their last step (N,).
        """
        active = ~self._episodes.over
        acts = self.actions.checked(actions)
        told = self.human() if commands is None else self.human_actions.checked(commands)
        targets, rests = self.act(acts, told, active)
        self.worlds.step(targets, rests, active)
        self._episodes.steps[active] += 1
        outcome = self.judge(active)
        late = active & (self._episodes.steps >= self.steps) & ~outcome.ended
        self._episodes.over |= (outcome.ended & active) | late
        return outcome, late

    # -- what a task defines ---------------------------------------------------------------

    @abstractmethod
    def plan(self) -> Plan:
        """What is in every world."""

    def settings(self) -> Settings:
        """Of the simulations."""
        return Settings()

    @abstractmethod
    def prepare(self) -> None:
        """Make the arrays of N episodes; the worlds are there."""

    @abstractmethod
    def start(self, i: int, chance: np.random.Generator) -> None:
        """Draw episode `i`, and start its world."""

    @abstractmethod
    def human(self) -> Array:
        """What people do who act by themselves (N, H), within `human_actions`."""

    @abstractmethod
    def act(self, actions: Array, commands: Array, active: Flags) -> tuple[Array, Array]:
        """Targets of the people (N, K) and rests of the motors (N, M) of the next frame; only
        active episodes change."""

    @abstractmethod
    def judge(self, active: Flags) -> Outcome:
        """What came of the frame."""

    @abstractmethod
    def observe(self) -> NDArray[np.float32]:
        """What the robots observe (N, O)."""

    @abstractmethod
    def observe_human(self) -> NDArray[np.float32]:
        """What the people observe (N, P)."""
