"""halfphysics: give a kinematic human a body.

A known SMPL-X motion, a body shape and a scene in; the same motion out where nothing was in the
way, corrected where something was, with the objects' motion and all contacts. World z-up; metres,
kilograms, seconds; quaternions wxyz; rotations axis-angle [rad].

Names are imported when first used: ``import halfphysics`` itself takes a few milliseconds.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from halfphysics import actors, baselines, errors, metrics, scenarios, support
    from halfphysics.adaptation.adapt import adapt
    from halfphysics.base.progress import progress
    from halfphysics.body.body import Body
    from halfphysics.errors import HalfPhysicsError, HalfPhysicsWarning
    from halfphysics.formats import load_sequence
    from halfphysics.formats.library import clips
    from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Mesh, Plane, Sphere
    from halfphysics.judging.judge import judge
    from halfphysics.live.client import connect
    from halfphysics.live.serve import serve
    from halfphysics.motion.motion import Motion
    from halfphysics.motion.pose import Pose
    from halfphysics.motion.skeleton import JOINT_NAMES
    from halfphysics.mujoco.attach import attach
    from halfphysics.mujoco.binding import bind
    from halfphysics.mujoco.worlds import step_worlds
    from halfphysics.repair.repair import fix
    from halfphysics.results.result import Result
    from halfphysics.scene.scene import Scene
    from halfphysics.scene.soft import Soft
    from halfphysics.settings import Settings
    from halfphysics.simulation.compile_world import compile_world
    from halfphysics.simulation.sequence import Sequence
    from halfphysics.simulation.simulate import simulate
    from halfphysics.simulation.simulate_many import simulate_many
    from halfphysics.simulation.simulator import Simulator
    from halfphysics.viewer.view import view
    from halfphysics.writers import export

__version__ = "0.1.0"

__all__ = [
    "JOINT_NAMES",
    "Body",
    "Box",
    "Capsule",
    "Cylinder",
    "HalfPhysicsError",
    "HalfPhysicsWarning",
    "Mesh",
    "Motion",
    "Plane",
    "Pose",
    "Result",
    "Scene",
    "Sequence",
    "Settings",
    "Simulator",
    "Soft",
    "Sphere",
    "__version__",
    "actors",
    "adapt",
    "attach",
    "baselines",
    "bind",
    "clips",
    "compile_world",
    "connect",
    "errors",
    "export",
    "fix",
    "judge",
    "load_sequence",
    "metrics",
    "progress",
    "scenarios",
    "serve",
    "simulate",
    "simulate_many",
    "step_worlds",
    "support",
    "view",
]

# Name -> module it comes from; None: the name is a module of this package.
_FROM: dict[str, str | None] = {
    "actors": None,
    "baselines": None,
    "errors": None,
    "metrics": None,
    "scenarios": None,
    "support": None,
    "JOINT_NAMES": "motion.skeleton",
    "adapt": "adaptation.adapt",
    "Body": "body.body",
    "Box": "geometry.shapes",
    "Capsule": "geometry.shapes",
    "Cylinder": "geometry.shapes",
    "HalfPhysicsError": "errors",
    "HalfPhysicsWarning": "errors",
    "Mesh": "geometry.shapes",
    "Motion": "motion.motion",
    "Plane": "geometry.shapes",
    "Pose": "motion.pose",
    "Result": "results.result",
    "Scene": "scene.scene",
    "Sequence": "simulation.sequence",
    "Settings": "settings",
    "Simulator": "simulation.simulator",
    "Soft": "scene.soft",
    "Sphere": "geometry.shapes",
    "attach": "mujoco.attach",
    "bind": "mujoco.binding",
    "clips": "formats.library",
    "compile_world": "simulation.compile_world",
    "connect": "live.client",
    "export": "writers",
    "fix": "repair.repair",
    "judge": "judging.judge",
    "load_sequence": "formats.registry",
    "progress": "base.progress",
    "serve": "live.serve",
    "simulate": "simulation.simulate",
    "simulate_many": "simulation.simulate_many",
    "step_worlds": "mujoco.worlds",
    "view": "viewer.view",
}


def __getattr__(name: str) -> Any:
    if name not in _FROM:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module = _FROM[name]
    if module is None:
        return importlib.import_module(f"{__name__}.{name}")
    value = getattr(importlib.import_module(f"{__name__}.{module}"), name)
    globals()[name] = value  # found without this function from now on
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
