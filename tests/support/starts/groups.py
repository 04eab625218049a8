"""Overlapping hulls at the start: connected groups of hulls, and their shortest exits."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations, pairwise

import numpy as np

from halfphysics.motion.skeleton import N_JOINTS, PARENTS
from support.starts.solids import EXACT, Solid, bounds

#: Solids that a group passes on its way are left one after the other, at most this many times.
PASSES = 30


def path(joint):
    """Joints from the root to `joint`, both counted."""
    out = [int(joint)]
    while PARENTS[out[-1]] >= 0:
        out.append(int(PARENTS[out[-1]]))
    return out[::-1]


def paths_of(joints):
    """Which joints (55,) are on the path from the root to one of these."""
    out = np.zeros(N_JOINTS, dtype=bool)
    for j in joints:
        out[path(j)] = True
    return out


@dataclass(frozen=True, eq=False)
class Group:
    """Hulls next to each other in the skeleton that one static holds.

    Attributes:
        solids: The pieces of the static.
        inside: Hulls that meet one of them.
        beyond: Hulls that meet none, but whose bones from the root go through these solids.
        way: Unit vector (3,) of the smallest shift that frees all of them, on the root's side.
        depth: That shift [m].
        ways: All tested directions that lead back to the root's side.
    """

    solids: tuple[Solid, ...]
    inside: tuple[int, ...]
    beyond: tuple[tuple[int, Solid], ...]
    way: np.ndarray
    depth: float
    ways: tuple[np.ndarray, ...] = ()

    @property
    def hulls(self):
        return tuple(dict.fromkeys((*self.inside, *(h for h, _ in self.beyond))))

    def depth_at(self, posed, k, way=None, most=np.inf):
        """Smallest shift along the way that frees all hulls at pose k [m]; inf from `most` on."""
        n = self.way if way is None else way
        r = max((posed.way_out(h, k, s, n) for h, s in self.beyond), default=0.0)
        for _ in range(PASSES):
            before = r
            for s in self.solids:
                for h in self.hulls:
                    if posed.meets(h, k, s, r * n):
                        r = max(r, posed.way_out(h, k, s, n))
                        if r >= most:
                            return np.inf
            if r == before:
                return r
        return r

    def through(self, posed, k):
        """Do the bones of the hulls beyond still go through?"""
        joints = posed.joints[k]
        for h, s in self.beyond:
            bones = path(posed.hulls.joint[h])
            if s.crossed(joints[bones[:-1]], joints[bones[1:]]).any():
                return True
        return False


def groups_at(posed, k, solids):
    """The groups of one pose, none if it is clear."""
    out = []
    statics = {}
    for s in solids:
        statics.setdefault(s.static or s.name, []).append(s)
    for pieces in statics.values():
        others = [s for s in solids if s not in pieces]
        held, touched = {}, {}
        for s in pieces:
            inside = _inside(posed, k, s)
            for h in inside:
                touched.setdefault(h, []).append(s)
            if inside and s.near is None:
                for h, before in _beyond(posed, k, s).items():
                    held.setdefault(h, []).append((s, before))
        if not touched:
            continue
        for hulls in _connected(posed, {*touched, *held}):
            inside = tuple(h for h in hulls if h in touched)
            if inside:
                beyond = [(h, s, x) for h in hulls for s, x in held.get(h, ())]
                met = list(dict.fromkeys(s for h in inside for s in touched[h]))
                out.append(_shortest(posed, k, tuple(pieces), inside, beyond, met, others))
    return out


def _inside(posed, k, solid):
    low, high = bounds(solid)
    near = ((posed.low[k] < high) & (posed.high[k] > low)).all(axis=1)
    if solid.near is not None:
        n, o = solid.normals[solid.near], solid.offsets[solid.near]
        return [h for h, p in enumerate(posed.points) if (p[k] @ n).min() < o - EXACT]
    return [int(h) for h in np.flatnonzero(near) if posed.depth(int(h), k, solid) > EXACT]


def _beyond(posed, k, solid):
    """Hulls whose bones from the root go through the solid: h -> last joint before it (3,)."""
    joints = posed.joints[k]
    if solid.separation(joints[:1]) <= 0.0:
        return {}
    cut = solid.crossed(joints[np.maximum(PARENTS, 0)], joints)
    out = {}
    for h, j in enumerate(posed.hulls.joint):
        met = [a for a, b in pairwise(path(j)) if cut[b]]
        if met:
            out[h] = joints[met[0]]
    return out


def _connected(posed, hulls):
    """Connected sets of hulls in the skeleton, each sorted."""
    of_joint = {}
    for h in sorted(hulls):
        of_joint.setdefault(int(posed.hulls.joint[h]), []).append(h)
    top = {}
    for j in sorted(of_joint):  # parents before children
        parent = int(PARENTS[j])
        top[j] = top.get(parent, j)
    sets = {}
    for j, hs in of_joint.items():
        sets.setdefault(top[j], []).extend(hs)
    return [sorted(hs) for hs in sets.values()]


def _shortest(posed, k, pieces, inside, beyond, met, others):
    faces = [
        n
        for s in {id(s): s for s in (*met, *(s for _, s, _ in beyond))}.values()
        for n in (s.normals if s.near is None else s.normals[s.near : s.near + 1])
    ]
    ways = _different(faces)
    if len(met) > 1:
        ways += _different([a + b for a, b in combinations(ways, 2) if a @ b > -0.5])
    back = [n for n in ways if all(_returns(n, s, x) for _, s, x in beyond)] or ways
    trial = Group(pieces, inside, tuple((h, s) for h, s, _ in beyond), ways[0], 0.0)
    # The hulls between the group and the root move with it: not from one static into another,
    # nor, where it can be avoided, from in front of an edge to under it.
    between = _between(posed, trial.hulls)
    best = {True: (np.inf, back[0]), False: (np.inf, back[0])}
    for n in back:
        r = trial.depth_at(posed, k, n, most=best[True][0])
        if np.isfinite(r):
            shift = (r + EXACT) * n
            good = all(
                posed.depth(h, k, s, shift) <= posed.depth(h, k, s) + EXACT
                for s in others for h in inside
            ) and not any(
                posed.meets(h, k, s, shift) and not posed.meets(h, k, s, 0.0 * n)
                for s in (*pieces, *others) for h in between
            )  # fmt: skip
            best[good] = min(best[good], (r, n), key=lambda x: x[0])
    depth, way = best[bool(np.isfinite(best[True][0]))]
    return Group(pieces, inside, trial.beyond, way, float(depth), tuple(back))


def _between(posed, hulls):
    """Hulls on the path from the root to these, without them."""
    joints = posed.hulls.joint
    on_path = paths_of({int(joints[h]) for h in hulls})
    return [h for h in range(len(joints)) if on_path[joints[h]] and h not in hulls]


def _different(vectors):
    out = []
    for v in vectors:
        v = v / np.linalg.norm(v)
        if not any(np.allclose(v, w, atol=1e-9) for w in out):
            out.append(v)
    return out


def _returns(n, solid, before):
    """Does a way along n lead back to the bones' side?"""
    outer = solid.normals @ before > solid.offsets - EXACT
    return bool((solid.normals[outer] @ n > 0.1).any())
