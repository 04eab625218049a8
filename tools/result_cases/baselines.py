"""The baselines that half-physics is compared with."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from typing import Any

import halfphysics as hp
from result_cases.case import Case
from result_cases.digests import result_values
from result_cases.scenes import body, bowling, clip

#: Name of a baseline -> what it changes.
BASELINES: Mapping[str, dict[str, Any]] = {
    "torque": {"mode": "torque"},
    "torque_soft": {"mode": "torque", "torque_frequency": 20.0, "torque_damping": 0.5},
    "positions": {"mode": "positions"},
    "interpolated": {"mode": "interpolated"},
    "kinematic": {"mode": "kinematic"},
    "engine_kinematic": {"mode": "engine_kinematic"},
    "engine_velocity": {"mode": "engine_velocity"},
    "internal_forces": {"internal_forces": True},
    "joint_damping": {"joint_damping": 2.0},
    "both": {"internal_forces": True, "joint_damping": 0.5, "drive_time": None},
    "torque_forces": {"mode": "torque", "internal_forces": True, "joint_damping": 1.0},
}


def baseline_settings(changes: Mapping[str, Any]) -> Any:
    """Settings of a baseline: the one place that knows how they are asked for."""
    if hasattr(hp, "baselines"):
        return hp.baselines.from_options(changes)
    return hp.Settings(**changes)  # before baselines had settings of their own


def played(name: str, changes: Mapping[str, Any]) -> dict[str, Any]:
    """A scenario as a baseline plays it."""
    told = hp.scenarios.load(name)
    settings = baseline_settings(changes)
    motion = told.motions[0][:60] if len(told.motions) == 1 else told.motion
    return result_values(hp.simulate(motion, told.scene, body=told.body, settings=settings))


def solids(changes: Mapping[str, Any]) -> dict[str, Any]:
    """A kick among solids of every kind as a baseline plays it."""
    motion = clip("asap_kick1", seconds=1.0)
    settings = baseline_settings(changes)
    return result_values(hp.simulate(motion, bowling(), body=body(), settings=settings))


def cases() -> Iterator[Case]:
    """Each baseline in a few scenes."""
    for what, changes in BASELINES.items():
        for contact in ("skin", "parts"):
            chosen = {**changes, "contact": contact}
            yield Case(
                f"baseline/{what}/solids_{contact}", partial(solids, chosen), contact == "parts"
            )
        for name in ("kick_ball", "walk_into_wall", "push_door"):
            yield Case(f"baseline/{what}/{name}", partial(played, name, changes))
