"""Scenes of things on soft layers, through the public API, and the poses of all substeps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.geometry.shapes import Plane
from halfphysics.scene.scene import Scene
from halfphysics.settings import Settings
from halfphysics.simulation.simulator import Simulator

#: On its side: the axis of a cylinder or capsule along y.
LYING = rot.exp([np.pi / 2, 0.0, 0.0])


def soft(stiffness, damping=0.0, thickness=0.1, **more):
    """A layer with a linear law [Pa/m], [Pa s/m], [m]."""
    return hp.Soft(
        thickness=thickness,
        stiffness=stiffness,
        damping=damping,
        **{"law": "linear", **more},
    )


def on_floor(layer, shape, height, mass=10.0, friction=1.0, **more):
    """One "thing" over a floor whose unloaded surface is z = 0, its frame's origin at a height."""
    scene = Scene()
    scene.add_static("floor", Plane(), soft=layer, friction=friction)
    more = {"position": (0.0, 0.0, height), **more}
    scene.add_object("thing", shape, mass=mass, friction=friction, **more)
    return scene


@dataclass
class Run:
    """A simulation of objects.

    Attributes:
        simulator: At the end.
        times, poses: Of the start and all substeps (n,) [s], (n, nq).
        velocities: Of the start and all frames (T, nv).
        frames: The frames.
    """

    simulator: Simulator
    times: np.ndarray
    poses: np.ndarray
    velocities: np.ndarray
    frames: list

    @property
    def positions(self):
        """Positions (n, objects, 3) [m]."""
        return self.poses.reshape(len(self.poses), -1, 7)[:, :, :3]

    @property
    def quaternions(self):
        """Quaternions (n, objects, 4)."""
        return self.poses.reshape(len(self.poses), -1, 7)[:, :, 3:]

    @property
    def height(self):
        """Heights (n,) of the first object [m]."""
        return self.poses[:, 2]


def run(scene, seconds, fps=30.0, substeps=8):
    """Objects alone for so long."""
    settings = Settings(substeps=substeps, record="substeps")
    simulator = Simulator(scene, body=[], settings=settings, fps=fps)
    simulator.reset([])
    poses, velocities = [simulator.world.stepper.qpos()[None]], [simulator.world.stepper.qvel()]
    frames = []
    for _ in range(round(seconds * fps)):
        frames.append(simulator.step([]))
        poses.append(frames[-1].substeps)
        velocities.append(simulator.world.stepper.qvel())
    poses = np.concatenate(poses)
    times = np.arange(len(poses)) / (fps * substeps)
    return Run(simulator, times, poses, np.array(velocities), frames)


def load(frames, dt):
    """Force (3,) [N] on the objects of the frames' contacts, mean over these frames."""
    total = np.zeros(3)
    for frame in frames:
        total += frame.contacts.impulse.sum(axis=0)
    return total / (len(frames) * dt)


def energies(result, scene):
    """Kinetic energy and energy of height (T,) [J] of all objects at the frames."""
    objects = list(scene.objects.values())
    every = (len(result.poses) - 1) // (len(result.velocities) - 1)
    poses = result.poses[::every].reshape(len(result.velocities), -1, 7)
    rates = result.velocities.reshape(len(result.velocities), -1, 6)
    total = np.zeros(len(rates))
    for i, thing in enumerate(objects):
        velocity, spin = rates[:, i, :3], rates[:, i, 3:]  # of the centre of mass; in the body
        total += 0.5 * thing.mass * (velocity**2).sum(axis=1)
        total += 0.5 * np.einsum("ti,ij,tj->t", spin, thing.inertia, spin)
        total -= thing.mass * poses[:, i, :3] @ scene.gravity
    return total


@dataclass(frozen=True)
class Pressed:
    """Samples under pressure at the end of a frame: depth (n,) [m], pressure [Pa], projected area
    [m^2], position (n, 3) [m], normal out of the layer (n, 3)."""

    depth: np.ndarray
    pressure: np.ndarray
    area: np.ndarray
    position: np.ndarray
    normal: np.ndarray

    @property
    def force(self):
        """Sum of the pressures (3,) [N]."""
        return (self.pressure * self.area) @ self.normal


def pressures(result):
    """What is pressed in the last frame of a run."""
    rows = result.frames[-1].soft_contacts
    return Pressed(**{name: np.array(getattr(rows, name)) for name in Pressed.__dataclass_fields__})
