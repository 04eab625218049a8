"""Limited strength in plain numpy, beside the drive of `reference.py`; see docs/physics.md.

Limits come three dofs at a time: the force on the root's position, then the torque on its rotation
and on every joint. All are impulses of a substep here [N s, N m s].
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from halfphysics._native import tuning

Array = NDArray[np.float64]

#: Smaller changes of velocity [m/s, rad/s] and impulses [N s, N m s] are rounding.
REST = tuning.velocity_rounding
#: Share of what it can that a drive pulls with by itself: the rest is for what holds the body.
PULL = tuning.pull_share
#: Joints that give in are to exert this share of what they can; after so many rounds they do not
#: resist at all.
AIM, ROUNDS = tuning.resist_share, tuning.resist_rounds
#: What gives way exerts its limit to this share, turns no faster [rad/s], and is solved for in so
#: many rounds, over-relaxed; what does not, creeps [rad/s], and what has no limit resists like so
#: much inertia [kg m^2].
SHARE, FASTEST, WAYS = tuning.yield_tolerance, tuning.fastest_yield, tuning.yield_rounds
STRIDE, CREEP = tuning.yield_over_relaxation, tuning.least_yield_rate
HOLD = tuning.rigid_resistance


def sizes(x: Array) -> Array:
    """Norms (n,) of the limits' three entries of `x` (3n,)."""
    return np.asarray(np.linalg.norm(x.reshape(-1, 3), axis=1))


def capped(x: Array, most: Array) -> Array:
    """Three entries of `x` (3n,) at a time, scaled to at most the norms `most` (n,)."""
    size = sizes(x)
    share = np.where(size > most, most / np.maximum(size, 1e-300), 1.0)
    result: Array = x * np.repeat(share, 3)
    return result


def pull_within(
    pull: Array, most: Array, M: Array, M_hat: Array, now: Array, asked: Array
) -> Array:
    """What a drive with limits `most` does of D = `pull`, which it wants to take off `now`.

    1. No joint's own share of what M^ D asks for against what holds it may be more than 97 %,
    2. nor what the joints' coupling makes of it.
    3. Nor, where nothing holds the body, may M D be more: joints give way.

    `now`: the velocity that it would leave alone; `asked`: the motion's. All (3n,) but `most` (n,).
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
    v = now - D + give_way(-M @ D, may, M)
    fastest = np.maximum(FASTEST, sizes(asked))
    fastest[0] = np.inf
    return now - capped(v, fastest)


def give_way(need: Array, may: Array, M: Array) -> Array:
    """y of M y = u - need with |u_j| <= may_j, equal to that and against y_j where y_j is not zero.

    Dry friction, solved as a row of linear problems with resistances may_j / |y_j|.
    """
    rate = np.full_like(may, CREEP)
    for _ in range(WAYS):
        resistance = np.minimum(HOLD, may / rate)
        y = np.asarray(np.linalg.solve(M + np.diag(np.repeat(resistance, 3)), -need))
        share = sizes(y) / rate
        settled = (may == 0.0) | (may / rate >= HOLD) | ((rate == CREEP) & (share <= 1.0))
        if (settled | (np.abs(share - 1.0) <= SHARE)).all():
            return y
        rate = np.where(settled, rate, np.maximum(CREEP, rate * share**STRIDE))
    return y


@dataclass
class Yielding:
    """How far joints that something overcomes give in within a substep, from round to round.

    M^ = M + X is heavier than the body, and what hits it is met with X (v* - v) besides the drive's
    pull. Of that is left theta X theta, with a share theta for every joint. (The core's step that
    cannot be made whole goes to theta = 0 at once.)
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
        """Shares of the next round, where `exerted` is more than the limits: then True.

        `pull` is what of it the drive does by itself.
        """
        over = sizes(exerted) > most + REST
        if self.rounds > ROUNDS or not over.any():
            return False
        room, more = np.maximum(0.0, AIM * most - sizes(pull)), sizes(exerted - pull)
        less = np.where(over & (more > room), room / np.maximum(more, 1e-300), 1.0)
        self.theta = self.theta * np.repeat(less, 3) if self.rounds < ROUNDS else 0.0 * self.theta
        self.rounds += 1
        return True
