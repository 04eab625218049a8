"""The visible gap: the distance of a pole or an edge that touches the hulls from the skin.

A pole (a cylinder of 2 cm radius) and a 90 degree edge, both endless, approach a posed body from
outside until they touch the union of its convex hulls. The gap is their remaining distance from
the skin. Both problems are flat: everything is projected along the pole.

As a script, the whole table::

    PYTHONPATH=tests python -m support.judges.hull_gap --motions FOLDER [--cut skin|joints|parts]
                                                       [--frames 12] [--trials 40]
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from halfphysics.body.body import Body
from halfphysics.body.skin_hulls import SkinHulls
from halfphysics.motion.motion import Motion
from halfphysics.motion.pose import Pose
from halfphysics.motion.skeleton import JOINT_INDEX

RADIUS = 0.02
#: Range [m] of the search for skin around the contact point: larger gaps count as this.
NEAR = 0.2


class Gaps(NamedTuple):
    """Arrays over n first contacts: pole or edge, gap [m], nearest skin vertex."""

    pole: np.ndarray  # (n,) bool
    gap: np.ndarray  # (n,)
    vertex: np.ndarray  # (n,)


def convex(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Corner indices and edges (m, 2) of the hull of points; of flat sets every pair is an edge."""
    try:
        hull = ConvexHull(points)
    except (QhullError, ValueError):
        a, b = np.triu_indices(len(points))
        return np.arange(len(points)), np.stack([a, b], axis=1)
    s = hull.simplices
    edges = np.unique(np.sort(np.concatenate([s[:, :2], s[:, 1:], s[:, ::2]]), axis=1), axis=0)
    return hull.vertices, edges


def union_edges(hulls: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Ends (m, 3) and (m, 3) of all edges of all hulls of the point sets `hulls`.

    The outline of a convex solid, seen from anywhere, is made of some of its edges.
    """
    starts, ends = [], []
    for points in hulls:
        edges = convex(points)[1]
        starts.append(points[edges[:, 0]])
        ends.append(points[edges[:, 1]])
    return np.concatenate(starts), np.concatenate(ends)


def _to_segments(c: np.ndarray, p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Distance of the point c (2,) to segments p (m, 2) to q (m, 2)."""
    d = q - p
    along = np.einsum("mi,mi->m", c - p, d) / np.maximum(np.einsum("mi,mi->m", d, d), 1e-30)
    return np.linalg.norm(p + np.clip(along, 0.0, 1.0)[:, None] * d - c, axis=1)


def pole_contact(p: np.ndarray, q: np.ndarray, y: float, r: float = RADIUS) -> float:
    """First x of a disc at height y that comes along +x onto segments (m, 2); inf if it misses."""
    first = np.inf
    close = (np.minimum(p[:, 1], q[:, 1]) < y + r) & (np.maximum(p[:, 1], q[:, 1]) > y - r)
    p, q = p[close], q[close]
    for end in (p, q):
        off = np.abs(end[:, 1] - y)
        hit = off <= r
        if hit.any():
            first = min(first, (end[hit, 0] - np.sqrt(r * r - off[hit] ** 2)).min())
    d = q - p
    length = np.linalg.norm(d, axis=1)
    long = length > 1e-9
    p, d, length = p[long], d[long], length[long, None]
    normal = np.stack([-d[:, 1], d[:, 0]], axis=1) / length
    normal *= np.where(normal[:, :1] > 0.0, -1.0, 1.0)  # the side that faces the disc
    start = p + r * normal
    with np.errstate(divide="ignore", invalid="ignore"):
        u = (y - start[:, 1]) / d[:, 1]
        x = start[:, 0] + u * d[:, 0]
    on = (u >= 0.0) & (u <= 1.0)
    return float(min(first, x[on].min())) if on.any() else float(first)


def edge_contact(p: np.ndarray, q: np.ndarray) -> float:
    """Largest s for which the quadrant {u >= s, v >= s} touches segments (m, 2)."""
    best = float(np.maximum(p.min(axis=1), q.min(axis=1)).max())
    dp, dq = p[:, 0] - p[:, 1], q[:, 0] - q[:, 1]
    across = (dp < 0.0) != (dq < 0.0)
    u = dp[across] / (dp[across] - dq[across])
    crossing = p[across, 0] + u * (q[across, 0] - p[across, 0])
    return max(best, float(crossing.max())) if across.any() else best


def first_contacts(
    skin: np.ndarray,
    faces: np.ndarray,
    edges: tuple[np.ndarray, np.ndarray],
    targets: np.ndarray,
    rng: np.random.Generator,
) -> Gaps:
    """A pole and an edge for each of the vertices `targets` (n,), from about its outside.

    Args:
        skin: Posed vertices (V, 3).
        faces: (F, 3).
        edges: Edges of the hulls, as `union_edges` gives them.
    """
    normals = vertex_normals(skin, faces)
    start, end = edges
    wires = np.unique(
        np.sort(np.concatenate([faces[:, :2], faces[:, 1:], faces[:, ::2]]), axis=1), axis=0
    )
    pole, gap, vertex = [], [], []
    for v in targets:
        a = normals[v] + 0.6 * rng.normal(size=3)  # the direction of approach
        a /= np.linalg.norm(a)
        e = np.cross(a, rng.normal(size=3))  # along the pole
        e /= np.linalg.norm(e)
        b = np.cross(e, a)
        y = b @ skin[v] + rng.uniform(-0.01, 0.01)
        # pole
        plane = np.stack([-a, b])
        x = pole_contact(start @ plane.T, end @ plane.T, y)
        if np.isfinite(x):
            flat, c = skin @ plane.T, np.array([x, y])
            distance, nearest = _nearest(flat, wires, c)
            pole.append(True)
            gap.append(distance - RADIUS)
            vertex.append(nearest)
        # edge: its two flanks at 45 degrees to the approach, its ridge through y
        plane = np.stack([a + b, a - b]) / np.sqrt(2.0)
        shift = np.array([y, -y]) / np.sqrt(2.0)
        p, q, flat = (points @ plane.T - shift for points in (start, end, skin))
        s = edge_contact(p, q)
        distance, nearest = _nearest(flat, wires, np.array([s, s]))
        to_flanks = np.linalg.norm(np.maximum(s - flat, 0.0), axis=1)
        if to_flanks.min() < distance:
            distance, nearest = to_flanks.min(), int(to_flanks.argmin())
        pole.append(False)
        gap.append(distance)
        vertex.append(nearest)
    return Gaps(np.array(pole), np.array(gap), np.array(vertex))


def _nearest(flat: np.ndarray, wires: np.ndarray, c: np.ndarray) -> tuple[float, int]:
    """Distance of c to the skin's outline, capped at about NEAR, and the nearest vertex."""
    to_vertex = np.linalg.norm(flat - c, axis=1)
    nearest = int(to_vertex.argmin())
    # A segment that comes nearer than the nearest vertex has an end within its own length of c.
    around = to_vertex < min(NEAR, to_vertex[nearest]) + 0.05
    some = wires[around[wires[:, 0]] | around[wires[:, 1]]]
    distance = to_vertex[nearest]
    if len(some):
        distance = min(distance, _to_segments(c, flat[some[:, 0]], flat[some[:, 1]]).min())
    return float(min(distance, NEAR)), nearest


def vertex_normals(skin: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Outward unit normals (V, 3), by area."""
    a, b, c = np.moveaxis(skin[faces], 1, 0)
    n = np.cross(b - a, c - a)
    total = np.stack(
        [np.bincount(faces.ravel(), np.repeat(n[:, k], 3), len(skin)) for k in range(3)], axis=1
    )
    return total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-30)


def regions(body: Body) -> dict[str, np.ndarray]:
    """Vertices (n,) of every region of a body, by name."""
    part = body.weights.argmax(axis=1)
    name = np.full(len(part), "limbs", dtype="U12")
    groups = {
        "torso": (0, 3, 6, 9),
        "head, neck": (12, 15, 22, 23, 24),
        "feet": (7, 8, 10, 11),
        "wrist": (20, 21),
        "fingers": range(25, 55),
    }
    for group, parts in groups.items():
        name[np.isin(part, list(parts))] = group

    def near(group: str, parts: tuple[int, ...], joint: str, reach: float) -> None:
        for side in ("left", "right"):
            centre = body.rest_joints[JOINT_INDEX[f"{side}_{joint}"]]
            close = np.linalg.norm(body.rest_vertices - centre, axis=1) < reach * body.stature / 1.7
            name[np.isin(part, parts) & close] = group

    near("hips", (0, 1, 2), "hip", 0.20)
    near("knees", (1, 2, 4, 5), "knee", 0.13)
    near("shoulders", (13, 14, 16, 17, 9), "shoulder", 0.14)
    near("elbows", (16, 17, 18, 19), "elbow", 0.10)
    return {str(n): np.flatnonzero(name == n) for n in np.unique(name)}


def bends() -> dict[str, np.ndarray]:
    """Poses (55, 3) in which people touch objects: hollows open and close."""

    def pose(**turns: tuple[float, float, float]) -> np.ndarray:
        rotations = np.zeros((55, 3))
        for joint, (x, y, z) in turns.items():
            if joint in JOINT_INDEX:
                rotations[JOINT_INDEX[joint]] = x, y, z
            else:  # both sides; the right one is the mirror image
                rotations[JOINT_INDEX[f"left_{joint}"]] = x, y, z
                rotations[JOINT_INDEX[f"right_{joint}"]] = x, -y, -z
        return rotations

    def fist(angle: float) -> dict[str, tuple[float, float, float]]:
        fingers = ("index", "middle", "pinky", "ring")
        return {f"{f}{k}": (0.0, 0.0, -angle) for f in fingers for k in (1, 2, 3)}

    down = {"shoulder": (0.0, 0.0, -1.2)}
    return {
        "rest": pose(),
        "standing": pose(**down, elbow=(0.0, -0.3, 0.0), **fist(0.4)),
        "sitting": pose(hip=(-1.5, 0.0, 0.1), knee=(1.5, 0.0, 0.0), **down),
        "deep squat": pose(
            hip=(-2.1, 0.3, 0.3), knee=(2.3, 0.0, 0.0), ankle=(-0.5, 0.0, 0.0),
            spine1=(0.3, 0.0, 0.0), shoulder=(0.0, -1.3, 0.0),
        ),
        "arms raised": pose(collar=(0.0, 0.0, 0.3), shoulder=(0.0, 0.0, 1.2)),
        "elbows bent": pose(shoulder=(0.0, 0.0, -0.9), elbow=(0.0, -2.2, 0.0), **fist(1.4)),
        "bowed": pose(
            spine1=(0.4, 0.0, 0.0), spine2=(0.4, 0.0, 0.0), spine3=(0.3, 0.0, 0.0),
            neck=(0.4, 0.0, 0.0), head=(0.3, 0.0, 0.0), hip=(-0.6, 0.0, 0.0), **down,
        ),
        "arched": pose(
            spine1=(-0.25, 0.0, 0.1), spine2=(-0.25, 0.0, 0.1), neck=(-0.4, 0.0, 0.0),
            head=(-0.3, 0.3, 0.0), hip=(0.3, 0.0, 0.0), ankle=(0.6, 0.0, 0.0),
            wrist=(0.0, 0.0, 1.0),
        ),
    }  # fmt: skip


def motion_poses(folder: Path, frames: int) -> Iterator[np.ndarray]:
    """Rotations (55, 3) of some frames of every clip of a folder."""
    for path in sorted(folder.glob("*.npz")):
        motion = Motion.load(path)
        yield from motion.rotations[np.linspace(0, len(motion) - 1, frames).round().astype(int)]


def posed(body: Body, rotations: np.ndarray) -> np.ndarray:
    """Skin (V, 3) of one pose."""
    return body.vertices(Pose(np.zeros(3), rotations))


def split(hulls: SkinHulls) -> list[np.ndarray]:
    """Vertex sets."""
    return np.split(hulls.vertex, hulls.first[1:-1])


def joint_sets(body: Body) -> list[np.ndarray]:
    """One set of whole faces for each joint with skin."""
    joint = body.weights[body.faces].sum(axis=1).argmax(axis=1)
    return [np.unique(body.faces[joint == k]) for k in np.unique(joint)]


def gaps(
    body: Body,
    sets: list[np.ndarray] | None,
    poses: list[np.ndarray],
    trials: int,
    seed: int = 0,
) -> Gaps:
    """First contacts of `trials` poles and edges at every pose; every region has as many.

    Args:
        sets: Vertex sets of the hulls; None: the 55 rigid parts; skin may protrude from them (their
            gaps count as zero there).
    """
    rng = np.random.default_rng(seed)
    places = list(regions(body).values())
    out = []
    for rotations in poses:
        skin = posed(body, rotations)
        if sets is None:
            positions, quaternions = body.joint_frames(Pose(np.zeros(3), rotations))
            from halfphysics.base import rotations as rot

            hulls = [
                rot.rotate(quaternions[p.index], p.vertices) + positions[p.index]
                for p in body.variant.parts
                if len(p.vertices)
            ]
        else:
            hulls = [skin[s] for s in sets]
        targets = np.array([rng.choice(places[k]) for k in rng.integers(0, len(places), trials)])
        out.append(first_contacts(skin, body.faces, union_edges(hulls), targets, rng))
    return Gaps(*(np.concatenate(column) for column in zip(*out, strict=True)))


def table(body: Body, found: Gaps) -> str:
    """Median, 95th percentile and largest gap [mm] of pole and edge, by region."""
    where = np.full(len(body.rest_vertices), "", dtype="U12")
    for name, vertices in regions(body).items():
        where[vertices] = name
    lines = [
        f"{'[mm]':12s}  {'pole: n':>8s} median    p95    max   {'edge: n':>8s} median    p95    max"
    ]
    for name in ["all", *regions(body)]:
        row = f"{name:12s}"
        for kind in (True, False):
            chosen = (found.pole == kind) & ((where[found.vertex] == name) | (name == "all"))
            g = 1e3 * found.gap[chosen]
            q = [np.median(g), np.percentile(g, 95), g.max()] if len(g) else [np.nan] * 3
            row += f"  {len(g):8d} {q[0]:6.2f} {q[1]:6.2f} {q[2]:6.1f}"
        lines.append(row)
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--motions", type=Path, help="folder of motion clips")
    parser.add_argument("--cut", choices=("skin", "joints", "parts"), default="skin")
    parser.add_argument("--frames", type=int, default=12, help="of every clip")
    parser.add_argument("--trials", type=int, default=40, help="at every pose")
    parser.add_argument("--model", type=Path, help="body model file; none: the default body")
    options = parser.parse_args()
    body = Body.default() if options.model is None else Body.load(options.model)
    poses = list(bends().values())
    if options.motions is not None:
        poses += motion_poses(options.motions, options.frames)
    begin = time.perf_counter()
    hulls = body.skin_hulls
    seconds = time.perf_counter() - begin
    sets = {"skin": split(hulls), "joints": joint_sets(body), "parts": None}[options.cut]
    if sets is not None:
        print(f"{len(sets)} hulls, {sum(map(len, sets))} vertices; cut in {seconds:.2f} s")
    print(table(body, gaps(body, sets, poses, options.trials)))


if __name__ == "__main__":
    main()
