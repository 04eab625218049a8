"""Walking: planned footsteps, a pelvis carried by the legs, arms that swing against the legs.

All quantities are functions of the phase, which counts steps: step k swings one foot from phase
k + d/2 to k + 1 - d/2, where d is the fraction of a step with both feet down. A foot on the
ground rolls over its heel, lies flat, and rolls over its toe joint: it never slides. The pelvis
is as high as the legs allow. The plan of the steps is a `Walk` (`acting.walk_plan`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.errors import InputError
from halfphysics.motion.easing import ease
from halfphysics.motion.motion import MODELS, Motion
from halfphysics.motion.pose import Pose
from halfphysics.scenarios.acting import posture
from halfphysics.scenarios.acting.legs import WORLD_FROM_REST, Leg, about, leg_of, planted, solve
from halfphysics.scenarios.acting.walk_plan import Walk

if TYPE_CHECKING:
    from halfphysics.body.body import Body

Array = NDArray[np.float64]

#: Fraction of a step with both feet on the ground.
DOUBLE = 0.24
HEEL_STRIKE = np.radians(20.0)
TOE_OFF = np.radians(55.0)
# Width of a stride divided by the distance between the hip joints.
WIDTH = 0.75
TOES_OUT = np.radians(6.0)
# Lift of the ankle in mid-swing, in addition to that of rolling off [m].
LIFT = 0.045
# Time step of the plan [s]; frames are interpolated from it.
_FINE = 1.0 / 240.0


def _pitch(walk: Walk, step: int, phase: Array) -> tuple[Array, Array]:
    """Pitch of a foot that landed with `step`: (rolling down, rolling off) [rad]."""
    half = 0.5 * walk.stride
    down = np.zeros_like(phase)
    if step >= 0:
        strike = step + 1.0 - 0.5 * DOUBLE
        ahead = np.clip((walk.mark(step) - walk.travelled(strike)) / half, 0.0, 1.0)
        down = HEEL_STRIKE * ahead * (1.0 - ease((phase - strike) / (0.9 * DOUBLE)))
    off = np.zeros_like(phase)
    lift = step + 2.0 + 0.5 * DOUBLE
    if step + 2 < walk.steps:
        behind = np.clip((walk.travelled(lift) - walk.mark(step)) / half, 0.0, 1.0)
        off = -TOE_OFF * max(float(behind), 0.15) * ease((phase - lift + 0.78) / 0.95)
    return down, off


# Path of the kicking ankle over the swing: time, distance ahead of the standing foot, height above
# the standing ankle (both in leg lengths), pitch of the foot [degrees], negative with toes down.
_KICK = np.array(
    [
        [0.00, -0.62, 0.12, -60.0],
        [0.22, -0.62, 0.36, -80.0],
        [0.36, -0.45, 0.33, -72.0],
        [0.49, -0.05, 0.19, -38.0],
        [0.57, 0.28, 0.15, -25.0],
        [0.66, 0.66, 0.25, -18.0],
        [0.78, 0.94, 0.42, -14.0],
        [0.90, 0.78, 0.24, -5.0],
        [1.00, 0.50, 0.10, 5.0],
    ]
)
#: Fraction of the kick's swing at which the foot meets a ball on the ground.
IMPACT = 0.54


def _kick_path(leg: Leg, u: Array) -> tuple[Array, Array, Array]:
    """Kicking ankle at swing time u: distance ahead of the standing foot, height, pitch."""
    from scipy.interpolate import PchipInterpolator

    ahead, above, tilt = PchipInterpolator(_KICK[:, 0], _KICK[:, 1:])(u).T
    return ahead * leg.length, leg.height + above * leg.length, np.radians(tilt)


def _foot(walk: Walk, leg: Leg, side: str, phase: Array, width: float) -> tuple[Array, ...]:
    """Ankle (T, 3) in path coordinates, pitch (T,) and toe bend (T,) of one foot."""
    left = 1.0 if side == "left" else -1.0
    yaw = left * TOES_OUT
    ankle, pitch, bend = np.empty((len(phase), 3)), np.empty(len(phase)), np.empty(len(phase))
    parity = 0 if walk.first == side else 1
    own = [-2 + parity, *range(parity, walk.steps, 2)]
    for i, step in enumerate(own):
        start = -np.inf if i == 0 else step + 0.5 * DOUBLE
        end = own[i + 1] + 0.5 * DOUBLE if i + 1 < len(own) else np.inf
        rows = np.flatnonzero((phase >= start) & (phase < end))
        if not len(rows):
            continue
        p = phase[rows]
        # The pose of landing and standing, continued back into the swing before.
        down, off = _pitch(walk, step, p)
        to_pitch = down + off
        to = planted(leg, np.array([walk.mark(step), left * width]), yaw, to_pitch)
        to_bend = np.maximum(-to_pitch, 0.0)
        if i == 0:
            ankle[rows], pitch[rows], bend[rows] = to, to_pitch, to_bend
            continue
        # The pose of lift-off, continued forward into the swing.
        before = own[i - 1]
        from_pitch = np.add(*_pitch(walk, before, p))
        mark = np.array([walk.mark(before), left * width])
        away = planted(leg, mark, yaw, from_pitch)
        u = (p - start) / (1.0 - DOUBLE)
        w = u * u * (3.0 - 2.0 * u)
        w = np.where(u < 1.0, w, 1.0)
        # Up quickly, so that the toes do not scuff, and down smoothly.
        bump = 6.75 * u * (1.0 - u) ** 2 * (u < 1.0)
        ankle[rows] = (1.0 - w)[:, None] * away + w[:, None] * to
        pitch[rows] = (1.0 - w) * from_pitch + w * to_pitch
        bend[rows] = (1.0 - ease(2.2 * u)) * np.maximum(-from_pitch, 0.0) + (u > 0.6) * to_bend
        far = min(1.0, (walk.mark(step) - walk.mark(before)) / walk.stride)
        ankle[rows, 2] += LIFT * max(far, 0.8) * bump
        if walk.kick is not None and step == walk.kick.step:
            x, z, tilt = _kick_path(leg, np.clip(u, 0.0, 1.0))
            share = ease(u / 0.25) * ease((1.0 - u) / 0.25)
            ankle[rows, 0] += share * (walk.mark(step - 1) + x - ankle[rows, 0])
            ankle[rows, 2] += share * (z - ankle[rows, 2])
            pitch[rows] += share * (tilt - pitch[rows])
    return ankle, pitch, bend


def _carried(limit: Array, window: int) -> Array:
    """The smoothest height that stays under `limit` (T,): a running minimum, then averaged.

    Each averaged value is a minimum over a window that contains the frame, so no average exceeds
    the limit of its frame.
    """
    from scipy.ndimage import convolve1d, minimum_filter1d

    low = minimum_filter1d(limit, 2 * window + 1, mode="nearest")
    weights = np.hanning(2 * window + 3)[1:-1]
    result: Array = convolve1d(low, weights / weights.sum(), mode="nearest")
    return result


def walk(body: Body, plan: Walk, fps: float = 30.0) -> Motion:
    """The motion of `plan` for this body's proportions.

    Args:
        body: The walker's body; the motion gets its betas, gender and model if the model is one
            of the SMPL family.
        plan: The plan of the walk.
        fps: Frames per second of the motion.

    Raises:
        InputError: An `fps` that is not positive, or leaves fewer than two frames.
    """
    fps = float(fps)
    if not (np.isfinite(fps) and fps > 0.0):
        raise InputError(f"fps: found {fps!r}, expected a positive number, such as 30.0")
    count = int(np.floor(plan.clock()[0][-1] * fps + 1e-9)) + 1
    translation, rotations = _sampled(body, plan, np.arange(count) / fps)
    smpl = body.model in MODELS
    return Motion(
        translation,
        rotations,
        fps,
        betas=body.betas if smpl else None,
        gender=body.gender if smpl else "neutral",
        model=body.model if smpl else "smplx",
    )


def pose_at(body: Body, plan: Walk, time: float) -> Pose:
    """The pose of a walk at one time [s] after its start."""
    translation, rotations = _sampled(body, plan, np.array([time]))
    return Pose(translation[0], rotations[0])


def _sampled(body: Body, plan: Walk, frames: Array) -> tuple[Array, Array]:
    """Translation (T, 3) and rotations (T, 55, 3) at times `frames` (T,) [s]."""
    joints = np.asarray(body.rest_joints)
    legs = {side: leg_of(body, side) for side in ("left", "right")}
    width = WIDTH * 0.5 * float(legs["left"].hip[0] - legs["right"].hip[0])
    times, phases = plan.clock()
    fine = np.arange(int(np.floor(times[-1] / _FINE)) + 1) * _FINE
    phase = np.interp(fine, times, phases)
    going = posture.envelope(plan, phase)
    feet = {side: _foot(plan, leg, side, phase, width) for side, leg in legs.items()}
    root = posture.pelvis(plan, phase, going) @ WORLD_FROM_REST
    pelvis = np.zeros((len(fine), 3))
    pelvis[:, 0] = plan.travelled(phase) + posture.forward(legs["left"])
    pelvis[:, 1] = posture.sway(plan, phase, going)
    limit = np.full(len(fine), np.inf)
    for side, leg in legs.items():
        hip = pelvis + root @ leg.hip
        away = feet[side][0] - hip
        reach = np.sqrt(np.clip(leg.length**2 - away[:, 0] ** 2 - away[:, 1] ** 2, 1e-4, None))
        limit = np.minimum(limit, feet[side][0][:, 2] + reach - (root @ leg.hip)[:, 2])
    pelvis[:, 2] = _carried(limit, max(1, int(0.22 * plan.stride / plan.speed / _FINE)))

    def at(values: Array) -> Array:
        flat = values.reshape(len(values), -1)
        out = np.stack([np.interp(frames, fine, column) for column in flat.T], axis=1)
        return out.reshape(len(frames), *values.shape[1:])

    phase, going, pelvis = at(phase), at(going), at(pelvis)
    root = posture.pelvis(plan, phase, going) @ WORLD_FROM_REST
    rotations = posture.upper_body(plan, phase, going)
    for side, leg in legs.items():
        ankle, pitch, bend = (at(values) for values in feet[side])
        yaw = TOES_OUT if side == "left" else -TOES_OUT
        foot = about(2, np.full(len(frames), yaw)) @ WORLD_FROM_REST @ about(0, -pitch)
        for joint, rotvec in solve(leg, root, pelvis + root @ leg.hip, ankle, foot, bend).items():
            rotations[:, joint] = rotvec
    heading = about(2, plan.heading)
    rotations[:, 0] = rot.matrix_to_rotvec(heading @ root)
    pelvis = pelvis @ heading.T + np.array([*plan.start, plan.lift])
    return pelvis - joints[0], rotations
