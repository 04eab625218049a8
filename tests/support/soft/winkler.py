"""A rigid body on a flat elastic foundation, integrated in plain numpy and scipy.

A reference for the core's soft layers that shares no code with it: own quadrature of the surface,
own equations of motion, an adaptive integrator of high order. The layer fills z < 0. A point of
the surface at depth d = -z, with outward normal n and area a, is pressed up with

    a max(0, -n_z) max(0, k d + c d'),   d > 0,

and rubs with Coulomb friction, which below `SLOW` grows in proportion to the speed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

#: Speed at which friction has grown to 70 % [m/s].
SLOW = 1e-3


@dataclass(frozen=True)
class Surface:
    """Points (n, 3) [m], outward normals (n, 3) and areas (n,) [m^2] in the frame of the mass."""

    points: np.ndarray
    normals: np.ndarray
    areas: np.ndarray


@dataclass(frozen=True)
class Body:
    """Mass [kg], principal moments of inertia (3,) [kg m^2], surface."""

    mass: float
    inertia: np.ndarray
    surface: Surface


@dataclass(frozen=True)
class Layer:
    """Stiffness [Pa/m], damping [Pa s/m], coefficient of friction, gravity (3,) [m/s^2]."""

    stiffness: float
    damping: float = 0.0
    friction: float = 0.0
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81)


@dataclass(frozen=True)
class State:
    """Centre of mass (3,) [m], quaternion wxyz (4,), velocity (3,) [m/s] and spin (3,) [rad/s], in
    the world."""

    position: np.ndarray
    quaternion: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray


def box(mass: float, size: tuple[float, float, float], across: int = 24) -> Body:
    """A solid box whose edges have `across` points each."""
    size = np.asarray(size, float)
    steps = (np.arange(across) + 0.5) / across - 0.5
    points, normals, areas = [], [], []
    for axis in range(3):
        one, two = (axis + 1) % 3, (axis + 2) % 3
        u, v = (g.ravel() for g in np.meshgrid(steps * size[one], steps * size[two]))
        for side in (-1.0, 1.0):
            face, out = np.zeros((len(u), 3)), np.zeros((len(u), 3))
            face[:, one], face[:, two], face[:, axis] = u, v, side * 0.5 * size[axis]
            out[:, axis] = side
            points.append(face)
            normals.append(out)
            areas.append(np.full(len(u), size[one] * size[two] / across**2))
    square = size**2
    inertia = mass / 12.0 * (square.sum() - square)
    return Body(mass, inertia, Surface(*map(np.concatenate, (points, normals, areas))))


def ball(mass: float, radius: float, bands: int = 60) -> Body:
    """A solid ball, its surface in rings of equal height, and so of equal area."""
    height = (np.arange(bands) + 0.5) / bands * 2.0 - 1.0
    around = 2 * bands
    angle = 2.0 * np.pi * (np.arange(around) + 0.5) / around
    z, phi = (g.ravel() for g in np.meshgrid(height, angle, indexing="ij"))
    ring = np.sqrt(1.0 - z**2)
    out = np.stack([ring * np.cos(phi), ring * np.sin(phi), z], axis=1)
    areas = np.full(len(out), 4.0 * np.pi * radius**2 / len(out))
    return Body(mass, np.full(3, 0.4 * mass * radius**2), Surface(radius * out, out, areas))


def cylinder(mass: float, radius: float, length: float, around: int = 360) -> Body:
    """A solid cylinder along z."""
    along = max(8, round(0.25 * around * length / (2.0 * np.pi * radius)))
    angle = 2.0 * np.pi * (np.arange(around) + 0.5) / around
    z, phi = (
        g.ravel()
        for g in np.meshgrid(
            ((np.arange(along) + 0.5) / along - 0.5) * length, angle, indexing="ij"
        )
    )
    out = np.stack([np.cos(phi), np.sin(phi), np.zeros_like(phi)], axis=1)
    side = radius * out + np.stack([0.0 * z, 0.0 * z, z], axis=1)
    points, normals = [side], [out]
    areas = [np.full(len(side), 2.0 * np.pi * radius * length / len(side))]
    rings = max(8, around // 8)
    r, phi = (
        g.ravel()
        for g in np.meshgrid((np.arange(rings) + 0.5) / rings * radius, angle, indexing="ij")
    )
    for end in (-1.0, 1.0):
        points.append(np.stack([r * np.cos(phi), r * np.sin(phi), 0.0 * r + end * 0.5 * length], 1))
        normals.append(np.tile([0.0, 0.0, end], (len(r), 1)))
        areas.append(r * (radius / rings) * (2.0 * np.pi / around))
    thick = mass * (3.0 * radius**2 + length**2) / 12.0
    inertia = np.array([thick, thick, 0.5 * mass * radius**2])
    return Body(mass, inertia, Surface(*map(np.concatenate, (points, normals, areas))))


def matrix(quaternion: np.ndarray) -> np.ndarray:
    """Rotation matrix (3, 3) of a quaternion wxyz of any length."""
    w, x, y, z = quaternion / np.linalg.norm(quaternion)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def pressed(body: Body, layer: Layer, state: State) -> tuple[np.ndarray, np.ndarray, float]:
    """Force (3,) [N], moment (3,) about the centre of mass [N m], energy in the layer [J]."""
    turn = matrix(state.quaternion)
    facing = -(body.surface.normals @ turn[2])
    depth = -(body.surface.points @ turn[2] + state.position[2])
    under = np.flatnonzero((depth > 0.0) & (facing > 0.0))
    depth = depth[under]
    areas = body.surface.areas[under] * facing[under]
    arms = body.surface.points[under] @ turn.T
    speed = state.velocity + np.cross(state.spin, arms)
    size = areas * np.maximum(0.0, layer.stiffness * depth - layer.damping * speed[:, 2])
    force = np.zeros_like(arms)
    force[:, 2] = size
    slip = np.sqrt((speed[:, :2] ** 2).sum(axis=1) + SLOW**2)
    force[:, :2] = -(layer.friction * size / slip)[:, None] * speed[:, :2]
    stored = 0.5 * layer.stiffness * float((areas * depth**2).sum())
    return force.sum(axis=0), np.cross(arms, force).sum(axis=0), stored


def energy(body: Body, layer: Layer, state: State) -> float:
    """Kinetic energy, energy of height, and that stored in the layer [J]."""
    spin = matrix(state.quaternion).T @ state.spin
    moving = 0.5 * body.mass * state.velocity @ state.velocity + 0.5 * spin @ (body.inertia * spin)
    height = -body.mass * np.asarray(layer.gravity) @ state.position
    return float(moving + height + pressed(body, layer, state)[2])


def _packed(state: State) -> np.ndarray:
    parts = (state.position, state.quaternion, state.velocity, state.spin)
    return np.concatenate([np.asarray(part, float) for part in parts])


def _state(y: np.ndarray) -> State:
    return State(y[:3], y[3:7], y[7:10], y[10:13])


def _rates(body: Body, layer: Layer, y: np.ndarray) -> np.ndarray:
    state = _state(y)
    turn = matrix(state.quaternion)
    force, moment, _ = pressed(body, layer, state)
    spin, moment = turn.T @ state.spin, turn.T @ moment
    turned = (moment - np.cross(spin, body.inertia * spin)) / body.inertia
    w, v = state.quaternion[0], state.quaternion[1:]
    rate = 0.5 * np.concatenate([[-state.spin @ v], w * state.spin + np.cross(state.spin, v)])
    fall = np.asarray(layer.gravity) + force / body.mass
    # The spin is kept in the world, where its rate is the same as in the body.
    return np.concatenate([state.velocity, rate, fall, turn @ turned])


def follow(
    body: Body, layer: Layer, start: State, times: np.ndarray, *, accuracy: float = 1e-7
) -> list[State]:
    """The states at `times` (T,) [s], the first of them that of the start.

    Without friction by Runge-Kutta of order 8; with it, which is stiff, by LSODA.
    """
    done = solve_ivp(
        lambda _, y: _rates(body, layer, y),
        (times[0], times[-1]),
        _packed(start),
        method="LSODA" if layer.friction else "DOP853",
        t_eval=times,
        rtol=accuracy,
        atol=accuracy,
        max_step=0.01,
    )
    assert done.success, done.message
    return [_state(y) for y in done.y.T]
