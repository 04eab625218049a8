"""Many MuJoCo worlds with people, stepped together on several threads."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING

from halfphysics.base.machine import cores
from halfphysics.base.validation import is_whole, shown
from halfphysics.errors import InputError
from halfphysics.mujoco import engine
from halfphysics.mujoco.control import Control, _timestep

if TYPE_CHECKING:
    from halfphysics.motion.pose import Pose


def step_worlds(
    controls: Sequence[Control],
    poses: Sequence[Pose | Sequence[Pose]],
    dt: float | None = None,
    *,
    threads: int | None = None,
) -> None:
    """`Control.step` of many worlds at once, each on one thread: the same bits for any number.

    Args:
        controls: Each with a `mujoco.MjData` of its own; models may be shared.
        poses: For each its reference pose, or a sequence of them where it has several people.
        dt: Length of the step of all of them, as in `Control.step` [s].
        threads: How many to use at most; None: as many as there are processors. Where MuJoCo
            calls back into Python (`mujoco.set_mjcb_control`, ...) worlds are stepped one after
            the other.

    Raises:
        InputError: Not one pose per control, two controls of one `MjData`, or what `Control.step`
            refuses: then no world has been stepped.
    """
    import mujoco

    from halfphysics import _native

    _check_lists(controls, poses)
    _check(controls, poses, threads)
    steps = [control._steps(dt) for control in controls]
    for control, pose in zip(controls, poses, strict=True):
        control._ready(pose)
        control._follow_masses("step")
    if engine.watched() or not all(control._alone for control in controls):
        for control, pose in zip(controls, poses, strict=True):
            control.step(pose, dt)
        return
    with ExitStack() as stack:
        for control, pose in zip(controls, poses, strict=True):
            control._aim(pose, dt)
            stack.callback(control._relax)
        for control, (_, h) in zip(controls, steps, strict=True):
            stack.enter_context(_timestep(control._model, h))
        count = cores() if threads is None else int(threads)
        errors = _native.run_worlds([control._world for control in controls], count)
    for control, error in zip(controls, errors, strict=True):
        if not error:
            control._finish()
    if any(errors):
        index, message = next((i, e) for i, e in enumerate(errors) if e)
        raise mujoco.FatalError(f"world {index}: {message}")


def _check_lists(controls: object, poses: object) -> None:
    """Refuse what has no length or no order, such as a single world and its pose."""
    for name, given in (("controls", controls), ("poses", poses)):
        if not (hasattr(given, "__len__") and hasattr(given, "__getitem__")):
            raise InputError(
                f"step_worlds: {name}: found {type(given).__name__}, expected a list with one "
                "entry per world (Control.step steps a single one)"
            )


def _check(controls: Sequence[Control], poses: Sequence[object], threads: int | None) -> None:
    for control in controls:
        if not isinstance(control, Control):
            raise InputError(
                f"step_worlds: found {type(control).__name__}, expected what bind returned"
            )
    if len(poses) != len(controls):
        raise InputError(
            f"step_worlds: found {len(poses)} poses, expected one per world: {len(controls)}"
        )
    if len({id(control._data) for control in controls}) < len(controls):
        raise InputError(
            "step_worlds: two controls of one MjData; expected one each (several people in one "
            "world are bound together: halfphysics.bind)"
        )
    if threads is not None and not is_whole(threads, least=1, plain=False):
        raise InputError(f"step_worlds: threads: found {shown(threads)}, expected 1 or more")
