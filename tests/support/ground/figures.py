"""Figures of one person of a result: how they stand, what carries them, where they end."""

from __future__ import annotations

import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.metrics.airborne import airborne
from halfphysics.metrics.asked import asked_motion
from halfphysics.metrics.floating import TOLERANCE, floating_from
from halfphysics.metrics.net_force import net_force
from halfphysics.metrics.path_offset import path_offset
from halfphysics.metrics.range_violations import range_violations
from halfphysics.metrics.stance import LOW, sole_patches, stance_from
from halfphysics.metrics.surface_gaps import RISE, carrying_gaps
from halfphysics.metrics.unsupported import unsupported_weight
from halfphysics.motion.skeleton import JOINT_INDEX, JOINT_NAMES

#: Groups of skin after the four patches of the soles: the rest of the feet, seat, back, all else.
LEFT, RIGHT, SEAT, BACK, ELSE = range(4, 9)
#: What may carry a person at the end, and the groups it has.
CARRIERS = {
    "left foot": (0, 1, LEFT),
    "right foot": (2, 3, RIGHT),
    "seat": (SEAT,),
    "back": (BACK,),
}
#: Gaps of a group beyond this do not matter [m].
REACH = 0.3
#: First frames [s]: how a clip that starts displaced is received.
FIRST = 0.2
#: Back on the path: nearer than this [m], and this upright [rad]. Height is that of `end_height`.
BACK_AT = (0.02, np.deg2rad(2.0))
#: Smallest jerk of a knee that counts [rad/s^3]: a clip that stands still has none.
CALM = 50.0
#: Time after the last contact from which the motion is exact [s]: toes that were bent by 150
#: degrees need more than the 0.5 s of `Result.free_frames`.
FREE = 1.0
#: The clock of a reference stands where it runs at less than this share of time.
STANDS = 0.1
#: Time until the feet of who begins to wait may be still [s].
SETTLING = 0.2
_TOES = [JOINT_INDEX["left_foot"], JOINT_INDEX["right_foot"]]
_KNEES = [JOINT_INDEX["left_knee"], JOINT_INDEX["right_knee"]]


def groups_of(body):
    """Group of every vertex (V,): patches of the soles, then LEFT to ELSE."""
    group = sole_patches(body)
    name = np.array(JOINT_NAMES)[body.weights.argmax(axis=1)]
    rest = np.full(len(group), ELSE)
    for k, side in ((LEFT, "left"), (RIGHT, "right")):
        rest[np.isin(name, [f"{side}_ankle", f"{side}_foot"])] = k
    rest[np.isin(name, ["pelvis", "left_hip", "right_hip"])] = SEAT
    rest[np.isin(name, ["spine1", "spine2", "spine3"])] = BACK
    return np.where(group >= 0, group, rest)


def figures(result, person=0):
    """All figures of a person, as plain numbers; None: undefined."""
    subject, fps = result.people[person], result.fps
    group = groups_of(subject.body)
    asked = asked_motion(subject)
    gaps = [
        carrying_gaps(
            m,
            subject.body,
            result.scene,
            group,
            objects=result.objects,
            reach=REACH,
            visible=True,
        )
        for m in (asked, subject.motion)
    ]
    in_air = airborne(asked, subject.body)
    floats = [floating_from(g.whole, in_air) for g in gaps]
    stance = stance_from(
        subject, np.where(group < 4, group, -1), (gaps[0], gaps[1]), result.objects, in_air
    )
    force, path = net_force(result, person), path_offset(result, person)
    size = np.linalg.norm(force.force, axis=1)
    first = max(2, round(FIRST * fps))
    clear = result.clearance[round(fps) :]
    ends = [
        last_gaps(m, subject.body, result, group, g.gap[-1])
        for m, g in zip((asked, subject.motion), gaps, strict=True)
    ]
    end, carrier = end_height(*ends)
    return {
        "end_mm": end,
        "end_carrier": carrier,
        "float_percent": floats[1].percent,
        "float_mm": floats[1].mean_mm,
        "float_asked_percent": floats[0].percent,
        "unsupported_percent": unsupported_weight(result, person).percent,
        "slide_mm": stance.simulated.mean_mm,
        "slide_p95_mm": stance.simulated.p95_mm,
        "slide_max_mm": stance.simulated.max_mm,
        "slide_more_mm": stance.simulated.mean_mm - stance.asked.mean_mm,
        "range_deg": range_violations(result, person).max_deg,
        "sustained_bw": force.sustained_weights,
        "window_bw": force.window_weights,
        "peak_bw": force.peak_weights,
        "peak_n": force.peak,
        "first_bw": float(size[:first].max()) / force.weight,
        "toes_deg": toes_angle(subject),
        "knee_jerk": knee_jerk(subject),
        "end_offset_mm": path.end_offset_mm,
        "end_tilt_deg": path.end_tilt_deg,
        "end_above_mm": path.end_height_mm,
        "max_offset_mm": path.max_offset_mm,
        "max_tilt_deg": path.max_tilt_deg,
        **way_back(result, person, path),
        "free_mm": free_error(result, person),
        "wait_slide_mm": slide_in_waiting(subject, stance.slide),
        "breaches": len(result.breaches),
        "clearance_mm": float(1000.0 * clear.min()) if len(clear) else None,
        "lost_s": float(result.lost_time.sum()),
        "airborne_percent": float(100.0 * in_air.mean()),
    }


def last_gaps(motion, body, result, group, visible):
    """Gaps of the groups in the last frame (9,) [m]: those to what is seen, `visible`; but what
    presses into a soft layer stands on it, and only in its frame is it inside.
    """
    if (visible >= 0.0).all():
        return visible
    hard = carrying_gaps(motion, body, result.scene, group, objects=result.objects, reach=REACH)
    return np.where(visible >= 0.0, visible, np.minimum(hard.gap[-1], 0.0))


def end_height(asked, got):
    """How much higher feet and seat end above their support than in the reference, the worst [mm].

    A foot, the seat or the back carries at the end if it is within 3 cm of a surface in the
    reference, or of the lowest skin where the reference floats as a whole. It should be as high
    above its surface as there, or nearer to it; on it, where the reference is inside, or floats by
    over 5 mm.

    Args:
        asked, got: Gaps of the groups in the last frame (9,) [m], reference and result.
    """
    whole = float(asked.min()) if asked.min() > TOLERANCE else 0.0
    worst, name = 0.0, ""
    for carrier, its in CARRIERS.items():
        wanted = max(float(asked[list(its)].min()) - whole, 0.0)
        if wanted < LOW:
            off = _beyond(float(got[list(its)].min()), wanted)
            if not name or abs(off) > abs(worst):
                worst, name = off, carrier
    if not name:  # on hands and knees, or in the air
        return _beyond(float(got.min()), max(float(asked.min()) - whole, 0.0)), "skin"
    return worst, name


def _beyond(gap, most):
    """How far a gap is above `most`, or inside (negative) [mm]."""
    return 1000.0 * (max(min(gap, 1.0) - most, 0.0) + min(gap, 0.0))


def free_error(result, person):
    """Largest distance of a joint from the reference, seen from the pelvis, in frames in which
    nothing acts on the person [mm]; None: there are none.
    """
    free = result.free_frames(person, FREE)
    local = result.people[person].joint_errors()[0]
    return float(1000.0 * local[free].max()) if free.any() else None


def slide_in_waiting(subject, slide):
    """Mean slide of resting patches in the frames in which the clock of the reference stands, less
    `SETTLING` at their beginning [mm]; None: it never stands. `slide` (T - 1, 4) [m].
    """
    clock, fps = getattr(subject, "clock", None), subject.motion.fps
    if clock is None:
        return None
    stands = np.diff(clock) * fps < STANDS
    stands[: int(np.argmax(stands)) + round(SETTLING * fps)] = False
    own = slide[stands]
    own = own[np.isfinite(own)]
    return float(1000.0 * own.mean()) if len(own) else None


def toes_angle(subject):
    """Largest angle of the toes' joints from the reference's [deg]."""
    own = rot.angles(asked_motion(subject).rotations[:, _TOES], subject.motion.rotations[:, _TOES])
    return float(np.rad2deg(own.max()))


def knee_jerk(subject):
    """Mean jerk of the knees' angles over that of the reference; None: too short."""
    if len(subject.motion) < 4:
        return None
    jerks = []
    for motion in (subject.motion, asked_motion(subject)):
        turn = rot.exp(motion.rotations[:, _KNEES])
        speed = rot.log(rot.multiply(rot.conjugate(turn[:-1]), turn[1:])) * motion.fps
        third = np.diff(speed, n=2, axis=0) * motion.fps**2
        jerks.append(float(np.linalg.norm(third, axis=-1).mean()))
    return max(jerks[0], CALM) / max(jerks[1], CALM)


def way_back(result, person, path):
    """The last obstacle [s], the offset there, and the time until the person is back for good.

    An obstacle is a contact whose normal rises by less than what can carry. `back_s` None: not back
    by the end, `back_left_s` after the obstacle.
    """
    contacts = result.contacts
    hit = (contacts.person == person) & (contacts.strength > 0.0) & (contacts.normal[:, 2] < RISE)
    if not hit.any():
        return {"last_hit_s": None, "hit_offset_mm": None, "back_s": None, "back_left_s": None}
    last = int(contacts.frame[hit].max())
    off = (path.offset > BACK_AT[0]) | (path.tilt > BACK_AT[1])
    after = np.flatnonzero(off[last:])
    back = 0 if not len(after) else int(after[-1]) + 1
    fps = result.fps
    return {
        "last_hit_s": last / fps,
        "hit_offset_mm": float(1000.0 * path.offset[last]),
        "back_s": back / fps if last + back < len(result) else None,
        "back_left_s": (len(result) - 1 - last) / fps,
    }


def push_figures(result, what, person=0):
    """Of a push: mean and peak horizontal force on the thing [N], its way, the feet's slide."""
    contacts, index = result.contacts, result.names.index(what)
    rows = (contacts.person == person) & (contacts.other == index)
    force = np.zeros((len(result), 2))
    np.add.at(force, contacts.frame[rows], contacts.impulse[rows, :2] * result.fps)
    size = np.linalg.norm(force, axis=1)
    pushing = size > 0.0
    track = result.objects.get(what)
    moved = None if track is None else float(np.ptp(track.position[:, 0]))
    return {
        "push_mean_n": float(size[pushing].mean()) if pushing.any() else 0.0,
        "push_peak_n": float(size.max()),
        "pushing_s": float(pushing.sum() / result.fps),
        "pushed_mm": None if moved is None else 1000.0 * moved,
    }
