"""Things that spin on floors, and the closed forms by which they stop."""

from __future__ import annotations

import numpy as np
import trimesh

from halfphysics.base import rotations as rot
from halfphysics.geometry.shapes import Box, Cylinder, Plane
from halfphysics.scene.scene import Scene
from halfphysics.settings import Settings
from halfphysics.simulation.simulator import Simulator

G, FRICTION = 9.81, 0.3
#: Clearance, in which what was set down rests [m].
GAP = 1e-3
SIDES = 48


def mean_distance(inside, half=(1.0, 1.0), n=1000):
    """Mean distance from the centre of the points (x, y) of a rectangle that are inside."""
    x, y = (
        ((2 * np.arange(n) + 1.0) / n - 1) * half[0],
        ((2 * np.arange(n) + 1.0) / n - 1) * half[1],
    )
    x, y = np.meshgrid(x, y)
    return np.hypot(x, y)[inside(x, y)].mean()


def ring(outer, inner, height):
    """A ring about the origin, of convex solids that meet."""
    pieces = []
    for k in range(SIDES):
        at = 2 * np.pi * np.array([k, k + 1]) / SIDES
        flat = [(r * np.cos(a), r * np.sin(a)) for r in (inner, outer) for a in at]
        corners = [(*xy, z) for xy in flat for z in (-0.5 * height, 0.5 * height)]
        pieces.append(trimesh.PointCloud(corners).convex_hull)
    return trimesh.util.concatenate(pieces)


#: Name -> shape of size s, mean distance/s, square of the radius of inertia/s^2; each s/5 high.
SHAPES = {
    "disc": (lambda s: Cylinder(0.5 * s, 0.2 * s), 1.0 / 3.0, 1.0 / 8.0),
    "square": (
        lambda s: Box((s, s, 0.2 * s)),
        (np.sqrt(2.0) + np.log(1.0 + np.sqrt(2.0))) / 6.0,
        1.0 / 6.0,
    ),
    "2:1": (
        lambda s: Box((s, 0.5 * s, 0.2 * s)),
        mean_distance(lambda x, y: np.abs(x) < 1.0, (0.5, 0.25)),
        1.25 / 12.0,
    ),
    "mesh of a disc": (
        lambda s: trimesh.creation.cylinder(0.5 * s, 0.2 * s, sections=32),
        1.0 / 3.0,
        1.0 / 8.0,
    ),
}


def floor(scene, kind, size, turn):
    """Adds a level or turned floor; the height of its top [m]."""
    common = {"quaternion": turn, "friction": FRICTION}
    if kind == "plane":
        scene.add_static("floor", Plane(), **common)
    elif kind == "box":
        down = rot.rotate(turn, [0.0, 0.0, -0.5 * size])
        scene.add_static("floor", Box((6 * size, 6 * size, size)), position=down, **common)
    elif kind == "mesh":
        mesh = trimesh.creation.box((6 * size, 6 * size, size)).subdivide_to_size(0.7 * size)
        down = rot.rotate(turn, [0.0, 0.0, -0.5 * size])
        scene.add_static("floor", mesh, position=down, **common)
    else:
        scene.add_static("floor", Plane())
        slab = Box((4 * size, 4 * size, 0.3 * size))
        at = (0, 0, 0.15 * size + GAP)
        scene.add_object("slab", slab, mass=1000.0, friction=FRICTION, position=at)
        return 0.3 * size + GAP
    return 0.0


def spin_of(name, *, on="plane", size=0.2, fps=60, substeps=None, turn=(1.0, 0, 0, 0), yaw=0.4):
    """The deceleration of a spin, over that of the closed form, from a fit over most of it."""
    make, mean, square = SHAPES[name]
    scene, turn = Scene(), np.asarray(turn, dtype=np.float64)
    top = floor(scene, on, size, turn)
    up = rot.rotate(turn, [0.0, 0.0, 1.0])
    expected = FRICTION * G * mean / (square * size)
    start = min(0.25 * expected, 40.0)  # rad/s; at most a sixth of a turn in a substep
    scene.add_object(
        "thing",
        make(size),
        mass=1.3,
        friction=FRICTION,
        position=(top + 0.1 * size + GAP) * up,
        quaternion=rot.multiply(turn, rot.exp([0.0, 0.0, yaw])),
        angular_velocity=start * up,
    )
    # On a slope gravity is turned with it: the same problem, elsewhere.
    if not np.allclose(turn, [1.0, 0, 0, 0]):
        scene = turned_gravity(scene, -G * up)
    settings = Settings(substeps=substeps)
    simulator = Simulator(scene, body=[], settings=settings, fps=fps)
    simulator.reset([])
    spins = [start]
    while spins[-1] > 0.3 * start and len(spins) < 2.0 * fps * start / expected + 5:
        simulator.step([])
        spins.append(simulator.world.stepper.qvel()[-1])
    return -np.polyfit(np.arange(len(spins)) / fps, spins, 1)[0] / expected


def turned_gravity(scene, gravity):
    """The scene with another gravity."""
    out = Scene(gravity=list(gravity))
    for name, item in scene.statics.items():
        out.add_static(
            name, item.shape, position=item.position, quaternion=item.quaternion, friction=FRICTION
        )
    thing = scene.objects["thing"]
    out.add_object(
        "thing",
        thing.shape,
        mass=1.3,
        friction=FRICTION,
        position=thing.position,
        quaternion=thing.quaternion,
        angular_velocity=thing.angular_velocity,
    )
    return out


def ring_spin(outer, inner, height=0.02):
    """The deceleration of the spin of a ring of convex pieces, over that of the closed form."""
    scene = Scene()
    scene.add_static("floor", Plane(), friction=FRICTION)
    scene.add_object(
        "ring",
        ring(outer, inner, height),
        mass=1.0,
        friction=FRICTION,
        position=(0, 0, 0.5 * height + GAP),
        angular_velocity=(0, 0, 6.0),
    )
    simulator = Simulator(scene, body=[], settings=Settings(), fps=60)
    simulator.reset([])
    spins = []
    for _ in range(10):
        simulator.step([])
        spins.append(simulator.world.stepper.qvel()[5])
    mean = 2.0 / 3.0 * (outer**3 - inner**3) / (outer**2 - inner**2)
    expected = FRICTION * G * mean / (0.5 * (outer**2 + inner**2))
    return -np.polyfit(np.arange(10) / 60.0, spins, 1)[0] / expected
