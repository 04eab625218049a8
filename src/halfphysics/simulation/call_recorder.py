"""The calls that build a world in the core, kept with their arguments, for world files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.simulation.mesh_trees import world_triangles

if TYPE_CHECKING:
    from halfphysics.scene.scene import Scene
    from halfphysics.simulation.person_shapes import PersonSkin

#: Calls of the core that build a world -> the names of their arguments in world files, in the
#: order in which `_native.Stepper` has them; those given by keyword have the keyword's.
CALLS: Mapping[str, tuple[str, ...]] = {
    "set_model": (),
    "set_joint_forces": (),
    "add_shape": ("body", "name", "person", "part", "vertices", "normals", "radius", "rim"),
    "set_slack": ("slack",),
    "add_half_space": ("name", "normal", "offset"),
    "add_hull": ("name", "vertices", "normals", "radius", "rim"),
    "set_soft_static": (
        "law",
        "thickness",
        "stiffness",
        "damping",
        "densification",
        "arm",
        "relaxation",
        "corners",
    ),
    "set_soft_shape": (
        "law",
        "thickness",
        "stiffness",
        "damping",
        "densification",
        "arm",
        "relaxation",
    ),
    "set_samples": ("points", "normals", "areas"),
    "set_skin_samples": (
        "person",
        "vertices",
        "areas",
        "normals",
        "parts",
        "thickness",
        "stiffness",
        "damping",
    ),
    "set_pairings": ("friction", "restitution", "ignore"),
    "set_drive": (),
    "set_contact": (),
    "set_baselines": (),
    "set_prescribed": ("how",),
    "add_trajectory": ("body", "fps", "loop", "position", "turn"),
    "start_asleep": ("body",),
    "finish": ("roots",),
    "set_strength": ("person", "limits"),
    "set_joint_ranges": ("person",),
    "set_waiting": ("on",),
    "set_footing": (),
    "set_self_pairs": ("pairs",),
}
#: Arguments that are numbers with a fraction even where Python has a whole one.
_REAL = frozenset(
    {
        "radius",
        "offset",
        "slack",
        "fps",
        "thickness",
        "stiffness",
        "damping",
        "densification",
        "arm",
        "relaxation",
        "corners",
        "areas",
    }
)
#: Questions that building asks the core: passed on, not kept.
_QUESTIONS = frozenset({"pair_gaps"})


@dataclass(frozen=True)
class Call:
    """One call: its name, and its arguments by name: arrays of int32 or float64, or text."""

    name: str
    arguments: Mapping[str, NDArray[Any] | str]


class CallRecorder:
    """In place of the core: passes calls on to it and keeps those that build the world.

    Args:
        core: The native stepper.
        scene: What is built, with the triangles of static meshes.

    Attributes:
        calls: What was called so far.
    """

    def __init__(self, core: Any, scene: Scene) -> None:
        self._core, self._scene = core, scene
        self.calls: list[Call] = []

    def __getattr__(self, name: str) -> Any:
        if name in _QUESTIONS:
            return getattr(self._core, name)
        if name not in CALLS:
            raise AttributeError(f"the core's {name} has no place in world files yet")

        def call(*given: Any, **named: Any) -> Any:
            self.keep(name, **dict(zip(CALLS[name], given, strict=True)), **named)
            return getattr(self._core, name)(*given, **named)

        return call

    def add_skin_shapes(self, shapes: PersonSkin, person: int, names: NDArray[np.int32]) -> None:
        """The skin of a person, with the arrays that it was made of."""
        self.keep("add_skin_shapes", **shapes.arrays, person=person, names=names)
        self._core.add_skin_shapes(shapes, person, names)

    def add_mesh(self, name: int, mesh: Any) -> None:
        """A static mesh: its triangles in the world."""
        static = list(self._scene.statics.values())[name]
        position = np.asarray(static.position, dtype=np.float64)
        vertices, faces = world_triangles(static, rot.to_matrix(static.quaternion), position)
        self.keep("add_mesh", name=name, vertices=vertices, faces=faces)
        self._core.add_mesh(name, mesh)

    def keep(self, name: str, /, **arguments: Any) -> None:
        """Keep a call that the core itself does not have, such as of names."""
        self.calls.append(Call(name, {key: _stored(key, v) for key, v in arguments.items()}))


def _stored(name: str, value: Any) -> NDArray[Any] | str:
    """An argument as world files have it."""
    if isinstance(value, str):
        return value
    array = np.asarray(value, dtype=np.int32 if isinstance(value, list) else None)
    whole = array.dtype.kind in "iub" and name not in _REAL
    return np.ascontiguousarray(array, dtype=np.int32 if whole else np.float64).reshape(array.shape)
