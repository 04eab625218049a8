"""Openings, poles and slots: what parts of a body get into and hold on to."""

from __future__ import annotations

import numpy as np
import trimesh

from halfphysics.geometry.shapes import Box, Cylinder
from halfphysics.scene.scene import Scene
from support.attacks import meshes
from support.attacks.registry import family
from support.attacks.stage import MARGIN, Attack, body, person, placed

SIDEWAYS = (0.0, 1.0, 0.0)


def _hand(rng, speed=1.0, seconds=0.8):
    """Goes sideways, the left hand first; and the tip of that hand."""
    motion = person(rng, SIDEWAYS, speed, seconds)
    skin = body().vertices(motion, frames=[0])[0]
    return motion, skin[skin[:, 1].argmax()]


def _one(motion, shape, **settings):
    scene = Scene()
    scene.add_static("it", shape)
    return Attack([motion], scene, settings)


@family
def ring_net(rng):
    """A net of rings, thousands of triangles, that the person runs into."""
    rings = []
    for y in np.arange(-0.9, 0.95, 0.09):
        for z in np.arange(0.1, 1.8, 0.09):
            ring = trimesh.creation.torus(0.045, 0.004, major_sections=12, minor_sections=5)
            turn = trimesh.transformations.rotation_matrix(np.pi / 2, [0, 1, 0])
            rings.append(ring.apply_transform(turn).apply_translation([MARGIN + 0.01, y, z]))
    return _one(person(rng, speed=2.0, seconds=0.7, flail=0.3), meshes.joined(rings))


@family
def fine_tube(rng):
    """A finely cut tube that hand and arm go into, not quite along its axis."""
    motion, tip = _hand(rng)
    tube = meshes.tube(rng.uniform(0.06, 0.09), 0.5, 120, 120)
    tube.apply_translation(np.add(tip, (rng.uniform(-0.02, 0.02), 0.25 + MARGIN, 0.0)))
    return _one(motion, tube)


@family
def ring(rng):
    """A ring little wider than the hand."""
    motion, tip = _hand(rng, 1.5)
    hoop = trimesh.creation.torus(rng.uniform(0.05, 0.08), 0.005)
    hoop.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [1, 0, 0]))
    return _one(
        motion, hoop.apply_translation(np.add(tip, (0.0, MARGIN, rng.uniform(-0.02, 0.02))))
    )


@family
def cup(rng):
    """A cup whose bottom the hand reaches."""
    motion, tip = _hand(rng, 1.5)
    side = meshes.tube(0.07, 0.12, 60, 20)
    inner = meshes.tube(0.067, 0.12, 60, 20)
    k = np.arange(60)
    last = 20 * 60
    bottom = meshes.mesh(
        np.vstack([side.vertices, [[0.0, 0.06, 0.0]]]),
        np.stack([last + k, last + (k + 1) % 60, np.full(60, len(side.vertices))], axis=1),
    )
    whole = meshes.joined([side, inner, bottom])
    whole.apply_translation(np.add(tip, (0.0, 0.06 + MARGIN, 0.0)))
    return _one(motion, whole)


@family
def slot(rng):
    """A slot narrower than the hand, between two plates."""
    motion, tip = _hand(rng, rng.uniform(0.5, 3.0))
    gap = rng.uniform(0.008, 0.03)
    scene = Scene()
    for side, sign in (("above", 1), ("below", -1)):
        at = np.add(tip, (0.0, 0.3 + MARGIN, sign * (0.25 + 0.5 * gap)))
        scene.add_static(side, Box((1.0, 0.6, 0.5)), position=at)
    return Attack([motion], scene)


@family
def wedge(rng):
    """Two fine walls that narrow to an edge, the trunk between them."""
    motion = person(rng, speed=1.0, seconds=1.2, lower=1.3)
    sides = []
    for sign in (1, -1):
        sides.append(
            meshes.grid(
                lambda a, b: np.zeros((len(a), 3)), 60, 60, (MARGIN, sign * 0.6, 0.0),
                (1.0, -sign * 0.6, 0.0), (0.0, 0.0, 2.0),
            )
        )  # fmt: skip
    return _one(motion, meshes.joined(sides))


@family
def thin_poles(rng):
    """Poles a millimetre thick, everywhere in the way."""
    scene = Scene()
    for k in range(40):
        at = (MARGIN + rng.uniform(0, 0.5), rng.uniform(-0.8, 0.8), 1.0)
        scene.add_static(f"pole{k}", Cylinder(0.0005, 4.0), position=at)
    return Attack([person(rng, speed=rng.uniform(1, 6), seconds=0.7, flail=0.3)], scene)


@family
def cage(rng):
    """Bars before, above and beside, and the person thrashes between them."""
    scene, motion = Scene(), person(rng, speed=0.5, seconds=1.0, flail=0.8)
    skin = np.concatenate(body().vertices(motion, frames=[0]))
    low, high = skin.min(axis=0) - MARGIN, skin.max(axis=0) + MARGIN
    for k, y in enumerate(np.linspace(low[1], high[1], 20)):
        for side, x in (("front", high[0]), ("back", low[0])):
            scene.add_static(f"{side}{k}", Cylinder(0.008, 3.0), position=(x, y, 1.0))
    return Attack([motion], scene)


@family
def hoops(rng):
    """Rings of triangles around both arms, already on them, while the arms thrash."""
    motion = person(rng, speed=0.3, seconds=0.8, flail=0.0)
    swing = person(rng, speed=0.3, seconds=0.8, flail=0.5).rotations
    ramp = np.minimum(np.arange(len(motion)) / 5.0, 1.0)[:, None, None]
    rotations = motion.rotations + ramp * (swing - motion.rotations)
    motion = placed(motion.with_frames(motion.translation, rotations))
    joints = body().joints(motion)[0]
    rings = []
    for side, sign in ((18, 1), (19, -1)):
        for along in np.arange(0.02, 0.2, 0.03):
            hoop = trimesh.creation.torus(0.09, 0.004, major_sections=24, minor_sections=6)
            hoop.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [1, 0, 0]))
            rings.append(hoop.apply_translation(joints[side] + (0.0, sign * along, 0.0)))
    return _one(motion, meshes.joined(rings))
