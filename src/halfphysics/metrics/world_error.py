"""Errors in the world against a truth, as on EMDB: WA-MPJPE_100, W-MPJPE_100, RTE, foot sliding.

Source: EMDB (Kaufmann et al. 2023) as WHAM (Shin et al. 2024) evaluates it, yohanshin/WHAM
lib/eval/eval_utils.py, which follows SLAHMR (Ye et al. 2023). Joints (T, J, 3) [m]; there J = 24 of
SMPL, the judge takes the first 22, which SMPL, SMPL-H and SMPL-X share. A truth of another shape,
and numbers that are not finite, are an `InputError`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.metrics.argument_checks import Array, beside
from halfphysics.motion.skeleton import JOINT_INDEX

#: Frames of a piece that is aligned as one.
CHUNK = 100
#: Frames by whose joints W-MPJPE aligns a chunk.
FIRST = 2
#: A vertex of the truth that moves less than this from frame to frame is in contact [m].
CONTACT = 0.01
#: Big toe and heel, left and right, of SMPL's 6,890 vertices.
SMPL_SOLES, SMPL_VERTICES = (3216, 3387, 6617, 6787), 6890


def wa_mpjpe(joints: ArrayLike, truth: ArrayLike) -> float:
    """WA-MPJPE_100 [mm]: mean joint error, each 100 frames aligned to the truth as a whole.

    Of each piece of the clip (`pieces`) the similarity (scale, rotation, translation) that brings
    all its joints nearest to the truth in the least squares sense is applied first.

    Args:
        joints: Positions (T, J, 3) [m].
        truth: The true ones (T, J, 3) [m].
    """
    return _in_pieces(joints, truth, slice(None))


def w_mpjpe(joints: ArrayLike, truth: ArrayLike) -> float:
    """W-MPJPE_100 [mm]: as `wa_mpjpe`, but each piece is aligned by its first two frames alone."""
    return _in_pieces(joints, truth, slice(0, FIRST))


def pieces(frames: int) -> list[slice]:
    """The pieces in which a clip is aligned, cut as WHAM does.

    They begin at 0, 100, ... while over 100 frames are left. Where no whole further piece fits,
    the piece takes what is left except for the last frame. A clip of up to 100 frames, which has no
    piece there, is one piece here.
    """
    if frames <= CHUNK:
        return [slice(0, frames)]
    return [
        slice(start, start + CHUNK if start + 2 * CHUNK <= frames else frames - 1)
        for start in range(0, frames - CHUNK, CHUNK)
    ]


def rte(path: ArrayLike, truth: ArrayLike) -> float:
    """RTE [%]: mean distance of the root from the true root over the length of the true path.

    The whole path is aligned first, by rotation and translation without scale. NaN where the true
    root does not move.

    Args:
        path: Positions of the root (T, 3) [m].
        truth: The true ones (T, 3) [m].
    """
    path, truth = beside("path", path, truth)
    length = float(np.linalg.norm(np.diff(truth, axis=0), axis=1).sum())
    if length == 0.0:
        return float("nan")
    move = _alignment(path, truth, scaled=False)
    return float(100.0 * np.linalg.norm(move(path) - truth, axis=1).mean() / length)


def world_foot_sliding(soles: ArrayLike, truth: ArrayLike, *, contact: float = CONTACT) -> float:
    """Foot sliding [mm]: mean displacement from frame to frame of vertices of the soles, over the
    steps in which the true vertex moves less than 1 cm; NaN where there is none.

    Args:
        soles: Big toe and heel, left and right (T, 4, 3) [m]; `sole_vertices` names them.
        truth: The true ones (T, 4, 3) [m].
        contact: Displacement of the truth under which a vertex is in contact [m].
    """
    soles, truth = beside("soles", soles, truth)
    moved, true = (np.linalg.norm(np.diff(p, axis=0), axis=-1) for p in (soles, truth))
    held = true < contact
    return float(1000.0 * moved[held].mean()) if held.any() else float("nan")


def sole_vertices(body: Any) -> NDArray[np.intp]:
    """Vertices (4,) of big toe and heel, left and right.

    SMPL's are those of WHAM. On another skin they are the foremost vertex of the foot at rest, and
    the rearmost (z is forward).
    """
    if len(body.rest_vertices) == SMPL_VERTICES:
        return np.array(SMPL_SOLES, dtype=np.intp)
    of, ahead = np.asarray(body.weights).argmax(axis=1), body.rest_vertices[:, 2]
    found = []
    for side in ("left", "right"):
        foot = np.isin(of, [JOINT_INDEX[f"{side}_ankle"], JOINT_INDEX[f"{side}_foot"]])
        own = np.flatnonzero(foot)
        found += [own[ahead[own].argmax()], own[ahead[own].argmin()]]
    return np.array(found, dtype=np.intp)


def _in_pieces(joints: ArrayLike, truth: ArrayLike, by: slice) -> float:
    """Mean error [mm] of pieces that are aligned by the frames `by` of each."""
    joints, truth = beside("joints", joints, truth)
    errors = []
    for piece in pieces(len(joints)):
        own, true = joints[piece], truth[piece]
        move = _alignment(own[by].reshape(-1, 3), true[by].reshape(-1, 3), scaled=True)
        errors.append(np.linalg.norm(move(own) - true, axis=-1).mean(axis=-1))
    return float(1000.0 * np.concatenate(errors).mean())


def _alignment(points: Array, onto: Array, *, scaled: bool) -> Callable[[Array], Array]:
    """The similarity that brings points (n, 3) nearest to others (Umeyama 1991), as a function."""
    middle, target = points.mean(axis=0), onto.mean(axis=0)
    own, true = points - middle, onto - target
    u, size, vt = np.linalg.svd(true.T @ own)
    sign = np.array([1.0, 1.0, np.sign(np.linalg.det(u) * np.linalg.det(vt)) or 1.0])
    turn = (u * sign) @ vt
    spread = float((own**2).sum())
    scale = float((size * sign).sum()) / spread if scaled and spread > 0.0 else 1.0

    def move(these: Array) -> Array:
        moved: Array = scale * (these - middle) @ turn.T + target
        return moved

    return move
