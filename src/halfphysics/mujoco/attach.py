"""A person in a `mujoco.MjSpec`: bodies without joints, which a `Control` moves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.body.mjcf_person import UPRIGHT, add_person_mocap
from halfphysics.errors import InputError

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.mujoco.control import Control
    from halfphysics.settings import Settings


def attach(spec: Any, body: Body | None = None, prefix: str = "human/") -> Human:
    """Add a person to a `mujoco.MjSpec`, to be driven after it is compiled.

    The person's 55 parts are mocap bodies: the model's joints, degrees of freedom, keyframes and
    masses stay as they are. Their geoms are seen by cameras and rangefinders and have no contacts
    in MuJoCo itself.

    Args:
        spec: The `mujoco.MjSpec` of a world: a robot, a kitchen.
        body: The person's body; None: `Body.default()`.
        prefix: Prefix of the names of bodies, meshes and geoms; each person needs their own.

    Raises:
        InputError: `spec` is no MjSpec or has bodies of that prefix already; a prefix that is
            empty or cannot be printed.
    """
    import mujoco

    from halfphysics.body.body import Body

    if not isinstance(spec, mujoco.MjSpec):
        raise InputError(
            f"attach: found {type(spec).__name__}, expected a mujoco.MjSpec "
            "(mujoco.MjSpec.from_file(path) reads one)"
        )
    if body is None:
        body = Body.default()
    if not isinstance(body, Body):
        raise InputError(f"attach: body: found {body!r}, expected a halfphysics.Body")
    if not isinstance(prefix, str) or not prefix or not prefix.isprintable():
        raise InputError(f"attach: prefix: found {prefix!r}, expected text such as 'human/'")
    if any(b.name.startswith(prefix) for b in spec.bodies):
        raise InputError(
            f"attach: the spec has bodies named {prefix}... already; give another prefix"
        )
    add_person_mocap(spec, body.variant, prefix, contype=0, conaffinity=0)
    _stand(spec, body, prefix)
    return Human(body, prefix)


def _stand(spec: Any, body: Body, prefix: str) -> None:
    """Until a control moves it the person stands upright on z = 0; its geoms weigh nothing."""
    joints = body.rest_joints - body.rest_joints[0]
    places = rot.rotate(np.array(UPRIGHT), joints)
    places[:, 2] += body.variant.standing_height
    for part in body.variant.parts:
        mirror = spec.body(prefix + part.name)
        mirror.pos, mirror.quat = places[part.index], UPRIGHT
        for geom in mirror.geoms:
            geom.mass = 0.0


@dataclass(frozen=True, eq=False)
class Human:
    """A person that `attach` added to a spec."""

    body: Body
    prefix: str

    def bind(self, model: Any, data: Any, *, settings: Settings | None = None) -> Control:
        """Take over the person in a compiled model. Several people at once: `halfphysics.bind`.

        Args:
            model, data: The `mujoco.MjModel` that the spec compiled to, and its `mujoco.MjData`.
            settings: See `Settings`; `substeps` and `record` do not apply (a substep is a timestep
                of the model), friction is that of the geoms.

        Raises:
            InputError: Another model, or geoms that cannot be touched.
        """
        from halfphysics.mujoco.binding import bound

        return bound(model, data, [self], settings)
