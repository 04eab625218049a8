"""Many episodes in one call: the face of `gymnasium.make_vec`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.arrays import as_array
from halfphysics.base.machine import cores
from halfphysics.base.optional_package import optional
from halfphysics.base.validation import is_whole, shown
from halfphysics.envs.channels import checked_actions
from halfphysics.envs.pictures import SIZE, checked_size, picture
from halfphysics.envs.single import checked_render_mode
from halfphysics.envs.tasks import task_class
from halfphysics.errors import InputError

_vector = optional("gymnasium.vector", "environments", "rl")
_Env: Any = _vector.VectorEnv
_utils = optional("gymnasium.vector.utils", "environments", "rl")
AutoresetMode = _vector.AutoresetMode

Array = NDArray[np.float64]


class VectorEnv(_Env):  # type: ignore[misc]
    """A task as a `gymnasium.vector.VectorEnv`: one frame of all worlds in one call of the core.

    Episode i of `reset(seed=s)` is that of a single environment with seed s + i, bit for bit,
    whatever `num_envs` and `threads`.

    Args:
        task: Its name, such as "HandOver".
        num_envs: Number of episodes side by side.
        threads: Number of threads; None: one per core that this process may use.
        render_mode, steps, size: As for a single environment; `render` gives a tuple of pictures.
        autoreset_mode: When an episode that is over begins again, as gymnasium defines it.

    Raises:
        InputError: A task or mode that there is not, an impossible number or size.
    """

    metadata: dict[str, Any] = {  # noqa: RUF012 - an instance may have its own
        "render_modes": ["rgb_array"],
        "render_fps": 30,
        "autoreset_mode": AutoresetMode.NEXT_STEP,
    }

    def __init__(
        self,
        task: str,
        num_envs: int = 1,
        *,
        threads: int | None = None,
        render_mode: str | None = None,
        steps: int | None = None,
        size: tuple[int, int] = SIZE,
        autoreset_mode: Any = AutoresetMode.NEXT_STEP,
    ) -> None:
        super().__init__()
        self.render_mode = checked_render_mode(render_mode)
        try:
            self._mode = AutoresetMode(autoreset_mode)
        except ValueError:
            modes = ", ".join(repr(mode.value) for mode in AutoresetMode)
            raise InputError(
                f"autoreset_mode: found {shown(autoreset_mode)}, expected one of {modes}"
            ) from None
        self.metadata = {**type(self).metadata, "autoreset_mode": self._mode}
        self.size = checked_size(size)
        count = cores() if threads is None else threads
        self.task = task_class(task)(num_envs, threads=count, steps=steps)
        self.num_envs = num_envs = self.task.count
        self.single_observation_space = self.task.observed.space()
        self.single_action_space = self.task.actions.space()
        self.observation_space = _utils.batch_space(self.single_observation_space, num_envs)
        self.action_space = _utils.batch_space(self.single_action_space, num_envs)
        self._seeded = np.zeros(num_envs, dtype=bool)

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begin episodes.

        Args:
            seed: s: episode i has the seed s + i; or one for each, of which None goes on by chance.
            options: "reset_mask" (N,): those that begin, in place of all.

        Raises:
            InputError: Seeds or a mask of another length, other options.
        """
        mask, seeds = self._mask(options), self._seeds(seed)
        if isinstance(seed, int | np.integer):
            super().reset(seed=int(seed))
        for i, s in enumerate(seeds):
            if mask[i]:
                if s is not None:
                    self.task.seed(i, s)
                elif not self._seeded[i]:
                    self.task.seed(i, int(self.np_random.integers(2**31)))
                self._seeded[i] = True
                self.task.begin(i)
        return self.task.observe(), {}

    def step(
        self, actions: Any
    ) -> tuple[
        NDArray[np.float32],
        NDArray[np.float64],
        NDArray[np.bool_],
        NDArray[np.bool_],
        dict[str, Any],
    ]:
        """One step of all episodes.

        Raises:
            InputError: Before `reset`, actions of another shape; an episode that is over, where
                they do not begin again by themselves.
        """
        task = self.task
        given = checked_actions(actions, (self.num_envs, task.actions.size))
        again = task.over.copy()
        if again.any() and (self._mode is not AutoresetMode.NEXT_STEP or not self._seeded.all()):
            which = ", ".join(map(str, np.flatnonzero(again)[:8]))
            raise InputError(f"step: episodes {which} are over, or have not begun; call reset()")
        outcome, late = task.step(given)
        ended, reward = outcome.ended & ~again, np.where(again, 0.0, outcome.reward)
        final: dict[str, Any] = {}
        if self._mode is AutoresetMode.SAME_STEP and task.over.any():
            again = task.over.copy()
            final = self._final(outcome.info, again)
        info = _told(outcome.info, ~again) | final
        for i in np.flatnonzero(again):
            task.begin(int(i))
        return task.observe(), reward, ended, late, info

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """Pictures (H, W, 3) of all episodes; None without a render mode."""
        if self.render_mode is None:
            return None
        return tuple(picture(self.task, i, self.size) for i in range(self.num_envs))

    # -- inside ----------------------------------------------------------------------------

    def _final(self, info: Mapping[str, Array], over: NDArray[np.bool_]) -> dict[str, Any]:
        """What gymnasium wants to know of episodes that end and begin in one step."""
        seen, last = self.task.observe(), np.full(self.num_envs, None, dtype=object)
        for i in np.flatnonzero(over):
            last[i] = seen[i]
        ends = _told(info, over)
        return {"final_obs": last, "_final_obs": over, "final_info": ends, "_final_info": over}

    def _mask(self, options: dict[str, Any] | None) -> NDArray[np.bool_]:
        if not isinstance(options, Mapping | None):
            raise InputError(f"reset: options: found {shown(options)}, expected a dict or None")
        given = dict(options or {})
        found = given.pop("reset_mask", np.ones(self.num_envs, dtype=bool))
        if given:
            raise InputError(f"reset: options: found {shown(given)}, expected 'reset_mask' only")
        try:
            mask = as_array(found)
        except (TypeError, ValueError):
            mask = np.zeros(0)
        if mask.shape != (self.num_envs,) or mask.dtype != np.bool_:
            raise InputError(
                f"reset_mask: found {shown(found)}, expected {self.num_envs} times True or False"
            )
        return mask

    def _seeds(self, seed: Any) -> list[int | None]:
        if seed is None:
            return [None] * self.num_envs
        if is_whole(seed, least=0, plain=False):
            return [int(seed) + i for i in range(self.num_envs)]
        seeds = list(seed) if isinstance(seed, Sequence | np.ndarray) else []
        fine = all(s is None or is_whole(s, least=0, plain=False) for s in seeds)
        if len(seeds) != self.num_envs or not fine:
            raise InputError(
                f"seed: found {shown(seed)}, expected a whole number from 0 on, or "
                f"{self.num_envs} of them"
            )
        return [None if s is None else int(s) for s in seeds]


def _told(info: Mapping[str, Array], of: NDArray[np.bool_]) -> dict[str, Any]:
    """Numbers (N,) of some episodes as gymnasium has them: 0 and not marked where of the others."""
    told = {name: np.where(of, values, 0.0) for name, values in info.items()}
    return told | {f"_{name}": of.copy() for name in info}
