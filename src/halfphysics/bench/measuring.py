"""Computations on a motion besides simulation: skinning and penetration."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

import numpy as np

from halfphysics import metrics
from halfphysics.bench.clips import body, story
from halfphysics.bench.record import Options, Record
from halfphysics.bench.room import room
from halfphysics.bench.sides import measure
from halfphysics.body.body import Body
from halfphysics.geometry.shapes import Mesh
from halfphysics.motion.motion import Motion
from halfphysics.scene.scene import Scene

_VERTICES, _FRAMES, _QUICK_FRAMES = 10_000, 100, 4
#: For the rows with 100,000 triangles: frames, threads, and the largest number of timed runs.
_LONG, _THREADS, _REPEATS = 1000, 2, 2


def penetration(options: Options) -> Iterator[Record]:
    """Penetration of a walk past and through meshes of 10,000 and 100,000 triangles.

    The meshes: a closed lumpy ring; a furnished room; a lumpy ball around the person, closed and
    with a hole at its top. Depths inside the ball are the hardest to compute.
    """
    walk = story().motions[0]
    frames = _QUICK_FRAMES if options.quick else _FRAMES
    long = _QUICK_FRAMES if options.quick else _LONG
    # Frames around the middle of the walk, where the ring stands.
    middle = len(walk) // 2
    part = walk[middle - frames // 2 : middle - frames // 2 + frames]
    x, y = part.translation[frames // 2, :2]
    yield _penetration("walking through a ring", part, ring(), (x, y, 1.0), 1, options)
    large = 10_000 if options.quick else 100_000
    whole, steps = _to_and_fro(walk, long), _to_and_fro(walk[middle - 15 : middle + 15], long)
    # One pass is long enough for a timed run.
    once = dataclasses.replace(options, quick=True, repeats=min(options.repeats, _REPEATS))
    for name, motion, mesh, height in (
        ("walking about a room", whole, room(large).mesh, 0.0),
        ("deep inside a ball", steps, ball(large), 1.0),
        ("deep inside an open ball", steps, ball(large, opened=True), 1.0),
    ):
        yield _penetration(name, motion, mesh, (0.0, 0.0, height), _THREADS, once)


def _penetration(
    name: str,
    motion: Motion,
    mesh: Mesh,
    position: tuple[float, float, float],
    threads: int,
    options: Options,
) -> Record:
    """One row: 10,000 vertices of the skin against a mesh."""
    person = _part_of(body(), _VERTICES)
    scene = Scene()
    scene.add_static("mesh", mesh, position=position)
    mesh.query  # noqa: B018  built once for a mesh, outside the clock
    done = measure(
        "metrics",
        f"{name}: {_VERTICES} vertices, {len(mesh.faces)} triangles, {threads} thread"
        + ("s" if threads > 1 else ""),
        len(motion),
        options,
        ours=lambda: metrics.penetration(motion, person, scene, threads=threads),
        unit="s",
    )
    return dataclasses.replace(
        done.record,
        checks={
            "vertices inside [%]": (done.ours.rate_percent, None),
            "deepest [mm]": (done.ours.depth_max_mm, None),
        },
    )


def _to_and_fro(walk: Motion, frames: int) -> Motion:
    """The walk forwards and backwards about the origin for `frames` frames."""
    last = len(walk) - 1
    there = np.abs(np.arange(frames) % (2 * last) - last)
    path = walk.translation[there]
    path = path - [*walk.translation[:, :2].mean(axis=0), 0.0]
    return walk.with_frames(path, walk.rotations[there])


def skinning(options: Options) -> Iterator[Record]:
    """Skinning of all vertices for the first 100 frames of the walk."""
    person = body()
    motion = story().motions[0][: _QUICK_FRAMES if options.quick else _FRAMES]
    yield measure(
        "skinning",
        f"{len(person.rest_vertices)} vertices",
        len(motion),
        options,
        ours=lambda: person.vertices(motion, threads=1),
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


def ball(triangles: int, *, opened: bool = False) -> Mesh:
    """A lumpy ball of radius 1.6 m with about `triangles` triangles; `opened` removes its top."""
    rings = round(np.sqrt(triangles / 4))
    around = 2 * rings
    u = np.linspace(0.0, 2.0 * np.pi, around, endpoint=False)
    v = np.linspace(-0.5 * np.pi, 0.5 * np.pi, rings + 2)[1:-1]
    u, v = np.meshgrid(u, v)
    radius = 1.6 * (1.0 + 0.05 * np.sin(7.0 * u) * np.cos(5.0 * v))
    across = np.cos(v)
    points = np.stack([across * np.cos(u), across * np.sin(u), np.sin(v)], axis=-1)
    points = (radius[..., None] * points).reshape(-1, 3)
    corner = np.arange(len(points)).reshape(rings, around)
    after = np.roll(corner, -1, axis=1)
    a, b, c, d = corner[:-1], after[:-1], after[1:], corner[1:]
    south, north = np.full(around, len(points)), np.full(around, len(points) + 1)
    faces = [np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))]
    faces += [np.stack([south, after[0], corner[0]], axis=-1)]
    faces += [np.stack([north, corner[-1], after[-1]], axis=-1)]
    points = np.concatenate([points, [[0.0, 0.0, -1.6], [0.0, 0.0, 1.6]]])
    every = np.concatenate(faces)
    if opened:
        every = every[points[every][..., 2].mean(axis=1) < 1.2]
    return Mesh(points, every.astype(np.int32))


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
