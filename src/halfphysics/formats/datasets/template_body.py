"""The free body with the size of a subject's own template: a mesh of the skin at rest.

Data sets give a person's size as such a mesh, in the rest pose of SMPL-X (y up, z forward, arms out
to the sides), and leave the joints to the licensed model's regressor. Without that model:

- Any template gives the stature, the span of the arms and the place of the soles. The body is
  scaled to the stature and its arms to the span. Where joints are inside the flesh is the free
  body's: those of SMPL-X differ by centimetres at hips, spine and shoulders.
- One with the vertices of the free body, in their order, has joints by the free body's own
  regressor, too; that one of both bodies is taken whose skin is nearer to the template.
"""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from halfphysics.body.body import Body, free_regressor
from halfphysics.body.model_files import mesh_vertices
from halfphysics.body.proportions import scaled_bones
from halfphysics.errors import InputError
from halfphysics.motion.skeleton import JOINT_INDEX

Array = NDArray[np.float64]

#: A person's height [m], and width and depth at rest as a part of it.
_HEIGHTS, _WIDTHS, _DEPTHS = (1.0, 2.4), (0.75, 1.25), (0.1, 0.45)
#: Arms may be this much shorter or longer than those of the free body.
_ARMS = (0.7, 1.4)


def template_body(path: Path) -> Body:
    """The free body with the size of a template.

    Args:
        path: A PLY or OBJ mesh of the subject at rest [m], y up, z forward.

    Raises:
        FileError: The mesh cannot be read.
        InputError: It is no person at rest.
    """
    skin = mesh_vertices(path)
    body = Body.default()
    try:
        if skin.shape == body.rest_vertices.shape:
            return _by_vertices(skin)
        return Body.default(bones=_by_extent(skin, body))
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def _by_vertices(skin: Array) -> Body:
    """The body of a template with the vertices of the free body (V, 3) [m]."""
    joints = np.einsum("jv,vc->jc", free_regressor(), skin)
    found = [Body.default(bones=scaled_bones(joints, 1.0))]
    with suppress(InputError):
        found.append(Body.default(bones=_by_extent(skin, Body.default())))
    off = [np.linalg.norm(body.rest_vertices - skin, axis=1).mean() for body in found]
    return found[int(np.argmin(off))]


def _by_extent(skin: Array, body: Body) -> Array:
    """Bones (55, 3) [m] by the stature and the span of any template (V, 3) [m]."""
    if len(skin) < 4 or not np.isfinite(skin).all():
        raise InputError(f"found {len(skin)} vertices, expected the skin of a person")
    low, high = skin.min(axis=0), skin.max(axis=0)
    own_low, own_high = body.rest_vertices.min(axis=0), body.rest_vertices.max(axis=0)
    height = float(high[1] - low[1])
    width, depth = float(high[0] - low[0]) / height, float(high[2] - low[2]) / height
    if not (
        _HEIGHTS[0] < height < _HEIGHTS[1]
        and _WIDTHS[0] < width < _WIDTHS[1]
        and _DEPTHS[0] < depth < _DEPTHS[1]
    ):
        raise InputError(
            f"found a template {height:.2f} m high, {width * height:.2f} wide and "
            f"{depth * height:.2f} deep, expected a person at rest in metres: y up, z forward, "
            "arms out to the sides"
        )
    size = height / float(own_high[1] - own_low[1])
    joints = np.asarray(body.rest_joints)
    # Half the span is shoulder, arm and hand: the arm has what is over.
    shoulder, wrist = (joints[JOINT_INDEX[f"left_{name}"], 0] for name in ("shoulder", "wrist"))
    arm = size * float(wrist - shoulder)
    over = 0.5 * (width * height - size * float(own_high[0] - own_low[0]))
    factor = 1.0 + over / arm
    if not _ARMS[0] < factor < _ARMS[1]:
        raise InputError(
            f"found arms {factor:.2f} times as long as a person's of {height:.2f} m; is it at rest?"
        )
    bones = scaled_bones(joints, size, factor)
    # The same place in the box around the skin: soles, back and the middle between the hands.
    middle, own_middle = 0.5 * (low + high), 0.5 * (own_low + own_high)
    place = joints[0]
    bones[0] = np.array(
        [
            middle[0] + size * (place[0] - own_middle[0]),
            low[1] + size * (place[1] - own_low[1]),
            middle[2] + size * (place[2] - own_middle[2]),
        ]
    )
    return bones
