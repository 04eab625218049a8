"""A world compiled into one file, for programs that have no Python (docs/c-api.md)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.errors import InputError
from halfphysics.results.argument_checks import checked_bodies, checked_scene, checked_settings
from halfphysics.scene.articulated import SIZES
from halfphysics.scene.trajectories import KinematicObject
from halfphysics.simulation.build_world import build_world
from halfphysics.simulation.call_recorder import CallRecorder
from halfphysics.simulation.coordinates import FreeObject
from halfphysics.simulation.pairing import friction_rows
from halfphysics.simulation.world_file import world_bytes

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.scene.scene import Scene
    from halfphysics.settings import Settings
    from halfphysics.simulation.holding import Hold
    from halfphysics.simulation.world import World

Array = NDArray[np.float64]

#: What a world file may ask for: its reader waits for every frame, and a file may be a stranger's
#: (src/native/compiled/world_check.cpp has the same).
MOST_SUBSTEPS, MOST_SWEEPS = 1_000, 10_000


def compile_world(
    scene: Scene | None = None,
    *,
    body: Body | Sequence[Body] | None = None,
    settings: Settings | None = None,
) -> bytes:
    """The bytes of a world file: people and a scene, for the C library and the browser.

    What `Simulator` would be made of, in one piece: `hp_world_load` of `halfphysics.h` and
    `core.world` of the npm package simulate it with the same numbers. The bytes contain the skin of
    each person's body: share those of a licensed body model only as its licence allows.

    Args:
        scene: Statics and objects; None: an empty one.
        body: The person's body, or a sequence for several people (empty: objects alone); None:
            `Body.default()`.
        settings: See `Settings`.

    Raises:
        InputError: An impossible value; settings of a baseline that runs in Python.
    """
    bodies, scene, settings = checked_bodies(body), checked_scene(scene), checked_settings(settings)
    if settings.drive.follow is not None:
        raise InputError(
            f"settings: the baseline {type(settings).__name__} runs in Python only; expected "
            "halfphysics.Settings or another baseline"
        )
    return _compiled(bodies, scene, settings, {}, [np.eye(3)] * len(bodies))


def compiled_again(world: World, axes: Sequence[Array]) -> bytes:
    """The bytes of a world file of a simulator's world, with the axes of its people's poses."""
    return _compiled(world.bodies, world.made_of, world.settings, world.held, axes)


def _compiled(
    bodies: Sequence[Body],
    scene: Scene,
    settings: Settings,
    held: Mapping[str, Hold],
    axes: Sequence[Array],
) -> bytes:
    from halfphysics import _native

    for what, value, most in (
        ("substeps", settings.substeps or 0, MOST_SUBSTEPS),
        ("max_sweeps", settings.max_sweeps, MOST_SWEEPS),
    ):
        if value > most:
            raise InputError(
                f"settings: found {what}={value}, expected at most {most:,} in a world file. "
                "Shorter frames need fewer substeps"
            )
    recorder = CallRecorder(_native.Stepper(), scene)
    world = build_world(bodies, scene, settings, held, core=recorder)
    _label(recorder, world, axes)
    return world_bytes(recorder.calls)


def _label(recorder: CallRecorder, world: World, axes: Sequence[Array]) -> None:
    """Add what the numbers of a world stand for (src/native/compiled/labels.h)."""
    recorder.keep(
        "label_everything",
        names="".join(f"{name}\0" for name in world.names),
        shape_name=world.shape_name,
        shape_part=world.shape_part,
        static_name=world.static_name,
    )
    for person, its in zip(world.people, axes, strict=True):
        pelvis = person.body.rest_joints[0]
        recorder.keep(
            "label_person",
            name=person.name,
            root=person.root,
            qpos=person.qpos,
            joint_qpos=person.joint_qpos,
            body=person.bodies,
            ball=person.balls,
            rest_pelvis=pelvis,
            axes=its,
            pelvis=its @ pelvis,
            stiffness=world.stiffness,
        )
    _label_items(recorder, world)
    qpos, qvel = np.zeros(world.nq), np.zeros(world.nv)
    world.place_objects(qpos, qvel)
    substeps = world.settings.substeps or 0
    recorder.keep("label_start", qpos=qpos, qvel=qvel, substeps=substeps)
    own, apart = friction_rows(world.made_of, world.called)
    recorder.keep("label_friction", own=own, pair=apart.ravel())


def _label_items(recorder: CallRecorder, world: World) -> None:
    for place, item in zip(world.objects, world.made_of.objects.values(), strict=True):
        pushable = isinstance(place, FreeObject) and not isinstance(item, KinematicObject)
        recorder.keep(
            "label_object",
            name=place.name,
            body=world.joined.body(f"object/{place.name}").id,
            qpos=place.qpos if isinstance(place, FreeObject) else -1,
            dof=place.dof if isinstance(place, FreeObject) else -1,
            com=place.com,
            inertia=np.asarray(item.inertia if pushable else np.eye(3), dtype=np.float64),
            pushable=pushable,
        )
    for articulated in world.made_of.articulated.values():
        for i, name in enumerate(articulated.link_names):
            body = world.joined.body(f"articulated/{articulated.name}/{i}").id
            recorder.keep("label_link", name=name, body=body)
    for joint in world.joints:
        width = SIZES[joint.joint.kind][0]
        recorder.keep("label_joint", name=joint.name, qpos=joint.qpos, width=width)
