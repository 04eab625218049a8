"""Common parts of the scenarios with a glass in the right hand of a standing or walking person.

The plan gives position and rotation of the glass over time, independent of the body; the arm
follows by `arms.solve`. While the person walks, the plan moves along.
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
from halfphysics.motion.easing import ease
from halfphysics.motion.motion import Motion
from halfphysics.motion.skeleton import RIGHT_HAND_JOINTS
from halfphysics.scenarios.acting.arms import REACH, arm_of, solve
from halfphysics.scenarios.acting.gait import walk
from halfphysics.scenarios.acting.grip import grip
from halfphysics.scenarios.acting.legs import about
from halfphysics.scenarios.acting.walk_plan import Walk
from halfphysics.scenarios.props import stage
from halfphysics.scenarios.props.vessels import Vessel

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.scene.scene import Scene

Array = NDArray[np.float64]

#: Finger targets further than this beyond contact [rad] eject the object.
MOST_SQUEEZE = 0.5
#: Initial height of an object above its support [m].
_ABOVE = 0.001
#: Radius of the stand and thickness of its top [m].
_STAND, _TOP = 0.09, 0.03
#: Distance to the right from which the hand approaches, and its initial offset [m].
_ASIDE, _WAITS = 0.07, np.array([-0.08, -0.10, 0.06])
#: Yaw of the fingers, positive to the left [rad]: at the stand, and in front of the chest.
AT_STAND, BEFORE_CHEST = np.radians([-40.0, 0.0])
#: Middle of the standing glass from the shoulder, in arm lengths.
_PLACE = np.array([0.60, -0.44, -0.66])
#: Where the elbow hangs, behind and to the right; farther to the right while the hand is turned.
_BEHIND, _BESIDE, _OUT = 0.8, 0.25, 1.5
# Durations of the phases of the grasp [s].
_WAIT, _COME, _NEAR, _CLOSE, _FIRM = 0.2, 0.7, 0.4, 0.6, 0.3
#: Displacement of the lift [m] and its duration [s].
_UP, _LIFTING = np.array([0.02, 0.10, 0.20]), 1.0
#: Time of the hand to open and draw back [s], and the displacement [m].
_OPENING, _AWAY = 0.12, np.array([-0.01, -0.05, 0.0])


@dataclass(frozen=True, eq=False)
class Track:
    """Targets of the hand and the glass over time: columns of knots, with easing between them.

    Attributes:
        time: (n,) [s].
        place: Middle of the glass from its start, moving along with a walk, (n, 3) [m].
        hand: Offset of the hand from its position when holding, (n, 3) [m].
        yaw: Yaw of the fingers, positive to the left [rad], (n,).
        turn: Rotation of the hand about the fingers' direction [rad], (n,).
        closed: Closure of the hand, 0 (open) to 1 (closed), (n,).
    """

    time: Array
    place: Array
    hand: Array
    yaw: Array
    turn: Array
    closed: Array


class Plan:
    """A track built one stage after the other."""

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
        """Time of the last knot [s]."""
        return self._knots[-1][0]

    def then(self, seconds: float, **changes: Array | float) -> None:
        """Add a knot after `seconds` with changed values; the others stay."""
        self._now.update(changes)
        self._knots.append((self.time + seconds, dict(self._now)))

    def stage(self, name: str, begin: float) -> None:
        """Name the knots since `begin` [s] as a stage."""
        self.times[name] = (begin, self.time)

    def grasp(self) -> None:
        """Add the grasp: reach, approach, close, hold firmly."""
        begin = self.time
        self.then(_WAIT)
        self.then(_COME, hand=np.array([0.0, -_ASIDE, 0.0]))
        self.then(_NEAR, hand=np.zeros(3))
        self.then(_CLOSE, closed=1.0)
        self.then(_FIRM)
        self.stage("grasp", begin)

    def lift(self) -> None:
        """Add the lift to a position before the chest."""
        begin = self.time
        self.then(_LIFTING, place=_UP, yaw=float(BEFORE_CHEST))
        self.stage("lift", begin)

    def open(self, seconds: float) -> None:
        """Add the release: open, draw back, wait."""
        begin = self.time
        self.then(_OPENING, closed=0.0, hand=_AWAY)
        self.then(seconds)
        self.stage("open", begin)

    def track(self) -> Track:
        """The track of all knots so far."""
        columns = {
            name: np.array([values[name] for _, values in self._knots]) for name in self._now
        }
        return Track(np.array([time for time, _ in self._knots]), **columns)


@dataclass(frozen=True, kw_only=True)
class Shake:
    """Vertical oscillation of the hand: amplitude `size` [m], frequency `rate` [Hz]."""

    begin: float
    seconds: float
    rate: float = 1.0
    size: float = 0.1

    def __call__(self, times: Array) -> Array:
        """Height (T,) [m]: sine waves that grow and decay over one period each."""
        x = times - self.begin
        on = ease(x * self.rate) * ease((self.seconds - x) * self.rate)
        out: Array = self.size * on * np.sin(2.0 * np.pi * self.rate * x)
        return out


def start(body: Body) -> Array:
    """Initial middle of the glass beside a person at the origin facing +x, (3,) [m].

    It is within easy reach of the right arm, and far enough to the right to walk past.
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
        plan: The plan of the hand.
        fps: Frames per second.
        squeeze: Flexion of the fingers' targets beyond contact [rad].
        held: The vessel in the hand.
        steps: A walk with times from the start of the plan; None: the person stands.
        shake: An oscillation to add.

    Raises:
        InputError: A negative squeeze, an invalid `fps`, a hand too small for the glass.
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
    # A right hand pointing ahead, palm to the left, thumb up.
    yaw = about(2, ways["yaw"])
    hand = yaw @ about(2, np.pi) @ about(0, ways["turn"])
    aside = np.einsum("tij,tj->ti", yaw, ways["hand"])
    wrist = place + aside - np.einsum("tij,j->ti", hand, holds.centre)
    # The elbow hangs behind the hand; turning the hand over lifts the elbow outwards.
    pole = np.stack(
        [0.0 * times - _BEHIND, -_BESIDE - _OUT * np.sin(0.5 * ways["turn"]), 0.0 * times - 1.0]
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
    """Interpolate place, hand, yaw, turn and closure of a track at `times` (T,) [s]."""
    i = np.clip(np.searchsorted(track.time, times, side="right") - 1, 0, len(track.time) - 2)
    x = ease((times - track.time[i]) / (track.time[i + 1] - track.time[i]))
    out = {}
    for name in ("place", "hand", "yaw", "turn", "closed"):
        knots = getattr(track, name)
        share = x.reshape(-1, *[1] * (knots.ndim - 1))
        out[name] = knots[i] + share * (knots[i + 1] - knots[i])
    return out


def add_glass(scene: Scene, at: Array, held: Vessel, mass: float, friction: float) -> None:
    """Add the glass with its origin, where it is held, at `at` (3,) [m]."""
    pieces = "auto" if held.pieces is None else held.pieces
    scene.add_object("glass", held.shape, mass=mass, friction=friction, position=at, pieces=pieces)


def add_stand(scene: Scene, name: str, at: Array, held: Vessel) -> None:
    """Add a round table, a top on one leg, for a glass with its origin at `at` (3,) [m]."""
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
