"""An actor that plays a clip: once or looped, mirrored, at any speed, at any place."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.actors.inertia import Inertia, State
from halfphysics.actors.limbs import vec
from halfphysics.actors.turns import (
    WORLD_FROM_REST,
    Quat,
    about_z,
    exp,
    heading_of,
    log,
    multiply,
    rotate,
    wrapped,
)
from halfphysics.base import rotations as rot
from halfphysics.base.validation import number, shown, vector
from halfphysics.errors import InputError
from halfphysics.motion.motion import Motion
from halfphysics.motion.pose import Pose
from halfphysics.motion.skeleton import MIRRORED
from halfphysics.results.argument_checks import checked_body

if TYPE_CHECKING:
    from halfphysics.actors.seen import Seen
    from halfphysics.body.body import Body

Array = NDArray[np.float64]

# A round that turns by less goes straight on [rad].
_STRAIGHT = 0.21


class Clip:
    """A motion, played.

    A loop goes on where it ended: each round begins at the place and heading at which the one
    before ended; a turn of less than 12 degrees a round is the sway of a pelvis, and not a curve.
    What does not fit fades within `fade` seconds of the seam (inertialisation). At its end a clip
    that is not looped rests at its last frame.

    Args:
        motion: Any motion, z up.
        body: Whose motion it is: the root turns about the pelvis of this body.
        loop: Whether it begins again at its end.
        mirror: Whether left and right change places.
        speed: 1 as recorded, 2 twice as fast; above 0.
        place: Where the pelvis is at the first frame, (x, y) [m]; None: as recorded.
        heading: Where it faces then, about z [rad], 0 along +x; None: as recorded.
        fade: After how long nothing is left of the end of the round before [s], at any speed;
            half a round at most.

    Raises:
        InputError: An impossible value.
    """

    def __init__(
        self,
        motion: Motion,
        body: Body,
        *,
        loop: bool = False,
        mirror: bool = False,
        speed: float = 1.0,
        place: ArrayLike | None = None,
        heading: float | None = None,
        fade: float = 0.3,
    ) -> None:
        if not isinstance(motion, Motion):
            raise InputError(f"Clip: motion: found {shown(motion)}, expected a halfphysics.Motion")
        self.body = body = checked_body(body)
        self.speed = number(speed, "Clip: speed", above=0.0)
        self.loop = bool(loop)
        self._pelvis = np.asarray(body.rest_joints)[0]
        roots = motion.translation + motion.axes @ self._pelvis
        rotations = np.array(motion.rotations)
        if mirror:
            roots, rotations = _mirrored(roots, rotations)
        if heading is not None:
            heading = number(heading, "Clip: heading", unit="rad")
        at = None if place is None else vector(place, "Clip: place", 2, unit="m")
        roots, rotations = moved(roots, rotations, at, heading)
        self._fps, self._axes = motion.fps, np.array(motion.axes)
        self._roots, self._quats = roots, rot.continuous(rot.exp(rotations))
        # In time of the motion, as a seam is; half a round at most.
        fades = self.speed * number(fade, "Clip: fade", least=0.0, unit="s")
        self._fade = min(fades, 0.5 * motion.duration)
        self._last = len(roots) - 1
        turn = wrapped(_facing(self._quats[-1, 0]) - _facing(self._quats[0, 0]))
        turn = 0.0 if abs(turn) < _STRAIGHT else turn
        self._round = Round(turn, roots[0], (roots[-1] - roots[0]) * [1.0, 1.0, 0.0])
        self._seam = self._made_seam(self._fade)
        self._place: tuple[Array, Quat] | None = None
        self._time = 0.0

    @property
    def duration(self) -> float:
        """Length of one round at this speed [s]."""
        return self._last / (self._fps * self.speed)

    @property
    def done(self) -> bool:
        """Whether a clip that is not looped is at its end."""
        return not self.loop and self._time >= self._last / self._fps

    def reset(self, seed: int = 0) -> Pose:
        """The first frame; nothing is drawn by chance."""
        self._time, self._place = 0.0, None
        return self._at(0.0)

    def restart(self, pose: Pose) -> Pose:
        """The first frame, at the place of a pose and facing as it does."""
        at = pose.axes @ self._pelvis + pose.translation
        turn = heading_of(exp(vec(pose.rotations[0]))) - _facing(self._quats[0, 0])
        self._time, self._place = 0.0, (at * [1.0, 1.0, 0.0], about_z(turn))
        return self._at(0.0)

    def next(self, dt: float, seen: Seen) -> Pose:
        """The clip `dt` [s] later; what is seen changes nothing."""
        self._time += dt * self.speed
        return self._at(self._time)

    def _at(self, time: float) -> Pose:
        frames = time * self._fps
        rounds = math.floor(frames / self._last) if self.loop else 0
        frames = min(frames - rounds * self._last, float(self._last))
        state = self._sampled(frames)
        if rounds and self._seam is not None:
            state = self._seam.at(frames / self._fps, state)
        root, turns = state.root, rotvecs(state.quats)
        turn = about_z(rounds * self._round.turn)
        if rounds:
            root = self._round.after(rounds, root)
        if self._place is not None:
            first, extra = self._place
            flat = self._roots[0] * [1.0, 1.0, 0.0]
            root = first + np.array(rotate(extra, vec(root - flat)))
            turn = multiply(extra, turn)
        if rounds or self._place is not None:
            turns[0] = log(multiply(turn, exp(vec(turns[0]))))
        return Pose.trusted(root - self._axes @ self._pelvis, turns, self._axes.copy())

    def _sampled(self, frame: float) -> State:
        low = min(int(frame), self._last - 1)
        w = frame - low
        root = (1.0 - w) * self._roots[low] + w * self._roots[low + 1]
        return State(root, (1.0 - w) * self._quats[low] + w * self._quats[low + 1])

    def _made_seam(self, fade: float) -> Inertia | None:
        """What is left of the end of a round at the begin of the next."""
        if not self.loop or fade <= 0.0:
            return None
        undo = rot.exp([0.0, 0.0, -self._round.turn])
        ends = []
        for frame in (self._last - 1, self._last):
            state = State(self._roots[frame], self._quats[frame])
            quats = np.concatenate([rot.multiply(undo, state.quats[:1]), state.quats[1:]])
            ends.append(State(self._round.before(state.root), quats))
        old = ends[1], ends[1].on(ends[0])
        new = (State(self._roots[0], self._quats[0]), State(self._roots[1], self._quats[1]))
        return Inertia(old, new, 1.0 / self._fps, fade)


@dataclass(frozen=True)
class Round:
    """How a loop goes on: turned about the vertical through the pelvis, and moved.

    Attributes:
        turn: About z [rad].
        start: Of the pelvis at the first frame, (3,) [m].
        way: From there to the last frame, (3,) [m], at constant height.
    """

    turn: float
    start: Array
    way: Array

    def after(self, rounds: int, root: Array) -> Array:
        """A position of the first round (3,), as many rounds later."""
        once = cmath.exp(1j * self.turn)
        turned = once**rounds
        # The ways of all rounds, each turned by those before it, are a geometric series.
        ways = rounds if abs(once - 1.0) < 1e-9 else (1.0 - turned) / (1.0 - once)
        x, y, z = root - self.start
        there = ways * complex(*self.way[:2]) + turned * complex(x, y)
        out: Array = self.start + np.array([there.real, there.imag, z])
        return out

    def before(self, root: Array) -> Array:
        """A position (3,), one round earlier."""
        return self.start + rot.rotate(
            rot.exp([0.0, 0.0, -self.turn]), root - self.start - self.way
        )


def _facing(quat: Array) -> float:
    w, x, y, z = quat.tolist()
    return heading_of((w, x, y, z))


def rotvecs(quats: Array) -> Array:
    """Axis-angle vectors (n, 3) of quaternions (n, 4) of any length, not zero."""
    v = quats[:, 1:]
    size = np.sqrt(np.einsum("ij,ij->i", v, v))
    w = quats[:, 0]
    angle = 2.0 * np.arctan2(size, np.abs(w))
    factor = np.where(size > 1e-12, angle / np.maximum(size, 1e-12), 2.0 / np.maximum(w, 0.5))
    result: Array = np.where(w < 0.0, -factor, factor)[:, None] * v
    return result


def moved(
    roots: Array, rotations: Array, place: Array | None, facing: float | None
) -> tuple[Array, Array]:
    """A motion whose first frame is at a place (x, y) and faces a direction; None: as it is."""
    turn = 0.0 if facing is None else facing - _facing(rot.exp(rotations[0, 0]))
    about = rot.exp([0.0, 0.0, turn])
    first = roots[0] * [1.0, 1.0, 0.0]
    at = first if place is None else np.array([place[0], place[1], 0.0])
    rotations = np.array(rotations)
    rotations[:, 0] = rot.log(rot.multiply(about, rot.exp(rotations[:, 0])))
    return at + rot.rotate(about, roots - first), rotations


def _mirrored(roots: Array, rotations: Array) -> tuple[Array, Array]:
    """Left and right exchanged at the plane in which the person stands at the first frame.

    A turn about (x, y, z) of a joint becomes one about (x, -y, -z) of its mirror image, because x
    points left in the rest frame. That is the mirror image at the world's plane y = 0 of a person
    who faces +x; the plane is turned and moved to the person.
    """
    facing, first = _facing(rot.exp(rotations[0, 0])), roots[0].copy()
    roots, rotations = moved(roots, rotations, np.zeros(2), 0.0)
    swapped = rotations[:, MIRRORED] * np.array([1.0, -1.0, -1.0])
    # Of the pelvis A W, with W from rest to facing +x, A is mirrored at y.
    facing_x = np.array(WORLD_FROM_REST)
    turns = rot.multiply(rot.exp(rotations[:, 0]), rot.conjugate(facing_x))
    turns = turns * np.array([1.0, -1.0, 1.0, -1.0])
    swapped[:, 0] = rot.log(rot.multiply(turns, facing_x))
    return moved(roots * [1.0, -1.0, 1.0], swapped, first[:2], facing)
