"""Coulomb contacts in plain numpy: slow and obvious; the tests hold it equal to the native solver.

Every contact has three rows (n, t, s). With velocity w = A p + b and impulse p:
0 <= p_n, w_n >= 0, p_n w_n = 0, |p_t| <= mu p_n, and p_t = -mu p_n w_t/|w_t| in a sliding contact.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def coulomb_answers(A: Array, r: Array, mu: float) -> list[Array]:
    """All solutions p (3,) of one contact with w = r + A p; smallest p_n first.

    `A` (3, 3) is symmetric and positive definite, so at least one solution exists.
    """
    answers = _at_rest(A, r, mu)
    slips = [p for p in _sliding(A, r, mu) if p[0] > 0.0]
    # At the edge of sticking, rounding decides the direction of slip.
    rounding = 1e-13 * np.diag(A).max() * float(np.linalg.norm(r)) / A[0, 0]
    along = [float(p[1:] @ (r + A @ p)[1:]) for p in slips]
    answers += [p for p, e in zip(slips, along, strict=True) if e <= rounding * p[0]]
    if not answers:
        answers = [slips[int(np.argmin(along))]]
    return sorted(answers, key=lambda p: float(p[0]))


def _at_rest(A: Array, r: Array, mu: float) -> list[Array]:
    """The separating solution (p = 0) and the sticking one, if they are valid."""
    leaves = [np.zeros(3)] if r[0] >= 0.0 else []
    stick = np.asarray(-np.linalg.solve(A, r), dtype=np.float64)
    sticks = stick[0] >= 0.0 and np.hypot(stick[1], stick[2]) <= mu * stick[0]
    return [*leaves, stick] if sticks else leaves


def _sliding(A: Array, r: Array, mu: float) -> list[Array]:
    """p = p_n (1, mu d) with w_n = 0 and w_t parallel to d, for every such direction d (2,).

    p_n = -r_n / N with N = A_nn + mu A_nt d, and N w_t = N r_t - r_n (A_tn + mu A_tt d). Its
    component across d = (cos a, sin a) must be zero: a polynomial of degree 4 in z = exp(i a).
    """
    if mu == 0.0:
        return [np.array([-r[0] / A[0, 0], 0.0, 0.0])]

    def across(a: NDArray[Any]) -> Array:
        d, e = np.array([np.cos(a), np.sin(a)]), np.array([-np.sin(a), np.cos(a)])
        N = A[0, 0] + mu * A[0, 1:] @ d
        slip = N * r[1:, None] - r[0] * (A[1:, :1] + mu * A[1:, 1:] @ d)
        return np.asarray((e * slip).sum(axis=0), dtype=np.float64)

    # Fourier coefficients of orders -2..2, exact from eight samples.
    samples = 2.0 * np.pi * np.arange(8) / 8.0
    c = np.fft.fft(across(samples)) / 8.0
    roots = np.roots([c[2], c[1], c[0], c[-1], c[-2]])
    angles = np.angle(roots[np.abs(np.abs(roots) - 1.0) < 1e-3])
    if len(angles) == 0:
        return []
    slope = 1j * np.arange(-2, 3)
    for _ in range(3):  # double roots of a polynomial have only half the digits
        waves = np.exp(np.outer(angles, slope)) * c[[-2, -1, 0, 1, 2]]
        f, df = waves.sum(axis=1).real, (waves * slope).sum(axis=1).real
        step = np.divide(-f, df, out=np.zeros_like(f), where=df != 0.0)
        angles = angles + np.clip(step, -1e-3, 1e-3)
    d = np.array([np.cos(angles), np.sin(angles)])
    with np.errstate(divide="ignore"):
        normal = -r[0] / (A[0, 0] + mu * A[0, 1:] @ d)
    return list(np.column_stack([normal, *(mu * normal * d)]))


def contact_residual(A: Array, b: Array, friction: Array, p: Array) -> Array:
    """Residual of each contact's law (n, 2) [m/s]: normal, friction.

    With w = A p + b: normal |min(w_n, A_nn p_n)|; friction: distance from p_t/k to the projection
    of p_t/k - w_t on the disc of radius mu p_n/k, 1/k: largest eigenvalue of the tangential block.
    """
    w = (A @ p.ravel() + b).reshape(-1, 3)
    out = np.zeros((len(friction), 2))
    for i, (x, u) in enumerate(zip(p, w, strict=True)):
        own = A[3 * i : 3 * i + 3, 3 * i : 3 * i + 3]
        scale = np.linalg.eigvalsh(own[1:, 1:])[-1]
        out[i, 0] = abs(min(u[0], own[0, 0] * x[0]))
        y, limit = scale * x[1:] - u[1:], scale * friction[i] * max(x[0], 0.0)
        y = y * min(1.0, limit / max(float(np.hypot(*y)), 1e-300))
        out[i, 1] = np.hypot(*(y - scale * x[1:]))
    return out


def solve_contacts(
    A: Array, b: Array, friction: Array, *, tolerance: float, sweeps: int, start: Array
) -> Array:
    """Impulses p (n, 3) of Coulomb contacts by Gauss-Seidel with exact solutions per contact.

    With w = A p + b (normal row first, minus its target velocity), each contact obeys the law of
    `coulomb_answers`. `A` (3n, 3n), `b` (3n,). Every few sweeps Newton's method solves the
    equations of the loaded contacts, each in its current state (stick or slip). Stops when
    `contact_residual` is under `tolerance` [m/s].
    """
    n = len(friction)
    p: Array = start.copy()
    for sweep in range(sweeps):
        for i in range(n):
            at = slice(3 * i, 3 * i + 3)
            r = A[at] @ p.ravel() + b[at] - A[at, at] @ p[i]
            own, mu = A[at, at], float(friction[i])
            p[i] = (_at_rest(own, r, mu) or coulomb_answers(own, r, mu))[0]
        if sweep % 5 == 4 or n == 1:
            guess = _polished(A, b, friction, p)
            for x in (p, guess):
                if contact_residual(A, b, friction, x).max() < tolerance:
                    return x
    return p


def _polished(A: Array, b: Array, friction: Array, p: Array) -> Array:
    """Newton's method from p on w_n = 0 and, for sticking contacts, w_t = 0, for sliding ones
    p_t |w_t| = -mu p_n w_t. No contact changes its state. Each step is the least change of p."""
    p = p.copy()
    carries = p[:, 0] > 0.0
    p[~carries] = 0.0
    slips = carries & (np.hypot(p[:, 1], p[:, 2]) > (1.0 - 1e-9) * friction * p[:, 0])
    rows = np.repeat(carries, 3)
    if not rows.any():
        return p
    for _ in range(12):
        w = A @ p.ravel() + b
        f, J = w.copy(), A.copy()
        for i in np.flatnonzero(slips):
            t, u = slice(3 * i + 1, 3 * i + 3), w[3 * i + 1 : 3 * i + 3]
            size = max(float(np.hypot(*u)), 1e-300)
            # Scaled to a velocity, like the other rows.
            unit, mu = u / size, friction[i]
            scale = A[3 * i, 3 * i]
            f[t] = scale * (p[i, 1:] + mu * p[i, 0] * unit)
            turn = (np.eye(2) - np.outer(unit, unit)) / size
            J[t] = scale * mu * p[i, 0] * turn @ A[t]
            J[t, t] += scale * np.eye(2)
            J[t, 3 * i] += scale * mu * unit
        step = np.linalg.lstsq(J[np.ix_(rows, rows)], -f[rows], rcond=1e-13)[0]
        flat = p.ravel()
        flat[rows] += step
        if np.abs(step).max() <= 1e-15 * np.abs(flat).max():
            break
    return p
