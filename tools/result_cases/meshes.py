"""Mesh files as what stands, as what can be pushed, and as what moves along a trajectory."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

import halfphysics as hp
from result_cases.case import Case
from result_cases.digests import frames_values, result_values
from result_cases.scenes import SCALE, body, clip, floor, meshes

#: Meshes that `--quick` takes.
QUICK = ("couch", "chair_A", "bowl", "Barrel_A", "Door_A")
_MESH = {"scale": SCALE, "up": "y"}


def stands(name: str, contact: str) -> dict[str, Any]:
    """A clip beside and through a mesh that stands, and a ball that falls onto it."""
    scene = floor()
    scene.add_static("thing", meshes()[name], position=(0.35, 0.0, 0.0), **_MESH)
    scene.add_object("ball", hp.Sphere(0.1), mass=0.5, position=(0.4, 0.05, 2.0))
    settings = hp.Settings(contact=contact)
    motion = clip("asap_walk1", seconds=1.0, first=0.2)
    return result_values(hp.simulate(motion, scene, body=body(), settings=settings))


def falls(name: str, pieces: str) -> dict[str, Any]:
    """A mesh that is thrown onto a floor and against a post; there is no person."""
    scene = floor()
    scene.add_static("post", hp.Cylinder(0.1, 2.0), position=(0.9, 0.0, 1.0))
    thrown = {"velocity": (2.0, 0.3, 0.0), "angular_velocity": (1.0, 3.0, -2.0)}
    turn = (0.9, 0.3, -0.1, 0.2)
    thing = scene.add_object(
        "thing", meshes()[name], mass=3.0, pieces=pieces, position=(0.0, 0.0, 1.3),
        quaternion=turn / np.linalg.norm(turn), **thrown, **_MESH,
    )  # fmt: skip
    simulator = hp.Simulator(scene, body=[], fps=60.0)
    frames = [simulator.reset([]), *(simulator.step([]) for _ in range(60))]
    return {"inertia": (thing.mass, thing.com, thing.inertia), **frames_values(frames)}


def swept(name: str) -> dict[str, Any]:
    """A person who stands in the way of a mesh on a trajectory."""
    scene = floor()
    path = np.linspace([-1.2, 0.05, 0.05], [0.3, 0.0, 0.05], 25)
    scene.add_moving("thing", meshes()[name], path, fps=30.0, **_MESH)
    motion = clip("asap_squat3", seconds=1.0, first=0.0)
    return result_values(hp.simulate(motion, scene, body=body()))


def cut() -> dict[str, Any]:
    """A corner of two boards, which is cut into convex pieces, on its way to the floor."""
    outline = np.array([(0.0, 0.0), (0.4, 0.0), (0.4, 0.1), (0.1, 0.1), (0.1, 0.3), (0.0, 0.3)])
    vertices = np.concatenate([np.insert(outline, 1, y, axis=1) for y in (0.0, 0.2)])
    ends = np.array([(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)])
    i, j = np.arange(6), (np.arange(6) + 1) % 6
    sides = np.concatenate([np.stack([j, i, i + 6], 1), np.stack([j, i + 6, j + 6], 1)])
    faces = np.concatenate([ends, ends[:, ::-1] + 6, sides]).astype(np.int32)
    scene = floor()
    turned = {"position": (0.0, 0.0, 0.6), "angular_velocity": (1.0, 2.0, 0.5)}
    thing = scene.add_object("corner", hp.Mesh(vertices, faces), density=300.0, **turned)
    simulator = hp.Simulator(scene, body=[], fps=60.0)
    frames = [simulator.reset([]), *(simulator.step([]) for _ in range(40))]
    return {"inertia": (thing.mass, thing.com, thing.inertia), **frames_values(frames)}


def cases() -> Iterator[Case]:
    """Every mesh; one is cut into convex pieces, which takes long."""
    for name in meshes():
        yield Case(f"mesh/{name}/stands_skin", partial(stands, name, "skin"), name in QUICK[1:])
        yield Case(f"mesh/{name}/stands_parts", partial(stands, name, "parts"))
        yield Case(f"mesh/{name}/falls", partial(falls, name, "hull"), name in QUICK)
    yield Case("mesh/corner/cut", cut)
    yield Case("mesh/Primitive_Cube/swept", partial(swept, "Primitive_Cube"))
