"""Robot and person both moved by policies: the face of PettingZoo."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.optional_package import optional
from halfphysics.envs.channels import checked_actions
from halfphysics.envs.pictures import SIZE, checked_size, picture
from halfphysics.envs.single import checked_render_mode
from halfphysics.envs.tasks import task_class
from halfphysics.errors import InputError

_Env: Any = optional("pettingzoo", "environments of several agents", "rl").ParallelEnv

#: The agents of every task.
AGENTS = ("robot", "human")


class ParallelEnv(_Env):  # type: ignore[misc]
    """A task as a `pettingzoo.ParallelEnv` with the agents "robot" and "human".

    Args:
        task: Its name, such as "HandOver".
        render_mode, steps, size: As for a single environment.

    Raises:
        InputError: A task or render mode that there is not, an impossible number or size.
    """

    metadata: dict[str, Any] = {  # noqa: RUF012 - an instance has its own
        "render_modes": ["rgb_array"],
        "render_fps": 30,
    }

    def __init__(
        self,
        task: str,
        *,
        render_mode: str | None = None,
        steps: int | None = None,
        size: tuple[int, int] = SIZE,
    ) -> None:
        self.render_mode = checked_render_mode(render_mode)
        self.size = checked_size(size)
        self.task = task_class(task)(1, steps=steps)
        self.metadata = {**type(self).metadata, "name": f"halfphysics_{task}"}
        self.possible_agents = list(AGENTS)
        self.agents: list[str] = []
        self.observation_spaces = {
            "robot": self.task.observed.space(),
            "human": self.task.human_observed.space(),
        }
        self.action_spaces = {
            "robot": self.task.actions.space(),
            "human": self.task.human_actions.space(),
        }
        self._seeded = False

    def observation_space(self, agent: str) -> Any:
        """The space of what an agent observes."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> Any:
        """The space of an agent's actions."""
        return self.action_spaces[agent]

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, NDArray[np.float32]], dict[str, dict[str, Any]]]:
        """Begin an episode; the same seed begins the same one. `options` change nothing.

        Raises:
            InputError: A seed that is no whole number from 0 on.
        """
        if seed is not None:
            self.task.seed(0, seed)
        elif not self._seeded:
            self.task.seed(0, int(np.random.default_rng().integers(2**31)))
        self._seeded = True
        self.task.begin(0)
        self.agents = list(AGENTS)
        return self._observed(), {agent: {} for agent in AGENTS}

    def step(
        self, actions: Mapping[str, Any]
    ) -> tuple[
        dict[str, NDArray[np.float32]],
        dict[str, float],
        dict[str, bool],
        dict[str, bool],
        dict[str, dict[str, Any]],
    ]:
        """One step of both.

        Raises:
            InputError: Before `reset`, after the end of an episode, without an agent's action.
        """
        if not self.agents:
            raise InputError("step: the episode is over, or has not begun; call reset() first")
        missing = [agent for agent in AGENTS if agent not in actions]
        if missing:
            raise InputError(
                f"step: actions: found {', '.join(map(str, actions)) or 'none'}, expected one of "
                f"{' and one of '.join(AGENTS)}"
            )
        task = self.task
        acts = checked_actions(actions["robot"], (task.actions.size,))
        told = checked_actions(actions["human"], (task.human_actions.size,))
        outcome, late = task.step(acts[None], told[None])
        info = {name: float(values[0]) for name, values in outcome.info.items()}
        if task.over[0]:
            self.agents = []
        return (
            self._observed(),
            {"robot": float(outcome.reward[0]), "human": float(outcome.human_reward[0])},
            {agent: bool(outcome.ended[0]) for agent in AGENTS},
            {agent: bool(late[0]) for agent in AGENTS},
            {agent: dict(info) for agent in AGENTS},
        )

    def render(self) -> NDArray[np.uint8] | None:
        """A picture (H, W, 3) of the episode as it is now; None without a render mode."""
        return picture(self.task, 0, self.size) if self.render_mode == "rgb_array" else None

    def close(self) -> None:
        """Nothing is left open."""

    def _observed(self) -> dict[str, NDArray[np.float32]]:
        return {"robot": self.task.observe()[0], "human": self.task.observe_human()[0]}
