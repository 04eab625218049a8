"""Figures of one simulated take against its recording, from arrays alone (numpy).

None of this is shared with the code that is judged.
"""

from __future__ import annotations

import numpy as np

from support.carries.figures import LET_GO, NEAR, TURN, angle_deg, change_figures, untouched
from support.carries.limits import Limit
from support.carries.takes import PARTS

#: Recorded rises, ways and turns from which on a ratio is asked for [m], [deg].
RISE, WAY, TURNED = 0.05, 0.05, 15.0
#: Most force of a part [N]: of a hand, of a foot that pushes.
MOST = {"wrist": 300.0, "ankle": 400.0}

LIMITS = (
    Limit("lifted", "lifted", 1.1, 0.9),
    Limit("moved", "moved", 1.1, 0.9),
    Limit("away_mm", "away mm", 1000.0 * NEAR),
    Limit("away_deg", "away deg", TURN),
    Limit("released_s", "release", 0.1, -0.2),
    Limit("early_mm", "early mm", 2.0),
    Limit("pushed_mm", "pushed mm", 20.0),
    Limit("stays_mm", "stays mm", 5.0),
    Limit("stays_deg", "stays deg", 2.0),
    Limit("peak", "of most", 1.0),
    Limit("parts_mm", "parts mm", 50.0),
    Limit("elsewhere_mm", "else mm", 10.0),
    Limit("jerk_ratio", "jerk", 1.5),
    Limit("untouched_equal", "same", least=1.0),
    Limit("breaches", "breach", 0.0),
)
#: What makes a take right: what the others measure is how it came about.
CARRIED = ("lifted", "moved", "away_mm", "away_deg")


def take_figures(result, take, prepared) -> dict:
    """All figures of one run; None: undefined.

    Args:
        result: The simulation.
        take: The recording.
        prepared: The motions that were simulated, as recorded or adapted.
    """
    got, want = result.objects[take.name], take.track
    first, last = take.span
    frames = len(want.position)
    at = np.round(np.linspace(first, last, 11)[1:]).astype(int)
    away = np.linalg.norm(got.position - want.position, axis=1)[at]
    turned = angle_deg(got.quaternion, want.quaternion)[at]
    force = forces(result, take)
    touched = np.any([rows > 0.0 for rows in force.values()], axis=0)
    begin = int(np.argmax(touched)) if touched.any() else frames
    least = {
        part: max((MOST[end] for end in MOST if part.endswith(end)), default=np.inf)
        for _, part in force
    }
    after = slice(last, None)
    return {
        "lifted": _ratio(_rise(got), _rise(want), RISE),
        "moved": _moved(got, want),
        "away_mm": float(1000.0 * away.max()),
        "away_deg": float(turned.max()),
        "released_s": released(touched, take, result.fps),
        "early_mm": _before(got, min(begin, first)),
        "pushed_mm": _before(got, first),
        "stays_mm": float(
            1000.0 * np.linalg.norm(got.position[after] - got.position[last], axis=1).max()
        ) if _rests(want, last) else None,
        "stays_deg": float(
            angle_deg(got.quaternion[after], got.quaternion[last]).max()
        ) if _rests(want, last) else None,
        "peak": float(max(rows.max() / least[part] for (_, part), rows in force.items())),
        "peak_n": float(max(rows.max() for rows in force.values())),
        "mean_n": {
            f"{person} {part}": float(rows[first : last + 1].mean())
            for (person, part), rows in force.items()
        },
        **changes(take, prepared),
        "breaches": len(result.breaches),
    }  # fmt: skip


def forces(result, take) -> dict:
    """(person, part) -> normal force of the thing on that part by frame (T,) [N]."""
    from halfphysics.motion.skeleton import JOINT_NAMES

    rows, names = result.contacts, np.array([*JOINT_NAMES, ""])
    thing = list(result.names).index(take.name)
    push = np.einsum("ij,ij->i", rows.impulse, rows.normal) * result.fps
    out = {}
    for hold in take.holds:
        own = (rows.person == hold.person) & (rows.other == thing)
        own &= np.isin(names[rows.part], PARTS[hold.part])
        out[hold.person, hold.part] = np.bincount(
            rows.frame[own], push[own], minlength=len(take.motions[0])
        )
    return out


def released(touched, take, fps):
    """How much later than recorded no part touches the thing [s]; None: it is never let go."""
    last, need = take.span[1], round(LET_GO * fps)
    frames = len(touched)
    if any(h.part == "pelvis" for h in take.holds) or last >= frames - need:
        return None
    if not touched[take.span[0] : last + 1].any():
        return None
    begin = take.span[0] + int(np.argmax(touched[take.span[0] :]))
    for frame in range(begin + 1, frames - need + 1):
        if not touched[frame : frame + need].any():
            return (frame - last - 1) / fps
    return (frames - last - 1) / fps


def changes(take, prepared) -> dict:
    """By how much the motions were changed: the worst of the people."""
    from halfphysics.motion.skeleton import JOINT_NAMES

    found = []
    for person, (body, was, now) in enumerate(
        zip(take.bodies, take.motions, prepared, strict=True)
    ):
        own = {n for h in take.holds if h.person == person for n in PARTS[h.part]}
        mask = np.array([name in own for name in JOINT_NAMES])
        p, q = body.joints(was), body.joints(now)
        row = change_figures(p, q, was.fps, take.span, mask)
        row["untouched_equal"] = untouched(was, now, take.span)
        found.append(row)
    return {
        "parts_mm": max(row["hands_mm"] for row in found),
        "elsewhere_mm": max(row["elsewhere_mm"] for row in found),
        "jerk_ratio": max(row["jerk_ratio"] for row in found),
        "untouched_equal": all(row["untouched_equal"] for row in found),
    }


def _rise(track):
    return float(track.position[:, 2].max() - track.position[0, 2])


def _ratio(got, want, least):
    return float(got / want) if want > least else None


def _moved(got, want):
    """Largest way from the start over the recorded one, in the plane; of a turn, where it turns."""
    ways = [np.linalg.norm((t.position - t.position[0])[:, :2], axis=1).max() for t in (got, want)]
    if ways[1] > WAY:
        return _ratio(*ways, WAY)
    turns = [angle_deg(t.quaternion, t.quaternion[:1]).max() for t in (got, want)]
    return _ratio(*turns, TURNED)


def _rests(want, last):
    """Whether the recorded thing stays where it is at the end of its hold."""
    return bool(np.abs(want.position[last:] - want.position[-1]).max() < 1e-3)


def _before(got, frame):
    """How far the thing moves before a frame [mm]."""
    away = got.position[:frame] - got.position[0]
    return float(1000.0 * np.linalg.norm(away, axis=1).max(initial=0.0))
