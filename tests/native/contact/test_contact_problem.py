"""Whole contact problems w = beta + A p: against a QP solver, and against the law itself.

The problems are those of mechanisms: chains of links with mass ratios of a thousandth to a
thousand, several points on one link, links against the world and against each other.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import nnls

from halfphysics import _native
from halfphysics.body.body import Body
from halfphysics.geometry.shapes import Box, Plane
from halfphysics.reference import step as reference
from halfphysics.reference.contact import contact_residual
from halfphysics.scene.scene import Scene
from halfphysics.simulation.simulator import Simulator
from support.as_it_is import as_it_is
from support.judges.person_hulls import CONTACTS
from support.people import along_x

#: For a substep of 1/240 s, the stepper's tolerance [m/s]; and its limit of sweeps.
TOLERANCE = 1e-6 * 240
SWEEPS = 50
#: Multiplications that a solve may cost: enough for any of these from zero.
BUDGET = 1e12
#: The solver's tolerance when it takes long; only friction may miss it.
ENOUGH = 5 * TOLERANCE
#: Sweeps and Newton steps of one solve: from two starts, rounds of normals, steps of a path.
MOST = 2 * SWEEPS + 12 + 24 + 400
#: Shares of a run's problems that may stay unsettled when solved from zero, all points at once; the
#: core does not solve them that way. Points of several skin hulls coincide: 119 on a limp body
#: where the parts have 76, too many for a path. Measured are 0 and 3 of 31.
FROM_NOTHING = {
    ("parts", None, 1.0): 0.0,
    ("parts", 0.02, 1.0): 0.0,
    ("parts", None, 0.0): 0.0,
    ("skin", None, 1.0): 0.0,
    ("skin", 0.02, 1.0): 0.0,
    ("skin", None, 0.0): 0.15,
}


def cross_matrix(r):
    return np.array([[0, -r[2], r[1]], [r[2], 0, -r[0]], [-r[1], r[0], 0]])


def chain(rng, links):
    """Point Jacobian (link, point) -> (3, nv), M, and the links' positions.

    Coordinates: the first joint's velocity, then the links' absolute angular velocities.
    """
    joints = np.cumsum(rng.normal(size=(links + 1, 3)) * 0.2, axis=0)
    nv = 3 + 3 * links

    def jacobian(link, x):
        J = np.zeros((3, nv))
        J[:, :3] = np.eye(3)
        for i in range(link + 1):
            end = x if i == link else joints[i + 1]
            J[:, 3 + 3 * i : 6 + 3 * i] = -cross_matrix(end - joints[i])
        return J

    M = np.zeros((nv, nv))
    for k in range(links):
        mass = 10.0 ** rng.uniform(-1.5, 1.5)
        Q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        J = jacobian(k, 0.5 * (joints[k] + joints[k + 1]))
        M += mass * J.T @ J
        at = slice(3 + 3 * k, 6 + 3 * k)
        M[at, at] += mass * Q @ np.diag(0.01 * rng.uniform(0.2, 1.0, 3)) @ Q.T
    return jacobian, M, joints


def mechanism(rng):
    """J (3n, nv), M, v* and pairs (n,) of a random problem; zero velocity obeys it."""
    chains = [chain(rng, int(rng.integers(1, 7))) for _ in range(rng.integers(1, 4))]
    first = np.cumsum([0] + [len(M) for _, M, _ in chains])
    M = np.zeros((first[-1], first[-1]))
    for (_, block, _), at in zip(chains, first, strict=False):
        M[at : at + len(block), at : at + len(block)] = block
    rows, pairs = [], []
    for pair in range(int(rng.integers(1, 7))):
        a = int(rng.integers(len(chains)))
        b = int(rng.integers(len(chains)))
        frame, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        links = [int(rng.integers(len(chains[c][2]) - 1)) for c in (a, b)]
        centre = chains[a][2][links[0]] + rng.normal(size=3) * 0.1
        against = a != b and rng.uniform() < 0.5
        for _ in range(int(rng.choice([1, 1, 2, 4]))):  # points of one face
            x = centre + frame[1:].T @ rng.normal(size=2) * 0.05
            J = np.zeros((3, len(M)))
            J[:, first[a] : first[a + 1]] = frame @ chains[a][0](links[0], x)
            if against:
                J[:, first[b] : first[b + 1]] -= frame @ chains[b][0](links[1], x)
            rows.append(J)
            pairs.append(pair)
    return np.concatenate(rows), M, rng.normal(size=len(M)), np.array(pairs, dtype=np.int32)


def solve(A, b, mu, pairs, warm=None, tolerance=TOLERANCE, fine=TOLERANCE, most=SWEEPS):
    warm = np.zeros(len(b)) if warm is None else warm
    p, sweeps, residual, normal, _, _ = _native.solve_contacts(
        A, b, np.asarray(mu, dtype=float), pairs, warm, tolerance, fine, most, BUDGET
    )
    return p.reshape(-1, 3), sweeps, residual, normal


def symmetric(A):
    return 0.5 * (A + A.T)


def test_frictionless_problems_agree_with_a_qp_solver():
    """Least change of motion: min |M^1/2 (v - v*)| with J_n v >= 0, by non-negative least squares.

    The normal velocities are unique, even with redundant contacts.
    """
    rng = np.random.default_rng(0)
    worst = 0.0
    carrying = 0
    for _ in range(300):
        J, M, v, pairs = mechanism(rng)
        L = np.linalg.cholesky(M)
        Y = np.linalg.solve(L, J.T)
        p, *_ = solve(
            symmetric(Y.T @ Y), J @ v, np.zeros(len(pairs)), pairs, None, 1e-11, 1e-11, 500
        )
        q, _ = nnls(Y[:, ::3], -L.T @ v, maxiter=3000)
        moved, expected = Y @ p.ravel(), Y[:, ::3] @ q
        carrying += (q > 0).sum() > 2
        worst = max(worst, np.abs(moved - expected).max() / max(1e-3, np.abs(expected).max()))
        assert np.abs(p[:, 1:]).max() == 0.0
    assert carrying > 60
    assert worst < 1e-8


def test_law_of_contact_over_random_mechanisms():
    """1,000 problems, cold and warm: nearly all obey the law to the tolerance; the
    reported residual is the true one; and where friction does not settle normals still hold."""
    rng = np.random.default_rng(1)
    missed, unsettled = {"cold": 0, "warm": 0}, 0
    for _ in range(500):
        J, M, v, pairs = mechanism(rng)
        Y = np.linalg.solve(np.linalg.cholesky(M), J.T)
        A, mu = symmetric(Y.T @ Y), rng.uniform(0.0, 1.5, len(pairs))
        warm = None
        for start in missed:
            b = J @ v
            p, sweeps, residual, normal = solve(A, b, mu, pairs, warm)
            left = contact_residual(A, b, mu, p)
            # The report, up to the small term added to the diagonal of A.
            assert residual == pytest.approx(left.max(), rel=1e-6, abs=1e-3 * TOLERANCE)
            assert normal == pytest.approx(left[:, 0].max(), rel=1e-6, abs=1e-3 * TOLERANCE)
            assert normal <= ENOUGH
            assert (np.hypot(p[:, 1], p[:, 2]) <= mu * p[:, 0] * (1 + 1e-12)).all()
            w = A @ p.ravel() + b
            # The solver gains no energy and, where it has converged, friction does not accelerate.
            energy = p.ravel() @ (b + 0.5 * A @ p.ravel())
            assert energy <= 3 * len(mu) * ENOUGH * np.abs(p).max()
            if residual <= TOLERANCE:
                along = np.einsum("ij,ij->i", p[:, 1:], w.reshape(-1, 3)[:, 1:])
                assert (along <= 3 * TOLERANCE * np.abs(p).max(axis=1)).all()
            missed[start] += residual > TOLERANCE
            unsettled += residual > ENOUGH
            assert sweeps <= MOST
            # The next substep: all values change a little.
            v = v + 0.02 * rng.normal(size=len(v))
            warm = p.ravel().copy()
    # Problems that do not converge (1 to 2 %) are near jamming: mu |A_nt| > A_nn. Measured are 8, 5
    # and 2; of two other seeds 9, 2, 0 and 3, 3, 0. Without a path 18 stay unsettled.
    assert missed["cold"] <= 12
    assert missed["warm"] <= 12
    assert unsettled <= 3


@pytest.mark.parametrize("contact", CONTACTS)
@pytest.mark.parametrize(("drive_time", "stiffness"), [(None, 1.0), (0.02, 1.0), (None, 0.0)])
def test_law_of_contact_for_a_person_against_a_wall(drive_time, stiffness, contact):
    """The problems of a real run, set up in numpy, 50 to 120 points at once.

    The core's solution obeys the law. Solved again from zero, all points at once, nearly
    all problems settle; the reported residual is the true one.
    """
    body = Body.default()
    motion = along_x(1.5, 26, start=-0.1).grounded(body, 0.0005).resample(240.0)
    scene = Scene()
    scene.add_static("wall", Box((0.01, 6.0, 6.0)), position=(0.6, 0.0, 0.0), friction=1.0)
    scene.add_static("floor", Plane(), friction=0.5)
    settings = as_it_is(contact=contact, drive_time=drive_time, stiffness=stiffness, substeps=1)
    simulator = Simulator(scene, body=body, settings=settings, fps=240)
    simulator.reset(motion[0])
    stepper, model = simulator.world.stepper, simulator.world.model
    stepper.keep_trace(True)
    targets = simulator.world.motion_coordinates([motion])
    person = simulator.world.people[0]
    dof = int(model.jnt_dofadr[model.body_jntadr[person.root]])
    own = reference.ReferenceDrive(settings, person.qpos, dof, targets[0])
    solved = missed = normals = unsettled = 0
    for t in range(1, len(motion)):
        qpos = np.array(stepper.qpos())
        simulator.step(motion[t])
        trace = stepper.trace()
        points = trace["contacts"]
        n = len(points["dist"])
        if t % 4 or n == 0:
            continue
        M = reference.inertia_matrix(model, qpos)
        stiff = reference.stiff_diagonal(model, M, own)
        held = reference.held_diagonal(model, stiff, own, trace["touched"])
        M = own.scale(1.0 / 240.0) * (M + np.diag(held))
        problem = reference.contact_problem(model, qpos, trace["v_free"], M, 1.0 / 240.0, points)
        A = symmetric(problem.A)
        found = contact_residual(A, problem.b, problem.friction, problem.found)
        assert found[:, 0].max() <= ENOUGH
        unsettled += found.max() > ENOUGH
        pairs = np.array(100 * points["bodies_a"][:, 0] + points["bodies_b"][:, 0], dtype=np.int32)
        p, _, residual, normal = solve(A, problem.b, problem.friction, pairs)
        left = contact_residual(A, problem.b, problem.friction, p)
        assert residual == pytest.approx(left.max(), rel=1e-6, abs=1e-3 * TOLERANCE)
        solved += 1
        missed += residual > ENOUGH
        normals += normal > ENOUGH
    assert solved > 20
    assert unsettled == 0
    assert missed <= FROM_NOTHING[contact, drive_time, stiffness] * solved
    assert normals == 0


def net(rng, contacts):
    """A (3n, 3n), beta (3n,) and pairs (n,) of points that press on few degrees of freedom."""
    J = rng.normal(size=(3 * contacts, 40))
    beta = J @ rng.normal(size=40)
    beta[::3] -= 1.0
    return symmetric(J @ J.T), beta, np.arange(contacts, dtype=np.int32) // 3


@pytest.mark.parametrize("contacts", [30, 100, 300])
def test_work_ends_with_its_budget_and_is_reported(contacts):
    """A solve costs what its budget says and one step of pivoting more, at most; if that is not
    enough it says so."""
    A, beta, pairs = net(np.random.default_rng(contacts), contacts)
    mu = np.full(contacts, 0.7)
    step = contacts**3 / 6 + 2 * contacts**2
    for budget in (1e4, 1e6, 1e7):
        found = [
            _native.solve_contacts(
                A, beta, mu, pairs, np.zeros(3 * contacts), TOLERANCE, TOLERANCE, SWEEPS, budget
            )
            for _ in range(2)
        ]
        p, _, residual, _, work, exhausted = found[0]
        assert found[1][4] == work
        np.testing.assert_array_equal(found[1][0], p)
        assert work <= budget + step + 8 * (3 * contacts) ** 2
        assert np.isfinite(p).all()
        assert (np.hypot(p[1::3], p[2::3]) <= 0.7 * p[::3] * (1 + 1e-12)).all()
        if budget == 1e4:
            assert exhausted
        if exhausted:
            assert residual >= TOLERANCE
