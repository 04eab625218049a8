"""The default body's joint regressor: tame averages of the skin, by linear programming.

What a reader regresses is where the joints are, so the regressor defines them, and the rig is only
what it is fitted to. The skin near a joint does not move with shape as the rig does: to match the
rig to 0.1 mm takes rows of large entries of both signs, whose absolute sums of 30 make a reader
that computes in single precision err by a micrometre, and enlarge the flaws of a scanned template
as much. So the sum is bounded, and of the rig these are kept, in turn: the mean joints, straight
limbs along their axes for every shape, the joints of every shape as near as may be.

One linear programme per joint or limb. Its optimum lies at a corner, so rows are sparse.
Part of `bake_body.py`. Lengths in here are millimetres, so that the solver sees numbers near 1.
"""

from __future__ import annotations

import numpy as np

X, Y, Z = 0, 1, 2
#: Joints fitted together, and the axes across which each stays in line with the others.
GROUPS: tuple[dict[str, tuple[int, ...]], ...] = (
    *({n: ()} for n in ("pelvis", "spine1", "spine2", "spine3", "neck", "head", "jaw")),
    {"left_hip": (X, Z), "left_knee": (X, Z), "left_ankle": (X, Z), "left_foot": (X,)},
    {f"left_{n}": (Y, Z) for n in ("shoulder", "elbow", "wrist", "middle1", "middle2", "middle3")},
    {"left_collar": ()},
    {"left_eye_smplhf": ()},
    *({f"left_{f}{k}": ()} for f in ("index", "pinky", "ring", "thumb") for k in (1, 2, 3)),
)
ABSOLUTE_SUM = 1.5  # of a row, at most; 1 would be an average
MEAN_TOLERANCE = 0.001
FREE = 0.05  # per unit of shape: errors below this cost nothing
LINE_PRICE = 10.0  # of the error across a straight limb; the largest error of each joint costs 1
SUM_PRICE = 0.05  # of an absolute sum of 1 at the joint, growing with distance squared: ...
FAR = 200.0  # ... twice as much here
#: A vertex is near where so much of it goes with joints at most two bones away.
NEAR = 0.05
UNIT = 2.0**-24  # entries are whole multiples: exact in float32, and rows sum to exactly 1


def joint_regressor(vertices, dirs, joints, joint_dirs, weights, *, parents, names, mirror):
    """Regressor (J, V): joints from a shaped skin.

    Args:
        vertices: Mean skin (V, 3) [m].
        dirs: Its shape directions (V, 3, K) [m].
        joints: The rig's mean joints (J, 3) [m], reproduced.
        joint_dirs: Their shape directions (J, 3, K) [m], approached.
        weights: Skinning weights (V, J).
        parents: Parent (J,) of each joint, negative for the root.
        names: Names of the joints.
        mirror: Index of the mirror image of each vertex (V,) and of each joint (J,).
    """
    partner, opposite = mirror
    basis = 1e3 * np.concatenate([vertices[:, :, None], dirs], axis=2)
    goals = 1e3 * np.concatenate([joints[:, :, None], joint_dirs], axis=2)
    near = weights @ neighbours(parents) > NEAR
    regressor = np.zeros((len(names), len(vertices)))
    for group in GROUPS:
        own = [list(names).index(name) for name in group]
        skins, bases = [], []
        for j in own:
            # A joint in the plane of symmetry takes left and right alike: one entry for each pair.
            paired = opposite[j] == j
            skins.append(np.flatnonzero(near[:, j] & ((vertices[:, X] >= 0) | ~paired)))
            mean = (basis[skins[-1]] + basis[partner[skins[-1]]]) / 2
            bases.append(mean if paired else basis[skins[-1]])
        rows = fit(bases, goals[own], list(group.values()))
        for j, skin, row in zip(own, skins, rows, strict=True):
            if opposite[j] == j:
                np.add.at(regressor[j], skin, row / 2)
                np.add.at(regressor[j], partner[skin], row / 2)
                regressor[j] = quantise(regressor[j], partner)
            else:
                regressor[j, skin] = row
                regressor[j] = quantise(regressor[j], np.arange(len(partner)))
                regressor[opposite[j], partner] = regressor[j]
    return regressor


def neighbours(parents: np.ndarray) -> np.ndarray:
    """Which joints (J, J) are at most two bones apart."""
    step = np.eye(len(parents), dtype=int)
    child = np.flatnonzero(parents >= 0)
    step[child, parents[child]] = step[parents[child], child] = 1
    return (step @ step > 0).astype(int)


def fit(bases, goals, in_line) -> list[np.ndarray]:
    """Rows of the joints of one group.

    Args:
        bases: For each joint, position and shape directions (n, 3, 1 + K) of the skin near it.
        goals: Its own (3, 1 + K).
        in_line: Its axes of `GROUPS`.
    """
    from scipy.optimize import linprog

    # Columns: for each joint the positive parts of its entries, the negative parts, its largest
    # error; then by how much the limb as a whole is off its axis (3, K), and the largest error
    # across that.
    counts = [len(base) for base in bases]
    starts = np.cumsum([0, *(2 * n + 1 for n in counts)])
    k = bases[0].shape[2] - 1
    aside = starts[-1] + np.arange(3 * k).reshape(3, k)
    across = starts[-1] + 3 * k
    cost, least = np.zeros(across + 1), np.zeros(across + 1)
    cost[across], least[across], least[aside] = LINE_PRICE, FREE, -np.inf
    ones = np.zeros((len(bases), len(cost)))
    A, b = [], []

    def bound(rows: np.ndarray, aim: np.ndarray, slack: np.ndarray) -> None:
        A.extend([rows - slack, -rows - slack])
        b.extend([aim, -aim])

    for i, (base, goal) in enumerate(zip(bases, goals, strict=True)):
        entries, worst = slice(starts[i], starts[i + 1] - 1), starts[i + 1] - 1
        distance = np.linalg.norm(base[:, :, 0] - goal[:, 0], axis=1)
        cost[entries] = np.tile(SUM_PRICE * (1 + (distance / FAR) ** 2), 2)
        cost[worst], least[worst] = 1.0, FREE
        ones[i, entries] = np.repeat([1.0, -1.0], counts[i])
        A.append(np.abs(ones[i : i + 1]))
        b.append(np.array([ABSOLUTE_SUM]))
        for axis in range(3):
            rows = np.zeros((1 + k, len(cost)))
            offset = base[:, axis] - np.r_[goal[axis, 0], np.zeros(k)]
            rows[:, entries] = np.concatenate([offset, -offset]).T
            slack = np.zeros((k, len(cost)))
            slack[:, worst] = 1.0
            A.extend([rows[:1], -rows[:1]])
            b.extend([np.array([MEAN_TOLERANCE])] * 2)
            bound(rows[1:], goal[axis, 1:], slack)
            if axis in in_line[i]:
                rows[np.arange(1, 1 + k), aside[axis]] = -1.0
                slack = np.zeros((k, len(cost)))
                slack[:, across] = 1.0
                bound(rows[1:], goal[axis, 1:], slack)
    solved = linprog(
        cost,
        A_ub=np.concatenate(A),
        b_ub=np.concatenate(b),
        A_eq=ones,
        b_eq=np.ones(len(bases)),
        bounds=np.stack([least, np.full(len(cost), np.inf)], axis=1),
        method="highs",
    )
    if solved.status != 0:
        raise SystemExit(f"no joint regressor: {solved.message}")
    parts = [solved.x[s : s + 2 * n] for s, n in zip(starts[:-1], counts, strict=True)]
    return [part[: len(part) // 2] - part[len(part) // 2 :] for part in parts]


def quantise(row: np.ndarray, partner: np.ndarray) -> np.ndarray:
    """A row (V,) in whole multiples of `UNIT` that sum to exactly 1, as symmetric as it was."""
    units = np.round(row / UNIT)
    rest = round(1 / UNIT) - units.sum()
    if rest % 2:  # pairs are even, so there is something without a pair
        single = (np.arange(len(row)) == partner) & (units != 0)
        units[np.flatnonzero(single)[0]] += 1
        rest -= 1
    largest = units.argmax()
    np.add.at(units, [largest, partner[largest]], rest / 2)
    return units * UNIT
