"""How tall a person is and how long their arms are, from how they move alone.

Some data sets give a person's size as shape coefficients of a licensed model only. Without it, two
facts are left. Both are linear in the size and need no joint positions:

- A planted foot stays where it is. With p(t) the translation and f(t) the foot from the pelvis
  on the free body, ``p + s f`` is constant while the foot does not turn, so over all such spans
  ``s = - sum f' p' / sum f' f'``, where ' means less the mean of the span. Any step, squat or
  shift of weight tells the size of the legs, and the body is scaled by it.
- A hand at a thing that moves stays where it is on it. With b(t) the shoulder and a(t) the wrist
  from it, both on the scaled body and seen from the thing, ``b + r a`` is constant while the hand
  does not turn against the thing, and the arms are r times as long.

Spans that fit badly are dropped, and the sums are taken again: a foot in the air that does not
turn, a hand that passes a thing.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.reader_warnings import warn
from halfphysics.body.body import Body
from halfphysics.body.proportions import scaled_bones
from halfphysics.motion.skeleton import JOINT_INDEX

if TYPE_CHECKING:
    from halfphysics.motion.motion import Motion
    from halfphysics.results.result import ObjectTrack

Array = NDArray[np.float64]

_SIDES = ("left", "right")
#: A foot, and a hand against a thing, that turns slower than this is still [rad/s].
_FOOT, _HAND = 0.15, 0.1
#: Spans of at least so long count [s].
_LEAST_FOOT, _LEAST_HAND = 0.2, 0.3
#: A thing moves faster than this [m/s].
_MOVES = 0.06
#: A span fits with an error (root mean square) below three times the median, at least this [m].
_FITS_FOOT, _FITS_HAND = 0.002, 0.012
#: The size of a body, and of arms, is known where its error, that of a span over the movement in
#: it, is below this; errors of spans are taken as at least so much [m].
_KNOWN, _KNOWN_ARMS, _LEAST_ERROR = 0.02, 0.1, 0.0003
#: What holds arms to those of the free body, weighed against the sums of squares [m^2].
_PRIOR = 0.002
#: Sizes of the body and of the arms that people have.
_SIZES, _ARMS = (0.6, 1.4), (0.8, 1.25)
_ROUNDS = 8


class _Span(NamedTuple):
    """Frames in which ``known + size * unit`` should be constant: both (n, 3), less their means."""

    unit: Array
    known: Array


def body_by_motion(
    why: str, motion: Motion, tracks: Mapping[str, ObjectTrack] | None = None
) -> Body | None:
    """The free body with the size that planted feet and hands at moving things say.

    Args:
        why: Begins the message: which file does not say the size.
        motion: How the person moves.
        tracks: Recorded poses of things, frame by frame of the motion.

    Returns:
        The body; None: no foot was planted while the person moved.

    Warns:
        HalfPhysicsWarning: What was found, or that nothing was.
    """
    body, things = Body.default(), (tracks or {}).values()
    size, who = _fitted(_planted(motion, body), _FITS_FOOT, _SIZES), "planted feet tell"
    found = None
    if size is None:
        spans = [span for track in things for span in _held(motion, body, track, None)]
        size, who = _fitted(spans, _FITS_HAND, _SIZES), "hands on what they move tell"
    else:
        spans = [span for track in things for span in _held(motion, body, track, size)]
        found = _fitted(spans, _FITS_HAND, _ARMS, known=_KNOWN_ARMS, prior=_PRIOR)
    if size is None:
        warn(
            f"{why}, and neither planted feet nor hands on what they move tell the person's size: "
            "Body.default() is taken. Give a body of your own, or model="
        )
        return None
    arms = 1.0 if found is None else found
    body = Body.default(bones=scaled_bones(np.asarray(body.rest_joints), size, arms))
    told = "" if found is None else f", hands on what they move arms of {arms:.2f} times the usual"
    warn(f"{why}: {who} {body.stature:.2f} m{told}. Give a body of your own, or model=")
    return body


def _planted(motion: Motion, body: Body) -> list[_Span]:
    """Spans of frames in which a foot does not turn."""
    places, turns = body.joint_frames(motion)
    spans = []
    for side in _SIDES:
        foot = JOINT_INDEX[f"{side}_ankle"]
        for rows in _still(turns[:, foot], motion.fps, _FOOT, _LEAST_FOOT):
            spans.append(_span(places[rows, foot] - places[rows, 0], motion.translation[rows]))
    return spans


def _held(motion: Motion, body: Body, track: ObjectTrack, size: float | None) -> list[_Span]:
    """Spans of frames in which a thing moves and a hand does not turn against it.

    The size asked for is that of the arms of a body of `size`; None: of the whole body.
    """
    if len(track) != len(motion) or len(motion) < 2:
        return []
    places, turns = body.joint_frames(motion)
    root = motion.axes @ np.asarray(body.rest_joints)[0]
    speed = np.linalg.norm(np.gradient(track.position, axis=0), axis=1) * motion.fps
    back = rot.conjugate(track.quaternion)
    spans = []
    for side in _SIDES:
        shoulder, wrist = JOINT_INDEX[f"{side}_shoulder"], JOINT_INDEX[f"{side}_wrist"]
        base, arm = motion.translation - track.position, root + places[:, wrist] - places[:, 0]
        if size is not None:
            base = base + size * (root + places[:, shoulder] - places[:, 0])
            arm = size * (places[:, wrist] - places[:, shoulder])
        against = rot.multiply(back, turns[:, wrist])
        for rows in _still(against, motion.fps, _HAND, _LEAST_HAND, speed > _MOVES):
            spans.append(
                _span(rot.rotate(back[rows], arm[rows]), rot.rotate(back[rows], base[rows]))
            )
    return spans


def _span(unit: Array, known: Array) -> _Span:
    return _Span(unit - unit.mean(axis=0), known - known.mean(axis=0))


def _still(
    turns: Array, fps: float, slow: float, least: float, also: NDArray[np.bool_] | None = None
) -> list[slice]:
    """Runs of at least `least` [s] in which quaternions (T, 4) turn slower than `slow` [rad/s]."""
    steps = rot.log(rot.multiply(rot.conjugate(turns[:-1]), turns[1:]))
    calm = np.linalg.norm(steps, axis=1) * fps < slow
    mask = np.r_[True, calm] & np.r_[calm, True]
    if also is not None:
        mask &= also
    ends = np.flatnonzero(np.diff(np.r_[0, mask.astype(np.int64), 0])).reshape(-1, 2)
    return [slice(int(a), int(b)) for a, b in ends if b - a >= max(2, round(least * fps))]


def _fitted(
    spans: list[_Span],
    fits: float,
    limits: tuple[float, float],
    *,
    known: float = _KNOWN,
    prior: float = 0.0,
) -> float | None:
    """The size that keeps ``known + size * unit`` constant in most spans; None: not known."""
    if not spans:
        return None
    squares = np.array([float((s.unit * s.unit).sum()) for s in spans])
    frames = np.array([len(s.unit) for s in spans])
    products = np.array([-float((s.unit * s.known).sum()) for s in spans])
    kept = np.ones(len(spans), dtype=bool)
    for _ in range(_ROUNDS):
        total = float(squares[kept].sum())
        if total <= 0.0:
            return None
        size = float((products[kept].sum() + prior) / (total + prior))
        errors = np.array(
            [np.sqrt(((s.known + size * s.unit) ** 2).sum(axis=1).mean()) for s in spans]
        )
        again = errors <= max(3.0 * float(np.median(errors)), fits)
        if (again == kept).all():
            break
        kept = again
    error = max(float(np.sqrt(np.mean(errors[kept] ** 2))), _LEAST_ERROR)
    if error > known * np.sqrt(kept.sum() * total / frames[kept].sum()):
        return None
    return size if limits[0] <= size <= limits[1] else None
