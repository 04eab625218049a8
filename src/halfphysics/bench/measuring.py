"""What is done with a motion besides simulating it: skin and penetration."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

import numpy as np

from halfphysics import metrics
from halfphysics.bench.clips import body, story
from halfphysics.bench.record import Options, Record
from halfphysics.bench.sides import measure
from halfphysics.body import Body
from halfphysics.scene import Scene
from halfphysics.shapes import Mesh

_VERTICES, _FRAMES, _QUICK_FRAMES = 10_000, 100, 4


def penetration(options: Options) -> Iterator[Record]:
    """The walk passes through a lumpy ring of 10,000 triangles."""
    frames = _QUICK_FRAMES if options.quick else _FRAMES
    # From the middle of the walk, which is where the ring stands.
    middle = len(story().motions[0]) // 2
    motion = story().motions[0][middle - frames // 2 : middle - frames // 2 + frames]
    who = _part_of(body(), _VERTICES)
    scene = Scene()
    x, y = motion.translation[frames // 2, :2]
    scene.add_static("ring", ring(), position=(x, y, 1.0))
    done = measure(
        "metrics",
        f"{_VERTICES} vertices, {len(ring().faces)} triangles",
        frames,
        options,
        ours=lambda: metrics.penetration(motion, who, scene, threads=1),
        unit="s",
    )
    yield dataclasses.replace(
        done.record,
        checks={
            "vertices inside [%]": (done.ours.rate_percent, None),
            "deepest [mm]": (done.ours.depth_max_mm, None),
        },
    )


def skinning(options: Options) -> Iterator[Record]:
    """All vertices of the first 100 frames of the walk."""
    who = body()
    motion = story().motions[0][: _QUICK_FRAMES if options.quick else _FRAMES]
    yield measure(
        "skinning",
        f"{len(who.rest_vertices)} vertices",
        len(motion),
        options,
        ours=lambda: who.vertices(motion, threads=1),
    ).record


def ring(around: int = 100, across: int = 50) -> Mesh:
    """A closed lumpy ring about z: 2 `around` `across` triangles, 0.9 m in radius."""
    u, v = np.meshgrid(
        np.linspace(0.0, 2.0 * np.pi, around, endpoint=False),
        np.linspace(0.0, 2.0 * np.pi, across, endpoint=False),
        indexing="ij",
    )
    tube = 0.3 + 0.03 * np.sin(9.0 * u) * np.cos(5.0 * v)
    radius = 0.6 + tube * np.cos(v)
    vertices = np.stack([radius * np.cos(u), radius * np.sin(u), tube * np.sin(v)], axis=-1)
    i, j = np.meshgrid(np.arange(around), np.arange(across), indexing="ij")
    a, b = i * across + j, (i + 1) % around * across + j
    c, d = (i + 1) % around * across + (j + 1) % across, i * across + (j + 1) % across
    faces = np.concatenate([np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    return Mesh(vertices.reshape(-1, 3), faces.astype(np.int32))


def _part_of(body: Body, count: int) -> Body:
    """The body with `count` of its vertices, spread evenly over the skin, and no triangles."""
    keep = np.linspace(0, len(body.rest_vertices) - 1, count).round().astype(int)
    return dataclasses.replace(
        body,
        faces=np.zeros((0, 3), dtype=np.int32),
        weights=body.weights[keep],
        rest_vertices=body.rest_vertices[keep],
        posedirs=None if body.posedirs is None else body.posedirs[keep],
    )
