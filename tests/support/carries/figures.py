"""Figures of one simulated carry against its recording, from arrays alone (numpy).

None of this is shared with the code that is judged: contacts are counted here from their rows,
rotations are turned into angles here.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

#: Rises from which on a thing was lifted in the record, and the share that counts as lifted.
RISE, SHARE = 0.05, 0.9
#: Carried: this near to the record at every tenth of the hold [m], [deg].
NEAR, TURN = 0.10, 15.0
#: A thing is released where no hand touches it for so long [s].
LET_GO = 0.2
#: Frames so far from the hold should be as recorded [s].
FREE = 1.0
#: Slip is counted from this time after the hold begins [s]: the hands have closed.
CLOSED = 0.2
#: Smallest mean jerk that counts [m/s^3].
CALM = 1.0


@dataclass(frozen=True)
class Carry:
    """What happened to one thing, frame by frame.

    Attributes:
        fps: Frames per second.
        hold: First and last frame of the recorded hold.
        position, quaternion: Of the simulated thing (T, 3) [m], (T, 4).
        recorded_position, recorded_quaternion: Of the recorded one.
        hand: Which hand touches, by contact: 0, 1, ... (n,); `frame` (n,).
        normal: From the thing into the hand (n, 3); `impulse` on the hand (n, 3) [N s].
        hand_position, hand_quaternion: Of the simulated hands (T, H, 3), (T, H, 4).
    """

    fps: float
    hold: tuple[int, int]
    position: np.ndarray
    quaternion: np.ndarray
    recorded_position: np.ndarray
    recorded_quaternion: np.ndarray
    hand: np.ndarray
    frame: np.ndarray
    normal: np.ndarray
    impulse: np.ndarray
    hand_position: np.ndarray
    hand_quaternion: np.ndarray


def carry_of(result, recording, middle=(0.0, 0.0, 0.0)) -> Carry:
    """The columns of a result that concern the recorded thing and the hands that hold it.

    `middle`: of the thing, in the frame that was simulated (3,) [m].
    """
    from halfphysics.motion.skeleton import JOINT_NAMES

    name, sides = recording.case.thing, list(recording.thing.grasps)
    person, rows = result.people[0], result.contacts
    parts = np.array([*JOINT_NAMES, ""])
    hand = np.full(len(rows.part), -1)
    fingers = ("wrist", "index", "middle", "ring", "pinky", "thumb")
    for k, side in enumerate(sides):
        own = [p.startswith(f"{side}_") and p.split("_")[1].rstrip("123") in fingers for p in parts]
        hand[np.asarray(own)[rows.part]] = k
    kept = (hand >= 0) & (rows.person == 0) & (rows.other == list(result.names).index(name))
    places, turns = person.body.joint_frames(person.motion)
    wrists = [JOINT_NAMES.index(f"{side}_wrist") for side in sides]
    thing = result.objects[name]
    return Carry(
        fps=result.fps,
        hold=recording.hold,
        position=thing.position + _rotated(thing.quaternion, np.asarray(middle, dtype=float)),
        quaternion=thing.quaternion,
        recorded_position=recording.track.position,
        recorded_quaternion=recording.track.quaternion,
        hand=hand[kept],
        frame=rows.frame[kept],
        normal=rows.normal[kept],
        impulse=rows.impulse[kept],
        hand_position=places[:, wrists],
        hand_quaternion=turns[:, wrists],
    )


def figures(result, recording, middle=(0.0, 0.0, 0.0)) -> dict:
    """All figures of one run, as plain numbers; None: undefined. `middle`: as in `carry_of`."""
    person = result.people[0]
    clear = result.clearance[np.isfinite(result.clearance)]
    measured = carry_figures(carry_of(result, recording, middle))
    facing = np.sum([grasp.facing for grasp in recording.thing.grasps.values()], axis=0)
    if facing[2] > 0.5:  # carried from below: weight, not the hands, presses against the hands
        measured["opposition"] = None
    return {
        **measured,
        "breaches": len(result.breaches),
        "clearance_mm": float(1000.0 * clear.min()) if len(clear) else None,
        "hand_error_mm": _hand_error(person, recording),
    }


def carry_figures(carry: Carry) -> dict:
    """What became of the thing and of the hold."""
    worst_mm, worst_deg, share = carried(carry)
    rise, wanted = _rise(carry.position), _rise(carry.recorded_position)
    force = hand_forces(carry)
    first, last = carry.hold
    return {
        "rise_mm": 1000.0 * rise,
        "recorded_rise_mm": 1000.0 * wanted,
        "lifted": bool(rise >= SHARE * wanted) if wanted > RISE else None,
        "carried_share": share,
        "carried": bool(share == 1.0),
        "away_mm": worst_mm,
        "away_deg": worst_deg,
        "released_s": released(carry),
        "early_mm": _moved(carry, int(min(carry.hold[0], carry.frame.min(initial=carry.hold[0])))),
        "pushed_mm": _moved(carry, carry.hold[0]),
        "mean_n": [float(f) for f in force[first : last + 1].mean(axis=0)],
        "peak_n": float(force.max(initial=0.0)),
        "opposition": opposition(carry),
        "slip_mm": slip(carry),
        "end_mm": float(1000.0 * np.linalg.norm(carry.position[-1] - carry.recorded_position[-1])),
    }


def _rise(position):
    """Highest place above the first [m]."""
    return float(position[:, 2].max() - position[0, 2])


def angle_deg(a, b):
    """Angles between quaternions (..., 4) [deg]."""
    return np.degrees(2.0 * np.arccos(np.clip(np.abs(np.sum(a * b, axis=-1)), 0.0, 1.0)))


def carried(carry):
    """Worst distance [mm] and angle [deg] at the tenths of the hold, and the share in limits."""
    at = np.round(np.linspace(*carry.hold, 11)[1:]).astype(int)
    away = np.linalg.norm(carry.position[at] - carry.recorded_position[at], axis=1)
    turned = angle_deg(carry.quaternion[at], carry.recorded_quaternion[at])
    near = (away <= NEAR) & (turned <= TURN)
    return float(1000.0 * away.max()), float(turned.max()), float(near.mean())


def hand_forces(carry):
    """Normal force of the thing on each hand (T, H) [N]."""
    out = np.zeros(carry.hand_position.shape[:2])
    normal = np.sum(carry.impulse * carry.normal, axis=1) * carry.fps
    np.add.at(out, (carry.frame, carry.hand), normal)
    return out


def opposition(carry):
    """1: the hands' normal forces in the hold cancel; 0: all press one way; None: none press."""
    kept = (carry.frame >= carry.hold[0]) & (carry.frame <= carry.hold[1])
    push = np.sum(carry.impulse * carry.normal, axis=1)[kept]
    if not push.sum() > 0.0:
        return None
    together = np.linalg.norm((push[:, None] * carry.normal[kept]).sum(axis=0))
    return float(1.0 - together / push.sum())


def touched(carry):
    """Whether a hand touches the thing (T,)."""
    out = np.zeros(len(carry.position), bool)
    out[carry.frame] = True
    return out


def release(carry):
    """The first frame from which no hand touches it for `LET_GO`, after one did in the hold.

    None: never touched in the hold, or held to the end.
    """
    touch = touched(carry)
    touch[: carry.hold[0]] = False
    if not touch[: carry.hold[1] + 1].any():
        return None
    frames, need = len(touch), round(LET_GO * carry.fps)
    begin = int(np.argmax(touch))
    for frame in range(begin + 1, frames - need + 1):
        if not touch[frame : frame + need].any():
            return frame
    return None


def released(carry):
    """How much later than recorded it is released [s]; negative: dropped; None: never held.

    Held to the end of the clip counts as released with it.
    """
    touch = touched(carry)
    if not touch[carry.hold[0] : carry.hold[1] + 1].any():
        return None
    found = release(carry)
    return ((len(touch) if found is None else found) - (carry.hold[1] + 1)) / carry.fps


def _moved(carry, frame):
    """How far it moves before a frame: that of the first touch, or of the recorded hold [mm]."""
    before = carry.position[:frame] - carry.position[0]
    return float(1000.0 * np.linalg.norm(before, axis=1).max(initial=0.0))


def slip(carry):
    """How far the thing moves in the hands while both are at it [mm]; None: no hand touches it.

    From shortly after the hold begins to its end, or its release; the mean over the hands that
    touch it at all, of the largest distance in the hand's frame.
    """
    begin = carry.hold[0] + round(CLOSED * carry.fps)
    found = release(carry)
    end = carry.hold[1] if found is None else min(carry.hold[1], found - 1)
    hands = np.unique(carry.hand[(carry.frame >= carry.hold[0]) & (carry.frame <= carry.hold[1])])
    if not len(hands):
        return None
    if end <= begin:
        return 0.0
    far = []
    for k in hands:
        away = carry.position - carry.hand_position[:, k]
        local = _rotated_back(carry.hand_quaternion[:, k], away)[begin : end + 1]
        far.append(np.linalg.norm(local - local[0], axis=1).max())
    return float(1000.0 * np.mean(far))


def _rotated_back(quaternion, vector):
    """Vectors (T, 3) in the frames of quaternions (T, 4)."""
    return _rotated(quaternion * [1.0, -1.0, -1.0, -1.0], vector)


def _rotated(quaternion, vector):
    """Vectors (T, 3) or (3,), turned by quaternions (T, 4)."""
    w, v = quaternion[:, :1], quaternion[:, 1:]
    cross = 2.0 * np.cross(v, vector)
    return vector + w * cross + np.cross(v, cross)


def _hand_error(person, recording):
    """Mean distance of the simulated wrists from what they were asked for, in the hold [mm]."""
    from halfphysics.motion.skeleton import JOINT_NAMES

    own = [JOINT_NAMES.index(f"{side}_wrist") for side in recording.thing.grasps]
    first, last = recording.hold
    away = person.body.joints(person.motion) - person.body.joints(person.reference)
    return float(1000.0 * np.linalg.norm(away[first : last + 1, own], axis=-1).mean())


def change(recorded, prepared, body, hold, sides):
    """By how much a motion was changed before it was simulated.

    Args:
        recorded, prepared: Motions of the same frames.
        body: Whose joints are compared.
        hold: First and last frame of the recorded hold.
        sides: Of the hands that hold.
    """
    from halfphysics.motion.skeleton import JOINT_NAMES

    p, q = body.joints(recorded), body.joints(prepared)
    return change_figures(p, q, recorded.fps, hold, _is_arm(JOINT_NAMES, sides)) | {
        "untouched_equal": untouched(recorded, prepared, hold)
    }


def change_figures(recorded, prepared, fps, hold, hand):
    """Median change of the hands and of all else in the hold [mm], and the ratio of jerks.

    Args:
        recorded, prepared: Joints (T, J, 3) [m].
        fps: Frames per second.
        hold: First and last frame of the recorded hold.
        hand: Which joints are of hands that hold (J,).
    """
    away = 1000.0 * np.linalg.norm(prepared - recorded, axis=-1)
    within = slice(hold[0], hold[1] + 1)
    jerk = [
        np.linalg.norm(np.diff(joints[:, hand], n=3, axis=0) * fps**3, axis=-1).mean()
        for joints in (prepared, recorded)
    ]
    return {
        "hands_mm": float(np.median(away[within][:, hand])),
        "elsewhere_mm": float(np.median(away[within][:, ~hand])),
        "most_mm": float(away.max()),
        "jerk_ratio": float(max(jerk[0], CALM) / max(jerk[1], CALM)),
    }


def untouched(recorded, prepared, hold):
    """Whether all frames farther than `FREE` from the hold are exactly as recorded."""
    frames = np.arange(len(recorded.translation))
    far = round(FREE * recorded.fps)
    free = (frames < hold[0] - far) | (frames > hold[1] + far)
    return bool(
        np.array_equal(recorded.translation[free], prepared.translation[free])
        and np.array_equal(recorded.rotations[free], prepared.rotations[free])
    )


def _is_arm(names, sides):
    fingers = ("wrist", "index", "middle", "ring", "pinky", "thumb")
    return np.array(
        [n.split("_")[0] in sides and n.split("_")[-1].rstrip("123") in fingers for n in names]
    )
