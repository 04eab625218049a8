"""Judges two people of a run independently: do they stay apart, and how near are they?

For every pose three questions; the core supplies only coordinates:

- the convex pieces of both (`person_hulls`), those of one against those of the other, by `coal`;
- the skins themselves, triangles against triangles, by `coal`;
- a vertex of one inside the other's skin, by winding number.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import coal
import numpy as np

from halfphysics.simulation.simulator import Simulator
from support.judges.person_hulls import pieces_of
from support.judges.posed_skin import Skinner
from support.judges.triangle_soup import RAY, Soup

#: Distances up to this are measured [m]; larger ones are inf.
NEAR = 0.004
#: Poses processed together: bounds the memory.
CHUNK = 64


@dataclass
class PairVerdict:
    """Results of a comparison.

    Attributes:
        gaps: Smallest distance of the pieces at every pose (T,) [m], negative by depth, inf
            beyond `NEAR`.
        where: The pieces of the smallest gap, and its pose.
        cut: Poses at which triangles of the two skins meet.
        inside: Poses at which a vertex of one is inside the other's skin.
        near: Poses at which triangles and vertices could meet: the others are apart by boxes.
    """

    gaps: np.ndarray
    where: tuple[str, str, int] = ("", "", -1)
    cut: list[int] = field(default_factory=list)
    inside: list[int] = field(default_factory=list)
    near: int = 0

    @property
    def gap(self):
        """Smallest distance of all poses [m]."""
        return float(self.gaps.min())

    @property
    def clear(self):
        """No pose has an overlap."""
        return self.gap > 0.0 and not self.cut and not self.inside

    def __str__(self):
        return (
            f"gap {1e3 * self.gap:.4f} mm {' '.join(map(str, self.where))}, cut at {self.cut[:5]}, "
            f"inside at {self.inside[:5]}, near at {self.near} of {len(self.gaps)}"
        )


class PairJudge:
    """Judges the first two of these people.

    Args:
        bodies: All people's bodies.
        contact: Pieces: hulls of the "skin", the rigid "parts" or "both".
    """

    def __init__(self, bodies, contact="skin"):
        simulator = Simulator(body=list(bodies))
        self._coordinates = simulator.world.motion_coordinates
        self._people = simulator.world.people[:2]
        pieces = pieces_of(simulator, contact)
        self._pieces = [[p for p in pieces if p.name == who.name] for who in self._people]
        self._skinners = [Skinner(who.body, samples=0) for who in self._people]

    def judge(self, motions, *, skin_every=1):
        """Motions of one length, one per person; the skins at every `skin_every`-th pose."""
        poses = self._coordinates(motions)
        verdict = PairVerdict(np.full(len(poses), np.inf))
        for first in range(0, len(poses), CHUNK):
            for a, b in zip(*self._pieces, strict=True):
                rows = poses[first : first + CHUNK]
                self._gaps(a.at(rows), b.at(rows), first, verdict)
        for t in range(0, len(poses), skin_every):
            self._skins(poses[t : t + 1], t, verdict)
        return verdict

    def _gaps(self, a, b, first, verdict):
        for t in range(len(a.low)):
            low, high = a.low[t, :, None] - NEAR, a.high[t, :, None] + NEAR
            meet = ((low <= b.high[t]) & (high >= b.low[t])).all(axis=2)
            meeting = np.argwhere(meet)
            one, other = meeting.T
            between = np.maximum(b.low[t, other] - a.high[t, one], a.low[t, one] - b.high[t, other])
            boxes = np.linalg.norm(np.maximum(between, 0.0), axis=1)
            solids = {}
            for k in np.argsort(boxes, kind="stable").tolist():
                if boxes[k] > max(verdict.gaps[first + t], 0.0):
                    break  # pairs are no nearer to each other than their boxes
                i, j = meeting[k].tolist()
                for key, mine in (((0, i), a), ((1, j), b)):
                    if key not in solids:
                        solids[key] = mine.solid(key[1], t)
                asked, found = coal.DistanceRequest(), coal.DistanceResult()
                gap = coal.distance(*solids[0, i], *solids[1, j], asked, found)
                if gap < verdict.gap:
                    verdict.where = (a.pieces.names[i], b.pieces.names[j], first + t)
                if gap < min(NEAR, verdict.gaps[first + t]):
                    verdict.gaps[first + t] = gap

    def _skins(self, pose, t, verdict):
        skins = [
            skinner.vertices(*who.pose(pose, np.eye(3)), np.eye(3))[0]
            for who, skinner in zip(self._people, self._skinners, strict=True)
        ]
        low = np.maximum(*(s.min(axis=0) for s in skins))
        high = np.minimum(*(s.max(axis=0) for s in skins))
        if (low > high).any():
            return
        corners = [s[k.faces] for s, k in zip(skins, self._skinners, strict=True)]
        # Only the intersection of both boxes can contain contacts.
        shared = [
            c[((c.min(axis=1) <= high) & (c.max(axis=1) >= low)).all(axis=1)] for c in corners
        ]
        verdict.near += 1
        if all(map(len, shared)) and _meet(*shared):
            verdict.cut.append(t)
        for mine, other in ((0, 1), (1, 0)):
            points = skins[mine]
            points = points[((points >= low) & (points <= high)).all(axis=1)]
            if len(points) and _any_inside(points, corners[other]):
                verdict.inside.append(t)
                break


def _any_inside(points, corners):
    """Whether the closed surface of triangles (n, 3, 3) winds around one of the points (k, 3)."""
    across = np.linalg.svd(RAY[None])[2][1:].T  # two directions normal to the rays
    low, high = (points @ across).min(axis=0), (points @ across).max(axis=0)
    seen = corners @ across
    # Only these triangles can meet rays from the points.
    met = ((seen.min(axis=1) <= high) & (seen.max(axis=1) >= low)).all(axis=1)
    return met.any() and (Soup(corners[met]).winding(points) > 0.5).any()


def _meet(a, b):
    """Whether triangles (n, 3, 3) meet triangles (m, 3, 3)."""
    here = coal.Transform3s()
    asked, found = coal.CollisionRequest(), coal.CollisionResult()
    return coal.collide(_tree(a), here, _tree(b), here, asked, found) > 0


def _tree(corners):
    tree = coal.BVHModelOBBRSS()
    tree.beginModel(len(corners), 3 * len(corners))
    tree.addVertices(corners.reshape(-1, 3))
    tree.addTriangles(np.arange(3 * len(corners)).reshape(-1, 3))
    tree.endModel()
    return tree
