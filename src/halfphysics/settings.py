"""How to simulate: one frozen dataclass, read by the Python API and the command line alike."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from enum import IntEnum
from typing import Any, Literal

from halfphysics.base.field_checks import FieldChecks
from halfphysics.base.short_repr import changed_repr
from halfphysics.body.soft_skin import SoftSkin, checked_soft_skin
from halfphysics.body.strength import checked_strength
from halfphysics.errors import InputError
from halfphysics.motion.joint_groups import joint_values

#: Largest clearance that can be asked for [m]: fifty times the default. Hands that keep more from
#: what they hold (twice, for the two sides of a rod) hold nothing of the size of a hand.
MAX_CLEARANCE = 0.05


class PosesSet(IntEnum):
    """Whether the core sets people's poses in place of driving them, numbered as the core does."""

    NO = 0
    UNNOTICED = 1
    """Once a frame; contacts do not notice the people."""
    EVERY_FRAME = 2
    EVERY_SUBSTEP = 3


@dataclass(frozen=True, kw_only=True)
class Drive:
    """What moves the people: half-physics by default; `halfphysics.baselines` has the others.

    Attributes:
        poses: Whether the people's poses are set.
        torque_frequency: Natural frequency of PD torques in place of velocities [rad/s]; 0: none.
        torque_damping: Damping ratio of those.
        internal_forces: Whether Coriolis, centrifugal and gyroscopic forces act on people.
        joint_damping: Viscous damping of the people's joints [N m s/rad].
        follow: Runs a world over whole motions in place of the core, given the world, its motions,
            stiffness over time or None, and a function to tell how many frames were done.
    """

    poses: PosesSet = PosesSet.NO
    torque_frequency: float = 0.0
    torque_damping: float = 1.0
    internal_forces: bool = False
    joint_damping: float = 0.0
    follow: Callable[[Any, Any, Any, Callable[[int], Any]], Any] | None = None


#: Fields of `Settings` with which a motion is followed as it is, as the paper does: nobody has
#: weight, waits, walks back, or has limits of strength and joints.
AS_IT_IS: Mapping[str, Any] = {
    "weight": False,
    "blocked": "continue",
    "root": "stay",
    "strength": None,
    "joint_limits": False,
}

#: Half-physics: velocities by the drive of `Settings`, and no other force on people.
HALF_PHYSICS = Drive()


@dataclass(frozen=True, kw_only=True)
class Settings:
    """All choices of a simulation; every one has a default. Raises InputError if impossible."""

    substeps: int | None = None
    """Substeps N per frame; None: as many as keep h at or under 1/240 s (8 at 30 fps)."""
    stiffness: float | Mapping[str, float] = 1.0
    """Stiffness of the joints, lambda: 0 limp (with drive_time=None), 1 stiff, 10 nearly rigid; a
    number, or one per joint or joint group (legs, arms, hands, ...), of which the smaller group
    wins; joints not named have 1."""
    drive_time: float | None = 0.02
    """Time constant of the drive [s]; None: Algorithm 1 of the paper."""
    recovery_rate: float = 8.0
    """Fastest speed at which a joint returns to its reference [rad/s]; with drive_time=None, and
    three times the speed of the reference."""
    weight: bool = True
    """People stand, sit and lie on what is under them, instead of floating over it or sinking into
    it: their height, and the legs that stand, follow the surface."""
    blocked: Literal["wait", "continue"] = "wait"
    """Who cannot go on waits, up to three seconds, while the reference's clock stands still, or
    walks on the spot ("continue")."""
    root: Literal["stay", "recover"] = "recover"
    """After an obstacle the root walks back to the reference ("recover") or keeps its offset."""
    root_speed: float = 1.0
    """Fastest speed of that return [m/s]."""
    clearance: float = 0.001
    """Distance kept between the body and all else [m]; at most 0.05, under 2e-5 counts as 2e-5."""
    clearance_range: float = 0.05
    """Minimum distances up to this are reported exactly, larger ones as inf [m]."""
    contact: Literal["skin", "parts"] = "skin"
    """What of a person touches: hulls of the skin itself, or the 55 rigid parts (faster)."""
    self_contact: bool = False
    """Enable self-collision: arms stay off the chest; parts within two joints may touch."""
    depenetration_speed: float = 0.5
    """Fastest speed at which initial overlaps are resolved [m/s]."""
    tolerance: float = 1e-6
    """Largest violation of a contact that the solver may leave in a substep [m]."""
    max_sweeps: int = 50
    """Sweeps of the contact solver over all points with friction; then normals alone."""
    strength: Literal["human"] | Mapping[str, float] | None = "human"
    """What the drive can exert: as much as a person ("human"), all it needs (None, and always with
    drive_time=None), or per joint group or joint [N m]; "pelvis" limits the torque on the whole
    body, "root" the force on it [N]; what is not named has no limit."""
    joint_limits: bool = True
    """Contact turns no joint farther than people's joints go, or than the motion itself has it."""
    soft_skin: bool | SoftSkin = False
    """Skin gives way, by millimetres and more at the seat; what stays clear is the hard core
    beneath. Values by part: docs/soft.md."""
    threads: int = 1
    """Threads for measuring a result (a substep runs on one); no number depends on it."""
    record: Literal["frames", "substeps"] = "frames"
    """Keep the pose at every frame, or at every committed substep too."""

    __repr__ = changed_repr

    def __post_init__(self) -> None:
        check = FieldChecks(self)
        check.plain()
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
        check.flag("weight")
        check.choice("blocked", "wait", "continue")
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
        if self.drive_time is None and self.strength == "human":
            object.__setattr__(self, "strength", None)
        check.holds(
            "strength",
            self.strength is None or self.drive_time is not None,
            "None without drive_time: Algorithm 1 sets velocities, whatever force that takes. Set "
            "drive_time, such as 0.02",
        )
        check.flag("self_contact")
        check.flag("joint_limits")
        object.__setattr__(self, "soft_skin", checked_soft_skin(self.soft_skin))
        check.holds(
            "soft_skin",
            self.soft_skin is False or self.contact == "skin",
            'False with contact="parts": rigid parts have no skin. Set contact="skin"',
        )
        check.number("depenetration_speed", least=0.0)
        check.number("tolerance", above=0.0)
        check.count("max_sweeps")
        check.count("threads")
        check.choice("record", "frames", "substeps")

    @property
    def drive(self) -> Drive:
        """What moves the people."""
        return HALF_PHYSICS

    @classmethod
    def paper(cls, stiffness: float | Mapping[str, float] = 0.0, **changes: Any) -> Settings:
        """The paper's own setting: Algorithm 1, eight substeps a frame, lambda = `stiffness`.

        Nobody has weight, waits, walks back to the motion or has limits (`AS_IT_IS`). `changes`
        overrides further fields.
        """
        values: dict[str, Any] = {
            "drive_time": None,
            "substeps": 8,
            "stiffness": stiffness,
            **AS_IT_IS,
        }
        known = {f.name for f in fields(cls)}
        for name in changes:
            if name not in known:
                raise InputError(f"{cls.__name__} has no field {name!r}; it has {sorted(known)}")
        return cls(**{**values, **changes})

    def substeps_for(self, dt: float) -> int:
        """Number of substeps N of a frame of length `dt` [s] (h = dt/N <= 1/240 s)."""
        if self.substeps is not None:
            return self.substeps
        return max(1, math.ceil(240.0 * dt - 1e-9))
