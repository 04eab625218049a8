"""Rotations of a body from where its joints are: Gauss-Newton steps over all frames at once.

Unknown in every frame are the place of the pelvis and the rotation R_j of every joint with a known
joint below it. Minimised is::

    sum_k w_k |x_k - X_k|^2 / s^2  +  sum_j (phi_j - m_j)' W_j (phi_j - m_j)

- x_k = x_p + R_p o_k are the joints of the body, o_k their offsets at rest, X_k the given places,
  s the `_NOISE` of these, w_k 1 or what a `compromise` says.
- phi_j = log(R_p' R_j) is a joint's own rotation. m_j and W_j (`joint_priors`) say how people bend:
  a knee about one axis, an elbow about one, shoulders and hips about all. Places alone leave the
  turn about a straight limb free, and bent limbs show it through the bending plane; the two are
  weighed here, so that it goes over smoothly from one to the other, and positions are met all the
  same: s is small.

A step turns every joint by omega_j, R_j <- exp(omega_j) R_j, and moves the pelvis. To first order
a child moves by ``dx_c = dx_j - [R_j o_c]x omega_j`` and ``dphi_j = Jr^-1(phi_j) R_j' (omega_j -
omega_p)``. So the normal equations are a tree: what is below joint j costs a quadratic function of
(dx_j, omega_p) alone. From the leaves to the pelvis each omega_j is eliminated by a 3 x 3 solve,
then all are found from the pelvis to the leaves. The work grows with the number of joints, not
with its cube.

Joints without a known joint below them (head, hands, toes) keep their parents' rotations. Marks are
further points, rigid to a joint (a nose, a heel), that are met in the same way: with them such
joints turn, too.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.progress import over
from halfphysics.formats.positions.first_guess import first_guess, rigid
from halfphysics.formats.positions.joint_priors import MEANS, WEIGHTS
from halfphysics.motion.skeleton import N_JOINTS, PARENTS

Array = NDArray[np.float64]

#: How precisely joints are met [m]: smaller, and noise of centimetres turns limbs about themselves;
#: larger, and the priors move joints by more than a millimetre.
_NOISE = 4e-3
#: Steps of Gauss-Newton: two more change no angle by more than two degrees (ten real clips).
_STEPS = 4
#: A step turns no joint by more than this [rad].
_LARGEST = 0.7
#: Added to the matrices that are inverted, relative to 1 / s^2 and the square of a bone.
_DAMPING = 1e-9
#: Frames solved at once: bounds the memory and keeps arrays in the cache.
_CHUNK = 512


class Marks(NamedTuple):
    """Points of the skin that are seen, each rigid to a joint.

    Attributes:
        joints: The SMPL-X joint of each (m,).
        offsets: From that joint, at rest (m, 3) [m].
        seen: Where they are (T, m, 3) [m], in the axes of the positions.
    """

    joints: tuple[int, ...]
    offsets: Array
    seen: Array


class Solved(NamedTuple):
    """A motion that meets joint positions.

    Attributes:
        pelvis: Positions of the pelvis joint (T, 3) [m].
        rotations: Axis-angle (T, 55, 3) [rad] in the parents' frames.
        errors: Distances of the joints from the given places (T, n) [m], in the order given.
    """

    pelvis: Array
    rotations: Array
    errors: Array


def solve(
    positions: Array,
    joints: Sequence[int],
    rest: Array,
    pulls: Array | None = None,
    marks: Marks | None = None,
) -> Solved:
    """The rotations with which a body's joints are where they are seen.

    Args:
        positions: Positions (T, n, 3) [m], in axes with y up or any others.
        joints: Their SMPL-X joints (n,): all of the first 22, and others such as those of fingers.
        rest: Joints of the body at rest (55, 3) [m].
        pulls: Factors w_k of the joints (55,); None: all 1.
        marks: Points rigid to joints, all of them to `joints`.
    """
    tree = _Tree(joints, rest, marks)
    seen = np.empty((len(positions), len(tree.parents), 3))
    seen[:, list(joints)] = positions
    if marks is not None:
        seen[:, N_JOINTS:] = marks.seen
    world = first_guess(seen, rest)
    precision = np.ones(len(tree.parents)) / _NOISE**2
    if pulls is not None:
        precision[:N_JOINTS] *= pulls
    for joint in set(() if marks is None else marks.joints):
        below = tree.children[joint]
        if len(below) > 1:
            world[:, joint] = rigid(tree.offsets[below], seen[:, below] - seen[:, [joint]])
    pelvis = np.array(seen[:, 0])
    errors = np.empty(positions.shape[:2])
    for start in over(
        range(0, len(positions), _CHUNK), "rotations of positions", "frame", size=_CHUNK
    ):
        rows = slice(start, start + _CHUNK)
        for _ in range(_STEPS):
            _step(tree, seen[rows], world[rows], pelvis[rows], precision)
        places = tree.places(world[rows], pelvis[rows])
        off = places[:, list(joints)] - positions[rows]
        errors[rows] = np.linalg.norm(off, axis=2)
    local = world.copy()
    local[:, 1:] = rot.multiply(rot.conjugate(world[:, PARENTS[1:]]), world[:, 1:])
    rotations = rot.log(local)
    rotations[:, [j for j in range(1, N_JOINTS) if j not in tree.inner]] = 0.0
    return Solved(pelvis, rotations, errors)


class _Tree:
    """The joints that are seen, then the marks; those that turn, and their bones."""

    def __init__(self, joints: Sequence[int], rest: Array, marks: Marks | None) -> None:
        self.parents = PARENTS.tolist()
        self.seen = sorted(joints)
        self.offsets = rest - rest[np.maximum(PARENTS, 0)]
        if marks is not None:
            self.parents += marks.joints
            self.seen += range(N_JOINTS, len(self.parents))
            self.offsets = np.concatenate([self.offsets, marks.offsets])
        #: Joints with something seen below them: these turn.
        self.inner = sorted({self.parents[j] for j in self.seen if j})
        self.children = {j: [c for c in self.seen if self.parents[c] == j] for j in self.inner}

    def places(self, world: Array, pelvis: Array) -> Array:
        """Positions (T, 55 + m, 3) [m], in those not seen nothing is written."""
        places = np.empty((len(world), len(self.parents), 3))
        places[:, 0] = pelvis
        for joint in self.inner:
            for child in self.children[joint]:
                bone = rot.rotate(world[:, joint], self.offsets[child])
                places[:, child] = places[:, joint] + bone
        return places


def _step(tree: _Tree, seen: Array, world: Array, pelvis: Array, precision: Array) -> None:
    """One step; `world` (T, 55, 4) and `pelvis` (T, 3) are changed.

    `precision` (55,): w_k / s^2.
    """
    places = tree.places(world, pelvis)
    damping = _DAMPING / _NOISE**2
    # Of every inner joint but the pelvis: the cost of all below as a quadratic of (dx_j, omega_p),
    # and the gain and the offset of omega_j in it.
    costs: dict[int, tuple[Array, Array]] = {}
    policies: dict[int, tuple[Array, Array]] = {}
    for joint in reversed(tree.inner):
        hessian, gradient = _below(tree, joint, places, seen, world, costs, precision)
        if joint == 0:
            damped = hessian + damping * np.eye(6)
            step = -_times(np.asarray(np.linalg.inv(damped), dtype=np.float64), gradient)
            break
        weight, pull = _prior(joint, world)
        damped = hessian[:, 3:, 3:] + weight + damping * np.eye(3)
        inverse = np.asarray(np.linalg.inv(damped), dtype=np.float64)
        # omega_j = -inverse (hwx dx + gw + pull - weight omega_p)
        cross = np.concatenate([hessian[:, 3:, :3], -weight], axis=2)  # d omega_j of (dx, omega_p)
        gain, constant = -inverse @ cross, -_times(inverse, gradient[:, 3:] + pull)
        own = np.zeros_like(hessian)
        own[:, :3, :3], own[:, 3:, 3:] = hessian[:, :3, :3], weight
        costs[joint] = (
            own + np.swapaxes(cross, 1, 2) @ gain,
            np.concatenate([gradient[:, :3], -pull], axis=1)
            + _times(np.swapaxes(cross, 1, 2), constant),
        )
        policies[joint] = (gain, constant)
    turns = {0: _limited(step[:, 3:])}
    moves = {0: step[:, :3]}
    for joint in tree.inner:
        if joint:
            gain, constant = policies[joint]
            state = np.concatenate([moves[joint], turns[int(PARENTS[joint])]], axis=1)
            turns[joint] = _limited(_times(gain, state) + constant)
        for child in tree.children[joint]:
            bone = places[:, child] - places[:, joint]
            moves[child] = moves[joint] + np.cross(turns[joint], bone)
    pelvis += moves[0]
    for joint in range(N_JOINTS):
        if joint in turns:
            world[:, joint] = rot.normalize(rot.multiply(rot.exp(turns[joint]), world[:, joint]))
        else:
            world[:, joint] = world[:, PARENTS[joint]]


def _below(
    tree: _Tree,
    joint: int,
    places: Array,
    seen: Array,
    world: Array,
    costs: dict[int, tuple[Array, Array]],
    precision: Array,
) -> tuple[Array, Array]:
    """Hessian (T, 6, 6) and gradient (T, 6) of all below a joint and its own place, in its
    (dx_j, omega_j)."""
    frames = len(places)
    hessian, gradient = np.zeros((frames, 6, 6)), np.zeros((frames, 6))
    diagonal = np.arange(3)
    hessian[:, diagonal, diagonal] += precision[joint]
    gradient[:, :3] += precision[joint] * (places[:, joint] - seen[:, joint])
    for child in tree.children[joint]:
        bone = _skew(places[:, child] - places[:, joint])  # dx_c = dx_j - bone omega_j
        if child in costs:
            below, slope = costs[child]
            xx, xw, ww = below[:, :3, :3], below[:, :3, 3:], below[:, 3:, 3:]
            gx, gw = slope[:, :3], slope[:, 3:]
        else:
            xx = np.broadcast_to(precision[child] * np.eye(3), (frames, 3, 3))
            xw = ww = np.zeros((frames, 3, 3))
            gx = precision[child] * (places[:, child] - seen[:, child])
            gw = np.zeros((frames, 3))
        turned = xx @ bone
        crossed = bone @ xw  # bone' = -bone
        hessian[:, :3, :3] += xx
        off = xw - turned
        hessian[:, :3, 3:] += off
        hessian[:, 3:, :3] += np.swapaxes(off, 1, 2)
        hessian[:, 3:, 3:] += ww - bone @ turned + crossed + np.swapaxes(crossed, 1, 2)
        gradient[:, :3] += gx
        gradient[:, 3:] += gw + _times(bone, gx)
    return hessian, gradient


def _prior(joint: int, world: Array) -> tuple[Array, Array]:
    """Weight (T, 3, 3) and pull (T, 3) of a joint's prior in omega_j - omega_p, world axes."""
    local = rot.multiply(rot.conjugate(world[:, PARENTS[joint]]), world[:, joint])
    phi = rot.log(local)
    jacobian = _right_inverse(phi) @ np.swapaxes(rot.to_matrix(world[:, joint]), 1, 2)
    weighed = np.swapaxes(jacobian, 1, 2) * WEIGHTS[joint]
    return weighed @ jacobian, _times(weighed, phi - MEANS[joint])


def _right_inverse(phi: Array) -> Array:
    """Inverse right Jacobian (T, 3, 3) of the exponential map at (T, 3): log(exp(phi) exp(d)) =
    phi + Jr^-1 d."""
    angle = np.linalg.norm(phi, axis=1)
    half = 0.5 * np.minimum(angle, 3.1)  # infinite at a full turn, which no joint makes
    small = angle < 1e-3
    safe = np.where(small, 1.0, angle)
    factor = np.where(
        small, 1.0 / 12.0, (1.0 - half / np.tan(np.where(small, 1.0, half))) / safe**2
    )
    cross = _skew(phi)
    return np.eye(3) + 0.5 * cross + factor[:, None, None] * (cross @ cross)


def _limited(turn: Array) -> Array:
    """Turns (T, 3), none over the largest."""
    angle = np.linalg.norm(turn, axis=1, keepdims=True)
    return np.asarray(turn * np.minimum(1.0, _LARGEST / np.maximum(angle, 1e-12)))


def _skew(v: Array) -> Array:
    """Matrices (T, 3, 3) of the cross product with (T, 3)."""
    out = np.zeros((len(v), 3, 3))
    out[:, 0, 1], out[:, 0, 2], out[:, 1, 2] = -v[:, 2], v[:, 1], -v[:, 0]
    out[:, 1, 0], out[:, 2, 0], out[:, 2, 1] = v[:, 2], -v[:, 1], v[:, 0]
    return out


def _times(matrix: Array, vector: Array) -> Array:
    return np.asarray((matrix @ vector[..., None])[..., 0])
