"""Acting: a motion from timed changes of pelvis, trunk, hands and feet.

An `Act` is a list of changes: a control goes from its value to a new one within some seconds, with
continuous speed and acceleration; overlapping changes of one control add up. Two-bone chains move
hands and feet to their targets. Angles are in degrees, lengths in metres, the world is z up; a
person with turn 0 faces +x.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.validation import frame_rate
from halfphysics.motion.easing import ease
from halfphysics.motion.motion import MODELS, Motion
from halfphysics.motion.skeleton import JOINT_INDEX, N_JOINTS
from halfphysics.scenarios.acting.arms import FOREARM
from halfphysics.scenarios.acting.legs import REACH, WORLD_FROM_REST, about, leg_of

if TYPE_CHECKING:
    from halfphysics.body.body import Body

Array = NDArray[np.float64]

#: Height of soles above the ground [m]: more than twice the simulator's clearance.
LIFT = 0.004
#: Side -> its sign along y.
SIDES = {"left": 1.0, "right": -1.0}
_SPINE = ("spine1", "spine2", "spine3")
_FINGERS = ("index", "middle", "pinky", "ring")
# Fraction of its reach beyond which a limb stays behind its target.
_SOFT = 0.985
# Lowering of a standing person by bent knees [m]: straight legs define no plane.
_BENT = 0.018

#: The controls and their initial values. `side` means left and right.
#:   pelvis: position of the pelvis joint; turn: rotation of the pelvis about z (left), about its
#:   left axis (forward), about its forward axis (to the right); bend: bend of the spine forward,
#:   to the right, and twist to the left; nod: forward bend of neck and head.
#:   side_foot: position of the ankle; side_toes: heading of the foot to the left, toes up, toes
#:   bent up; knees: direction of the knees, world.
#:   side_arm: wrist from shoulder in the chest's frame (ahead, outward, up), for a free arm;
#:   side_hand: wrist in the world; side_hold: 0 uses side_arm, 1 side_hand;
#:   side_palm: normal of the back of a holding hand, side_fingers: its direction, world;
#:   elbows: direction of elbows, chest's frame (ahead, outward, up); curl: flexion of the fingers.
_CONTROLS = {
    "pelvis": (0.0, 0.0, 1.0),
    "turn": (0.0, 0.0, 0.0),
    "bend": (0.0, 0.0, 0.0),
    "nod": (0.0,),
    "knees": (1.0, 0.0, 0.0),
    "elbows": (-1.0, 0.35, -0.2),
    "curl": (18.0,),
    **{
        f"{side}_{control}": value
        for side, y in SIDES.items()
        for control, value in (
            ("foot", (0.0, 0.1 * y, 0.1)),
            ("toes", (6.0 * y, 0.0, 0.0)),
            ("arm", (0.10, 0.12, -0.47)),
            ("hand", (0.3, 0.2 * y, 1.0)),
            ("hold", (0.0,)),
            ("palm", (0.0, 0.0, 1.0)),
            ("fingers", (1.0, 0.0, 0.0)),
        )
    },
}


class Act:
    """A motion under construction: a person at the origin, facing +x, arms hanging."""

    def __init__(self, body: Body) -> None:
        self.body = body
        self.legs = {side: leg_of(body, side) for side in SIDES}
        self._joints = np.asarray(body.rest_joints)
        self._now = {name: np.array(value) for name, value in _CONTROLS.items()}
        # Control -> (start, seconds, change, whether it returns).
        self._moves: dict[str, list[tuple[float, float, Array, bool]]] = {n: [] for n in _CONTROLS}
        pelvis = []
        for side, leg in self.legs.items():
            ankle = WORLD_FROM_REST @ (leg.hip + leg.thigh + leg.shank)
            pelvis.append(leg.height - ankle[2])
            self.begin(**{f"{side}_foot": (0.0, ankle[1], leg.height + LIFT)})
            self.begin(**{f"{side}_foot": (ankle[0], ankle[1], leg.height + LIFT)})
        #: Height of the pelvis joint when standing [m].
        self.standing = min(pelvis) + LIFT - _BENT
        self.begin(pelvis=(0.0, 0.0, self.standing))

    def __getitem__(self, control: str) -> Array:
        """The value of a control after all changes so far."""
        return self._now[control].copy()

    def begin(self, **values: ArrayLike) -> None:
        """Set the initial values of controls."""
        for name, value in values.items():
            self._now[name] = np.atleast_1d(np.array(value, dtype=np.float64))

    def both(self, **values: ArrayLike) -> dict[str, Array]:
        """Controls of both sides from those of the left side, mirrored at the x-z plane."""
        out = {}
        for name, value in values.items():
            for side, y in SIDES.items():
                given = np.atleast_1d(np.array(value, dtype=np.float64))
                if name in ("foot", "hand", "palm", "fingers"):
                    given[1] *= y
                elif name == "toes":
                    given[0] *= y
                out[f"{side}_{name}"] = given
        return out

    def move(self, start: float, seconds: float, **values: ArrayLike) -> None:
        """Change controls to new values within `seconds` from `start` on."""
        for name, value in values.items():
            goal = np.atleast_1d(np.array(value, dtype=np.float64))
            self._moves[name].append((start, seconds, goal - self._now[name], False))
            self._now[name] = goal

    def step(
        self, side: str, start: float, seconds: float, to: ArrayLike, lift: float = 0.06
    ) -> None:
        """Move the ankle of a foot to a new position (3,), raised by `lift` in between."""
        self.move(start, seconds, **{f"{side}_foot": to})
        self._moves[f"{side}_foot"].append((start, seconds, np.array([0.0, 0.0, lift]), True))

    def lift(self, control: str, start: float, seconds: float, by: ArrayLike) -> None:
        """Offset a control temporarily by `by`."""
        self._moves[control].append((start, seconds, np.array(by, dtype=np.float64), True))

    def motion(self, seconds: float, fps: float) -> Motion:
        """The motion, sampled `fps` times a second.

        Raises:
            InputError: An impossible `fps`.
        """
        fps = frame_rate(fps)
        times = np.arange(int(np.floor(seconds * fps + 1e-9)) + 1) / fps
        now = {name: self._sampled(name, times) for name in _CONTROLS}
        rotations = np.zeros((len(times), N_JOINTS, 3))
        root = _turned(now["turn"])
        rotations[:, 0] = rot.matrix_to_rotvec(root)
        chest, at = self._trunk(now, root, rotations)
        for side in SIDES:
            self._leg(side, now, root, rotations)
            self._arm(side, now, chest, at, rotations)
        smpl = self.body.model in MODELS
        return Motion(
            now["pelvis"] - self._joints[0],
            rotations,
            fps,
            betas=self.body.betas if smpl else None,
            gender=self.body.gender if smpl else "neutral",
            model=self.body.model if smpl else "smplx",
        )

    def _sampled(self, name: str, times: Array) -> Array:
        moves = self._moves[name]
        first = self._now[name] - sum((by for *_, by, back in moves if not back), np.zeros(1))
        out = np.tile(first, (len(times), 1))
        for start, seconds, by, back in moves:
            u = (times - start) / seconds
            part = ease(2.0 * u) * ease(2.0 - 2.0 * u) if back else ease(u)
            out += part[:, None] * by
        return out

    def _trunk(self, now: dict[str, Array], root: Array, rotations: Array) -> tuple[Array, Array]:
        """Set spine and head; returns the chest's frame (T, 3, 3) and position (T, 3)."""
        third = np.radians(now["bend"]) / 3.0
        turn = about(1, third[:, 2]) @ about(2, third[:, 1]) @ about(0, third[:, 0])
        at, frame, before = now["pelvis"], root, 0
        for name in _SPINE:
            joint = JOINT_INDEX[name]
            at = at + frame @ (self._joints[joint] - self._joints[before])
            frame, before = frame @ turn, joint
            rotations[:, joint] = rot.matrix_to_rotvec(turn)
        for name in ("neck", "head"):
            rotations[:, JOINT_INDEX[name], 0] = 0.5 * np.radians(now["nod"][:, 0])
        return frame, at

    def _leg(self, side: str, now: dict[str, Array], root: Array, rotations: Array) -> None:
        leg = self.legs[side]
        hip = now["pelvis"] + root @ leg.hip
        toes = np.radians(now[f"{side}_toes"])
        foot = about(2, toes[:, 0]) @ WORLD_FROM_REST @ about(0, -toes[:, 1])
        thigh, shank = _chain(
            leg.thigh, leg.shank, now[f"{side}_foot"] - hip, now["knees"], np.array([0.0, 0.0, 1.0])
        )
        turns = (_T(root) @ thigh, _T(thigh) @ shank, _T(shank) @ foot, about(0, -toes[:, 2]))
        for joint, turn in zip(leg.joints, turns, strict=True):
            rotations[:, joint] = rot.matrix_to_rotvec(turn)

    def _arm(
        self, side: str, now: dict[str, Array], chest: Array, at: Array, rotations: Array
    ) -> None:
        y, joints = SIDES[side], self._joints
        shoulder, elbow, wrist = (
            JOINT_INDEX[f"{side}_{n}"] for n in ("shoulder", "elbow", "wrist")
        )
        # Arms are given in the chest's frame with x ahead and y left, mirrored for the right arm.
        ahead = chest @ WORLD_FROM_REST.T
        here = at + chest @ (joints[shoulder] - joints[JOINT_INDEX["spine3"]])
        mirror = np.array([1.0, y, 1.0])
        free = np.einsum("tij,tj->ti", ahead, now[f"{side}_arm"] * mirror)
        pole = np.einsum("tij,tj->ti", ahead, now["elbows"] * mirror)
        hold = now[f"{side}_hold"]
        goal = (1.0 - hold) * free + hold * (now[f"{side}_hand"] - here)
        a, b = joints[elbow] - joints[shoulder], joints[wrist] - joints[elbow]
        upper, fore = _chain(a, b, goal, pole, np.array([0.0, 0.0, -1.0]))
        # Free hands: thumbs ahead and inward. Holding hands: the targets.
        loose = about(0, np.full(len(at), 0.9))
        fingers = y * now[f"{side}_fingers"]
        held = _T(fore) @ _frame(fingers, now[f"{side}_palm"])
        turn = _between(loose, held, hold[:, 0])
        # The forearm takes most of the twist of a hand.
        q = rot.from_matrix(turn)
        along = b / np.linalg.norm(b)
        half = np.arctan2(q[:, 1:] @ along, q[:, 0])
        half = (half + 0.5 * np.pi) % np.pi - 0.5 * np.pi
        twist = rot.rotvec_to_matrix(2.0 * FOREARM * half[:, None] * along)
        rotations[:, shoulder] = rot.matrix_to_rotvec(_T(chest) @ upper)
        rotations[:, elbow] = rot.matrix_to_rotvec(_T(upper) @ fore @ twist)
        rotations[:, wrist] = rot.matrix_to_rotvec(_T(twist) @ turn)
        for finger in _FINGERS:
            for knuckle in (1, 2, 3):
                joint = JOINT_INDEX[f"{side}_{finger}{knuckle}"]
                rotations[:, joint, 2] = -y * np.radians(now["curl"][:, 0])


def _T(matrices: Array) -> Array:
    return np.swapaxes(matrices, -1, -2)


def _turned(degrees: Array) -> Array:
    """Frames of the pelvis (T, 3, 3) from its turns (T, 3) [degrees]."""
    turn = np.radians(degrees)
    result: Array = (
        about(2, turn[:, 0]) @ about(1, turn[:, 1]) @ about(0, turn[:, 2]) @ WORLD_FROM_REST
    )
    return result


def _unit(vectors: Array) -> Array:
    result: Array = vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
    return result


def _frame(x: Array, y: Array) -> Array:
    """Frames (..., 3, 3) with x axis `x` and the y axis closest to `y`."""
    x = _unit(x)
    y = _unit(y - np.sum(x * y, axis=-1, keepdims=True) * x)
    return np.stack([x, y, np.cross(x, y)], axis=-1)


def _between(a: Array, b: Array, part: Array) -> Array:
    """Rotations (T, 3, 3) at the fraction `part` (T,) between `a` and `b`."""
    way = rot.matrix_to_rotvec(_T(a) @ b)
    return a @ rot.rotvec_to_matrix(part[:, None] * way)


def _reached(distance: Array, reach: float) -> Array:
    """Distances (T,), unchanged up to `_SOFT` of a reach, then approaching it exponentially.

    A limb that stops abruptly at its reach snaps: its joint's velocity jumps to zero.
    """
    free = _SOFT * reach
    rest = reach - free
    beyond = np.clip(distance - free, 0.0, None)
    return np.minimum(distance, free) + rest * (1.0 - np.exp(-beyond / rest))


def _chain(
    upper: Array, lower: Array, goal: Array, pole: Array, rest_pole: Array
) -> tuple[Array, Array]:
    """World frames (T, 3, 3) of two bones that reach from one end to `goal` (T, 3).

    Args:
        upper, lower: The bones at rest (3,).
        goal: The far end from the near end; if out of reach, approached along the same line.
        pole: Direction of the joint between the bones (T, 3).
        rest_pole: That direction at rest (3,).
    """
    a, b = np.linalg.norm(upper), np.linalg.norm(lower)
    line = _unit(goal)
    distance = _reached(np.linalg.norm(goal, axis=1), float(REACH * (a + b)))
    side = _unit(np.cross(pole, line))
    front = np.cross(line, side)
    cosine = (a * a + distance**2 - b * b) / (2.0 * a * distance)
    sine = np.sqrt(np.clip(1.0 - cosine**2, 0.0, None))
    joint = (a * cosine)[:, None] * line + (a * sine)[:, None] * front
    rest_side = _unit(np.cross(rest_pole, upper + lower))

    def bone(rest: Array, actual: Array) -> Array:
        return _frame(actual, side) @ _frame(rest, rest_side).T

    return bone(upper, joint), bone(lower, distance[:, None] * line - joint)
