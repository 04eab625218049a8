"""What the scenarios with a glass share: a standing or walking person whose right hand handles it.

The hand is planned as if it were alone: where the glass is to be and how it is to be turned, at
every time; the arm follows by `arms.solve`. While the person walks the plan moves along.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.validation import number
from halfphysics.errors import HalfPhysicsWarning
from halfphysics.geometry.shapes import Cylinder
from halfphysics.motion.motion import Motion
from halfphysics.motion.skeleton import RIGHT_HAND_JOINTS
from halfphysics.scenarios.acting.arms import REACH, arm_of, solve
from halfphysics.scenarios.acting.gait import walk
from halfphysics.scenarios.acting.grip import grip
from halfphysics.scenarios.acting.legs import about
from halfphysics.scenarios.acting.walk_plan import Walk, ease
from halfphysics.scenarios.props import stage
from halfphysics.scenarios.props.vessels import Vessel

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.scene.scene import Scene

Array = NDArray[np.float64]

#: Finger targets further than this beyond contact [rad] eject the object.
MOST_SQUEEZE = 0.5
#: A thing starts this far over what it stands on [m].
_ABOVE = 0.001
#: Half the width of the stand [m] and its thickness.
_STAND, _TOP = 0.09, 0.03
#: The hand comes from this far to the right of the glass [m], and where it waits before.
_ASIDE, _WAITS = 0.07, np.array([-0.08, -0.10, 0.06])
#: Fingers point this much to the left of ahead [rad]: at the stand, and in front of the chest.
AT_STAND, BEFORE_CHEST = np.radians([-40.0, 0.0])
#: Middle of the standing glass from the shoulder, in lengths of the arm.
_PLACE = np.array([0.60, -0.44, -0.66])
# When what happens at the start, and for how long [s].
_WAIT, _COME, _NEAR, _CLOSE, _FIRM = 0.2, 0.7, 0.4, 0.6, 0.3
#: The lift: to where [m], fingers pointing where [rad], in what time [s].
_UP, _LIFTING = np.array([0.02, 0.10, 0.20]), 1.0
#: Time that the hand takes to open and to draw back [s], and how far it draws back [m].
_OPENING, _AWAY = 0.12, np.array([-0.01, -0.05, 0.0])


@dataclass(frozen=True, eq=False)
class Track:
    """What the hand wants of the glass over time, as columns of knots that are eased between.

    Attributes:
        time: (n,) [s].
        place: Of the middle of the glass against where it stood, moving along, (n, 3) [m].
        hand: Of the hand against where it holds the glass, (n, 3) [m].
        yaw: Of the way that the fingers point to the left of ahead [rad], (n,).
        turn: Of the hand about that way [rad], (n,).
        closed: 0 open to 1 closed, (n,).
    """

    time: Array
    place: Array
    hand: Array
    yaw: Array
    turn: Array
    closed: Array


class Plan:
    """A track that is written down one stage after the other."""

    def __init__(self) -> None:
        zero = np.zeros(3)
        self._now: dict[str, Array | float] = {
            "place": zero,
            "hand": _WAITS + np.array([0.0, -_ASIDE, 0.0]),
            "yaw": float(AT_STAND),
            "turn": 0.0,
            "closed": 0.0,
        }
        self._knots: list[tuple[float, dict[str, Array | float]]] = [(0.0, dict(self._now))]
        #: Stage -> (begin, end) [s].
        self.times: dict[str, tuple[float, float]] = {}

    @property
    def time(self) -> float:
        """The end so far [s]."""
        return self._knots[-1][0]

    def then(self, seconds: float, **changes: Array | float) -> None:
        """Go on to new values, the others staying as they are."""
        self._now.update(changes)
        self._knots.append((self.time + seconds, dict(self._now)))

    def stage(self, name: str, begin: float) -> None:
        """Note what was written since `begin` [s] as a stage."""
        self.times[name] = (begin, self.time)

    def grasp(self) -> None:
        """Reach, come near, close and hold firm."""
        begin = self.time
        self.then(_WAIT)
        self.then(_COME, hand=np.array([0.0, -_ASIDE, 0.0]))
        self.then(_NEAR, hand=np.zeros(3))
        self.then(_CLOSE, closed=1.0)
        self.then(_FIRM)
        self.stage("grasp", begin)

    def lift(self) -> None:
        """Up and before the chest."""
        begin = self.time
        self.then(_LIFTING, place=_UP, yaw=float(BEFORE_CHEST))
        self.stage("lift", begin)

    def open(self, seconds: float) -> None:
        """Let go and draw back, then wait."""
        begin = self.time
        self.then(_OPENING, closed=0.0, hand=_AWAY)
        self.then(seconds)
        self.stage("open", begin)

    def track(self) -> Track:
        """Everything written so far."""
        columns = {
            name: np.array([values[name] for _, values in self._knots]) for name in self._now
        }
        return Track(np.array([time for time, _ in self._knots]), **columns)


@dataclass(frozen=True, kw_only=True)
class Shake:
    """An up and down of the hand: `size` [m] to either side, at `rate` [Hz]."""

    begin: float
    seconds: float
    rate: float = 1.0
    size: float = 0.1

    def __call__(self, times: Array) -> Array:
        """Height (T,) [m]: sine waves that swell and fade over a period."""
        x = times - self.begin
        on = ease(x * self.rate) * ease((self.seconds - x) * self.rate)
        out: Array = self.size * on * np.sin(2.0 * np.pi * self.rate * x)
        return out


def start(body: Body) -> Array:
    """Middle of the glass as it stands beside a person at the origin who looks along +x, (3,).

    Within easy reach of the right arm, and far enough to the right to be walked past.
    """
    arm = arm_of(body, "right")
    standing = walk(body, Walk(distance=1.0), 30.0)[0]
    shoulder = body.joints(standing)[arm.joints[0]]
    unit = arm.length / REACH
    place: Array = shoulder + unit * _PLACE
    return place


def perform(
    body: Body,
    plan: Plan,
    fps: float,
    squeeze: float,
    *,
    held: Vessel,
    steps: Walk | None = None,
    shake: Shake | None = None,
) -> Motion:
    """The motion of a person whose right hand follows a plan.

    Args:
        body: The person's body.
        plan: Of the hand.
        fps: Frames per second.
        squeeze: How far the fingers' targets are beyond contact [rad].
        held: What the hand closes around.
        steps: A walk, whose times count from the start of the plan; None: the person stands.
        shake: An up and down on top.

    Raises:
        InputError: A negative squeeze, an impossible `fps`, a hand too small for the glass.
    """
    squeeze = number(squeeze, "squeeze", least=0.0, unit="rad")
    if squeeze > MOST_SQUEEZE:
        warnings.warn(
            f"squeeze: found {squeeze:g} rad; beyond {MOST_SQUEEZE:g} fingers push a glass out of "
            "the hand",
            HalfPhysicsWarning,
            stacklevel=4,
        )
    track = plan.track()
    whole = steps or Walk(distance=1.0, before=plan.time + 1.0)
    whole = replace(whole, after=max(whole.after, plan.time - float(whole.clock()[0][-2]) + 0.1))
    motion = walk(body, whole, fps)[: int(np.floor(plan.time * fps + 1e-9)) + 1]
    times = np.arange(len(motion)) / fps
    holds = grip(body, held.outline)
    ways = eased(track, times)
    clock, phases = whole.clock()
    place = start(body) + ways["place"]
    place[:, 0] += whole.travelled(np.interp(times, clock, phases))
    if shake is not None:
        place[:, 2] += shake(times)
    # A right hand that points ahead, palm to the left, thumb up.
    yaw = about(2, ways["yaw"])
    hand = yaw @ about(2, np.pi) @ about(0, ways["turn"])
    aside = np.einsum("tij,tj->ti", yaw, ways["hand"])
    wrist = place + aside - np.einsum("tij,j->ti", hand, holds.centre)
    # The elbow hangs behind the hand; turning the hand over lifts it outwards.
    pole = np.stack(
        [0.0 * times - 0.3, -0.25 - 0.5 * np.sin(0.5 * ways["turn"]), 0.0 * times - 1.0]
    )
    arm = arm_of(body, "right")
    rotations = motion.rotations.copy()
    rotations[:, RIGHT_HAND_JOINTS] = holds.fingers(ways["closed"], squeeze)
    positions, frames = body.joint_frames(motion)
    collar = rot.to_matrix(frames[:, arm.collar])
    turned = solve(arm, collar, positions[:, arm.joints[0]], wrist, hand, pole.T)
    for joint, rotvec in turned.items():
        rotations[:, joint] = rotvec
    return motion.with_frames(motion.translation, rotations)


def eased(track: Track, times: Array) -> dict[str, Array]:
    """Place, hand, yaw, turn and closing of a track at `times` (T,) [s]."""
    i = np.clip(np.searchsorted(track.time, times, side="right") - 1, 0, len(track.time) - 2)
    x = ease((times - track.time[i]) / (track.time[i + 1] - track.time[i]))
    out = {}
    for name in ("place", "hand", "yaw", "turn", "closed"):
        knots = getattr(track, name)
        share = x.reshape(-1, *[1] * (knots.ndim - 1))
        out[name] = knots[i] + share * (knots[i + 1] - knots[i])
    return out


def add_glass(scene: Scene, at: Array, held: Vessel, mass: float, friction: float) -> None:
    """The glass with the place where it is held at `at` (3,) [m]."""
    pieces = "auto" if held.pieces is None else held.pieces
    scene.add_object("glass", held.shape, mass=mass, friction=friction, position=at, pieces=pieces)


def add_stand(scene: Scene, name: str, at: Array, held: Vessel) -> None:
    """A round table for a glass that is held at `at` (3,) [m]: a top on one leg."""
    top = float(at[2]) - held.below - _ABOVE
    scene.add_static(
        name,
        Cylinder(_STAND, _TOP),
        position=(at[0], at[1], top - 0.5 * _TOP),
        friction=stage.WOOD,
    )
    leg = top - _TOP
    scene.add_static(
        f"{name}_leg",
        Cylinder(0.025, leg),
        position=(at[0], at[1], 0.5 * leg),
        friction=stage.WOOD,
    )
