"""Independent checks of a run: distances by coal, poses of people by `person_hulls`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import coal
import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Mesh, Plane, Sphere
from halfphysics.scene.trajectories import KinematicObject
from support import short_rows as rows
from support.judges.coal_shapes import coal_shape
from support.judges.person_hulls import pieces_of
from support.judges.scene_solids import fixed_links, owners, solids_of
from support.judges.separation import planes

#: Pairs beyond this distance are skipped [m].
NEAR = 0.02
#: Accuracy of coal's own distances [m].
ROUNDING = 1e-6
#: Poses looked at together: bounds the memory.
CHUNK = 16
#: Corners of a cylinder's rim, around it.
SIDES = 32


@dataclass
class _Solid:
    """A solid that stays where it is: box [m], owner (a static or an articulated object), and
    coal's geometry, made when it is first asked for, and place."""

    owner: str
    low: np.ndarray
    high: np.ndarray
    make: Callable[[], object]
    place: object

    @property
    def solid(self):
        """coal's geometry and place."""
        return self.make(), self.place


def _bounds(geometry, turn, position):
    """Corners of a box around coal's geometry."""
    geometry.computeLocalAABB()
    box = geometry.aabb_local
    middle, half = 0.5 * (box.max_ + box.min_), 0.5 * (box.max_ - box.min_)
    middle, half = turn @ middle + position, np.abs(turn) @ half
    return middle - half, middle + half


def _apart(low, high, below, above):
    """Distance of two boxes [m]; -inf where they meet."""
    gaps = np.maximum(np.maximum(low - above, below - high), 0.0)
    return float(np.linalg.norm(gaps)) if gaps.any() else -np.inf


class Watch:
    """Distances between all moving and all static solids of a simulator.

    Attributes:
        people: The pieces of every person (`person_hulls`), as the simulator keeps them clear.
    """

    def __init__(self, simulator):
        self.simulator = simulator
        self.scene = simulator.world.scene
        self.statics = [self._static(s) for s in self.scene.statics.values()]
        self.people = pieces_of(simulator)
        world, standing = simulator.world, fixed_links(self.scene)
        self.owner = owners(self.scene)
        # Pieces of objects, geoms of links, with their poses.
        self.things = [
            (t, solid, coal_shape(solid.shape, solid=True), *_points_of(solid.shape))
            for t in world.tracked
            if t.name not in standing
            for solid in solids_of(self.scene, t.name)
        ]
        for link in world.links:
            if link.name in standing:
                at = link.pose(np.zeros(world.nq))
                for solid in solids_of(self.scene, link.name):
                    shape = coal_shape(solid.shape, solid=True)
                    name = self.owner[link.name]
                    self.statics.append(self._placed(name, solid, shape, at))
        self.request = coal.DistanceRequest()
        self._who_meets()

    def _who_meets(self):
        """Which pairs of movers (M, M), and of movers and statics (M, S), can meet.

        Contact does not push what is kinematic.
        """
        kinds = [(p.name, True, True) for p in self.people for _ in p.names]
        for thing, *_ in self.things:
            moves = not isinstance(self.scene.objects.get(thing.name), KinematicObject)
            kinds.append((self.owner[thing.name], False, moves))
        self._owner = [name for name, _, _ in kinds]
        self._human = np.array([human for _, human, _ in kinds], dtype=bool)
        others = [(s.owner, False, False) for s in self.statics]
        known = {}

        def meet(a, b):
            if (a, b) not in known:
                names = ["person" if human else name for name, human, _ in (a, b)]
                moved = a[2] or b[2]
                known[a, b] = moved and a[0] != b[0] and not self.scene.ignores(*names)
            return known[a, b]

        shapes = (len(kinds), len(kinds)), (len(kinds), len(others))
        self._meet, self._meet_static = (
            np.array([meet(a, b) for a in kinds for b in some], dtype=bool).reshape(shape)
            for some, shape in zip((kinds, others), shapes, strict=True)
        )

    @staticmethod
    def _static(s):
        turn, position = rot.to_matrix(s.quaternion), np.asarray(s.position, float)
        make = cache(lambda: coal_shape(s.shape, solid=False))
        place = coal.Transform3s(turn, position)
        low, high = np.full(3, -np.inf), np.full(3, np.inf)
        if isinstance(s.shape, Mesh):
            corners = np.asarray(s.shape.vertices) @ turn.T + position
            low, high = corners.min(axis=0), corners.max(axis=0)
        elif not isinstance(s.shape, Plane):
            low, high = _bounds(make(), turn, position)
        return _Solid(s.name, low, high, make, place)

    @staticmethod
    def _placed(name, solid, shape, pose):
        """A static solid of an item whose frame is at a pose (3,), (4,)."""
        position, turn = solid.at(pose[0], rot.to_matrix(rot.normalize(pose[1])))
        place = coal.Transform3s(turn, position)
        low, high = _bounds(shape, turn, position)
        return _Solid(name, low, high, lambda: shape, place)

    def gap(self, qpos, against_objects=True, statics="all"):
        """Smallest distance at one pose (inf: beyond `NEAR`), and the two items.

        statics: The solids whose distance to them counts: "all", "things" (not people's) or "none".
        """
        found = self.gaps(qpos, against_objects, statics)
        d, *pair = min(found, default=(np.inf, "", ""))
        return (d, tuple(pair)) if d < NEAR else (np.inf, ("", ""))

    def gaps(self, qpos, against_objects=True, statics="all"):
        """Distances of all near pairs at a pose: (distance, one, the other)."""
        at = Movers(self, qpos[None])
        for pair in self._pairs(at, NEAR, against_objects, statics).T.tolist():
            yield self._distance(at, *pair)

    def smallest(self, poses, known=np.inf, statics="all", told=None):
        """Over poses (T, nq): the smallest distance below `known` and `NEAR`, its items, and the
        number of poses with a negative one.

        `known` and no items, if there is none. `told`: What is left out (`clear_judge.told_inside`;
        pose 1 is the first of `poses`).

        Pairs that planes prove to be farther than the smallest known distance are not asked about.
        """
        gap, items, inside = known, ("", ""), set()
        last = self._last_told(told)

        def asked():
            return max(min(gap, NEAR), 0.0)

        for first in range(0, len(poses), CHUNK):
            at = Movers(self, poses[first : first + CHUNK])
            pairs = self._pairs(at, asked(), True, statics)
            if last is not None:
                pairs = pairs[:, first + 1 + pairs[0] > last[pairs[1], pairs[2]]]
            while pairs.size:
                far = asked()
                d = self._proven(at, pairs, far)
                left = np.flatnonzero(d < far)
                pairs = pairs[:, left[np.argsort(d[left], kind="stable")]]
                done = 0
                while done < pairs.shape[1] and asked() == far:
                    t = int(pairs[0, done])
                    d, *names = self._distance(at, *pairs[:, done].tolist())
                    done += 1
                    if d < -ROUNDING:
                        inside.add(first + t)
                    if d < min(gap, NEAR):
                        gap, items = d, tuple(names)
                pairs = pairs[:, done:]
        return gap, items, len(inside)

    def _last_told(self, told):
        """The last pose at which movers are said to meet movers and statics (M, M + S), -1: never;
        None where nothing is told."""
        if not told:
            return None
        pieces = [name for p in self.people for name in p.names]
        parts = ["/".join(name.split("/")[:2]) for name in pieces] + self._owner[len(pieces) :]
        owners = self._owner + [s.owner for s in self.statics]
        last = np.array([[told.get((a, b), -1) for b in owners] for a in parts])
        moving = last[:, : len(parts)]
        np.maximum(moving, moving.T, out=moving)
        return last

    def _pairs(self, at, near, against_objects, statics):
        """(pose, mover, other) of pairs with near boxes; others from `at.count` on: statics."""
        low, high = at.low, at.high
        found = []
        if against_objects:
            a, b = np.nonzero(np.triu(self._meet, 1))
            meet = np.ones((len(low), len(a)), bool)
            for x in range(3):  # numpy is slow along short rows
                below, above = low[..., x], high[..., x]
                meet &= below[:, a] - above[:, b] <= near
                meet &= below[:, b] - above[:, a] <= near
            t, pair = np.nonzero(meet)
            found.append((t, a[pair], b[pair]))
        if statics != "none" and self.statics:
            ends = np.array([[s.low, s.high] for s in self.statics])
            apart = np.maximum(low[:, :, None] - ends[:, 1], ends[:, 0] - high[:, :, None])
            counts = self._meet_static & ~(self._human[:, None] & (statics == "things"))
            t, a, b = np.nonzero((rows.largest(apart) <= near) & counts)
            found.append((t, a, b + at.count))
        return np.concatenate([np.array(f) for f in found] or [np.zeros((3, 0), int)], axis=1)

    def _proven(self, at, pairs, asked):
        """`asked` where planes prove that a pair is as far apart, else less (k,) [m]."""
        t, a, b = pairs
        out = np.full(len(t), -np.inf)
        two = np.flatnonzero(b < at.count)
        sizes = np.maximum(at.size[a[two]], at.size[b[two]])
        kinds = np.ceil(np.log2(sizes)).astype(int)
        for kind in np.unique(kinds):
            some = two[kinds == kind]
            ones, others = (at.clouds(m[some], t[some], 1 << kind) for m in (a, b))
            balls = at.ball[a[some]] + at.ball[b[some]]

            def highest(pair, n, others=others):
                heights = np.einsum("kmi,ki->km", others[pair], n)
                return others[pair, heights.argmax(axis=1)]

            guess = ones.mean(axis=1) - others.mean(axis=1)
            _, d = planes(ones, highest, guess, asked + balls.max(), settle=True)
            out[some] = np.minimum(d - balls, asked)
        return out

    def _distance(self, at, t, a, b):
        """Distance of a pair by coal, and the owners."""
        other = self.statics[b - at.count] if b >= at.count else None
        solid = at.solid(t, b) if other is None else other.solid
        d = coal.distance(*at.solid(t, a), *solid, self.request, coal.DistanceResult())
        ends = (at.low[t, b], at.high[t, b]) if other is None else (other.low, other.high)
        # Flat triangles and turns by 90 degrees mislead it at times, by metres.
        d = max(d, _apart(at.low[t, a], at.high[t, a], *ends))
        return d, self._owner[a], self._owner[b] if other is None else other.owner

    def smallest_gap(self, frames, every=1, against_objects=True):
        """Over all recorded substeps of `frames`: distance, pair, frame, substep."""
        worst = (np.inf, ("", ""), -1, -1)
        count = 0
        for f, frame in enumerate(frames):
            for k, qpos in enumerate(frame.substeps):
                count += 1
                if count % every:
                    continue
                d, pair = self.gap(qpos, against_objects)
                if d < worst[0]:
                    worst = (d, pair, f, k)
        return worst


class Movers:
    """All that moves at poses (T, nq): pieces of people, then solids of things.

    Attributes:
        count: How many there are, M.
        low, high: Corners of boxes around them (T, M, 3) [m].
        size: Numbers of their points (M,).
        ball: What is within this distance of a point's hull belongs to them too (M,) [m].
    """

    def __init__(self, watch, poses):
        self._people = [pieces.at(poses) for pieces in watch.people]
        self._things = []
        corners = [at.corners for at in self._people]
        first = [np.diff(at.pieces.first) for at in self._people]
        for thing, solid, shape, points, _ in watch.things:
            position, quaternion = thing.pose(poses)
            turn = rot.to_matrix(rot.normalize(np.broadcast_to(quaternion, (len(poses), 4))))
            position, turn = solid.at(np.broadcast_to(position, (len(poses), 3)), turn)
            self._things.append((shape, position, turn))
            corners.append(np.einsum("tij,nj->nti", turn, points) + position)
            first.append([len(points)])
        self.size = np.concatenate([*first, np.zeros(0, int)]).astype(int)
        self.count = len(self.size)
        self._first = np.cumsum([0, *self.size])
        self._corners = np.concatenate([*corners, np.zeros((0, len(poses), 3))])
        balls = [np.zeros(len(at.pieces.names)) for at in self._people]
        self.ball = np.concatenate([*balls, [t[4] for t in watch.things]])
        boxes = [(at.low, at.high) for at in self._people]
        boxes += [(c.min(axis=0)[:, None], c.max(axis=0)[:, None])
                  for c in corners[len(self._people) :]]  # fmt: skip
        none = np.zeros((len(poses), 0, 3))
        self.low = np.concatenate([*(b[0] for b in boxes), none], axis=1) - self.ball[:, None]
        self.high = np.concatenate([*(b[1] for b in boxes), none], axis=1) + self.ball[:, None]
        self._solids = {}

    def clouds(self, which, pose, most):
        """Points (k, most, 3) of movers (k,) at poses (k,): some repeat."""
        rows = np.minimum(np.arange(most), self.size[which][:, None] - 1)
        return self._corners[self._first[which][:, None] + rows, pose[:, None]]

    def solid(self, t, which):
        """coal's geometry and place of a mover at a pose."""
        if (t, which) not in self._solids:
            self._solids[t, which] = self._make(t, which)
        return self._solids[t, which]

    def _make(self, t, which):
        for at in self._people:
            if which < len(at.pieces.names):
                return at.solid(which, t)
            which -= len(at.pieces.names)
        shape, position, turn = self._things[which]
        return shape, coal.Transform3s(turn[t], position[t])


def _points_of(shape):
    """Points (n, 3) and the radius of a ball that make up a convex shape, or a little more."""
    if isinstance(shape, Box):
        return 0.5 * np.asarray(shape.size) * (np.indices((2, 2, 2)).reshape(3, -1).T * 2 - 1), 0.0
    if isinstance(shape, Sphere):
        return np.zeros((1, 3)), shape.radius
    if isinstance(shape, Capsule | Cylinder):
        ends = np.array([[0.0, 0.0, z] for z in (-0.5 * shape.length, 0.5 * shape.length)])
        if isinstance(shape, Capsule):
            return ends, shape.radius
        angle = np.arange(SIDES) * (2.0 * np.pi / SIDES)
        rim = (
            shape.radius / np.cos(np.pi / SIDES) * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        )
        rim = np.append(rim, np.zeros((SIDES, 1)), axis=1)
        return np.concatenate([rim + end for end in ends]), 0.0
    return np.asarray(shape.vertices, float), 0.0
