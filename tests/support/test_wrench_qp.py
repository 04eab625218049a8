"""The wrench spread over places: the core and numpy agree, and it is the minimum."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.support.wrench_qp import MOMENTS, PENALTY, SHEAR, spread
from support.references.wrench_qp import spread as reference


def problem(seed, frames=40, most=30, reachable=True):
    """Places on a floor and a wall, and wrenches, all reachable or all random."""
    rng = np.random.default_rng(seed)
    counts = rng.integers(0, most, frames)
    frame = np.repeat(np.arange(frames), counts)
    n = len(frame)
    arm = rng.normal(size=(n, 3)) * (0.3, 0.3, 0.05) - (0.0, 0.0, 0.9)
    normal = np.where(rng.random((n, 1)) < 0.8, (0.0, 0.0, 1.0), (0.0, 1.0, 0.0))
    friction = rng.choice([0.0, 0.3, 1.0], n)
    ready = rng.uniform(0.05, 1.0, n)
    wrench = rng.normal(size=(frames, 6)) * (200.0, 200.0, 300.0, 80.0, 80.0, 30.0)
    if reachable:
        wrench[:] = 0.0
        push = 30.0 * normal
        np.add.at(wrench, frame, np.concatenate([push, np.cross(arm, push)], axis=1))
    return wrench, frame, arm, normal, friction, ready


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("reachable", [True, False])
def test_the_core_equals_numpy(seed, reachable):
    given = problem(seed, reachable=reachable)
    # Both end where the gradient is under `TOLERANCE`; which of the last steps they take differs.
    assert spread(*given) == pytest.approx(reference(*given), rel=1e-5, abs=1e-3)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("reachable", [True, False])
def test_it_is_the_minimum_over_the_cones(seed, reachable):
    """Forces are in their cones, and no small step within them does better."""
    wrench, frame, arm, normal, friction, ready = problem(seed, reachable=reachable)
    force = spread(wrench, frame, arm, normal, friction, ready)
    along = np.einsum("ni,ni->n", force, normal)
    across = np.linalg.norm(force - along[:, None] * normal, axis=1)
    assert (across <= friction * along + 1e-9 * (1.0 + along)).all()
    # The gradient by each force, and its projection: a step along it leads out of the cone or back.
    scale = np.repeat([1.0, MOMENTS], 3)
    total = np.zeros_like(wrench)
    np.add.at(total, frame, np.concatenate([force, np.cross(arm, force)], axis=1))
    missing = (wrench - total) * scale**2
    pull = missing[frame, :3] + np.cross(missing[frame, 3:], arm)
    ease = (ready / PENALTY) ** 2
    assert projected(pull * ease[:, None], normal, friction) == pytest.approx(
        force,
        abs=0.02,  # the core's tolerance over the penalty of a ready place
    )


def projected(g, normal, mu):
    along = np.einsum("ni,ni->n", g, normal)
    across = (g - along[:, None] * normal) / SHEAR
    size = np.linalg.norm(across, axis=1)
    mu = SHEAR * mu
    slips = size > mu * along
    push = np.where(slips, np.maximum(along + mu * size, 0.0) / (1.0 + mu**2), along)
    held = np.where(slips, mu * push / np.where(size > 0.0, size, 1.0), 1.0)
    return push[:, None] * normal + held[:, None] / SHEAR * across


def test_what_can_be_reached_is_reached():
    given = problem(3)
    wrench, frame, arm = given[:3]
    given[-1][:] = 1.0
    force = spread(*given)
    total = np.zeros_like(wrench)
    np.add.at(total, frame, np.concatenate([force, np.cross(arm, force)], axis=1))
    size = np.linalg.norm(wrench, axis=1).max()
    assert np.abs(total - wrench).max() < 2e-3 * size


def test_nothing_to_spread():
    empty = np.zeros((0, 3))
    found = spread(
        np.ones((3, 6)), np.zeros(0, dtype=np.int64), empty, empty, np.zeros(0), np.zeros(0)
    )
    assert found.shape == (0, 3)


def test_a_wrench_of_zero_needs_no_force():
    wrench, *places = problem(1)
    assert not spread(0.0 * wrench, *places).any()


def test_forces_change_as_smoothly_as_what_they_come_from():
    """Half the change of the wrench and of the readiness changes the forces by half."""
    a = problem(5, reachable=False)
    changes = []
    for step in (1e-3, 5e-4):
        b = [a[0] * (1.0 + step), *a[1:5], a[5] * (1.0 - 0.5 * step)]
        changes.append(np.abs(spread(*b) - spread(*a)).max())
    assert changes[1] < 0.6 * changes[0]
