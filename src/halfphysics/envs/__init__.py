"""Environments for robots among people: gymnasium and PettingZoo (extra `rl`).

Importing this package registers `halfphysics/HandOver-v0` and the others with gymnasium:

    import gymnasium, halfphysics.envs

    env = gymnasium.make("halfphysics/HandOver-v0")
    many = gymnasium.make_vec("halfphysics/HandOver-v0", num_envs=16)

or, in one: `gymnasium.make("halfphysics.envs:halfphysics/HandOver-v0")`. What the numbers mean:
docs/envs.md.
"""

from __future__ import annotations

import importlib.util
from typing import Any

from halfphysics.base.optional_package import optional
from halfphysics.envs.tasks import names, task_class

__all__ = ["names", "parallel_env", "register", "task_class"]


def register() -> None:
    """Register all tasks with gymnasium; again and again does no harm.

    Raises:
        MissingDependencyError: gymnasium is not installed.
    """
    gymnasium = optional("gymnasium", "environments", "rl")
    for name in names():
        id_ = f"halfphysics/{name}-v0"
        if id_ not in gymnasium.registry:
            gymnasium.register(
                id_,
                entry_point="halfphysics.envs.single:SingleEnv",
                vector_entry_point="halfphysics.envs.vector:VectorEnv",
                kwargs={"task": name},
            )


def parallel_env(task: str, **options: Any) -> Any:
    """A task in which policies move robot and person both, as a `pettingzoo.ParallelEnv`.

    Args:
        task: Its name, such as "HandOver".
        options: `render_mode`, `steps`, `size`, as of `gymnasium.make`.

    Raises:
        InputError: As `ParallelEnv` does. MissingDependencyError: PettingZoo is not installed.
    """
    from halfphysics.envs.parallel import ParallelEnv

    return ParallelEnv(task, **options)


# Who has no gymnasium can still use the tasks and their policies.
if importlib.util.find_spec("gymnasium") is not None:
    register()
