"""Inverse dynamics: the wrench that the surroundings must supply, and the torques in the joints.

For part k with mass m, centre of mass c, inertia I about it (world axes), acceleration a and
angular velocity w (Newton and Euler)::

    f_k = m (a - g)                      n_k = I dw/dt + w x (I w)

Summed over all parts about the pelvis, less what is known to act, that is the wrench that is
missing. The torque in joint j is the moment about it of all that is beyond it::

    tau_j = sum_(k beyond j) n_k + (c_k - p_j) x f_k - (what acts on k from outside)

Rates come from the parts' own paths, so no generalised coordinates are needed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.motion.skeleton import N_JOINTS, PARENTS
from halfphysics.support.differentiation import rates, turns
from halfphysics.support.flight import flights, runs

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, kw_only=True, eq=False)
class Dynamics:
    """What moves the parts of a person, in T frames; world frame.

    Attributes:
        joints: Positions of the joints (T, 55, 3) [m].
        quaternions: World from joint (T, 55, 4).
        wrench: Force [N] and moment about the pelvis [N m] that each part needs, gravity and
            inertia included (T, 55, 6).
        spin: Angular velocity of each part (T, 55, 3) [rad/s].
        airborne: Frames of flights (T,).
        mass: Of the person [kg].
        centre: Centre of mass (T, 3) [m].
        momentum: (T, 3) [kg m/s].
        angular_momentum: About the centre of mass (T, 3) [kg m^2/s].
    """

    joints: Array
    quaternions: Array
    wrench: Array
    spin: Array
    airborne: Mask
    mass: float
    centre: Array
    momentum: Array
    angular_momentum: Array


def dynamics(
    body: Body,
    motion: Motion,
    gravity: Array,
    cutoff: float | None,
    carried: Mask | None = None,
) -> Dynamics:
    """The wrenches that a motion needs.

    Args:
        body: Its rigid parts carry mass and inertia.
        motion: T >= 1 frames.
        gravity: Acceleration of free fall (3,) [m/s^2].
        cutoff: Of the low-pass filter of velocities [Hz]; None: no filter.
        carried: Frames (T,) in which something could carry, which are no flight; None: all.
    """
    parts = body.variant.parts
    mass = np.array([part.mass for part in parts])
    com = np.array([part.com for part in parts])
    inertia = np.array([part.inertia for part in parts])
    joints, quaternions = body.joint_frames(motion)
    centre = joints + rot.rotate(quaternions, np.broadcast_to(com, joints.shape))
    total = mass.sum()
    middle = np.einsum("k,tki->ti", mass, centre) / total
    everywhere = np.ones(len(centre), dtype=bool)
    carried = everywhere if carried is None else carried
    airborne = flights(middle, motion.fps, gravity, carried)
    options = motion.fps, cutoff, runs(airborne)
    velocity, acceleration = rates(np.diff(centre, axis=0), *options)
    spin, spin_rate = rates(turns(quaternions), *options)
    turn = rot.to_matrix(quaternions)

    def inertial(vectors: Array) -> Array:
        """Products (T, 55, 3) of the inertias with vectors in the world."""
        own = np.einsum("tkji,tkj->tki", turn, vectors)
        result: Array = np.einsum("tkij,tkj->tki", turn, np.einsum("kij,tkj->tki", inertia, own))
        return result

    spinning = inertial(spin)
    force = mass[:, None] * (acceleration - gravity)
    moment = inertial(spin_rate) + np.cross(spin, spinning)
    moment += np.cross(centre - joints[:, :1], force)
    momentum = np.einsum("k,tki->tki", mass, velocity)
    swing = np.cross(centre - middle[:, None], momentum) + spinning
    return Dynamics(
        joints=joints,
        quaternions=quaternions,
        wrench=np.concatenate([force, moment], axis=-1),
        spin=spin,
        airborne=airborne,
        mass=float(total),
        centre=middle,
        momentum=momentum.sum(axis=1),
        angular_momentum=swing.sum(axis=1),
    )


def joint_torques(found: Dynamics, external: Array) -> Array:
    """Torques (T, 55, 3) [N m] on the joints, in the frame of the joint's child.

    Row 0 is the moment on the whole body that nothing supplies.

    Args:
        found: The wrenches that the parts need.
        external: Force [N] and moment about the pelvis [N m] that act on each part from outside
            (T, 55, 6).
    """
    beyond = found.wrench - external
    for k in range(N_JOINTS - 1, 0, -1):  # children follow their parents
        beyond[:, PARENTS[k]] += beyond[:, k]
    arm = found.joints - found.joints[:, :1]
    torque = beyond[..., 3:] - np.cross(arm, beyond[..., :3])
    return rot.rotate(rot.conjugate(found.quaternions), torque)


def joint_power(found: Dynamics, torque: Array) -> Array:
    """Power (T, 55) [W] of joint torques (T, 55, 3), in the frame of the child; row 0 is 0."""
    relative = found.spin - found.spin[:, np.maximum(PARENTS, 0)]
    power: Array = (rot.rotate(found.quaternions, torque) * relative).sum(axis=-1)
    return power
