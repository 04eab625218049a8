"""Recorded markers and force plates (OpenSim's .trc and .mot files) as motions of the default body.

A standing trial gives the place of every marker on the body; a trial that moves is then fitted by
least squares, frame by frame. Nothing is taken from the force plates.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.geometry.mesh_queries import MeshQuery
from halfphysics.motion.skeleton import JOINT_INDEX

Array = NDArray[np.float64]

#: Joint -> markers that it carries, by their names without side.
CARRIED = {
    "pelvis": ("R.ASIS", "L.ASIS", "V.Sacral"),
    "spine3": ("Sternum",),
    "head": ("R.Temple", "L.Temple", "Top.Head"),
    "{side}_hip": ("{S}.Thigh.Upper", "{S}.Thigh.Front", "{S}.Thigh.Rear"),
    "{side}_knee": ("{S}.Shank.Upper", "{S}.Shank.Front", "{S}.Shank.Rear"),
    "{side}_ankle": (
        *("{S}.Heel", "{S}.Midfoot.Sup", "{S}.Midfoot.Lat", "{S}.Toe.Lat", "{S}.Toe.Med"),
    ),
    "{side}_foot": ("{S}.Toe.Tip",),
    "{side}_collar": ("{S}.Acromium",),
    "{side}_shoulder": ("{S}.Bicep", "{S}.Elbow"),
    "{side}_elbow": ("{S}.Wrist.Med", "{S}.Wrist.Lat"),
}
#: Joints that are fitted, and how strongly each is drawn to its pose while standing [m/rad].
STIFF = {
    **dict.fromkeys(("pelvis", "left_hip", "right_hip", "left_knee", "right_knee"), 0.005),
    **dict.fromkeys(("left_ankle", "right_ankle", "left_shoulder", "right_shoulder"), 0.005),
    **dict.fromkeys(("left_elbow", "right_elbow", "left_foot", "right_foot"), 0.02),
    **dict.fromkeys(("spine1", "spine2", "spine3"), 0.15),  # trunks hardly bend in walking
    **dict.fromkeys(("left_collar", "right_collar", "neck", "head"), 0.05),
}
#: Shoulder joint under the acromion, in statures.
SHOULDER = 0.03
#: Weight of feet that stand flat [m/rad].
FLAT = 0.5
#: Middles of markers over the skin [m], its weight, and how often the nearest skin is found.
OVER, ON_SKIN, ROUNDS = 0.01, 0.5, 12


@dataclass(frozen=True)
class Markers:
    """Markers of a trial: names, positions (T, n, 3) [m], z up, x forward, and frames a second."""

    names: tuple[str, ...]
    positions: Array
    fps: float

    def of(self, name: str) -> Array:
        return self.positions[:, self.names.index(name)]


def read_markers(path: Path) -> Markers:
    """A .trc file: x forward, y up, z right."""
    lines = path.read_text().splitlines()
    names = tuple(name for name in lines[3].split("\t") if name.strip())[2:]
    head = lines[2].split("\t")
    rows = []
    for line in lines[5:]:
        if line.strip():
            cells = (line.split("\t") + [""] * 3 * len(names))[2 : 2 + 3 * len(names)]
            rows.append([float(cell) if cell.strip() else np.nan for cell in cells])
    unit = 1e-3 if "mm" in head else 1.0
    return Markers(names, unit * _turned(np.array(rows).reshape(len(rows), -1, 3)), float(head[0]))


@dataclass(frozen=True)
class Plates:
    """Two force plates: times (n,) [s]; right, left: force (n, 3) [N], centre of pressure [m]."""

    time: Array
    force: tuple[Array, Array]
    cop: tuple[Array, Array]

    def at(self, fps: float, frames: int, cutoff: float) -> tuple[Array, Array]:
        """Forces (2, T, 3), low-passed undelayed, and centres of pressure (2, T, 3) at frames."""
        from scipy.signal import butter, sosfiltfilt

        rate = 1.0 / np.median(np.diff(self.time))
        sections = butter(2, cutoff / (0.5 * rate), output="sos")
        when = self.time[0] + np.arange(frames) / fps
        sampled = [
            np.stack([np.interp(when, self.time, column) for column in table.T], axis=1)
            for table in (*(sosfiltfilt(sections, f, axis=0) for f in self.force), *self.cop)
        ]
        return np.stack(sampled[:2]), np.stack(sampled[2:])


def read_plates(path: Path) -> Plates:
    """A .mot file with two plates, the right foot's first."""
    table = np.genfromtxt(path, skip_header=7)
    columns = [_turned(table[:, k : k + 3]) for k in (1, 4, 7, 10)]
    return Plates(table[:, 0], (columns[0], columns[2]), (columns[1], columns[3]))


def _turned(values: Array) -> Array:
    return np.stack([values[..., 0], -values[..., 2], values[..., 1]], axis=-1)


@dataclass(frozen=True)
class Fit:
    """A body with markers: each one's joint (n,) and place in that joint's frame (n, 3) [m]."""

    body: hp.Body
    names: tuple[str, ...]
    joint: NDArray[np.int64]
    offset: Array
    standing: hp.Pose
    floor: float


def stand(trial: Markers, body: hp.Body) -> Fit:
    """Fit the mean of a standing trial, and read off where the markers are.

    Joints are between the markers on both sides of them, all markers are on the skin, the feet
    stand flat. The floor is at the height of the soles.
    """
    seen = {name: np.nanmean(trial.of(name), axis=0) for name in trial.names}
    joint, goal = zip(*_joint_goals(seen, body.stature).items(), strict=True)
    joints = np.array([JOINT_INDEX[name] for name in joint])
    rotations = np.zeros((2, 55, 3))  # a motion has two frames at least
    rotations[:, 0] = rot.matrix_to_rotvec(np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]]))
    root = np.mean([seen["R.ASIS"], seen["L.ASIS"], seen["V.Sacral"]], axis=0)[None]
    root = np.repeat(root, 2, axis=0)
    names, carrier = _carriers()
    places = np.array([seen[name] for name in names])
    goals = np.concatenate([goal, places])[None].repeat(2, axis=0)
    motion = _solve(
        body,
        rotations,
        root,
        joints,
        np.zeros((len(joints), 3)),
        goals[:, : len(joints)],
        flat=True,
    )
    weight = np.repeat([1.0, ON_SKIN], [len(joints), len(names)])
    for _ in range(ROUNDS):
        offset = np.concatenate(
            [np.zeros((len(joints), 3)), _on_skin(body, motion, carrier, places)]
        )
        motion = _solve(
            *(body, motion.rotations, motion.translation + body.rest_joints[0]),
            *(np.concatenate([joints, carrier]), offset, goals),
            flat=True,
            weight=weight,
            steps=3,
        )
    x, q = (array[0] for array in body.joint_frames(motion))
    offset = rot.rotate(rot.conjugate(q[carrier]), places - x[carrier])
    floor = float(body.vertices(motion)[0, :, 2].min())
    return Fit(body, names, carrier, offset, motion[0], floor)


def _carriers() -> tuple[tuple[str, ...], NDArray[np.int64]]:
    """The markers and the joints that carry them."""
    names, carriers = [], []
    for name, markers in CARRIED.items():
        for side in ("left", "right") if "{" in name else ("left",):
            for marker in markers:
                names.append(marker.format(S=side[0].upper()))
                carriers.append(JOINT_INDEX[name.format(side=side)])
    return tuple(names), np.array(carriers)


def _on_skin(body: hp.Body, motion: hp.Motion, carrier: NDArray[np.int64], places: Array) -> Array:
    """The points over the skin nearest to markers, in the frames of what carries them (n, 3)."""
    skin = body.vertices(motion[0])
    a, b, c = np.moveaxis(skin[body.faces], 1, 0)
    _, face, nearest = MeshQuery(skin, body.faces).closest(places)
    normal = np.cross(b - a, c - a)[face]
    x, q = body.joint_frames(motion[0])
    over = nearest + OVER * normal / np.linalg.norm(normal, axis=1, keepdims=True)
    return rot.rotate(rot.conjugate(q[carrier]), over - x[carrier])


def _joint_goals(seen: dict[str, Array], stature: float) -> dict[str, Array]:
    """Positions of joints [m] of a person who stands and faces x."""
    goals = {}
    for side, S in (("left", "L"), ("right", "R")):
        goals[f"{side}_knee"] = 0.5 * (seen[f"{S}.Knee.Lat"] + seen[f"{S}.Knee.Med"])
        goals[f"{side}_ankle"] = 0.5 * (seen[f"{S}.Ankle.Lat"] + seen[f"{S}.Ankle.Med"])
        goals[f"{side}_shoulder"] = seen[f"{S}.Acromium"] - (0.0, 0.0, SHOULDER * stature)
        goals[f"{side}_wrist"] = 0.5 * (seen[f"{S}.Wrist.Lat"] + seen[f"{S}.Wrist.Med"])
    return goals


def follow(fit: Fit, trial: Markers) -> tuple[hp.Motion, float]:
    """The motion that follows a trial's markers, and the markers' rms error [m]."""
    pose, frames = fit.standing, len(trial.positions)
    goal = np.stack([trial.of(name) for name in fit.names], axis=1)
    pelvis = fit.joint == 0
    shift = np.nanmean(goal[:, pelvis], axis=1) - pose.translation
    x, q = fit.body.joint_frames(pose)
    shift -= np.mean(x[0] - pose.translation + rot.rotate(q[:1], fit.offset[pelvis]), axis=0)
    start = np.tile(pose.rotations, (frames, 1, 1))
    root = pose.translation + fit.body.rest_joints[0] + shift
    motion = _solve(fit.body, start, root, fit.joint, fit.offset, goal, fps=trial.fps)
    error = _points(fit.body, motion, fit.joint, fit.offset) - goal
    return motion, float(np.sqrt(np.nanmean((error**2).sum(axis=-1))))


def _points(body: hp.Body, motion: hp.Motion, joint: NDArray[np.int64], offset: Array) -> Array:
    x, q = body.joint_frames(motion)
    return x[:, joint] + rot.rotate(q[:, joint], np.broadcast_to(offset, x[:, joint].shape))


def _solve(
    body: hp.Body,
    rotations: Array,
    root: Array,
    joint: NDArray[np.int64],
    offset: Array,
    goal: Array,
    *,
    fps: float = 60.0,
    flat: bool = False,
    weight: Array | float = 1.0,
    steps: int = 25,
) -> hp.Motion:
    """Least squares of points (T, n, 3) by Gauss and Newton, all frames at once."""
    fitted = np.array([JOINT_INDEX[name] for name in STIFF])
    stiff = np.repeat(list(STIFF.values()), 3) * np.repeat(fitted != 0, 3)
    rest, frames = rotations.copy(), len(rotations)
    feet = [JOINT_INDEX["left_ankle"], JOINT_INDEX["right_ankle"]]

    def made(turned: Array, at: Array) -> hp.Motion:
        return hp.Motion(at - body.rest_joints[0], turned, fps)

    def residual(turned: Array, at: Array) -> Array:
        motion = made(turned, at)
        miss = np.nan_to_num(_points(body, motion, joint, offset) - goal)
        miss = (np.reshape(weight, (-1, 1)) * miss).reshape(frames, -1)
        if not flat:
            return miss
        up = rot.rotate(body.joint_frames(motion)[1][:, feet], np.array([0.0, 1.0, 0.0]))
        return np.concatenate([miss, FLAT * up[..., :2].reshape(frames, -1)], axis=1)

    def turn(turned: Array, by: Array) -> Array:
        new = turned.copy()
        new[:, fitted] = rot.log(rot.multiply(rot.exp(turned[:, fitted]), rot.exp(by)))
        return new

    small, count = 1e-6, 3 * len(fitted)
    for _ in range(steps):
        now = residual(rotations, root)
        jacobian = np.empty((frames, now.shape[1], 3 + count))
        for k in range(3 + count):
            by, at = np.zeros((frames, len(fitted), 3)), root.copy()
            if k < 3:
                at[:, k] += small
            else:
                by[:, (k - 3) // 3, (k - 3) % 3] = small
            jacobian[..., k] = (residual(turn(rotations, by), at) - now) / small
        away = rot.log(
            rot.multiply(rot.conjugate(rot.exp(rest[:, fitted])), rot.exp(rotations[:, fitted]))
        )
        pull = np.concatenate([np.zeros(3), stiff**2])
        left = np.einsum("tia,tib->tab", jacobian, jacobian) + np.diag(pull + 1e-8)
        right = np.einsum("tia,ti->ta", jacobian, now)
        right[:, 3:] += stiff**2 * away.reshape(frames, -1)
        step = np.clip(np.linalg.solve(left, -right[..., None])[..., 0], -0.4, 0.4)
        root = root + step[:, :3]
        rotations = turn(rotations, step[:, 3:].reshape(frames, -1, 3))
    return made(rotations, root)
