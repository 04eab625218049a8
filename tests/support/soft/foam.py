"""A flat block on foam, integrated by scipy from the equations of docs/physics.md, "Soft layers".

One degree of freedom: the depth d of the block; with x = d / t the pressure is

    p = max(0, k d (1 + D x^4) + c d' + r k (d - q)),   q' = (d - q) / tau,

and where the block is away the surface comes back by q' = -q / (tau (1 + r)).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

G = 9.81


@dataclass(frozen=True)
class Foam:
    """Stiffness k [Pa/m], damping c [Pa s/m], thickness t [m], D, r, tau [s]."""

    stiffness: float
    damping: float
    thickness: float
    densification: float
    arm: float
    relaxation: float

    def springs(self, depth):
        """Pressure without what the foam remembers [Pa]."""
        return self.stiffness * depth * (1.0 + self.densification * (depth / self.thickness) ** 4)

    def pressure(self, depth, rate, gone):
        """Pressure [Pa] at a depth [m], its rate [m/s], and what the arm's dashpot has gone [m]."""
        if depth <= 0.0:
            return 0.0
        arm = self.arm * self.stiffness * (depth - gone)
        return max(0.0, self.springs(depth) + self.damping * rate + arm)


def press(foam: Foam, mass: float, area: float, depth: float, speed: float, times: np.ndarray):
    """A block that starts at a depth [m] (negative: above the surface) going down at a speed [m/s].

    Returns:
        Depth (T,) [m], rate (T,) [m/s], dashpot's way (T,) [m], work done on the foam (T,) [J].
    """

    def rates(_, y):
        d, v, q, _ = y
        force = area * foam.pressure(d, v, q)
        loaded = force > 0.0
        back = (d - q) / foam.relaxation if loaded else -q / (foam.relaxation * (1.0 + foam.arm))
        return [v, G - force / mass, back, force * v]

    start = [depth, speed, 0.0, 0.0]
    done = solve_ivp(
        rates, (times[0], times[-1]), start, t_eval=times, max_step=1e-3, rtol=1e-7, atol=1e-10
    )
    return tuple(done.y)


def creep(foam: Foam, pressure: float, times: np.ndarray) -> np.ndarray:
    """Depth (T,) [m] under a small pressure put on at once, without inertia, damping and D.

    From p / (k (1 + r)) to p / k, with the time constant tau (1 + r).
    """
    full = pressure / foam.stiffness
    share = foam.arm / (1.0 + foam.arm)
    return full * (1.0 - share * np.exp(-times / (foam.relaxation * (1.0 + foam.arm))))
