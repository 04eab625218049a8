"""The ghost of the reference motion: it fades out where it coincides with the body.

A ghost over a body that is in the same place only paints it blue. So a ghost is not drawn where it
is less than 1 cm from the body, and has its full opacity from 3 cm on (`look.GHOST_FADE`). The
distance is that of the same point of the skin in both poses.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.motion.skeleton import JOINT_INDEX, JOINT_NAMES, N_JOINTS
from halfphysics.render.cutting import Cut, cut
from halfphysics.render.look import GHOST_ALPHA, GHOST_FADE
from halfphysics.render.rasterizer import Surface

Array = NDArray[np.float64]

# Number of steps of opacity in a picture.
_BANDS = 5


def opacity(distance: Array | float) -> Array:
    """Opacity of a ghost at distances from the body [m]."""
    low, high = GHOST_FADE
    x = np.clip((np.asarray(distance, dtype=np.float64) - low) / (high - low), 0.0, 1.0)
    result: Array = GHOST_ALPHA * x * x * (3.0 - 2.0 * x)
    return result


def faded(surface: Surface, distance: Array) -> list[Surface]:
    """A ghost's surface as bands of growing opacity, without what coincides with the body.

    Args:
        surface: The ghost.
        distance: Distance of each of its vertices from the body's (V,) [m].
    """
    low, high = GHOST_FADE
    if not len(distance) or distance.max() <= low:
        return []
    edges = np.linspace(low, high, _BANDS)
    away, vertices, faces = distance, surface.vertices, surface.faces
    bands = []
    for k, edge in enumerate(edges):
        above = cut(away - edge, faces)
        away, vertices, faces = above.of(away), above.of(vertices), above.faces
        if not len(faces):
            break
        band, alpha = (vertices, faces), GHOST_ALPHA
        if k + 1 < len(edges):
            below = cut(edges[k + 1] - away, faces)
            band = below.of(vertices), below.faces
            alpha = float(opacity(0.5 * (edge + edges[k + 1])))
        if len(band[1]):
            rim = surface.rim * alpha / GHOST_ALPHA
            bands.append(replace(surface, vertices=band[0], faces=band[1], alpha=alpha, rim=rim))
    return bands


def _groups() -> dict[str, list[int]]:
    groups = {"trunk": [*("pelvis", "spine1", "spine2", "spine3", "neck", "head", "jaw")]}
    groups["trunk"] += ["left_eye_smplhf", "right_eye_smplhf", "left_collar", "right_collar"]
    for side in ("left", "right"):
        groups[f"{side}-thigh"] = [f"{side}_hip"]
        groups[f"{side}-leg"] = [f"{side}_knee", f"{side}_ankle", f"{side}_foot"]
        groups[f"{side}-arm"] = [f"{side}_shoulder"]
        taken = {name for names in groups.values() for name in names}
        rest = [n for n in JOINT_NAMES if n.startswith(f"{side}_") and n not in taken]
        groups[f"{side}-hand"] = rest  # with the forearm
    return {name: [JOINT_INDEX[n] for n in names] for name, names in groups.items()}


#: Parts of a ghost that appear together in a browser, with their joints.
PARTS = _groups()


def parts(body: Body) -> dict[str, Cut]:
    """The parts of a ghost, without empty ones; together they are the whole skin."""
    weights = np.asarray(body.weights)
    shares = np.stack([weights[:, joints].sum(axis=1) for joints in PARTS.values()], axis=1)
    out = {}
    for k, name in enumerate(PARTS):
        part = cut(shares[:, k] - np.delete(shares, k, axis=1).max(axis=1), body.faces)
        if len(part.faces):
            out[name] = part
    return out


class Separation:
    """How far apart the parts of a body are in two poses.

    Args:
        body: The body.

    Attributes:
        tips: From each joint at rest to the furthest skin that moves mainly with it (55, 3) [m].
    """

    def __init__(self, body: Body) -> None:
        rest = np.asarray(body.rest_joints)
        vertices = np.asarray(body.rest_vertices)
        main = np.asarray(body.weights).argmax(axis=1)
        self.tips = np.zeros((N_JOINTS, 3))
        for joint in range(N_JOINTS):
            own = vertices[main == joint] - rest[joint]
            if len(own):
                self.tips[joint] = own[np.argmax(np.linalg.norm(own, axis=1))]

    def of(self, one: tuple[Array, Array], other: tuple[Array, Array]) -> dict[str, float]:
        """The largest distance in each of `PARTS` [m].

        Args:
            one, other: Positions (55, 3) [m] and quaternions wxyz (55, 4) of the joints.
        """
        ends = [p + rot.rotate(q, self.tips) for p, q in (one, other)]
        apart = np.maximum(
            np.linalg.norm(one[0] - other[0], axis=1), np.linalg.norm(ends[0] - ends[1], axis=1)
        )
        return {name: float(apart[joints].max()) for name, joints in PARTS.items()}
