"""Tasks for stable-baselines3: a `VecEnv` of one native batched step (extra `ppo`)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.machine import cores
from halfphysics.base.optional_package import optional
from halfphysics.envs.channels import checked_actions
from halfphysics.envs.pictures import picture
from halfphysics.envs.task import checked_seed
from halfphysics.envs.tasks import task_class
from halfphysics.errors import InputError

_vec_env = optional("stable_baselines3.common.vec_env", "learners of stable-baselines3", "ppo")
_VecEnv: Any = _vec_env.VecEnv


class StableVecEnv(_VecEnv):  # type: ignore[misc]
    """N episodes of a task as stable-baselines3 wants them: episodes begin again at once.

    `infos` have "episode" (sum of rewards "r", length "l", "success") at the end of each, as its
    `VecMonitor` writes them.

    Args:
        task: Its name, such as "Corridor".
        num_envs: N.
        threads: Number of threads; None: one per core.
        seed: Of the first episode; the i-th has seed + i.
        steps: Longest episode; None: the task's own.

    Raises:
        InputError: A task that there is not, an impossible number.
    """

    def __init__(
        self,
        task: str,
        num_envs: int,
        *,
        threads: int | None = None,
        seed: int = 0,
        steps: int | None = None,
    ) -> None:
        count = cores() if threads is None else threads
        self.task = task_class(task)(num_envs, threads=count, steps=steps)
        num_envs = self.task.count
        self.render_mode = "rgb_array"
        self._sums = np.zeros(num_envs)
        super().__init__(num_envs, self.task.observed.space(), self.task.actions.space())
        self.seed(seed)

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        """Seeds of all episodes from the next `reset` on.

        Raises:
            InputError: A seed that is no whole number from 0 on.
        """
        if seed is not None:
            seed = checked_seed(seed)
            for i in range(self.num_envs):
                self.task.seed(i, seed + i)
        return [None if seed is None else seed + i for i in range(self.num_envs)]

    def reset(self) -> NDArray[np.float32]:
        """Begin all episodes."""
        for i in range(self.num_envs):
            self.task.begin(i)
        self._sums[:] = 0.0
        return self.task.observe()

    def step_async(self, actions: Any) -> None:
        """Take the actions (N, A) of the next `step_wait`.

        Raises:
            InputError: Before `reset`, actions of another shape, what is no finite number.
        """
        if self.task.over.any():
            raise InputError("step: the episodes have not begun; call reset() first")
        self._given = checked_actions(actions, (self.num_envs, self.task.actions.size))

    def step_wait(
        self,
    ) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.bool_], list[dict[str, Any]]]:
        """One step of all episodes; those that end begin again."""
        task = self.task
        outcome, late = task.step(self._given)
        self._sums += outcome.reward
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        over = task.over.copy()
        if over.any():
            last, lengths = task.observe(), np.rint(task.time * task.fps).astype(int)
            for i in np.flatnonzero(over):
                infos[i] = {
                    "terminal_observation": last[i],
                    "TimeLimit.truncated": bool(late[i]),
                    "episode": {
                        "r": float(self._sums[i]),
                        "l": int(lengths[i]),
                        "success": float(outcome.info["success"][i]),
                    },
                }
                self._sums[i] = 0.0
                task.begin(int(i))
        return task.observe(), outcome.reward.astype(np.float32), over, infos

    def get_images(self) -> Sequence[NDArray[np.uint8] | None]:
        """Pictures (H, W, 3) of all episodes."""
        return [picture(self.task, i) for i in range(self.num_envs)]

    def close(self) -> None:
        """Nothing is left open."""

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """An attribute of the task, once for each episode asked for."""
        of = self if attr_name == "render_mode" else self.task
        return [getattr(of, attr_name)] * len(list(self._get_indices(indices)))

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Raises `AttributeError`: episodes have no attributes of their own."""
        raise AttributeError(f"episodes have no attribute {attr_name!r} of their own to set")

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any) -> Any:
        """Raises `AttributeError`: episodes have no methods of their own."""
        raise AttributeError(f"episodes have no method {method_name!r} of their own")

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        """No episode is wrapped."""
        return [False] * len(list(self._get_indices(indices)))
