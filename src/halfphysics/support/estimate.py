"""The support of a motion: inverse dynamics, the places that can carry, the forces there."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.stopwatch import Stopwatch
from halfphysics.base.validation import number
from halfphysics.motion.skeleton import N_JOINTS
from halfphysics.results.contacts import Contacts
from halfphysics.results.surroundings import Surroundings
from halfphysics.support.flight import runs
from halfphysics.support.inverse_dynamics import (
    dynamics,
    joint_power,
    joint_torques,
)
from halfphysics.support.known_forces import givers_of, known_wrenches, touched_frames
from halfphysics.support.patches import Patches, find_patches
from halfphysics.support.support import Pressure, Support, sums
from halfphysics.support.surfaces import Surface, surfaces_of
from halfphysics.support.wrench_qp import spread

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion
    from halfphysics.scene.scene import Scene

logger = logging.getLogger(__name__)

Array = NDArray[np.float64]

#: Cut-off of the low-pass filter of velocities [Hz]: the usual one for walking (Winter 2009).
CUTOFF = 6.0
#: Readiness of a place from which on it ends a flight: in reach, and not passing by.
CARRIES = 0.1
#: Forces under this part of the weight count as none in the list of pressures.
FAINT = 1e-6


def estimate(
    motion: Motion,
    scene: Scene,
    *,
    body: Body | None = None,
    cutoff: float | None = CUTOFF,
) -> Support:
    """What holds a person up in a motion, without a simulation.

    Objects stay where they start, as static geometry would. In a result,
    `Result.people[i].support` has the moved objects and their contact impulses too.

    Args:
        motion: T frames; two have no acceleration and count as slow.
        scene: Its surfaces and gravity. Without any surface there is no support: all of the
            required wrench is residual.
        body: The person; None: the default body.
        cutoff: Of the low-pass filter of velocities [Hz]; None: no filter.

    Raises:
        InputError: No motion, scene or body, or an impossible cut-off.
        MismatchError: Motion and body belong to different models.
    """
    from halfphysics.body.match import check_match
    from halfphysics.results.argument_checks import checked_body, checked_motion, given_scene

    motion, scene, body = checked_motion(motion), given_scene(scene), checked_body(body)
    check_match(motion, body)
    names = (*scene.statics, *scene.objects, *_links(scene), "person")
    tracks = {name: _start(scene, name) for name in _links(scene)}
    alone = Surroundings(scene=scene, tracks=tracks, names=names, contacts=None)
    return support_of(motion, body, alone, cutoff)


def support_of(
    motion: Motion,
    body: Body,
    around: Surroundings,
    cutoff: float | None = CUTOFF,
) -> Support:
    """The support of a person among known surroundings."""
    if cutoff is not None:
        cutoff = number(cutoff, "support: cutoff", above=0.0, unit="Hz")
    scene = around.scene
    clock = Stopwatch(logger)
    count, gravity = len(motion), np.array(scene.gravity)
    me = around.first_person + around.person
    names = tuple(name for i, name in enumerate(around.names) if i != me)
    contacts = Contacts.none() if around.contacts is None else around.contacts
    givers = givers_of(scene, around.names, me)
    surfaces = surfaces_of(scene, around.tracks, around.names, around.contacts, count)
    places = find_patches(body, motion, surfaces)
    mine = contacts, around.person, givers, count
    found = dynamics(body, motion, gravity, cutoff, _carried(places, touched_frames(*mine)))
    external, sides = known_wrenches(*mine, motion.fps, cutoff, runs(found.airborne))
    pelvis = found.joints[:, 0]
    external[..., 3:] -= np.cross(pelvis[:, None], external[..., :3])
    required = found.wrench.sum(axis=1) - external.sum(axis=1)
    arm = places.position - pelvis[places.frame]
    force = spread(required, places.frame, arm, places.normal, places.friction, places.ready)
    acting = np.concatenate([force, np.cross(arm, force)], axis=1)
    external += sums(acting, places.frame * N_JOINTS + places.part, (count, N_JOINTS))
    torque = joint_torques(found, external)
    weight = found.mass * float(np.linalg.norm(gravity))
    pressure = _pressure(places, force, surfaces, names, weight)
    known = [names.index(around.names[i]) for i in givers]
    total, cop = _by_name(pressure, sides, known, (count, len(names)))
    clock.done("estimated the support of %d frames", count, count=count)
    return Support(
        fps=motion.fps,
        mass=found.mass,
        gravity=gravity,
        names=names,
        force=total,
        cop=cop,
        pressure=pressure,
        torque=torque,
        power=joint_power(found, torque),
        residual=(found.wrench - external).sum(axis=1),
        required=required,
        airborne=found.airborne,
        com=found.centre,
        momentum=found.momentum,
        angular_momentum=found.angular_momentum,
        cutoff=cutoff,
    )


def _links(scene: Scene) -> list[str]:
    return [name for item in scene.articulated.values() for name in item.link_names]


def _start(scene: Scene, name: str) -> Any:
    """The pose of a link at the start."""
    from types import SimpleNamespace

    from halfphysics.scene.articulated import start_poses

    for item in scene.articulated.values():
        if name in item.link_names:
            position, quaternion = start_poses(item)[item.link_names.index(name)]
            return SimpleNamespace(position=position, quaternion=quaternion)
    raise KeyError(name)


def _carried(places: Patches, touched: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Frames (T,) in which something could carry, or acts (`touched`)."""
    near = np.zeros(len(touched), dtype=bool)
    near[places.frame[places.ready > CARRIES]] = True
    return near | touched


def _pressure(
    places: Patches,
    force: Array,
    surfaces: list[Surface],
    names: tuple[str, ...],
    weight: float,
) -> Pressure:
    """The places that carry, with the names that people look for."""
    index = np.array([names.index(surface.name) for surface in surfaces], dtype=np.int64)
    rows = np.flatnonzero(np.linalg.norm(force, axis=1) > FAINT * weight)
    return Pressure(
        frame=places.frame[rows],
        vertex=places.vertex[rows],
        part=places.part[rows],
        surface=index[places.surface[rows]] if len(rows) else np.zeros(0, dtype=np.int64),
        position=places.position[rows],
        normal=places.normal[rows],
        force=force[rows],
    )


def _by_name(
    pressure: Pressure, sides: Array, givers: list[int], shape: tuple[int, int]
) -> tuple[Array, Array]:
    """Forces (T, S, 3) [N] and centres of pressure (T, S, 3) [m], nan where there is no force."""
    force, moment, size = np.zeros((*shape, 3)), np.zeros((*shape, 3)), np.zeros(shape)
    force[:, givers] = sides[..., :3]
    moment[:, givers] = sides[..., 3:6]
    size[:, givers] = sides[..., 6]
    pushes = np.einsum("ni,ni->n", pressure.force, pressure.normal)[:, None]
    values = np.concatenate([pressure.force, pushes * pressure.position, pushes], axis=1)
    found = sums(values, pressure.frame * shape[1] + pressure.surface, shape)
    force += found[..., :3]
    moment += found[..., 3:6]
    size += found[..., 6]
    some = size > 0.0
    return force, np.where(some[..., None], moment / np.where(some, size, 1.0)[..., None], np.nan)
