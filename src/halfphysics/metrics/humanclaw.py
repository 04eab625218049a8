"""HumanCLAW's measures of what a person did to a scene, by its document METRICS.md.

Of its published episodes `trajectory_before.npz` gives the jerk (`motion_jerk` of the motion that
`Motion.load` reads); contacts are in no file of theirs, so collisions and disturbance are of a
result of ours: simulate the motion in the scene and score that.

Three things are ours: the 22 joints of the jerk are those of the given body (theirs are constants
of a licensed model), a decision step is whatever frames it is said to begin at, and contact is
what the simulation reports, not a query afterwards.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.validation import number
from halfphysics.errors import InputError
from halfphysics.metrics.argument_checks import check_result
from halfphysics.metrics.scene_solids import links_of
from halfphysics.motion.skeleton import JOINT_NAMES
from halfphysics.scene.trajectories import KinematicObject

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion
    from halfphysics.results.result import Result

Array = NDArray[np.float64]

#: Frames between the samples of the jerk, and the moving average before it.
STRIDE, WINDOW = 8, 3
#: Height above the floor from which a contact with something fixed counts [m].
ABOVE_FLOOR = 0.0205
#: Fall below its first height with which an object has left the scene [m].
ESCAPED = 5.0

_GROUPS = {
    "arm and hand": ("shoulder", "elbow", "wrist", "index", "middle", "pinky", "ring", "thumb"),
    "torso": ("pelvis", "spine", "collar"),
    "leg and foot": ("hip", "knee", "ankle", "foot"),
    "head": ("neck", "head", "jaw", "eye"),
}


def _group(joint: str) -> str:
    return next(group for group, words in _GROUPS.items() if any(word in joint for word in words))


_GROUP_OF = tuple(_group(name) for name in JOINT_NAMES)


@dataclass(frozen=True, kw_only=True)
class HumanClawReport:
    """HumanCLAW's measures of one result.

    Attributes:
        collision_percent: Coll%: share of decision steps with a contact with something fixed (a
            static, a link that no joint moves) higher than 2.05 cm above the floor [%].
        collision_groups: The same by the part of the body that touched.
        disturbed: #Dtb: objects that the person moved, directly or through others.
        disturbance: dDtb: mean path of these from then on [m]; NaN if there are none.
        escaped: Of those moved, objects that fell out of the scene, which are not counted.
        jerk: Mean jerk of the reference motion [m/s^3].
    """

    collision_percent: float
    collision_groups: Mapping[str, float]
    disturbed: int
    disturbance: float
    escaped: int
    jerk: float


def report(
    result: Result, *, step_starts: ArrayLike | None = None, floor: float | None = None
) -> HumanClawReport:
    """The measures of the first person of a result.

    Args:
        result: With contacts.
        step_starts: First frames of the decision steps, ascending; None: each frame is one.
        floor: Height of the floor [m]; None: that of the lowest point of the body in the first
            frame.

    Raises:
        InputError: No result, a floor that is no number, or steps that are not ascending frames of
            the result.
    """
    check_result(result)
    person = result.people[0]
    if floor is None:
        floor = float(person.body.vertices(person.motion, frames=0)[:, 2].min())
    floor = number(floor, "floor", unit="m")
    steps = _steps(step_starts, len(person.motion))
    share, groups = _collisions(result, steps, floor)
    paths, escaped = _disturbed(result)
    return HumanClawReport(
        collision_percent=share,
        collision_groups=groups,
        disturbed=len(paths),
        disturbance=float(np.mean(paths)) if paths else float("nan"),
        escaped=escaped,
        jerk=motion_jerk(person.reference, person.body),
    )


def motion_jerk(motion: Motion, body: Body) -> float:
    """Mean jerk [m/s^3] of 22 joints that only the root moves: the body's articulation is frozen.

    |P(t + 3 s) - 3 P(t + 2 s) + 3 P(t + s) - P(t)| / (s / fps)^3 with s = 8 frames, of positions P
    that were averaged over 3 frames; the mean over joints and frames.

    Args:
        motion: Of at least 27 frames; others have no jerk (NaN).
        body: Whose rest joints are frozen.
    """
    positions, quaternions = body.joint_frames(motion)
    rest = body.rest_joints[:22] - body.rest_joints[0]
    places = positions[:, :1] + rot.rotate(quaternions[:, :1], rest[None])
    cut = np.cumsum(np.concatenate([np.zeros((1, 22, 3)), places]), axis=0)
    smooth = (cut[WINDOW:] - cut[:-WINDOW]) / WINDOW
    if len(smooth) <= 3 * STRIDE:
        return float("nan")
    a, b, c, d = (smooth[k * STRIDE : len(smooth) - (3 - k) * STRIDE] for k in range(4))
    jerk = (d - 3.0 * c + 3.0 * b - a) / (STRIDE / motion.fps) ** 3
    return float(np.linalg.norm(jerk, axis=2).mean())


def _steps(starts: ArrayLike | None, frames: int) -> NDArray[np.intp]:
    """The decision step of each frame (T,); -1 before the first one."""
    if starts is None:
        return np.arange(frames)
    array = np.asarray(starts)
    fine = array.ndim == 1 and array.size > 0 and np.issubdtype(array.dtype, np.integer)
    if not fine or (np.diff(array) <= 0).any() or not 0 <= array[0] <= array[-1] < frames:
        raise InputError(
            f"step_starts: expected ascending frames from 0 to {frames - 1}, found "
            f"{np.array2string(array, threshold=6)}"
        )
    return np.searchsorted(array, np.arange(frames), side="right") - 1


def _collisions(
    result: Result, steps: NDArray[np.intp], floor: float
) -> tuple[float, dict[str, float]]:
    contacts, links = result.contacts, links_of(result.scene)
    stands = {*result.scene.statics, *(name for name, (_, link) in links.items() if link.fixed)}
    fixed = np.array([name in stands for name in result.names])
    touched = (contacts.person == 0) & fixed[contacts.other]
    touched &= contacts.position[:, 2] - floor > ABOVE_FLOOR
    step, part = steps[contacts.frame[touched]], contacts.part[touched]
    count = len(np.unique(steps[steps >= 0]))
    groups = {}
    for group in _GROUPS:
        of_group = np.array([_GROUP_OF[p] == group for p in part], dtype=bool)
        groups[group] = 100.0 * len(np.unique(step[of_group & (step >= 0)])) / count
    return 100.0 * len(np.unique(step[step >= 0])) / count, groups


def _disturbed(result: Result) -> tuple[list[float], int]:
    """Paths [m] of the objects that the person moved, and how many of them left the scene."""
    since = _affected(result)
    paths, escaped = [], 0
    for name, frame in since.items():
        track = result.objects[name].position
        if track[:, 2].min() < track[0, 2] - ESCAPED:
            escaped += 1
            continue
        # Contacts of a frame are those since the one before it.
        moved = track[max(frame - 1, 0) :]
        paths.append(float(np.linalg.norm(np.diff(moved, axis=0), axis=1).sum()))
    return paths, escaped


def _affected(result: Result) -> dict[str, int]:
    """Object -> the frame from which on the person moves it, directly or through another.

    What moves along a trajectory is moved by nobody, and passes nothing on.
    """
    contacts = result.contacts
    things = result.scene.objects
    free = {name for name, item in things.items() if not isinstance(item, KinematicObject)}
    moving = {i: name for i, name in enumerate(result.names) if name in free}
    since: dict[int, int] = {}
    for frame in np.unique(contacts.frame).tolist():
        rows = np.flatnonzero(contacts.frame == frame)
        links = []
        for row in rows.tolist():
            other, subject = int(contacts.other[row]), int(contacts.subject[row])
            if contacts.person[row] == 0 and other in moving:
                since.setdefault(other, frame)
            elif subject in moving and other in moving:
                links.append((subject, other))
        changed = True
        while changed:
            changed = False
            for a, b in links:
                if (a in since) != (b in since):
                    since[a if b in since else b] = frame
                    changed = True
    return {moving[i]: frame for i, frame in since.items()}
