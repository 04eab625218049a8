"""PersonResult: one person of a result."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.copying import ReadOnly
from halfphysics.base.in_notebook import InNotebook
from halfphysics.errors import InputError
from halfphysics.motion.motion import Motion
from halfphysics.motion.pose import checked
from halfphysics.motion.skeleton import N_JOINTS
from halfphysics.results.deferred import Deferred, typed, typed_or_deferred
from halfphysics.results.surroundings import Surroundings

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.support.support import Support

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class PersonResult(InNotebook, ReadOnly):
    """One person of a result.

    Attributes:
        name: As in `Result.names`.
        motion: The simulated motion.
        reference: The reference motion, which the physics follows, with the same frames and frame
            rate; `recorded` is what measures compare with.
        body: The person's body. In a result from a file it is loaded on first access; raises
            `FileError` if a licensed model is missing or has changed (see `Result.load`).
        torque: Torque of the drive on the joints (T, 55, 3) [N m], mean over (t-1, t], in the frame
            of the joint's child, row 0 on the whole body: zero in free motion, against the
            contacts otherwise. See docs/physics.md. None: unknown (older files).
        clock: Time of the reference at every frame (T,) [s]: that of the frame, less what the
            person has waited (`Settings.blocked`); given None, it never waited.
        corrected: Frames (T,) in which the reference was put on what is under it
            (`Settings.weight`); given None, none.
        surroundings: What was around the person; `Result` sets it.
    """

    name: str
    motion: Motion
    reference: Motion
    body: Deferred[Body] = Deferred()
    torque: Array | None = None
    clock: Array | None = None
    corrected: NDArray[np.bool_] | None = None
    surroundings: Surroundings | None = None

    def __post_init__(self) -> None:
        from halfphysics.body.body import Body

        typed("motion", self.motion, Motion)
        typed("reference", self.reference, Motion)
        typed_or_deferred("body", vars(self)["_body"], Body)
        if len(self.motion) != len(self.reference):
            raise InputError(
                f"person {self.name!r}: the motion has {len(self.motion)} frames and the "
                f"reference {len(self.reference)}; expected the same number"
            )
        if self.torque is not None:
            shape = (len(self.motion), N_JOINTS, 3)
            # A read-only array is the core's own: mostly zeros, which take no memory.
            own = isinstance(self.torque, np.ndarray) and not self.torque.flags.writeable
            if not own or self.torque.shape != shape:
                object.__setattr__(
                    self, "torque", checked("torque", self.torque, shape, "(T, 55, 3)")
                )

        count = len(self.motion)
        clock = np.arange(count) / self.motion.fps if self.clock is None else self.clock
        object.__setattr__(self, "clock", checked("clock", clock, (count,), "(T,)"))
        corrected = np.zeros(count) if self.corrected is None else self.corrected
        flags = checked("corrected", corrected, (count,), "(T,)") != 0.0
        flags.setflags(write=False)
        object.__setattr__(self, "corrected", flags)
        # What was to be held is the reference's.
        object.__setattr__(self, "motion", self.motion.bare())

    def __repr__(self) -> str:
        off = np.linalg.norm(self.motion.translation - self.recorded.translation, axis=1).max()
        return (
            f"PersonResult({self.name}: {len(self.motion)} frames at {self.motion.fps:g} fps, "
            f"root up to {1000.0 * off:.3g} mm off its path)"
        )

    @property
    def recorded(self) -> Motion:
        """What was asked for: the reference, or what was recorded where it was adapted to it."""
        return self.reference if self.reference.recorded is None else self.reference.recorded

    @cached_property
    def support(self) -> Support:
        """What holds the person up: forces, centres of pressure, joint torques with gravity, and
        the residual that nothing could supply. Computed on first access; files do not hold it.

        Raises:
            InputError: The person is of no result.
            FileError: In a result from a file: the body or a mesh of the scene is missing.
        """
        from halfphysics.support.estimate import support_of

        if self.surroundings is None:
            raise InputError(
                f"person {self.name!r}: found no result that it is of, expected one of "
                "Result.people. Of a motion alone: halfphysics.support.estimate(motion, scene)"
            )
        return support_of(self.motion, self.body, self.surroundings)

    def joint_errors(self, *, driven: bool = False) -> tuple[Array, Array]:
        """Distances (T, 55) [m] of joints from `recorded`: relative to the pelvis, global.

        Args:
            driven: From the `reference` instead: how exactly it was followed.
        """
        asked = self.reference if driven else self.recorded
        p, q = self.body.joints(self.motion), self.body.joints(asked)
        local = np.linalg.norm((p - p[:, :1]) - (q - q[:, :1]), axis=-1)
        return local, np.linalg.norm(p - q, axis=-1)
