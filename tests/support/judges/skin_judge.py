"""Judges a run independently by the visible skin: is it outside all items, at every pose?

The core is not used: the skin is posed here in numpy, items are queried by their formulas,
by `triangle_soup` and by `coal`. The judge checks

- all vertices, and points sampled on the skin's triangles (area weighted, fixed seed): their
  depth; winding numbers where a mesh is closed;
- all triangles: does one meet the surface of an item? By separating axes, GJK where there is none;
- with `continuous`, all ways of triangles: does the hull of a triangle at two consecutive poses
  meet an item? A clear start with clear ways stays on its side of every sheet;
- the smallest distance of the vertices, pose by pose;
- at chosen poses all of that again by `coal` alone: tree of the skin against tree of the item.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import coal
import numpy as np
from scipy.spatial.transform import Rotation

from halfphysics import metrics
from halfphysics.motion.skeleton import JOINT_NAMES
from support.judges.posed_skin import SAMPLES, Skinner
from support.judges.scene_solids import owners, solids_of
from support.judges.skin_obstacles import obstacles_of
from support.judges.triangle_soup import Soup

#: Distances up to this are measured [m]; larger ones are inf.
NEAR = 0.03
#: Accuracy of formulas and skinning [m].
ROUNDING = 1e-9
#: Poses skinned together: bounds the memory.
CHUNK = 64
#: A way that is not clear as a whole is halved at most this often.
HALVES = 4
#: Up to this many ways are split; if one of them stays blocked, so do all.
PATIENCE = 50


@dataclass
class SkinVerdict:
    """Results. Distances and depths [m]; `where`: item, part, pose.

    Attributes:
        start: Smallest distance at the first pose, negative if inside.
        gaps: Smallest distance of the vertices from any surface at every pose, inf beyond `NEAR`.
        depths: Deepest vertex or sample at every pose checked for depth, else 0.
        shares: Share of vertices inside likewise.
        cut: Poses at which a triangle of the skin meets a surface.
        crossed: (item, part, pose) where the way from a clear place to a clear place is blocked.
        coal: Poses at which coal finds an intersection.
        checked: Number of poses checked for depth, and by coal.
    """

    poses: int = 0
    start: float = np.inf
    gaps: np.ndarray = field(default_factory=lambda: np.zeros(0))
    depths: np.ndarray = field(default_factory=lambda: np.zeros(0))
    shares: np.ndarray = field(default_factory=lambda: np.zeros(0))
    nearest: tuple[str, str, int] = ("", "", -1)
    deepest: tuple[str, str, int] = ("", "", -1)
    cut: set[int] = field(default_factory=set)
    crossed: list[tuple[str, str, int]] = field(default_factory=list)
    coal: set[int] = field(default_factory=set)
    swallowed: list[str] = field(default_factory=list)
    checked: int = 0

    @property
    def gap(self):
        """Smallest distance of a vertex from any surface [m]."""
        return float(self.gaps.min(initial=np.inf))

    @property
    def depth(self):
        """Deepest vertex or sampled point [m]."""
        return float(self.depths.max(initial=0.0))

    @property
    def clear(self):
        """The skin was inside no item, met none and crossed none."""
        hit = self.cut or self.crossed or self.coal or self.swallowed
        return self.depth <= ROUNDING and not hit

    def __str__(self):
        gap = "far" if np.isinf(self.gap) else f"{1e3 * self.gap:.3f} mm"
        return (
            f"gap {gap} {'/'.join(map(str, self.nearest))}, depth {1e3 * self.depth:.2f} mm "
            f"{'/'.join(map(str, self.deepest))}, {100 * self.shares.max(initial=0.0):.2f} % of "
            f"the skin, cut at {len(self.cut)}, coal at {len(self.coal)} of {self.checked}, "
            f"{len(self.crossed)} crossings {self.crossed[:1]}"
        )


@dataclass
class _Thing:
    name: str
    piece: object
    position: np.ndarray  # (T or 1, 3)
    turn: np.ndarray  # (T or 1, 3, 3)

    def local(self, points, t):
        k = t if len(self.position) > 1 else 0
        return (points - self.position[k]) @ self.turn[k]

    def world(self, points, t):
        k = t if len(self.position) > 1 else 0
        return points @ self.turn[k].T + self.position[k]

    def bounds(self, t):
        """Corners of a box around it in the world."""
        if self.piece.plane:
            return np.full(3, -np.inf), np.full(3, np.inf)
        ends = np.stack([self.piece.low, self.piece.high])
        corners = self.world(np.stack(np.meshgrid(*ends.T), axis=-1).reshape(-1, 3), t)
        return corners.min(axis=0), corners.max(axis=0)


def _matrices(quaternions):
    return Rotation.from_quat(np.array(np.atleast_2d(quaternions)), scalar_first=True).as_matrix()


class SkinJudge:
    """Judges the skin of one person in a scene."""

    def __init__(self, body, scene, samples=SAMPLES, seed=0):
        self.skin, self.body, self.scene = Skinner(body, samples, seed), body, scene
        self.statics = [
            _Thing(s.name, piece, np.asarray(s.position, float)[None], _matrices(s.quaternion))
            for s in scene.statics.values()
            if not scene.ignores("person", s.name)
            for piece in obstacles_of(s.shape)
        ]

    def judge_motion(
        self,
        motion,
        objects=None,
        *,
        poses=None,
        continuous=False,
        every=1,
        coal_every=1,
        least=False,
    ):
        """A motion's poses; with `continuous`, its ways from each to the next too.

        objects: name -> (positions (T, 3), quaternions (T, 4)) of the scene's objects and links,
            which are judged by their convex pieces.
        poses: number of first poses to judge.
        every, coal_every: interval of poses for depth and for coal (and the last pose).
        least: `gaps` are only those that are smaller than all before, and the last: others are inf.
        """
        things = [*self.statics, *self._objects(objects or {})]
        count = len(motion) if poses is None else poses
        verdict = SkinVerdict(
            poses=count, gaps=np.full(count, np.inf), depths=np.zeros(count), shares=np.zeros(count)
        )
        before = None
        for first in range(0, count, CHUNK):
            part = slice(first, first + CHUNK)
            skins = self.skin.vertices(
                motion.translation[part], motion.rotations[part], motion.axes
            )
            for k, skin in enumerate(skins[: count - first]):
                t = first + k
                last = t == count - 1
                self._pose(
                    skin,
                    before if continuous else None,
                    things,
                    t,
                    verdict,
                    full=t % every == 0 or last,
                    by_coal=t % coal_every == 0 or last,
                    most=verdict.gap if least and not last else NEAR,
                )
                before = skin
        return verdict

    def judge_result(self, result, **options):
        """A `halfphysics.Result`: every recorded substep if there are any, else every frame."""
        run = result.substeps
        motion = result.motion if run is None else run.motions[0]
        tracks = result.objects if run is None else run.objects
        objects = {n: (o.position, o.quaternion) for n, o in tracks.items()}
        options = {"continuous": run is not None, **options}
        return self.judge_motion(motion, objects, **options)

    def judge_frames(self, simulator, start, frames, **options):
        """Judges a `Simulator`'s poses: `frames` with their substeps after the pose `start`.

        With `simulator.world.stepper.keep_pieces(True)` these are all poses. Depths and coal: at
        the ends of frames.
        """
        person, axes = simulator.world.people[0], np.asarray(start.axes)
        first = simulator.world.start([start])[0]
        poses = np.concatenate([first[None], *(f.substeps for f in frames)])
        translation, rotations = person.pose(poses, axes)
        objects = {t.name: t.pose(poses) for t in simulator.world.tracked}
        every = max(1, round((len(poses) - 1) / max(1, len(frames))))
        options = {"continuous": True, "every": every, "coal_every": every, **options}
        return self.judge_motion(_Path(translation, rotations, axes), objects, **options)

    def penetration(self, motion, objects=None):
        """`halfphysics.metrics.penetration` of a motion: rate [%] and depth [mm]."""
        found = metrics.penetration(motion, self.body, self.scene, objects=objects)
        return found.rate_percent, found.depth_max_mm

    def surface_distance(self, pose):
        """Distance of the skin's triangles to statics at a `Pose`, by coal [m], without planes.

        At most the distance of the vertices, which are up to 6 cm apart.
        """
        skin = self.skin.vertices(pose.translation[None], pose.rotations[None], pose.axes)[0]
        best = np.inf
        for thing in self.statics:
            if not thing.piece.plane:
                tree = _tree(thing.local(skin, 0), self.skin.faces)
                here = coal.Transform3s()
                asked, found = coal.DistanceRequest(), coal.DistanceResult()
                best = min(best, coal.distance(tree, here, thing.piece.coal, here, asked, found))
        return best

    # -- one pose --------------------------------------------------------------------------

    def _objects(self, tracks):
        out, whose = [], owners(self.scene)
        for name, (position, quaternion) in tracks.items():
            if self.scene.ignores("person", whose[name]):
                continue
            for solid in solids_of(self.scene, name):
                at = solid.at(np.asarray(position), _matrices(quaternion))
                out += [_Thing(name, piece, *at) for piece in obstacles_of(solid.shape)]
        return out

    def _pose(self, skin, before, things, t, verdict, *, full, by_coal, most):
        verdict.checked += full
        points = self.skin.points(skin) if full else skin
        inside = np.zeros(len(skin), dtype=bool)
        low, high = (skin, skin) if before is None else _ends(skin, before)
        for thing in things:
            below, above = thing.bounds(t)
            near = _in_box(points, below - NEAR, above + NEAR)
            if len(near):
                local = thing.local(points[near], t)
                self._gap(thing, local[near < len(skin)], near, t, verdict, most)
                if full:
                    depth = self._depth(thing, local, near, t, verdict)
                    deep = near[depth > ROUNDING]
                    inside[deep[deep < len(skin)]] = True
            if t == 0:
                self._swallowed(thing, skin, verdict)
            if thing.piece.plane and thing.piece.clear_of(thing.local(skin, t)):
                continue  # and the way between two clear poses is clear
            met = self._met(low, high, below, above)
            if len(met):
                corners = skin[self.skin.faces[met]]
                start = None if before is None else before[self.skin.faces[met]]
                self._triangles(thing, met, corners, start, t, verdict)
                if by_coal and self._coal(thing, thing.local(corners, t)):
                    verdict.coal.add(t)
        verdict.shares[t] = inside.mean()

    def _met(self, low, high, below, above):
        """Triangles of the skin, of vertices with boxes (V, 3), whose boxes meet a box."""
        if not np.isfinite(below).all():
            return np.arange(len(self.skin.faces))
        sides = [high[:, k] >= below[k] for k in range(3)]
        sides += [low[:, k] <= above[k] for k in range(3)]
        # One vertex at least is not beyond a side, for each of them.
        out = np.ones(len(self.skin.faces), dtype=bool)
        a, b, c = self.skin.faces.T
        for side in sides:
            if not side.all():
                out &= side[a] | side[b] | side[c]
        return np.flatnonzero(out)

    def _gap(self, thing, skin, near, t, verdict, most):
        if not len(skin):
            return
        d, i = thing.piece.smallest(skin, min(most, NEAR, verdict.gaps[t]))
        if i < 0:
            return
        if d < verdict.gap:
            verdict.nearest = (thing.name, JOINT_NAMES[self.skin.part[near[i]]], t)
        verdict.gaps[t] = min(verdict.gaps[t], d)
        if t == 0:
            verdict.start = min(verdict.start, d)

    def _depth(self, thing, points, near, t, verdict):
        depth = thing.piece.depths(points)
        i = int(depth.argmax())
        if depth[i] > verdict.depth:
            verdict.deepest = (thing.name, JOINT_NAMES[self.skin.points_part[near[i]]], t)
        verdict.depths[t] = max(verdict.depths[t], depth[i])
        if t == 0 and depth[i] > 0.0:
            verdict.start = min(verdict.start, -float(depth[i]))
        return depth

    def _swallowed(self, thing, skin, verdict):
        """Small items may start within the body without touching its skin."""
        if thing.piece.plane:
            return
        at = thing.world(thing.piece.middle, 0)
        at = at[_in_box(at, skin.min(axis=0), skin.max(axis=0))]
        if len(at) and (Soup(skin[self.skin.faces]).winding(at) > 0.5).any():
            verdict.swallowed.append(thing.name)

    # -- triangles -------------------------------------------------------------------------

    def _triangles(self, thing, which, corners, before, t, verdict):
        """Notes which triangles (k, 3, 3) meet the item at this pose or on the way to it."""
        piece, ends = thing.piece, thing.local(corners, t)
        if before is None:
            if len(piece.met_by(ends)):
                verdict.cut.add(t)
            return
        starts = thing.local(before, t - 1)
        met = piece.met_by(np.concatenate([starts, ends], axis=1))
        if not len(met):
            return
        cut = piece.met_by(ends[met])
        if len(cut):
            verdict.cut.add(t)
        # Triangles that are cut at an end give no further evidence.
        met = np.delete(met, np.union1d(cut, piece.met_by(starts[met])).astype(int))
        # After one crossing the others get fewer attempts.
        few = met[:: max(1, len(met) // PATIENCE)]
        if not verdict.crossed and not len(self._blocked(piece, starts[few], ends[few], HALVES)):
            met = met[self._blocked(piece, starts[met], ends[met], HALVES)]
        for part in self.skin.part[self.skin.faces[which[met], 0]]:
            verdict.crossed.append((thing.name, JOINT_NAMES[part], t))

    def _blocked(self, piece, a, b, halves):
        """Which straight ways of triangles from a to b (k, 3, 3) meet the item."""
        met = piece.met_by(np.concatenate([a, b], axis=1))
        if halves == 0 or not len(met):
            return met
        middle = 0.5 * (a[met] + b[met])
        first = self._blocked(piece, a[met], middle, halves - 1)
        second = self._blocked(piece, middle, b[met], halves - 1)
        return met[np.union1d(first, second).astype(int)]

    def _coal(self, thing, corners):
        """Whether triangles (k, 3, 3) of the skin meet the item, by coal."""
        piece = thing.piece
        if piece.plane:
            return bool((corners @ np.asarray(piece.shape.normal) < piece.shape.offset).any())
        tree = _tree(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))
        here = coal.Transform3s()
        asked, found = coal.CollisionRequest(), coal.CollisionResult()
        return coal.collide(tree, here, piece.coal, here, asked, found) > 0


def _ends(skin, before):
    """Boxes (V, 3) around vertices and their previous positions."""
    return np.minimum(skin, before), np.maximum(skin, before)


def _tree(vertices, faces):
    tree = coal.BVHModelOBBRSS()
    tree.beginModel(len(faces), len(vertices))
    tree.addVertices(vertices)
    tree.addTriangles(np.asarray(faces, dtype=np.int64))
    tree.endModel()
    return tree


def _in_box(points, low, high):
    """Which of the points (n, 3) are in a box."""
    return np.flatnonzero(_meets(points, points, low, high))


def _meets(low, high, below, above):
    """Which of the boxes (n, 3) meet one: column by column, numpy is slow along short rows."""
    out = np.ones(len(low), dtype=bool)
    for k in range(3):
        out &= (low[:, k] <= above[k]) & (high[:, k] >= below[k])
    return out


@dataclass
class _Path:
    """The inputs of `judge_motion`, with other steps than a motion's."""

    translation: np.ndarray
    rotations: np.ndarray
    axes: np.ndarray

    def __len__(self):
        return len(self.translation)
