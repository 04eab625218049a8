"""A dancer: joint angles over time within human ranges, on the ground.

A `Score` is a list of changes: a channel (one angle of one joint) goes from what it is to a new
value by a polynomial without a jump in speed or acceleration, and never leaves its range. The
position of the dancer follows from contact: the lowest point of the body touches the ground and
does not slide, so that steps move the body and turns pivot on the standing foot; in a jump no point
touches the ground.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.body.skinning import kinematics
from halfphysics.motion.easing import ease
from halfphysics.motion.motion import MODELS, Motion
from halfphysics.motion.skeleton import JOINT_INDEX, N_JOINTS
from halfphysics.scenarios.acting.legs import WORLD_FROM_REST, about, leg_of

if TYPE_CHECKING:
    from halfphysics.body.body import Body

Array = NDArray[np.float64]

SIDES = {"left": 1.0, "right": -1.0}
#: Channel -> (minimum, maximum, initial value) [degrees; air: m]. Ranges of supple adults, well
#: within the limits of the joints. Forward, to the right side and turning left are positive.
TRUNK = {
    "lean": (-60.0, 75.0, 3.0),
    "roll": (-25.0, 25.0, 0.0),
    "bend": (-25.0, 60.0, 4.0),
    "side": (-30.0, 30.0, 0.0),
    "twist": (-45.0, 45.0, 0.0),
    "nod": (-35.0, 35.0, 0.0),
    "look": (-60.0, 60.0, 0.0),
    "bounce": (0.0, 12.0, 0.0),
    "air": (0.0, 0.4, 0.0),
}
#: The same of one arm: where the upper arm points (ahead of sideways, below horizontal), its turn
#: about itself, the elbow's bend, the forearm's turn, the hand's bend, the fingers' curl.
ARM = {
    "ahead": (-30.0, 120.0, 20.0),
    "down": (-80.0, 80.0, 70.0),
    "turned": (-60.0, 60.0, 0.0),
    "elbow": (4.0, 140.0, 30.0),
    "forearm": (-70.0, 70.0, 30.0),
    "wrist": (-55.0, 55.0, 0.0),
    "curl": (0.0, 75.0, 20.0),
    "shrug": (-5.0, 20.0, -3.0),
}
#: The same of one leg: thigh forward, outward and turned out, knee, foot pointed beyond flat.
LEG = {
    "hip": (-25.0, 105.0, 8.0),
    "open": (-15.0, 55.0, 5.0),
    "out": (-30.0, 40.0, 6.0),
    "knee": (4.0, 125.0, 14.0),
    "point": (0.0, 35.0, 0.0),
}
#: Least and most of the ankle, which keeps the sole flat where it can [degrees], toes down.
ANKLE = (-30.0, 50.0)
#: Largest rate of an angle [degrees/s]: of arms; of legs, the trunk and the whole body.
FASTEST_ARM, FASTEST = 700.0, 600.0
# Shortest duration of a change [s]; slightly longer for the height of a jump.
_SHORTEST, _SHORTEST_AIR = 0.05, 0.2
# Largest speed of the body over feet on the ground [m/s]: beyond it they slip.
_CARRIED = 3.0
# Width of the smooth minimum that finds the lowest point [m].
_SOFT = 0.02
# Smallest rate of integration [1/s].
_FINE = 240.0
_BOUND = {**TRUNK, **{f"{side}_{n}": v for side in SIDES for n, v in {**ARM, **LEG}.items()}}


def bounds(channel: str) -> tuple[float, float]:
    """Minimum and maximum of a channel [degrees; air: m]; "turn" has none."""
    return _BOUND[channel][:2] if channel in _BOUND else (-np.inf, np.inf)


class Score:
    """Keyframes of the channels of a dancer: `TRUNK`, and `ARM` and `LEG` by side."""

    def __init__(self, beat: float) -> None:
        #: Time between two beats [s].
        self.beat = beat
        self._now = {name: first for name, (_, _, first) in _BOUND.items()} | {"turn": 0.0}
        # Channel -> (start, seconds, by how much), one after the other.
        self._moves: dict[str, list[tuple[float, float, float]]] = {n: [] for n in self._now}

    def __getitem__(self, channel: str) -> float:
        return self._now[channel]

    def to(self, start: float, seconds: float, **goals: float) -> None:
        """Change channels to new values within `seconds` from `start` on, within their ranges.

        A change waits for the previous change of its channel, and takes longer where it would be
        faster than the limit.
        """
        for name, goal in goals.items():
            low, high = bounds(name)
            by = float(np.clip(goal, low, high)) - self._now[name]
            moves = self._moves[name]
            begin = max(start, moves[-1][0] + moves[-1][1]) if moves else start
            if name == "air":
                shortest = _SHORTEST_AIR
            else:  # the largest rate of `ease` is 15/8 of its mean
                fastest = FASTEST_ARM if name.split("_")[-1] in ARM else FASTEST
                shortest = max(_SHORTEST, 1.875 * abs(by) / fastest)
            moves.append((begin, max(start + seconds - begin, shortest), by))
            self._now[name] += by

    def both(self, start: float, seconds: float, **goals: float) -> None:
        """Change the same channels of both sides."""
        for side in SIDES:
            self.to(start, seconds, **{f"{side}_{name}": goal for name, goal in goals.items()})

    def sampled(self, times: Array) -> dict[str, Array]:
        """All channels at `times` (T,) [s]."""
        out = {}
        for name, moves in self._moves.items():
            first = self._now[name] - sum(by for *_, by in moves)
            out[name] = np.full(len(times), first)
            for start, seconds, by in moves:
                out[name] += by * ease((times - start) / seconds)
        return out


def danced(body: Body, score: Score, seconds: float, fps: float, heading: float = 0.0) -> Motion:
    """The motion of a score: `round(seconds * fps)` frames, from the origin, facing `heading`.

    Args:
        body: The body of the dancer; the motion gets its betas, gender and model if that is one of
            the SMPL family.
        score: The keyframes.
        seconds: Duration [s].
        fps: Frames per second.
        heading: Initial heading of the pelvis about z [rad], 0 along +x.
    """
    each = int(np.ceil(_FINE / fps))
    times = np.arange(round(seconds * fps) * each) / (fps * each)
    now = {name: np.radians(v) for name, v in score.sampled(times).items() if name != "air"}
    air = score.sampled(times)["air"]
    # Knees give on every beat; hips follow, so that the feet stay under the body.
    give = now["bounce"] * (0.5 - 0.5 * np.cos(2.0 * np.pi * times / score.beat))
    rotations = np.zeros((len(times), N_JOINTS, 3))
    root = (
        about(2, heading + now["turn"]) @ about(1, now["lean"]) @ about(0, now["roll"])
    ) @ WORLD_FROM_REST
    rotations[:, 0] = rot.matrix_to_rotvec(root)
    _trunk(now, rotations)
    for side, left in SIDES.items():
        _arm(side, left, now, rotations)
        _leg(side, left, now, give, rotations)
    path = _grounded(body, rotations, air, times[1])
    smpl = body.model in MODELS
    return Motion(
        path[::each] - np.asarray(body.rest_joints)[0],
        rotations[::each],
        fps,
        betas=body.betas if smpl else None,
        gender=body.gender if smpl else "neutral",
        model=body.model if smpl else "smplx",
    )


def _put(rotations: Array, joint: str, *matrices: Array) -> None:
    product = matrices[0]
    for matrix in matrices[1:]:
        product = product @ matrix
    rotations[:, JOINT_INDEX[joint]] = rot.matrix_to_rotvec(product)


# Rest frame: x left, y up, z forward. About x forward is positive for what points up and negative
# for what hangs; about z positive is to the own right for what points up.


def _trunk(now: dict[str, Array], rotations: Array) -> None:
    for joint in ("spine1", "spine2", "spine3"):
        turn, side, bend = (now[name] / 3.0 for name in ("twist", "side", "bend"))
        _put(rotations, joint, about(1, turn), about(2, side), about(0, bend))
    for joint in ("neck", "head"):
        _put(rotations, joint, about(1, 0.5 * now["look"]), about(0, 0.5 * now["nod"]))


def _arm(side: str, left: float, now: dict[str, Array], rotations: Array) -> None:
    ahead, down, turned, elbow, forearm, wrist, curl, shrug = (now[f"{side}_{n}"] for n in ARM)
    _put(rotations, f"{side}_collar", about(2, left * shrug))
    _put(
        rotations,
        f"{side}_shoulder",
        about(1, -left * ahead),
        about(2, -left * down),
        about(0, turned),
    )
    # Half of the forearm's turn is in the elbow's joint, half in the wrist's.
    half = about(0, 0.5 * forearm)
    _put(rotations, f"{side}_elbow", about(1, -left * elbow), half)
    _put(rotations, f"{side}_wrist", half, about(2, -left * wrist))
    for finger in ("index", "middle", "pinky", "ring"):
        for knuckle in (1, 2, 3):
            _put(rotations, f"{side}_{finger}{knuckle}", about(2, -left * curl))


def _leg(side: str, left: float, now: dict[str, Array], give: Array, rotations: Array) -> None:
    hip, open_, out, knee, point = (now[f"{side}_{n}"] for n in LEG)
    hip, knee = hip + give, knee + 2.0 * give
    _put(rotations, f"{side}_hip", about(1, left * out), about(2, left * open_), about(0, -hip))
    _put(rotations, f"{side}_knee", about(0, knee))
    low, high = np.radians(ANKLE)
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    flat = hip - knee - now["lean"] + point
    _put(rotations, f"{side}_ankle", about(0, middle + half * np.tanh((flat - middle) / half)))


def _grounded(body: Body, rotations: Array, air: Array, dt: float) -> Array:
    """Position of the pelvis (T, 3) [m] over the contact point, which does not slide."""
    places, quaternions = kinematics(
        rotations, np.zeros((len(rotations), 3)), np.asarray(body.rest_joints)
    )
    points, sizes = [places[:, 0]], [0.11]
    for side in SIDES:
        leg = leg_of(body, side)
        ankle = JOINT_INDEX[f"{side}_ankle"]
        for spot in (leg.toe, leg.heel):
            points.append(places[:, ankle] + rot.rotate(quaternions[:, ankle], spot))
            sizes.append(leg.height + spot[1])
        for joint, size in (("knee", 0.06), ("wrist", 0.04)):
            points.append(places[:, JOINT_INDEX[f"{side}_{joint}"]])
            sizes.append(size)
    spots = np.stack(points, axis=1)  # (T, 11, 3), from the pelvis
    height = spots[..., 2] - np.array(sizes)
    lowest = height.min(axis=1)
    share = np.exp(-(height - lowest[:, None]) / _SOFT)
    total = share.sum(axis=1)
    share /= total[:, None]
    speed = np.gradient(spots[..., :2], dt, axis=0)
    # In the air nothing pushes: horizontal motion comes to rest within a hand's breadth.
    pushed = 1.0 / (1.0 + (air / 0.1) ** 2)
    carried = -pushed[:, None] * np.einsum("tp,tpi->ti", share, speed)
    pace = np.linalg.norm(carried, axis=1, keepdims=True) / _CARRIED
    step = carried / np.sqrt(1.0 + pace**2) * dt
    path = np.empty((len(rotations), 3))
    path[:, :2] = np.concatenate([np.zeros((1, 2)), np.cumsum(0.5 * (step[1:] + step[:-1]), 0)])
    path[:, 2] = air - lowest + _SOFT * np.log(total)
    return path
