"""One episode at a time: the face of `gymnasium.make`."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.optional_package import optional
from halfphysics.base.validation import shown
from halfphysics.envs.channels import checked_actions
from halfphysics.envs.pictures import SIZE, checked_size, picture
from halfphysics.envs.task import checked_seed
from halfphysics.envs.tasks import task_class
from halfphysics.errors import InputError

_Env: Any = optional("gymnasium", "environments", "rl").Env

#: What `render_mode` can be.
RENDER_MODES = ("rgb_array",)


class SingleEnv(_Env):  # type: ignore[misc]
    """A task as a `gymnasium.Env`.

    Args:
        task: Its name, such as "HandOver".
        render_mode: "rgb_array": `render` gives a picture (H, W, 3); None: nothing.
        steps: Longest episode; None: the task's own.
        size: Width and height of pictures [pixels].

    Raises:
        InputError: A task or render mode that there is not, an impossible number or size.
    """

    metadata: ClassVar[dict[str, Any]] = {"render_modes": list(RENDER_MODES), "render_fps": 30}

    def __init__(
        self,
        task: str,
        *,
        render_mode: str | None = None,
        steps: int | None = None,
        size: tuple[int, int] = SIZE,
    ) -> None:
        self.render_mode = checked_render_mode(render_mode)
        self.size, self._seeded = checked_size(size), False
        self.task = task_class(task)(1, steps=steps)
        self.observation_space = self.task.observed.space()
        self.action_space = self.task.actions.space()

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begin an episode. The same seed begins the same one; without a seed chance goes on.

        `options` change nothing: no task has any.

        Raises:
            InputError: A seed that is no whole number from 0 on.
        """
        seed = None if seed is None else checked_seed(seed)
        super().reset(seed=seed)
        if seed is not None:
            self.task.seed(0, seed)
        elif not self._seeded:
            self.task.seed(0, int(self.np_random.integers(2**31)))
        self._seeded = True
        self.task.begin(0)
        return self.task.observe()[0], {}

    def step(self, action: Any) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """One step of 1/30 s; see docs/envs.md for what the numbers mean.

        Raises:
            InputError: Before `reset`, after the end of an episode, an action of another shape.
        """
        given = checked_actions(action, (self.task.actions.size,))
        if self.task.over[0]:
            raise InputError("step: the episode is over, or has not begun; call reset() first")
        outcome, late = self.task.step(given[None])
        info = {name: float(values[0]) for name, values in outcome.info.items()}
        return (
            self.task.observe()[0],
            float(outcome.reward[0]),
            bool(outcome.ended[0]),
            bool(late[0]),
            info,
        )

    def render(self) -> NDArray[np.uint8] | None:
        """A picture (H, W, 3) of the episode as it is now; None without a render mode."""
        return picture(self.task, 0, self.size) if self.render_mode == "rgb_array" else None


def checked_render_mode(mode: Any) -> str | None:
    """Raises `InputError` for a mode that there is not."""
    if mode is None:
        return None
    if not isinstance(mode, str) or mode not in RENDER_MODES:
        raise InputError(f"render_mode: found {shown(mode)}, expected 'rgb_array' or None")
    return str(mode)
