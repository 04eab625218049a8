"""Limited strength in plain numpy, beside the drive of `reference.py`; see docs/physics.md.

Each limit bounds the norm of three dofs: the force on the root's position, then the torque on its
rotation and on every joint. All limits here are impulses of a substep [N s, N m s].
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from halfphysics._native import tuning

Array = NDArray[np.float64]

#: Smaller changes of velocity [m/s, rad/s] and impulses [N s, N m s] are rounding.
REST = tuning.velocity_rounding
#: Share of its limit that the drive uses to pull; the rest is left for resistance to contacts.
PULL = tuning.pull_share
#: Yielding joints aim at this share of their limit; after this number of rounds they do not resist
#: at all.
AIM, ROUNDS = tuning.resist_share, tuning.resist_rounds
#: A yielding joint exerts its limit to this tolerance; number of rounds of its solver, and of those
#: after them in which joints only give way more.
SHARE, WAYS, SAFE = tuning.yield_tolerance, tuning.yield_rounds, tuning.safe_yield_rounds
#: Exponent of over-relaxation; least rate of a yielding joint in it [rad/s].
STRIDE, CREEP = tuning.yield_over_relaxation, tuning.least_yield_rate
#: Largest resistance, that of a joint without a limit [kg m^2].
HOLD = tuning.rigid_resistance


def sizes(x: Array) -> Array:
    """Norms (n,) of each three entries of `x` (3n,)."""
    return np.asarray(np.linalg.norm(x.reshape(-1, 3), axis=1))


def capped(x: Array, most: Array) -> Array:
    """`x` (3n,) with each three entries scaled to at most the norms `most` (n,)."""
    size = sizes(x)
    share = np.where(size > most, most / np.maximum(size, 1e-300), 1.0)
    result: Array = x * np.repeat(share, 3)
    return result


def pull_within(pull: Array, most: Array, M: Array, M_hat: Array) -> Array:
    """The part of D = `pull`, the change of velocity that the drive wants, within limits `most`.

    1. diag(M^) D of each joint is at most 97 % of its limit (body held still by contacts).
    2. So is M^ D, which includes the coupling of the joints.
    3. In a free body M D is at most the limit: weak joints yield.

    `pull` (3n,), `most` (n,).
    """
    if np.abs(pull).max() < REST:
        return pull
    D = capped(pull, PULL * most / np.diag(M_hat).reshape(-1, 3).mean(axis=1))
    wanted = M_hat @ D
    held = capped(wanted, PULL * most)
    if (held != wanted).any():
        D = np.asarray(np.linalg.solve(M_hat, held), dtype=np.float64)
    may = most / (1.0 + SHARE)
    if (sizes(M @ D) <= may + REST**2).all():
        return D
    return D - give_way(-M @ D, may, M)


def give_way(need: Array, may: Array, M: Array) -> Array:
    """y of M y = u - need with |u_j| <= may_j, and u_j = -may_j y_j/|y_j| where y_j is not zero.

    This is dry friction, solved as a series of linear problems with resistances may_j / |y_j|.
    """
    rate = np.full_like(may, CREEP)
    for way in range(WAYS + SAFE):
        resistance = np.minimum(HOLD, may / rate)
        y = np.asarray(np.linalg.solve(M + np.diag(np.repeat(resistance, 3)), -need))
        share = sizes(y) / rate
        settled = (may == 0.0) | (may / rate >= HOLD) | ((rate == CREEP) & (share <= 1.0))
        if way >= WAYS:
            settled |= share - 1.0 <= SHARE
        if (settled | (np.abs(share - 1.0) <= SHARE)).all():
            return y
        rate = np.where(settled, rate, np.maximum(CREEP, rate * share**STRIDE))
    return y


@dataclass
class Yielding:
    """Reduced resistance of joints over their limit within a substep, from round to round.

    M^ = M + X is heavier than the body, so a contact meets X (v* - v) besides the drive's pull. X
    is reduced to theta X theta, with a factor theta <= 1 for every joint. (In a step that cannot be
    completed the core sets theta = 0 at once.)
    """

    dofs: int
    theta: Array = field(init=False)
    rounds: int = 0

    def __post_init__(self) -> None:
        self.theta = np.ones(self.dofs)

    def heavier(self, M: Array, M_hat: Array) -> Array:
        """M + theta X theta (n, n)."""
        return np.asarray(M + np.outer(self.theta, self.theta) * (M_hat - M))

    def next(self, exerted: Array, pull: Array, most: Array) -> bool:
        """Reduce theta if `exerted` is over the limits; True: another round is needed.

        `pull`: the part of `exerted` that is independent of contacts.
        """
        over = sizes(exerted) > most + REST
        if self.rounds > ROUNDS or not over.any():
            return False
        room, more = np.maximum(0.0, AIM * most - sizes(pull)), sizes(exerted - pull)
        less = np.where(over & (more > room), room / np.maximum(more, 1e-300), 1.0)
        self.theta = self.theta * np.repeat(less, 3) if self.rounds < ROUNDS else 0.0 * self.theta
        self.rounds += 1
        return True
