"""Settings of the baselines: other ways to put a motion into a simulation, to compare with.

Each is a kind of `halfphysics.Settings` and goes wherever those go: `simulate`, `Simulator`, the
command line, result files. What they do and what was measured: docs/physics.md, "Baselines".
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Literal

from halfphysics.base.field_checks import FieldChecks
from halfphysics.base.short_repr import changed_repr
from halfphysics.errors import InputError
from halfphysics.settings import Drive, PosesSet, Settings

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from halfphysics.motion.motion import Motion
    from halfphysics.results.result import Result
    from halfphysics.simulation.world import World


def _refuse(settings: Settings, reasons: Mapping[str, str]) -> None:
    """Refuse fields that are not a baseline's default: name -> why it has none."""
    for name, why in reasons.items():
        found, only = getattr(settings, name), getattr(_Baseline, name)
        if found != only:
            raise InputError(
                f"{type(settings).__name__}.{name} is {found!r}: {why}; expected {only!r}, or "
                "halfphysics.Settings"
            )


@dataclass(frozen=True, kw_only=True)
class _Baseline(Settings):
    """Settings that follow a motion as it is: `halfphysics.settings.AS_IT_IS`."""

    __repr__ = changed_repr

    weight: bool = False
    blocked: Literal["wait", "continue"] = "continue"
    root: Literal["stay", "recover"] = "stay"
    strength: Literal["human"] | Mapping[str, float] | None = None
    joint_limits: bool = False

    def __post_init__(self) -> None:
        super().__post_init__()
        own = "it belongs to half-physics' own drive"
        _refuse(self, dict.fromkeys(("weight", "blocked", "joint_limits"), own))


@dataclass(frozen=True, kw_only=True)
class Ablation(_Baseline):
    """Half-physics with forces on the person that the paper leaves out."""

    __repr__ = changed_repr

    internal_forces: bool = False
    """Coriolis, centrifugal and gyroscopic forces act on the person."""
    joint_damping: float = 0.0
    """Viscous damping of the person's joints [N m s/rad]."""

    def __post_init__(self) -> None:
        super().__post_init__()
        check = FieldChecks(self)
        check.flag("internal_forces")
        check.number("joint_damping", least=0.0)
        own = "None: a strength limits half-physics' own drive"
        check.holds("strength", self.strength is None, own)

    @property
    def drive(self) -> Drive:
        return Drive(internal_forces=self.internal_forces, joint_damping=self.joint_damping)


@dataclass(frozen=True, kw_only=True)
class Torque(Ablation):
    """PD torques of joints in place of velocities; `stiffness` and `drive_time` do not apply."""

    __repr__ = changed_repr

    frequency: float = 100.0
    """Natural frequency of the joints' PD control [rad/s]."""
    damping: float = 1.0
    """Damping ratio of the joints' PD control."""

    def __post_init__(self) -> None:
        super().__post_init__()
        check = FieldChecks(self)
        check.number("frequency", above=0.0)
        check.number("damping", least=0.0)

    @property
    def drive(self) -> Drive:
        return Drive(
            internal_forces=self.internal_forces,
            joint_damping=self.joint_damping,
            torque_frequency=self.frequency,
            torque_damping=self.damping,
        )


@dataclass(frozen=True, kw_only=True)
class _PosesSet(_Baseline):
    """The person's pose is set: contacts push objects, and never the person."""

    __repr__ = changed_repr

    _POSES: ClassVar[PosesSet]

    def __post_init__(self) -> None:
        super().__post_init__()
        reasons = {
            "root": "the person never leaves the reference",
            "self_contact": "contacts never move the person",
            "strength": "nothing is exerted",
        }
        said = {name: f"it sets the person's pose: {why}" for name, why in reasons.items()}
        _refuse(self, said)

    @property
    def drive(self) -> Drive:
        return Drive(poses=self._POSES)


@dataclass(frozen=True, kw_only=True)
class Kinematic(_PosesSet):
    """The pose is set once a frame, and objects do not notice the person."""

    __repr__ = changed_repr

    _POSES = PosesSet.UNNOTICED


@dataclass(frozen=True, kw_only=True)
class Positions(_PosesSet):
    """The pose is set at the start of every frame; objects answer."""

    __repr__ = changed_repr

    _POSES = PosesSet.EVERY_FRAME


@dataclass(frozen=True, kw_only=True)
class Interpolated(_PosesSet):
    """The pose is set in every substep, interpolated within the frame; objects answer."""

    __repr__ = changed_repr

    _POSES = PosesSet.EVERY_SUBSTEP


@dataclass(frozen=True, kw_only=True)
class _InMujoco(_Baseline):
    """People and scene in plain MuJoCo, over whole motions."""

    __repr__ = changed_repr

    def __post_init__(self) -> None:
        super().__post_init__()
        _refuse(
            self, {name: f"MuJoCo has no {name}" for name in ("root", "self_contact", "strength")}
        )
        if isinstance(self.stiffness, Mapping):
            raise no_stiffness(self)

    @property
    def drive(self) -> Drive:
        return Drive(follow=follow_in_engine)


@dataclass(frozen=True, kw_only=True)
class EngineKinematic(_InMujoco):
    """The person's parts are mocap bodies of MuJoCo."""

    __repr__ = changed_repr


@dataclass(frozen=True, kw_only=True)
class EngineVelocity(_InMujoco):
    """Algorithm 1 of the paper in MuJoCo: the baseline of `halfphysics bench`."""

    __repr__ = changed_repr


def no_stiffness(settings: Settings) -> InputError:
    """The error where stiffness by joint or over time is asked for in MuJoCo."""
    return InputError(
        f"stiffness: found one by joint or over time with {type(settings).__name__}, which is "
        "plain MuJoCo without joint stiffness; leave it out, or use halfphysics.Settings"
    )


def follow_in_engine(
    world: World,
    motions: Sequence[Motion],
    stiffness: NDArray[np.float64] | None,
    done: Callable[[int], Any],
) -> Result:
    """`Drive.follow` of what runs in MuJoCo, which is imported only then."""
    from halfphysics.baselines.engine.following import follow

    if stiffness is not None:
        raise no_stiffness(world.settings)
    return follow(world, motions, done)
