"""Judge a run that started inside, from outside: depths by `coal`, kinematics by the body's own.

Conditions on every substep until all hulls are out, and after:

- *deeper*: depth does not grow. Three readings of depth: of each pair of a hull and a solid by
  EPA (`pair`); the largest of these (`worst`); and how far the hulls that a solid holds have to
  be shifted, along the direction that was shortest at the start, until they are out on the root's
  side (`way`). Only the last decreases monotonously: a forearm that slides back through a
  thin wall, or rounds an edge, must pass poses of larger EPA depth.
- *out*: the time from which no hull meets a solid or is beyond a wall.
- *fast*: how much faster than in the motion itself a skin vertex gets [m/s].
- *free*: distance [rad] from its target of a joint with no held joint beyond it, until then.
- *fresh*: depth of pairs that were clear at the start.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.motion.motion import Motion
from halfphysics.motion.skeleton import JOINT_NAMES
from support.starts.groups import groups_at, paths_of
from support.starts.solids import EXACT, Hulls, near_poses

#: Joints whose part comes nearer than this to a solid are not free [m].
TOUCHING = 0.01
#: The drive needs this long to forget a correction of a joint [s].
FADING = 0.1
#: The chosen way out is at most so many times as long as the shortest that is found.
LONGER = 1.5
#: Eyes and jaw: light, on short arms, they lag behind an accelerated trunk by the drive's inertia.
FACE = (22, 23, 24)


@dataclass
class Verdict:
    """All lengths in metres, times in seconds, angles in radians."""

    depth: float = 0.0  # at the start, the deepest way
    held: int = 0  # hulls inside or beyond at the start
    out: float = np.inf  # time
    skin_out: float = np.inf  # time from which no skin vertex is inside a solid
    again: float = 0.0  # EPA depth after the first time out
    deeper_pair: float = 0.0  # largest growth in a substep
    deeper_worst: float = 0.0
    deeper_way: float = 0.0
    deepest_way: float = 0.0  # over the depth at the start
    fresh: float = 0.0
    fresh_where: str = ""
    fast: float = 0.0  # m/s, until out
    fast_after: float = 0.0
    free: float = 0.0
    free_joint: str = ""
    free_after: float = 0.0  # from a moment after all is out
    face: float = 0.0
    root: float = 0.0
    root_end: float = 0.0
    end_gap: float = np.inf  # of the hulls held at the start, at the last pose
    ways: np.ndarray | None = None  # of the deepest group, every pose


class StartJudge:
    """The measurements of one run."""

    def __init__(self, simulator, solids):
        self.world = simulator.world
        self.body = simulator.bodies[0]
        self.contact = simulator.settings.contact
        self.hulls = Hulls(self.body, self.contact)
        self.solids = solids
        self.dt = simulator.dt
        self.count = simulator.settings.substeps_for(self.dt)

    def judge(self, motion, frames, until=0.0, touched=()):
        """`frames` of `Simulator.step` after the reset to motion[0], substeps recorded.

        `until`: objects are out only then [s]; `touched`: hulls that objects have touched.
        """
        start = self.world.start([motion[0]])[0]
        poses = np.concatenate([start[None], *(f.substeps for f in frames)])
        actual = Motion(*self.world.people[0].pose(poses, motion.axes), self.count / self.dt)
        posed = self.hulls.at(actual)
        v = Verdict()
        groups = groups_at(posed, 0, self.solids)
        held = {h for g in groups for h in g.hulls}
        v.held = len(held)
        v.depth = max((g.depth for g in groups), default=0.0)
        depths = self._depths(posed)
        self._measure_depths(v, posed, groups, depths)
        self._measure_skin(v, posed, groups)
        self.inside |= np.arange(len(poses)) * self.dt / self.count < until
        asked = self._asked(motion, len(frames))
        self._measure_speed(v, posed.skin, asked)
        touched = self._near(posed) | held | set(touched)
        self._measure_joints(v, motion, actual, touched)
        offset = actual.translation - asked.translation
        offset = np.linalg.norm(offset, axis=1)
        v.root, v.root_end = float(offset.max()), float(offset[-1])
        last = len(poses) - 1
        gaps = [self._gap(posed, h, last, s) for g in groups for s in g.solids for h in g.inside]
        v.end_gap = min(gaps, default=np.inf)
        return v

    @staticmethod
    def _gap(posed, h, k, solid):
        if solid.near is None:
            return posed.distance(h, k, solid)
        n, o = solid.normals[solid.near], solid.offsets[solid.near]
        return float((posed.points[h][k] @ n).min() - o)

    # -- depth -----------------------------------------------------------------------------

    def _depths(self, posed):
        """EPA depth of every pair that ever meets, (h, solid) -> (T,)."""
        out = {}
        for s, solid in enumerate(self.solids):
            for h in range(len(self.hulls)):
                near = near_poses(posed, h, solid)
                if not near.any():
                    continue
                depth = np.zeros(len(near))
                points = posed.points[h]
                near[near] = solid.separation(points[near]) < -EXACT
                still = np.zeros(len(near), dtype=bool)  # the same place as one pose before
                still[1:] = (points[1:] == points[:-1]).all(axis=(1, 2))
                for k in np.flatnonzero(near):
                    depth[k] = depth[k - 1] if still[k] else posed.depth(h, int(k), solid)
                if depth.max() > EXACT:
                    out[h, s] = depth
        return out

    def _measure_depths(self, v, posed, groups, depths):
        count = len(posed.joints)
        worst = np.zeros(count)
        place = {id(s): i for i, s in enumerate(self.solids)}
        held = {(h, place[id(s)]) for g in groups for h in g.hulls for s in g.solids}
        for (h, s), depth in depths.items():
            if (h, s) in held:
                v.deeper_pair = max(v.deeper_pair, float(np.diff(depth).max(initial=0.0)))
            elif depth.max() > v.fresh:
                v.fresh = float(depth.max())
                v.fresh_where = f"{JOINT_NAMES[self.hulls.joint[h]]}/{self.solids[s].name}"
            worst = np.maximum(worst, depth)
        v.deeper_worst = float(np.diff(worst).max(initial=0.0))
        inside = worst > EXACT
        for g in groups:
            mine = [depths[h, place[id(s)]] for h in g.hulls for s in g.solids
                    if (h, place[id(s)]) in depths]  # fmt: skip
            meets = np.max([np.zeros(count), *mine], axis=0) > EXACT
            way, meets = self._ways(posed, g, g.way, meets)
            inside |= meets
            rise = float(np.diff(way).max(initial=0.0))
            if rise > EXACT:
                rise = min(rise, *self._other_ways(posed, g, meets))
            v.deeper_way = max(v.deeper_way, rise)
            v.deepest_way = max(v.deepest_way, float(way.max() - way[0]))
            if v.ways is None or way[0] > v.ways[0]:
                v.ways = way
        self.inside = inside
        clear = np.flatnonzero(~inside)
        h = self.dt / self.count
        if len(clear):
            v.out = float(clear[0] * h)
            v.again = float(worst[clear[0] :].max())
        posed.forget()

    @staticmethod
    def _ways(posed, g, n, meets):
        """Depth of a group along a way at every pose (T,), and where it meets or is beyond."""
        count, meets = len(meets), meets.copy()
        wall = any(s.near is not None for s in g.solids)
        points = [posed.points[h] for h in g.hulls]
        still = np.zeros(count, dtype=bool)
        still[1:] = np.all([(p[1:] == p[:-1]).all(axis=(1, 2)) for p in points], axis=0)
        way = np.zeros(count)
        for k in range(count):
            if still[k]:
                way[k], meets[k] = way[k - 1], meets[k - 1]
            elif wall or meets[k] or g.through(posed, k):
                way[k] = g.depth_at(posed, k, n)
                meets[k] = meets[k] or way[k] > EXACT
        way[way <= EXACT] = 0.0
        return way, meets

    def _other_ways(self, posed, g, meets):
        """Largest growth of depth in a substep, along each other direction that leads out.

        Of several ways of similar length any may be taken; so may the one that was taken.
        """
        last = min(int(np.flatnonzero(meets)[-1]) + 1, len(meets) - 1)
        taken = np.mean([(posed.points[h][last] - posed.points[h][0]).mean(axis=0)
                         for h in g.hulls], axis=0)  # fmt: skip
        ways = list(g.ways)
        if np.linalg.norm(taken) > EXACT:
            ways.append(taken / np.linalg.norm(taken))
        out = [np.inf]
        for n in ways:
            if g.depth_at(posed, 0, n) <= LONGER * g.depth:
                way, _ = self._ways(posed, g, n, meets)
                out.append(float(np.diff(way).max(initial=0.0)))
        return out

    def _measure_skin(self, v, posed, groups):
        """When the last skin vertex has left the solids that it started in."""
        last = -1
        for solid in {id(s): s for g in groups for s in g.solids}.values():
            normals, offsets = solid.normals, solid.offsets
            if solid.near is not None:
                normals, offsets = normals[[solid.near]], offsets[[solid.near]]
            first = 0  # the side beyond which all were in the pose after this one: asked first
            for k in range(len(posed.skin) - 1, last, -1):
                x = posed.skin[k]
                for i in [first, *(i for i in range(len(normals)) if i != first)]:
                    x = x[x @ normals[i] < offsets[i] - EXACT]
                    if not len(x):
                        first = i
                        break
                if len(x):
                    last = k
                    break
        if last + 1 < len(posed.skin):
            v.skin_out = float((last + 1) * self.dt / self.count)

    # -- motion ----------------------------------------------------------------------------

    def _asked(self, motion, frames):
        """The reference at every substep: root straight, joints by the shortest arc."""
        n = self.count
        turns = rot.exp(motion.rotations[: frames + 1])
        path, out = [motion.translation[:1]], [turns[:1]]
        for k in range(1, n + 1):
            share = k / n
            x = motion.translation[: frames + 1]
            path.append((1 - share) * x[:-1] + share * x[1:])
            out.append(rot.slerp(turns[:-1], turns[1:], np.full(turns[1:].shape[:2], share)))
        path = np.concatenate([path[0], np.stack(path[1:], axis=1).reshape(-1, 3)])
        out = np.concatenate([out[0], np.stack(out[1:], axis=1).reshape(-1, 55, 4)])
        return Motion(path, rot.log(out), n / self.dt)

    def _measure_speed(self, v, skin, asked):
        rate = self.count / self.dt
        wanted = self.body.vertices(asked)
        fast = np.array([
            (_lengths(skin[k + 1] - skin[k]) - _lengths(wanted[k + 1] - wanted[k])).max()
            for k in range(len(skin) - 1)
        ]) * rate  # fmt: skip
        moving = self.inside[:-1]
        v.fast = float(fast[moving].max(initial=0.0))
        v.fast_after = float(fast[~moving].max(initial=0.0))

    def _near(self, posed):
        """Hulls that ever come near a solid."""
        out = set()
        for solid in self.solids:
            for h in range(len(self.hulls)):
                near = near_poses(posed, h, solid, TOUCHING)
                if near.any() and (solid.separation(posed.points[h][near]) < TOUCHING).any():
                    out.add(h)
        return out

    def _measure_joints(self, v, motion, actual, touched):
        free = ~paths_of({int(self.hulls.joint[h]) for h in touched})
        free[0] = False
        face = np.zeros(55, dtype=bool)
        face[list(FACE)] = True
        n = self.count
        at = rot.exp(actual.rotations[n::n])
        wanted = rot.exp(motion.rotations[1 : len(at) + 1])
        off = np.linalg.norm(rot.log(rot.multiply(rot.conjugate(wanted), at)), axis=2)
        # Later contacts do not count: walking on into a wall, say.
        inside = np.flatnonzero(self.inside)
        last = (inside[-1] if len(inside) else 0) / n + FADING / self.dt
        during = np.arange(1, len(at) + 1) <= last
        v.face = float(off[during][:, free & face].max(initial=0.0))
        free &= ~face
        v.free_after = float(off[~during][:, free].max(initial=0.0))
        off = off[during].max(axis=0, initial=0.0)
        if free.any():
            worst = int(np.flatnonzero(free)[off[free].argmax()])
            v.free, v.free_joint = float(off[worst]), JOINT_NAMES[worst]


def _lengths(x):
    return np.sqrt(np.einsum("ij,ij->i", x, x))
