"""Judges a recorded run independently: are the people clear of all statics, and do they stay so?

Two questions about the convex pieces that must stay clear (`person_hulls`: hulls of the skin, or
the rigid parts). The core supplies only coordinates and body frames:

1. *Clear*: at every committed pose, does a piece meet a static? Distances by `coal`, hull against
   triangles or primitive.
2. *Side*: between two committed poses, could the piece get from one to the other without meeting
   the static? By a plane that has both hulls on one side and the obstacle on the other, or by
   another witness (`crossings`). Without any it has crossed.

Most of it is far from everything, so that proofs come first, for all pieces and many poses at once
(`convex_obstacles`): where planes prove that the hull of a piece at some consecutive poses is
farther than the smallest distance known, both questions are answered. What is left is asked pose by
pose and static by static: by planes again, and by `coal` where planes prove nothing.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from halfphysics.geometry.shapes import Plane
from halfphysics.motion.skeleton import JOINT_NAMES
from support.judges.convex_obstacles import Obstacles
from support.judges.crossings import Way, possible
from support.judges.judged_static import JudgedStatic
from support.judges.person_hulls import pieces_of

#: Farther pairs are skipped [m]: of gaps beyond it, only that of the first pose is exact.
NEAR = 0.005
#: Accuracy of coal's own distances [m].
ROUNDING = 1e-6
#: With `told`, what starts no deeper in something than this touches it until it is clear: nothing
#: is told of it [m]; of planes, whose depth is exact, what docs/physics.md says of the reset.
TOUCH, TOUCH_OF_PLANES = 1e-4, 1e-5
#: A plane that is to separate has this much room [m]: rounding of coordinates.
ROOM = 1e-9
#: Poses processed together: bounds the memory. Steps proven together at first.
CHUNK, BLOCK = 64, 8
#: The planes that separated last are tried first.
RECENT = 3


@dataclass
class Verdict:
    """Results: distances [m], and their places; of gaps beyond `near` that of the start alone."""

    poses: int = 0
    near: float = NEAR
    start: float = np.inf
    gap: float = np.inf
    where: tuple[str, str, int] = ("", "", -1)
    crossed: list[tuple[str, str, int]] = field(default_factory=list)
    inside: set[int] = field(default_factory=set)

    @property
    def clear(self) -> bool:
        """No committed pose intersects a static and no step crosses one."""
        return self.gap >= -ROUNDING and not self.crossed

    @property
    def asked(self) -> float:
        """The distance that has to be proven: farther ones change nothing [m]."""
        return max(min(self.gap, self.near), 0.0)


class Judge:
    """Judges the committed poses of one simulator.

    `contact`: the hulls of the "skin", the rigid "parts" or "both"; None: the pieces that the
    simulator keeps clear.
    """

    def __init__(self, simulator, contact=None):
        world = simulator.world
        self.world, self.pieces = world, pieces_of(simulator, contact)
        statics = [
            s for s in world.scene.statics.values() if not world.scene.ignores("person", s.name)
        ]
        self.planes = [JudgedStatic.of(s) for s in statics if isinstance(s.shape, Plane)]
        others = [s for s in statics if not isinstance(s.shape, Plane)]
        self.statics = [JudgedStatic.of(s) for s in others]
        self.obstacles = Obstacles(others)
        self._posed = None, []  # the last pose of `gap_to`, and the pieces there

    def judge(self, start, frames, told=None, near=NEAR) -> Verdict:
        """`start`: coordinates (nq,) of the first pose; `frames`: with their substeps recorded."""
        poses = np.concatenate([start[None], *(f.substeps for f in frames)])
        return self.judge_poses(poses, told, near)

    def judge_poses(self, poses, told=None, near=NEAR) -> Verdict:
        """`poses`: consecutive coordinates (T, nq), the first at index 0; `told`: what is left out
        (`told_inside`), of all but the start's distance; `near`: gaps beyond it are not asked for,
        at most `NEAR` [m]."""
        verdict = Verdict(poses=len(poses) - 1, near=near)
        rests = {}  # of each person and plane: its pieces' start and what of them still touches it
        touching = {}  # of each person: (static, piece) that have touched since the start
        for first in range(0, max(1, len(poses) - 1), CHUNK):
            for n, pieces in enumerate(self.pieces):
                at = pieces.at(poses[first : first + CHUNK + 1])
                planes = zip(self.planes, last_told(told, pieces, self.planes), strict=True)
                for k, (s, last) in enumerate(planes):
                    rest = rests.setdefault((n, k), None if told is None else _Rest())
                    _over(s, at, first, verdict, last, rest)
                if self.statics:
                    last = last_told(told, pieces, self.statics)
                    touch = 0.0 if told is None else TOUCH
                    chunk = _Chunk(self, at, first, verdict, last, touch, touching.get(n, set()))
                    chunk.judge()
                    touching[n] = chunk.touching()
        return verdict

    def surely_off(self, static, pose):
        """Whether boxes prove a `halfphysics.scene.scene.Static` to be farther than `NEAR` from a
        pose (nq,): those around pieces, and around triangles."""
        s = JudgedStatic.of(static)
        for at in self._at(pose):
            low, high = at.low[0] - NEAR, at.high[0] + NEAR
            for i in np.flatnonzero(s.near(low, high)):
                if not s.within(low[i], high[i]).behind(at.points(i, 0), (), NEAR):
                    return False
        return True

    def gap_to(self, static, pose):
        """Distance of a `halfphysics.scene.scene.Static` from a pose (nq,); inf beyond `NEAR`."""
        s, best, recent = JudgedStatic.of(static), np.inf, []
        for at in self._at(pose):
            low, high = at.low[0] - NEAR, at.high[0] + NEAR
            for i in np.flatnonzero(s.near(low, high)):
                points = at.points(i, 0)
                if not s.within(low[i], high[i]).behind(points, recent, min(best, NEAR)):
                    d, away = s.distance(points, at.solid(i, 0))
                    best = min(best, d)
                    _keep(recent, away)
        return best

    def _at(self, pose):
        """The pieces at a pose (nq,)."""
        if not np.array_equal(self._posed[0], pose):
            self._posed = pose.copy(), [pieces.at(pose[None]) for pieces in self.pieces]
        return self._posed[1]


class _Chunk:
    """The pieces of one person at consecutive poses, among the statics that are no planes."""

    def __init__(self, judge, at, first, verdict, last_told, touch, touching):
        self.statics, self.obstacles = judge.statics, judge.obstacles
        self.at, self.first, self.verdict = at, first, verdict
        self.told = last_told - first  # last pose at which a piece is left out (S, P)
        self.touch = touch  # depth up to which it is left out until it is first clear [m]
        self.before = touching  # (static, piece) that have touched up to the first of the poses
        # Boxes of the statics (S, 1, 3).
        self.lows, self.highs = (
            np.array([getattr(s, k) for s in self.statics])[:, None] for k in ("low", "high")
        )
        self.known = {}  # (static, piece, pose) -> distance and direction

    def judge(self):
        """Notes distances and crossings in the verdict."""
        steps = len(self.at.low) - 1
        if self.first == 0:
            self._start()
        piece, block = np.divmod(np.arange(len(self.at.pieces.names) * -(-steps // BLOCK)),
                                 -(-steps // BLOCK))  # fmt: skip
        begin = BLOCK * block
        left = self._unproven(piece, begin, np.minimum(begin + BLOCK, steps))
        piece = np.repeat(piece[left], BLOCK)
        begin = (begin[left][:, None] + np.arange(BLOCK)).ravel()
        piece, begin = piece[begin < steps], begin[begin < steps]
        left = self._unproven(piece, begin, begin + 1)
        self._one_by_one(*self._with_statics(piece[left], begin[left]))

    def _unproven(self, piece, begin, end):
        """Which pieces are not proven to be farther than asked from all, at poses and between."""
        asked = self.verdict.asked
        return np.flatnonzero(self._clearance(piece, begin, end, asked) < asked)

    def _with_statics(self, piece, step, all_of_them=False):
        """(static, piece, step) of all near ones, in this order; without those left out."""
        low = np.minimum(self.at.low[step, piece], self.at.low[step + 1, piece]) - NEAR
        high = np.maximum(self.at.high[step, piece], self.at.high[step + 1, piece]) + NEAR
        near = ((low < self.highs) & (high > self.lows)).all(axis=2)
        s, which = np.nonzero(near & (all_of_them | (step > self.told[:, piece])))
        return s, piece[which], step[which]

    def _start(self):
        """The distance at the first pose."""
        every = np.arange(len(self.at.pieces.names))
        s, piece, pose = self._with_statics(every, np.zeros_like(every), all_of_them=True)
        near = self._clearance(piece, pose, pose, NEAR, s, settle=True) < NEAR
        for some in (np.flatnonzero(near), np.flatnonzero(~near)):
            if self.verdict.start > NEAR:
                for k in some:
                    self._exact(s[k], piece[k], pose[k])

    def _one_by_one(self, s, piece, step):
        """Steps of pieces by statics: the distances of both poses, and a witness between."""
        poses = np.concatenate([[s, piece, step], [s, piece, step + 1]], axis=1)
        self._distances(*np.unique(poses, axis=1))
        blocked = self._clearance(piece, step, step + 1, ROOM, s) < ROOM
        for k, i, t in zip(s[blocked], piece[blocked], step[blocked], strict=True):
            before, after = (self._exact(k, i, pose) for pose in (t, t + 1))
            # One proven crossing is enough: later steps get fewer attempts.
            patient = not self.verdict.crossed
            if not possible(Way(self.at, i, t), self.statics[k], before, after, patient):
                where = self.at.pieces.names[i], self.statics[k].name, self.first + int(t) + 1
                self.verdict.crossed.append(where)

    def _distances(self, s, piece, pose):
        """Finds what is inside or nearer than all known: the likely ones first."""
        while len(s):
            asked = self.verdict.asked
            d = self._clearance(piece, pose, pose, asked, s, settle=True)
            left = np.flatnonzero(d < asked)
            left = left[np.argsort(d[left], kind="stable")].tolist()
            while left and self.verdict.asked == asked:
                k = left.pop(0)
                self._exact(s[k], piece[k], pose[k])
            s, piece, pose = s[left], piece[left], pose[left]

    def _clearance(self, piece, begin, end, far, s=None, settle=False):
        """`Obstacles.clearance` of each piece over poses; s: from this static alone, one each."""
        low, high = self.at.boxes(piece, begin, end)
        item, which = self.obstacles.near(low - far, high + far)
        if s is not None:
            own = self.obstacles.owner[which] == s[item]
            item, which = item[own], which[own]
        out, near = np.full(len(piece), float(far)), np.unique(item)
        for some, clouds in self.at.clouds(piece[near], begin[near], end[near]):
            place = np.full(len(piece), -1)
            place[near[some]] = np.arange(len(some))
            mine = place[item] >= 0
            middle = 0.5 * (low + high)[near[some]]
            pairs = place[item[mine]], which[mine]
            out[near[some]] = self.obstacles.clearance(clouds, middle, *pairs, far, settle)
        return out

    def _exact(self, k, i, pose):
        """Distance and direction by coal, noted in the verdict."""
        k, i, pose = int(k), int(i), int(pose)
        if (k, i, pose) not in self.known:
            found = self.statics[k].distance(self.at.points(i, pose), self.at.solid(i, pose))
            self.known[k, i, pose] = found
            where = self.at.pieces.names[i], self.statics[k].name, self.first + pose
            touches = self._touches(k, i, pose)
            _note(self.verdict, found[0], where, touches or pose <= self.told[k, i])
        return self.known[k, i, pose]

    def _touches(self, k, i, pose):
        """Has a piece touched a static since the first pose of all?"""
        if not -self.touch <= self._exact(k, i, pose)[0] <= 0.0:
            return False
        return (
            self._touches(k, i, pose - 1) if pose > 0 else self.first == 0 or (k, i) in self.before
        )

    def touching(self):
        """(static, piece) that have touched from the first pose of all to the last of these."""
        last = len(self.at.low) - 1
        ends = [(k, i) for k, i, pose in self.known if pose == last]
        return {(k, i) for k, i in ends if self._touches(k, i, last)}


def told_inside(world, frames):
    """What a run itself says to be inside something: (part or object, other) -> the last pose at
    which it may be.

    Args:
        world: Its `names` are those of the frames, people last.
        frames: That of the reset, whose pose is 0, and all after it; their substeps recorded. What
            a frame tells at its end may be so until the end of the next.
    """
    out, names, people = {}, world.names, len(world.people)
    ends = np.cumsum([0, *(len(f.substeps) for f in frames[1:])]).tolist()
    for f, end in zip(frames, [*ends[1:], ends[-1]], strict=True):
        told = f.inside
        for person, part, subject, other in zip(
            told.person, told.part, told.subject, told.other, strict=True
        ):
            whose = names[len(names) - people + person]
            one = names[subject] if person < 0 else f"{whose}/{JOINT_NAMES[part]}"
            out[one, names[other]] = end
    return out


def last_told(told, pieces, statics):
    """The last pose at which pieces are said to be in statics (S, P); -1: never."""
    parts = ["/".join(name.split("/")[:2]) for name in pieces.names]
    told = told or {}
    last = [[told.get((part, s.name), -1) for part in parts] for s in statics]
    return np.array(last, int).reshape(len(statics), len(parts))


@dataclass
class _Rest:
    """Pieces that start in a plane by what a start may be: heights there (P,), and which of them
    have stayed so, no deeper."""

    start: np.ndarray = field(default_factory=lambda: np.zeros(0))
    still: np.ndarray = field(default_factory=lambda: np.zeros(0, bool))

    def left_out(self, heights, first):
        """Which of the heights (T, P) of poses from `first` on are such."""
        if first == 0:
            self.start = heights[0].copy()
            self.still = (self.start >= -TOUCH_OF_PLANES) & (self.start <= 0.0)
        no_deeper = heights >= np.maximum(self.start - ROUNDING, -TOUCH_OF_PLANES)
        out = self.still & np.logical_and.accumulate(no_deeper & (heights <= 0.0))
        self.still = out[-1]
        return out


def _over(s, at, first, verdict, last_told, rest):
    """Heights of all pieces over a plane; what is above it at two poses is so between.

    last_told: The last pose at which a piece is left out (P,).
    rest: What touches it from the start, `_Rest`, is left out; None: nothing.
    """
    normal, offset = s.plane
    heights = np.minimum.reduceat(at.corners @ normal, at.pieces.first[:-1]).T - offset
    if first == 0 and heights[0].min() < 0.0:
        verdict.start = min(verdict.start, float(heights[0].min()))
    if rest is not None:
        heights[rest.left_out(heights, first)] = np.inf
    heights[first + np.arange(len(heights))[:, None] <= last_told] = np.inf
    for k in np.flatnonzero(heights.min(axis=1) < -ROUNDING):
        verdict.inside.add(first + int(k))
    if first == 0:
        near = np.flatnonzero(heights[:2].min(axis=0) < NEAR)
        for i in near:
            _note(verdict, heights[0, i], (at.pieces.names[i], s.name, 0))
    if heights.min() < min(verdict.gap, NEAR):
        i, k = np.unravel_index(heights.T.argmin(), heights.T.shape)
        _note(verdict, heights[k, i], (at.pieces.names[i], s.name, first + int(k)))


def _note(verdict, gap, where, told=False):
    """A distance at (piece, static, pose); of what is left out, that of the start alone counts."""
    if where[2] == 0:
        verdict.start = min(verdict.start, float(gap))
    if told:
        return
    if gap < -ROUNDING:
        verdict.inside.add(where[2])
    if gap < verdict.gap:
        verdict.gap, verdict.where = float(gap), where


def _keep(recent, away):
    """Puts the latest direction first."""
    length = np.linalg.norm(away)
    if length > 0.0:
        recent.insert(0, away / length)
        del recent[RECENT:]
