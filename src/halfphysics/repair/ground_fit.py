"""The ground under a clip: its height, a drift of it, and its tilt, from the soles that rest.

Heights g of resting soles over the surface below are fitted, by robust least squares, with

    g = a + b (x - x0) + c (y - y0) + d (t - t0) + e [toe] + f [left]

a is how far the clip floats, (b, c) its tilt, d its drift. e and f take up what shoes and the
person's own soles differ by from those of the body: standing still, a foot that is pitched is no
tilt. A term is kept if it explains more than chance does: of all combinations of tilt and drift the
one with the least Bayesian information criterion (Schwarz 1978) is taken, where every rest of a
foot, and every second of it, is one observation: neighbouring frames say the same again.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halfphysics.repair.soles import Soles

Array = NDArray[np.float64]

#: Heights farther than this from the fit are no ground [m] (Tukey's biweight): toes that tip, a
#: foot on a step. The bound falls from the first to the last over the rounds: tails are all on one
#: side, above, and must not lift the fit.
_FIRST, _LAST = 0.06, 0.008
_ROUNDS = 24
#: The core lets soles stand this high over a surface [m].
STANDS = 0.003
#: Of the patches that rest in a frame those count that are within this of the lowest [m].
_BESIDE = 0.01
#: Less than this is measurement, not damage: height [m], tilt [rad], drift [m/s].
LEAST_HEIGHT, LEAST_TILT, LEAST_DRIFT = 0.004, np.deg2rad(0.4), 0.004
#: More than this is no damage of a clip but another ground: a ramp, a lift [rad], [m/s].
MOST_TILT, MOST_DRIFT = np.deg2rad(15.0), 0.3
#: Fewer observations than this say nothing of tilt or drift.
_OBSERVATIONS = 4
#: A term must lower the criterion by this: strong evidence (Kass and Raftery 1995).
_STRONG = 6.0


@dataclass(frozen=True)
class Ground:
    """What a clip's ground is, against the surface that it should stand on.

    Attributes:
        height: How far soles at `centre` float [m] at `time`; negative: sunk.
        slope: Rise of the clip's ground along x and y [1].
        drift: How fast it rises [m/s].
        centre: Where `height` is (3,) [m].
        time: When [s].
        spread: How far resting soles are off the fit, median [m].
    """

    height: float
    slope: tuple[float, float]
    drift: float
    centre: Array
    time: float
    spread: float

    @property
    def tilt(self) -> float:
        """Its tilt [rad]."""
        return float(np.arctan(np.hypot(*self.slope)))

    @property
    def level(self) -> bool:
        """Whether there is nothing to put right."""
        return not (self.tilt or self.drift or self.height)


def fit_ground(people: Sequence[Soles]) -> Ground | None:
    """The ground of a clip from the soles of those in it; None: no sole rests anywhere.

    Tilt, drift and height are 0 where they are not told from chance, or too small to be damage.
    """
    rows = [_samples(soles) for soles in people]
    data = np.concatenate([row[0] for row in rows])
    if not len(data):
        return None
    observations = sum(row[1] for row in rows)
    centre = np.median(data[:, :3], axis=0)
    time = float(np.median(data[:, 3]))
    best, score = (False, False), np.inf
    fits = {}
    for tilts in (False, True):
        for drifts in (False, True):
            if (tilts or drifts) and observations < _OBSERVATIONS:
                continue
            fit, misfit = _robust(data, centre, time, tilts, drifts)
            if np.hypot(fit[1], fit[2]) > np.tan(MOST_TILT) or abs(fit[3]) > MOST_DRIFT:
                continue
            fits[tilts, drifts] = fit
            terms = 2 * tilts + drifts
            its = observations * np.log(misfit) + terms * (np.log(observations) + _STRONG)
            if its < score:
                best, score = (tilts, drifts), its
    fit = fits[best]
    if np.arctan(np.hypot(fit[1], fit[2])) < LEAST_TILT:
        fit[1:3] = 0.0
    if abs(fit[3]) < LEAST_DRIFT:
        fit[3] = 0.0
    left = data[:, 5] - _design(data, centre, time) @ fit
    height = float(fit[0]) - STANDS
    if abs(height) < LEAST_HEIGHT and not fit[1:4].any():
        height = 0.0
    return Ground(
        height=height,
        slope=(float(fit[1]), float(fit[2])),
        drift=float(fit[3]),
        centre=centre,
        time=time,
        spread=float(np.median(np.abs(left))),
    )


def _samples(soles: Soles) -> tuple[Array, float]:
    """Of every frame in which a patch rests: x, y, z, t, patch, gap; and how many observations
    these frames are."""
    known = soles.rests & np.isfinite(soles.gap)
    # Of a foot that rolls off, the heel is in the air while it is still slow.
    lowest = np.where(known, soles.gap, np.inf).min(axis=1, keepdims=True)
    known &= soles.gap < lowest + _BESIDE
    t, patch = np.nonzero(known)
    data = np.column_stack([soles.centre[t, patch], t / soles.fps, patch, soles.gap[t, patch]])
    count = sum(max(1.0, (end - first) / soles.fps) for _, first, end in soles.phases())
    return data, 0.5 * count  # heel and toe of a foot say the same


def _design(data: Array, centre: Array, time: float) -> Array:
    patch = data[:, 4].astype(int)
    return np.column_stack(
        [
            np.ones(len(data)),
            data[:, 0] - centre[0],
            data[:, 1] - centre[1],
            data[:, 3] - time,
            patch % 2 - 0.5,
            patch // 2 - 0.5,
        ]
    )


def _robust(
    data: Array, centre: Array, time: float, tilts: bool, drifts: bool
) -> tuple[Array, float]:
    """Coefficients (6,), 0 where not fitted, and the mean square of what is left (capped)."""
    design, values = _design(data, centre, time), data[:, 5]
    used = np.array([True, tilts, tilts, drifts, True, True])
    # Differences between feet and between heel and toe are small: of a foot that never rests, or
    # of one that always does, they are not known at all.
    prior = np.diag([0.0, 0.0, 0.0, 0.0, 1.0, 1.0])[np.ix_(used, used)] * 0.05 * len(data)
    fit = np.zeros(6)
    fit[0] = np.median(values)
    weight = _weights(values - fit[0], _FIRST)
    for bound in np.geomspace(_FIRST, _LAST, _ROUNDS):
        its = design[:, used]
        square = its.T @ (weight[:, None] * its) + prior + 1e-9 * len(data) * np.eye(used.sum())
        fit = np.zeros(6)
        fit[used] = np.linalg.solve(square, its.T @ (weight * values))
        weight = _weights(values - design @ fit, bound)
    left = np.minimum(np.abs(values - design @ fit), 0.5 * _FIRST)
    return fit, float((left**2).mean()) + 1e-8


def _weights(left: Array, bound: float) -> Array:
    """Tukey's biweight, over the larger of the bound and three times the median."""
    bound = max(bound, 3.0 * float(np.median(np.abs(left))))
    result: Array = np.clip(1.0 - (left / bound) ** 2, 0.0, None) ** 2
    return result
