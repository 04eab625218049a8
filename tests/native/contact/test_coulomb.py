"""One Coulomb contact alone: the native solution obeys the law exactly."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics import _native
from halfphysics.reference import contact as reference_contact

#: Relative to the incoming velocities and those of the impulse (rounding: A may lose six
#: digits).
EXACT = 1e-9
ROUNDING = 1e-11


def spread(rng):
    B = rng.normal(size=(3, 3))
    return B @ B.T + 0.1 * np.eye(3)


def ill_conditioned(rng):
    Q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return Q @ np.diag(10.0 ** rng.uniform(-6.0, 0.0, 3)) @ Q.T


def jamming(rng):
    """Pushing causes sliding and sliding causes pushing: mu |A_nt| > A_nn (Painleve)."""
    angle, coupling = rng.uniform(0.0, 2 * np.pi), rng.uniform(1.0, 10.0)
    u = np.array([1.0, coupling * np.cos(angle), coupling * np.sin(angle)])
    return np.outer(u, u) + 10.0 ** rng.uniform(-3.0, 0.0) * np.eye(3)


def uncoupled(rng):
    return np.diag(10.0 ** rng.uniform(-3.0, 3.0, 3))


KINDS = [spread, ill_conditioned, jamming, uncoupled]


def inertia(kind, rng):
    A = kind(rng) * 10.0 ** rng.uniform(-6.0, 6.0)
    return 0.5 * (A + A.T)


def solve(A, mu, r, old=(0.0, 0.0, 0.0)):
    return _native.coulomb_contact(A, mu, np.array([r]), np.array([old], dtype=float))[0]


def violation(A, mu, r, p):
    """Violation of the law of contact, relative to the velocities."""
    size = EXACT * np.abs(r).max() + ROUNDING * np.abs(A).max() * np.abs(p).max()
    own = np.array([np.hypot(p[1], p[2]) - mu * p[0], -p[0]]) * A[0, 0]
    law = reference_contact.contact_residual(A, r, np.array([mu]), p[None])
    return max(own.max(), law.max()) / size


@pytest.mark.parametrize("kind", KINDS)
def test_the_law_holds(kind):
    """Complementarity, cone, and opposed slip; from any guess of the slip direction."""
    rng = np.random.default_rng(1)
    slipping = jammed = 0
    for k in range(3000):
        A, r = inertia(kind, rng), rng.normal(size=3) * 10.0 ** rng.uniform(-9.0, 2.0)
        mu = 0.0 if k % 10 == 0 else rng.uniform(0.0, 1.5)
        p = solve(A, mu, r, rng.normal(size=3))
        assert violation(A, mu, r, p) < 1.0, (A.tolist(), mu, r.tolist())
        slipping += p[0] > 0 and np.hypot(p[1], p[2]) > (1 - 1e-9) * mu * p[0]
        jammed += p[0] > 0 and mu * np.hypot(A[0, 1], A[0, 2]) > A[0, 0]
    assert slipping > 300  # each regime occurs
    if kind is jamming:
        assert jammed > 1000


@pytest.mark.parametrize("edge", [1e-15, 1e-12, 1e-9, 1e-6, 1.0])
def test_the_law_holds_at_the_edge_of_sticking(edge):
    """The solution is known: it slips slightly, or a slight force holds it.

    Here the possible directions of friction lie close together.
    """
    rng = np.random.default_rng(2)
    for k in range(4000):
        A, mu = inertia(KINDS[k % 4], rng), rng.uniform(0.0, 1.5)
        angle = rng.uniform(0.0, 2 * np.pi)
        d = np.array([np.cos(angle), np.sin(angle)])
        known = 10.0 ** rng.uniform(-6.0, 6.0) * np.array([1.0, *(mu * d)])
        slip = edge * np.abs(A @ known).max() * (-1.0 if k % 2 else 1.0)
        r = np.array([0.0, *(-slip * d)]) - A @ known
        p = solve(A, mu, r, rng.normal(size=3))
        assert violation(A, mu, r, p) < 1.0, (A.tolist(), mu, r.tolist())


@pytest.mark.parametrize("kind", KINDS)
def test_equal_to_the_reference(kind):
    """A unique solution equals the reference's; of several it is one of the reference's."""
    rng = np.random.default_rng(3)
    several = 0
    for _ in range(1000):
        A, r, mu = inertia(kind, rng), rng.normal(size=3), rng.uniform(0.0, 1.5)
        p = solve(A, mu, r)
        answers = reference_contact.coulomb_answers(A, r, mu)
        several += len(answers) > 1
        # Impulses lose the digits that A has lost.
        near = min(np.abs(p - q).max() for q in answers)
        size = np.linalg.cond(A) * max(np.abs(p).max(), np.abs(r / A[0, 0]).max())
        assert near <= 1e-14 * size
    if kind is jamming:
        assert several > 10


def test_the_reference_finds_what_a_search_of_all_directions_finds():
    """Slow and simple: 20,000 slip directions, each sign change."""
    rng = np.random.default_rng(4)
    a = np.linspace(0.0, 2 * np.pi, 20001)
    d, across = np.array([np.cos(a), np.sin(a)]), np.array([-np.sin(a), np.cos(a)])
    for k in range(400):
        A, r, mu = inertia(KINDS[k % 4], rng), rng.normal(size=3), rng.uniform(0.1, 1.5)
        r[0] = -abs(r[0])
        N = A[0, 0] + mu * A[0, 1:] @ d
        slip = N * r[1:, None] - r[0] * (A[1:, :1] + mu * A[1:, 1:] @ d)
        side = (across * slip).sum(axis=0) > 0.0
        there = side[1:] != side[:-1]
        right = (N > 0.0) & ((d * slip).sum(axis=0) < 0.0)
        good = there & right[1:] & right[:-1]
        found = [
            p
            for p in reference_contact.coulomb_answers(A, r, mu)
            if np.hypot(*p[1:]) > 0.999 * mu * p[0]
        ]
        angles = np.array([np.arctan2(p[2], p[1]) for p in found])
        for x in a[1:][good]:
            miss = np.abs(np.angle(np.exp(1j * (angles - x))))
            assert miss.min(initial=np.inf) < 1e-3, (A.tolist(), mu, r.tolist())


@pytest.mark.parametrize("kind", [spread, uncoupled])
def test_turned_tangents_give_the_turned_answer(kind):
    rng = np.random.default_rng(5)
    for _ in range(2000):
        A, r, mu = inertia(kind, rng), rng.normal(size=3), rng.uniform(0.0, 1.5)
        if len(reference_contact.coulomb_answers(A, r, mu)) > 1:
            continue
        angle = rng.uniform(0.0, 2 * np.pi)
        c, s = np.cos(angle), np.sin(angle)
        turn = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
        turned = turn @ A @ turn.T
        p, q = solve(A, mu, r), solve(0.5 * (turned + turned.T), mu, turn @ r)
        size = np.linalg.cond(A) * np.abs(r).max() / np.linalg.eigvalsh(A)[0]
        assert np.abs(q - turn @ p).max() <= 1e-14 * size


def test_without_friction_it_is_a_division():
    rng = np.random.default_rng(6)
    for _ in range(500):
        A, r = inertia(spread, rng), rng.normal(size=3)
        np.testing.assert_allclose(
            solve(A, 0.0, r), [max(0.0, -r[0] / A[0, 0]), 0.0, 0.0], rtol=1e-12
        )
