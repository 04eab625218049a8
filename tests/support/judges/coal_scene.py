"""Independent checks of a run: distances by coal, poses of people by `person_hulls`."""

from __future__ import annotations

from dataclasses import dataclass, field

import coal
import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.geometry.shapes import Mesh, Plane
from halfphysics.scene.trajectories import KinematicObject
from support.judges.coal_shapes import coal_shape
from support.judges.person_hulls import pieces_of
from support.judges.scene_solids import fixed_links, owners, solids_of

#: Pairs beyond this distance are skipped [m].
NEAR = 0.02
HERE = coal.Transform3s()


@dataclass
class _Solid:
    """A posed solid: box [m], owner, and coal's geometry and place, made on request.

    `owner`: a static, an object, an articulated object or a person; contact does not push
    a solid without `moves`.
    """

    owner: str
    low: np.ndarray
    high: np.ndarray
    make: object
    moves: bool = True
    human: bool = False
    made: tuple = field(default=())

    def solid(self):
        if not self.made:
            self.made = self.make()
        return self.made


def _bounds(geometry, turn, position):
    """Corners of a box around coal's geometry."""
    geometry.computeLocalAABB()
    box = geometry.aabb_local
    middle, half = 0.5 * (box.max_ + box.min_), 0.5 * (box.max_ - box.min_)
    middle, half = turn @ middle + position, np.abs(turn) @ half
    return middle - half, middle + half


def _apart(a, b):
    """Distance of the boxes around two solids [m]; -inf where they meet."""
    gaps = np.maximum(np.maximum(a.low - b.high, b.low - a.high), 0.0)
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
            (t, solid, coal_shape(solid.shape, solid=True))
            for t in world.tracked
            if t.name not in standing
            for solid in solids_of(self.scene, t.name)
        ]
        for link in world.links:
            if link.name in standing:
                at = link.pose(np.zeros(world.nq))
                for solid in solids_of(self.scene, link.name):
                    shape = coal_shape(solid.shape, solid=True)
                    self.statics.append(self._placed(link.name, solid, shape, at, moves=False))
        self.request = coal.DistanceRequest()

    @staticmethod
    def _static(s):
        turn, position = rot.to_matrix(s.quaternion), np.asarray(s.position, float)
        shape, place = coal_shape(s.shape, solid=False), coal.Transform3s(turn, position)
        low, high = np.full(3, -np.inf), np.full(3, np.inf)
        if isinstance(s.shape, Mesh):
            corners = np.asarray(s.shape.vertices) @ turn.T + position
            low, high = corners.min(axis=0), corners.max(axis=0)
        elif not isinstance(s.shape, Plane):
            low, high = _bounds(shape, turn, position)
        return _Solid(s.name, low, high, lambda: (shape, place), moves=False)

    def _movers(self, qpos):
        out = []
        for pieces in self.people:
            at = pieces.at(qpos[None])
            for i in range(len(pieces.names)):
                make = lambda at=at, i=i: at.solid(i, 0)  # noqa: E731
                out.append(_Solid(pieces.name, at.low[0, i], at.high[0, i], make, human=True))
        for thing, solid, shape in self.things:
            moves = not isinstance(self.scene.objects.get(thing.name), KinematicObject)
            out.append(self._placed(thing.name, solid, shape, thing.pose(qpos), moves))
        return out

    def _placed(self, name, solid, shape, pose, moves):
        """A solid of an item whose frame is at a pose (3,), (4,)."""
        position, turn = solid.at(pose[0], rot.to_matrix(rot.normalize(pose[1])))
        place = coal.Transform3s(turn, position)
        low, high = _bounds(shape, turn, position)
        return _Solid(self.owner[name], low, high, lambda: (shape, place), moves=moves)

    def _near(self, a, b):
        """Pairs (n, 2) of solids of these lists whose boxes are within `NEAR`."""
        ends = [np.array([[s.low, s.high] for s in some]).reshape(-1, 2, 3) for some in (a, b)]
        apart = np.maximum(
            ends[0][:, None, 0] - ends[1][None, :, 1], ends[1][None, :, 0] - ends[0][:, None, 1]
        )
        return np.argwhere((apart <= NEAR).all(axis=2))

    def _ignored(self, a, b):
        if a.owner == b.owner or not (a.moves or b.moves):
            return True
        names = ["person" if s.human else s.owner for s in (a, b)]
        return self.scene.ignores(*names)

    def gap(self, qpos, against_objects=True, statics="all"):
        """Smallest distance at one pose (inf: beyond `NEAR`), and the two items.

        statics: The solids whose distance to them counts: "all", "things" (not people's) or "none".
        """
        found = self.gaps(qpos, against_objects, statics)
        d, *pair = min(found, default=(np.inf, "", ""))
        return (d, tuple(pair)) if d < NEAR else (np.inf, ("", ""))

    def gaps(self, qpos, against_objects=True, statics="all"):
        """Distances of all near pairs at a pose: (distance, one, the other)."""
        movers = self._movers(qpos)
        pairs = [(movers[i], self.statics[k]) for i, k in self._near(movers, self.statics)]
        if statics != "all":
            pairs = [(a, s) for a, s in pairs if statics == "things" and not a.human]
        if against_objects:
            pairs += [(movers[i], movers[k]) for i, k in self._near(movers, movers) if i < k]
        for a, b in pairs:
            if not self._ignored(a, b):
                d = coal.distance(*a.solid(), *b.solid(), self.request, coal.DistanceResult())
                # Flat triangles and turns by 90 degrees mislead it at times, by metres.
                yield max(d, _apart(a, b)), a.owner, b.owner

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
