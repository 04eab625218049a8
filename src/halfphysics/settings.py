"""How to simulate: one frozen dataclass, read by the Python API and the command line alike."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, Literal, get_args

from halfphysics.base.field_checks import FieldChecks
from halfphysics.baselines.modes import Mode, check_mode
from halfphysics.body.strength import checked_strength
from halfphysics.errors import InputError
from halfphysics.motion.joint_groups import joint_values

#: Largest clearance that can be asked for [m]: fifty times the default. Hands that keep more from
#: what they hold (twice, for the two sides of a rod) hold nothing of the size of a hand.
MAX_CLEARANCE = 0.05


@dataclass(frozen=True, kw_only=True)
class Settings:
    """All choices of a simulation; every one has a default. Raises InputError if impossible."""

    substeps: int | None = None
    """Substeps N per frame; None: as many as keep h at or under 1/240 s (8 at 30 fps)."""
    stiffness: float | Mapping[str, float] = 1.0
    """Firmness of the joints, lambda: 0 limp (with drive_time=None), 1 firm, 10 nearly rigid; a
    number, or one per joint group or joint (see `JOINT_GROUPS`), the smaller group winning: joints
    not named have 1."""
    drive_time: float | None = 0.02
    """Time constant of the drive [s]; None: Algorithm 1 of the paper to the letter."""
    recovery_rate: float = 8.0
    """Fastest speed at which a joint returns to its reference [rad/s] (with drive_time)."""
    root: Literal["stay", "recover"] = "stay"
    """After an obstacle the root keeps its offset ("stay") or walks back to the reference."""
    root_speed: float = 1.0
    """Fastest speed of that return [m/s]."""
    clearance: float = 0.001
    """Distance kept between the body and all else [m]; at most 0.05, under 2e-5 counts as 2e-5."""
    clearance_range: float = 0.05
    """Distances up to this are reported exactly in `Result.clearance` [m], inf beyond."""
    contact: Literal["skin", "parts"] = "skin"
    """What of a person touches: hulls of the skin itself, or the 55 rigid parts (faster)."""
    self_contact: bool = False
    """Keep a person out of themselves: arms off the chest, but not parts within two joints."""
    depenetration_speed: float = 0.5
    """Fastest speed at which a part that starts inside something leaves it [m/s]."""
    tolerance: float = 1e-6
    """Largest violation of a contact that the solver may leave in a substep [m]."""
    max_sweeps: int = 50
    """Sweeps of the contact solver over all points with friction; then normals alone."""
    strength: Literal["human"] | Mapping[str, float] | None = None
    """What the drive can exert (with drive_time): all it needs (None), as much as a person
    ("human"), or per joint group or joint [N m]; "pelvis" limits the torque on the whole body,
    "root" the force on it [N]; what is not named has no limit."""
    mode: Mode = "velocity"
    """How the motion drives the body: by velocity (half-physics), or, to compare with, one of the
    baselines of docs/physics.md, "Baselines"."""
    internal_forces: bool = False
    """Coriolis, centrifugal and gyroscopic forces act on the person, which the paper leaves out: an
    ablation, for mode="velocity" and "torque"."""
    joint_damping: float = 0.0
    """Viscous damping of the person's joints [N m s/rad]: an ablation, for the same modes."""
    torque_frequency: float = 100.0
    """With mode="torque": natural frequency of the joints' PD control [rad/s]. Stiffness and
    drive_time do not apply then."""
    torque_damping: float = 1.0
    """With mode="torque": damping ratio of the joints' PD control."""
    threads: int = 1
    """Threads for measuring a result (a substep runs on one); no number depends on it."""
    record: Literal["frames", "substeps"] = "frames"
    """Keep the pose at every frame, or at every committed substep too."""

    def __post_init__(self) -> None:
        check = FieldChecks(self)
        if self.substeps is not None:
            check.count("substeps")
        if isinstance(self.stiffness, Mapping):
            given = joint_values(self.stiffness, "Settings.stiffness")
            object.__setattr__(self, "stiffness", given)
        else:
            check.number("stiffness", least=0.0)
        if self.drive_time is not None:
            check.number("drive_time", above=0.0)
        check.number("recovery_rate", above=0.0)
        check.choice("root", "stay", "recover")
        check.number("root_speed", above=0.0)
        check.number(
            "clearance",
            least=0.0,
            most=MAX_CLEARANCE,
            why=" [m]: a body farther from all it touches would stand, sit and grasp in the air",
        )
        check.number("clearance_range", least=0.0)
        check.choice("contact", "skin", "parts")
        object.__setattr__(self, "strength", checked_strength(self.strength))
        check.holds(
            "strength",
            self.strength is None or self.drive_time is not None,
            "None without drive_time: Algorithm 1 sets velocities, whatever force that takes. Set "
            "drive_time, such as 0.02",
        )
        check.choice("mode", *get_args(Mode))
        check.flag("internal_forces")
        check.number("joint_damping", least=0.0)
        check.number("torque_frequency", above=0.0)
        check.number("torque_damping", least=0.0)
        self._check_ablations(check)
        check.flag("self_contact")
        check.number("depenetration_speed", least=0.0)
        check.number("tolerance", above=0.0)
        check.count("max_sweeps")
        check.count("threads")
        check.choice("record", "frames", "substeps")
        check_mode(self)

    def _check_ablations(self, check: FieldChecks) -> None:
        """Forces and torques that are there to compare with, and what does not go with them."""
        if self.strength is not None:
            why = "with strength: it limits half-physics' own drive"
            check.holds("internal_forces", not self.internal_forces, f"False {why}")
            check.holds("joint_damping", not self.joint_damping, f"0 {why}")
            check.holds("mode", self.mode != "torque", f"'velocity' {why}")

    @classmethod
    def paper(cls, stiffness: float | Mapping[str, float] = 0.0, **changes: Any) -> Settings:
        """The paper's own setting: Algorithm 1, eight substeps a frame, lambda = `stiffness`.

        `changes` overrides further fields.
        """
        values: dict[str, Any] = {"drive_time": None, "substeps": 8, "stiffness": stiffness}
        known = {f.name for f in fields(cls)}
        for name in changes:
            if name not in known:
                raise InputError(f"Settings has no field {name!r}; it has {sorted(known)}")
        return cls(**{**values, **changes})

    def substeps_for(self, dt: float) -> int:
        """Number of substeps N of a frame of length `dt` [s] (METHOD: h = dt/N <= 1/240 s)."""
        if self.substeps is not None:
            return self.substeps
        return max(1, math.ceil(240.0 * dt - 1e-9))
