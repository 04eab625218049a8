"""Judge objects that start overlapping, from outside: see `starts_judge`."""

from __future__ import annotations

from itertools import product

import coal
import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.motion.motion import Motion
from halfphysics.motion.skeleton import JOINT_NAMES
from support.judges.coal_shapes import coal_shape
from support.judges.scene_solids import solids_of
from support.starts.judge import LONGER, TOUCHING
from support.starts.solids import ADVANCES, ARRIVED, EXACT, REQUEST, Hulls


def _distance(a, place, b, its):
    return coal.distance(a, place, b, its, REQUEST, coal.DistanceResult())


class ObjectJudge:
    """Objects that start overlapping: their depth in statics, each other and the person.

    Of an object of several pieces the deepest counts.
    """

    def __init__(self, simulator, solids):
        self.simulator = simulator
        self.world = simulator.world
        self.solids = solids
        self.hulls = Hulls(simulator.bodies[0], simulator.settings.contact)
        self.shapes = {
            t.name: [coal_shape(s.shape, solid=True) for s in solids_of(self.world.scene, t.name)]
            for t in self.world.objects
        }

    def judge(self, motion, frames):
        """Dictionary: depth at the start, time out, growth of depth, thrown [m/s], depth
        after that, and which hulls were touched."""
        simulator = self.simulator
        dt = simulator.dt / simulator.settings.substeps_for(simulator.dt)
        start = self.world.start([motion[0]])[0]
        poses = np.concatenate([start[None], *(f.substeps for f in frames)])
        actual = Motion(*self.world.people[0].pose(poses, motion.axes), 1.0 / dt)
        posed = self.hulls.at(actual)
        tracks = {t.name: t.pose(poses) for t in self.world.objects}
        depths, self.touched = {}, set()
        names = list(tracks)
        for i, name in enumerate(names):
            for solid in self.solids:
                depths[name, solid.name] = self._against(name, tracks, solid)
            for other in names[i + 1 :]:
                depths[name, other] = self._between(name, other, tracks)
            for h in range(len(self.hulls)):
                joint = JOINT_NAMES[self.hulls.joint[h]]
                depths[name, f"{joint}#{h}"] = self._with(name, tracks, posed, h)
        depths = {key: d for key, d in depths.items() if d.max() > EXACT}
        inside = {key: d for key, d in depths.items() if d[0] > EXACT}
        worst = np.max([d for d in depths.values()] or [np.zeros(len(poses))], axis=0)
        clear = np.flatnonzero(worst <= EXACT)
        gravity = np.linalg.norm(self.world.scene.gravity)
        thrown = 0.0
        for name, (x, q) in tracks.items():
            com = x + rot.rotate(q, np.array(self.world.scene.objects[name].com))
            speed2 = np.sum(np.diff(com, axis=0) ** 2, axis=1) / dt**2
            fallen = np.maximum(0.0, com[0, 2] - com[1:, 2])
            own = np.linalg.norm(self.world.scene.objects[name].velocity)
            thrown = max(
                thrown, np.sqrt(np.maximum(0.0, speed2 - 2 * gravity * fallen)).max() - own
            )
        fresh = {key: d.max() for key, d in depths.items() if d[0] <= EXACT}
        return {
            "touched": tuple(self.touched),
            "depth": max((d[0] for d in inside.values()), default=0.0),
            "out": float(clear[0] * dt) if len(clear) else np.inf,
            "again": float(worst[clear[0] :].max()) if len(clear) else np.inf,
            "deeper": max((np.diff(d).max() for d in inside.values()), default=0.0),
            "deeper_way": self._deeper(tracks, posed, depths),
            "fresh": max(fresh.values(), default=0.0),
            "thrown": float(thrown),
        }

    def _deeper(self, tracks, posed, depths):
        """Largest growth of depth: per static and object, and for a person's hulls together."""
        growth = 0.0
        for name in tracks:
            own = {key: d for key, d in depths.items() if key[0] == name and d[0] > EXACT}
            mine = [d for key, d in own.items() if "#" in key[1]]
            rises = [float(np.diff(d).max()) for key, d in own.items() if "#" not in key[1]]
            if mine and np.diff(np.max(mine, axis=0)).max() > EXACT:
                rises.append(self._growth(name, tracks, posed, np.max(mine, axis=0) > EXACT))
            growth = max(growth, *rises, 0.0)
        return growth

    def _against(self, name, tracks, solid):
        x, q = tracks[name]
        turns = rot.to_matrix(q)
        out = np.zeros(len(x))
        for k in range(len(x)):
            place = coal.Transform3s(turns[k], x[k])
            other, at = solid.geometry, solid.place
            if other is None:
                n = solid.normals[0]
                other, at = coal.Halfspace(n, float(solid.offsets[0])), coal.Transform3s()
            out[k] = -min(_distance(own, place, other, at) for own in self.shapes[name])
        return np.maximum(0.0, out)

    def _between(self, name, other, tracks):
        turns = [rot.to_matrix(tracks[n][1]) for n in (name, other)]
        out = np.zeros(len(turns[0]))
        for k in range(len(out)):
            a, b = (
                coal.Transform3s(r[k], tracks[n][0][k])
                for r, n in zip(turns, (name, other), strict=True)
            )
            pairs = product(self.shapes[name], self.shapes[other])
            out[k] = -min(_distance(mine, a, its, b) for mine, its in pairs)
        return np.maximum(0.0, out)

    def _with(self, name, tracks, posed, h):
        x, q = tracks[name]
        turns = rot.to_matrix(q)
        low, high = self._box(name)
        # In the object's own frame: clear where a side of its box separates.
        local = np.einsum("tni,tij->tnj", posed.points[h] - x[:, None], turns)
        apart = np.maximum(local.min(axis=1) - high, low - local.max(axis=1)).max(axis=1)
        if apart.min() < TOUCHING:
            self.touched.add(h)
        out = np.zeros(len(x))
        for k in np.flatnonzero(apart < 0.0):
            out[k] = -self._distance(name, x[k], turns[k], posed, h, int(k))
        return np.maximum(0.0, out)

    def _box(self, name):
        boxes = [shape.computeLocalAABB() or shape.aabb_local for shape in self.shapes[name]]
        return np.min([b.min_ for b in boxes], axis=0), np.max([b.max_ for b in boxes], axis=0)

    def _distance(self, name, x, turn, posed, h, k):
        shape, its_turn, at = posed.shape(h, k)
        place, its = coal.Transform3s(turn, x), coal.Transform3s(its_turn, at)
        return min(_distance(own, place, shape, its) for own in self.shapes[name])

    def _growth(self, name, tracks, posed, inside):
        """Largest growth in a substep of the way that an object has to go to be out of all hulls
        (T,) `inside`: along the direction of some in which it grows least, as any of several of
        similar length may be taken."""
        x, q = tracks[name]
        turns = rot.to_matrix(q)
        last = min(int(np.flatnonzero(inside)[-1]) + 1, len(x) - 1)
        low, high = self._box(name)
        reach = np.linalg.norm(high - low)
        middles = [p[: last + 1].mean(axis=1) - x[: last + 1] for p in posed.points]
        hulls = [h for h, m in enumerate(middles)
                 if np.linalg.norm(m, axis=1).min() < reach + 0.3]  # fmt: skip
        signs = np.array(list(product((-1.0, 0.0, 1.0), repeat=3)))
        ways = [n / np.linalg.norm(n) for n in signs if n.any()]
        moved = np.mean([p[last].mean(axis=0) - p[0].mean(axis=0)
                         for p in (posed.points[h] for h in hulls)], axis=0)  # fmt: skip
        ways += [v / np.linalg.norm(v) for v in (x[last] - x[0], x[last] - x[0] - moved)
                 if np.linalg.norm(v) > EXACT]  # fmt: skip
        start = [self._way(name, x[0], turns[0], posed, hulls, 0, n) for n in ways]
        best = np.inf
        for n, first in zip(ways, start, strict=True):
            if first > LONGER * min(start):
                continue
            way = [self._way(name, x[k], turns[k], posed, hulls, k, n) for k in range(last + 1)]
            best = min(best, float(np.diff(way).max(initial=0.0)))
        return best

    def _way(self, name, x, turn, posed, hulls, k, n):
        r = 0.0
        for _ in range(len(hulls)):
            before = r
            for h in hulls:
                if self._distance(name, x + r * n, turn, posed, h, k) < -ARRIVED:
                    r = max(r, self._far_end(name, x, turn, posed, h, k, n))
            if r == before:
                break
        return r

    def _far_end(self, name, x, turn, posed, h, k, n):
        low, high = self._box(name)
        corners = np.array(list(product(*zip(low, high, strict=True)))) @ turn.T + x
        r = (posed.points[h][k] @ n).max() - (corners @ n).min()
        for _ in range(ADVANCES):
            gap = self._distance(name, x + r * n, turn, posed, h, k)
            if gap <= ARRIVED:
                break
            r -= gap
        return max(r, 0.0)
