"""Closed forms of a body on a flat elastic foundation (Winkler): pressure k d at depth d.

Under a flat layer the force is k times the volume of the body below the layer's surface, whatever
the shape; the formulas of textbooks (pi k R d^2, 4/3 k L sqrt(2 R) d^1.5) are its limits at
small depth. Metres, kilograms, seconds; k in Pa/m, c in Pa s/m.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

G = 9.81


def ball_force(k: float, radius: float, depth: float) -> float:
    """Force on a ball [N]: k times a cap of a sphere; pi k R d^2 where d is small."""
    return np.pi * k * depth**2 * (radius - depth / 3.0)


def cylinder_force(k: float, radius: float, length: float, depth: float) -> float:
    """Force on a lying cylinder [N]: k times a segment; 4/3 k L sqrt(2 R) d^1.5 at small d."""
    segment = radius**2 * np.arccos(1.0 - depth / radius)
    segment -= (radius - depth) * np.sqrt(2.0 * radius * depth - depth**2)
    return k * length * segment


def box_force(k: float, area: float, depth: float) -> float:
    """Force on a flat face [N]."""
    return k * area * depth


def sink(force_of, weight: float, most: float) -> float:
    """Depth [m], up to `most`, at which force_of(depth) carries a weight [N]."""
    return float(brentq(lambda depth: force_of(depth) - weight, 0.0, most, xtol=1e-12))


def tilt(moment: float, k: float, long: float, wide: float) -> float:
    """Small angle [rad] of a flat face, `long` across the axis, under a moment [N m]."""
    return moment / (k * long**3 * wide / 12.0)


def frequency(k: float, area: float, mass: float) -> float:
    """Angular frequency of a flat face without damping [rad/s]."""
    return float(np.sqrt(k * area / mass))


def damping_ratio(k: float, c: float, area: float, mass: float) -> float:
    """Share of critical damping of a flat face."""
    return c * area / (2.0 * np.sqrt(k * area * mass))


def settling(k: float, c: float, area: float, mass: float, t: np.ndarray) -> np.ndarray:
    """Depth (T,) [m] of a flat face that is let go at rest on the unloaded surface."""
    omega, zeta = frequency(k, area, mass), damping_ratio(k, c, area, mass)
    turned = omega * np.sqrt(1.0 - zeta**2)
    swing = np.cos(turned * t) + zeta / np.sqrt(1.0 - zeta**2) * np.sin(turned * t)
    return mass * G / (k * area) * (1.0 - np.exp(-zeta * omega * t) * swing)


def contact_time(k: float, area: float, mass: float, speed: float) -> float:
    """How long a flat face that lands at a speed [m/s] stays on a layer without damping [s]."""
    omega = frequency(k, area, mass)
    return float(2.0 * (np.pi - np.arctan2(speed * omega, G)) / omega)


def deepest(k: float, area: float, mass: float, speed: float) -> float:
    """How deep it gets [m]."""
    still = mass * G / (k * area)
    return float(still + np.hypot(still, speed / frequency(k, area, mass)))


def peaks(t: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Times and values of the maxima of a sampled curve, by a parabola through three samples."""
    at = np.flatnonzero((x[1:-1] > x[:-2]) & (x[1:-1] >= x[2:])) + 1
    before, here, after = x[at - 1], x[at], x[at + 1]
    bent = before - 2.0 * here + after
    shift = 0.5 * (before - after) / bent
    step = t[1] - t[0]
    return t[at] + shift * step, here - 0.25 * (before - after) * shift
