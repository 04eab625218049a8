"""Values of the playground's sliders, and their effect on settings and on a scene."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from halfphysics.body.strength import HUMAN, ROOT_BODY_WEIGHTS
from halfphysics.errors import InputError
from halfphysics.motion.joint_groups import ROOT_FORCE
from halfphysics.scene.changed import changed
from halfphysics.settings import AS_IT_IS

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.scene.scene import Scene
    from halfphysics.settings import Settings

_STANDARD_GRAVITY = 9.80665

#: Name of a strength -> fraction of a person's strength; None: unlimited.
STRENGTHS: Mapping[str, float | None] = MappingProxyType(
    {"unlimited": None, "human": 1.0, "half": 0.5, "weak": 0.2, "very weak": 0.05}
)


@dataclass(frozen=True, kw_only=True)
class Knobs:
    """Values of the sliders; None or absent: the scenario's value.

    Attributes:
        stiffness: Stiffness lambda of the joints.
        substeps: Number of substeps per frame.
        strength: A name of `STRENGTHS`.
        drive_time: Time constant of the drive [s].
        paper: Whether to use the paper's Algorithm 1 instead of a drive with a time constant.
        masses: Name of an object -> its mass [kg]; of an articulated object: of all its links.
        frictions: Name of an item of the scene -> its friction.
    """

    stiffness: float | None = None
    substeps: int | None = None
    strength: str | None = None
    drive_time: float | None = None
    paper: bool | None = None
    masses: Mapping[str, float] = field(default_factory=dict)
    frictions: Mapping[str, float] = field(default_factory=dict)

    def settings(self, base: Settings, body: Body) -> Settings:
        """The scenario's settings with the values of the sliders.

        Raises:
            InputError: An impossible value.
        """
        changes: dict[str, Any] = {}
        if self.stiffness is not None:
            changes["stiffness"] = self.stiffness
        if self.substeps is not None:
            changes["substeps"] = self.substeps
        if self.drive_time is not None:
            changes["drive_time"] = self.drive_time
        if self.strength is not None:
            changes["strength"] = _strength(self.strength, body)
        if self.paper:
            changes |= {"drive_time": None, **AS_IT_IS}
        elif self.paper is not None and base.drive_time is None and self.drive_time is None:
            changes["drive_time"] = type(base).drive_time
        return replace(base, **changes)

    def scene(self, base: Scene) -> Scene:
        """The scenario's scene with the values of the sliders; the same object if none is set.

        Raises:
            InputError: An impossible value, or a name that the scene does not have.
        """
        return changed(base, self.masses, self.frictions)


def _strength(name: str, body: Body) -> Any:
    if name not in STRENGTHS:
        raise InputError(f"strength: found {name!r}, expected one of {', '.join(STRENGTHS)}")
    part = STRENGTHS[name]
    if part is None or part == 1.0:
        return None if part is None else "human"
    weight = _STANDARD_GRAVITY * sum(p.mass for p in body.variant.parts)
    limits = {joint: part * torque for joint, torque in HUMAN.items()}
    return {**limits, ROOT_FORCE: part * ROOT_BODY_WEIGHTS * weight}
