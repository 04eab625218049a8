"""MuJoCo's `mj_step` by its address, for loops of timesteps that need no interpreter."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

#: MuJoCo's library in its Python package, by platform.
LIBRARIES = ("libmujoco.so.*", "libmujoco.*.dylib", "mujoco.dll")


@cache
def step_address() -> int:
    """Where `mj_step` is in this process; 0 where that cannot be found.

    Errors of MuJoCo that nobody catches end the process; from the first call on those of our
    loops are caught.
    """
    import mujoco

    from halfphysics import _native

    folder = Path(mujoco.__file__).parent
    for path in sorted(p for name in LIBRARIES for p in folder.glob(name)):
        try:
            library = ctypes.CDLL(str(path))
            step = ctypes.cast(library.mj_step, ctypes.c_void_p).value
            handler = ctypes.addressof(ctypes.c_void_p.in_dll(library, "mju_user_error"))
        except (OSError, AttributeError, ValueError):
            continue
        if step:
            _native.catch_engine_errors(handler)
            return step
    return 0


def watched() -> bool:
    """Whether MuJoCo calls back into Python: then Python makes the timesteps."""
    import mujoco

    callbacks: Any = (
        mujoco.get_mjcb_control,
        mujoco.get_mjcb_passive,
        mujoco.get_mjcb_sensor,
        mujoco.get_mjcb_act_dyn,
        mujoco.get_mjcb_act_gain,
        mujoco.get_mjcb_act_bias,
        mujoco.get_mjcb_contactfilter,
        mujoco.get_mjcb_time,
    )
    return any(get() is not None for get in callbacks)


@dataclass(frozen=True)
class Addresses:
    """Where a model, its data and `mj_step` are in this process; 0: unknown."""

    step: int
    model: int
    data: int

    @staticmethod
    def of(model: Any, data: Any) -> Addresses:
        found = getattr(model, "_address", 0), getattr(data, "_address", 0)
        return Addresses(step_address() if all(found) else 0, *map(int, found))
