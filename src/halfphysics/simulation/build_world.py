"""From people and a scene to a world: the steps of building the core, in their order."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from halfphysics.motion.joint_groups import stiffness_array
from halfphysics.scene import articulated as jointed
from halfphysics.scene.trajectories import KinematicObject
from halfphysics.simulation.collision_shapes import ShapeTable, add_shapes
from halfphysics.simulation.compiled_model import armature_of, joint_arrays, model_arrays
from halfphysics.simulation.coordinates import FreeObject, Person
from halfphysics.simulation.core_settings import set_footing, set_limits, set_settings
from halfphysics.simulation.holding import HeldObject
from halfphysics.simulation.joined_model import join_model
from halfphysics.simulation.names import Names
from halfphysics.simulation.pairing import set_pairings
from halfphysics.simulation.self_contact import set_self_pairs
from halfphysics.simulation.world import World

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.scene.scene import Scene
    from halfphysics.settings import Settings
    from halfphysics.simulation.holding import Hold


def build_world(
    bodies: Sequence[Body],
    scene: Scene,
    settings: Settings,
    held: Mapping[str, Hold] | None = None,
    *,
    core: Any = None,
) -> World:
    """Put people and a scene into a core of their own.

    Args:
        bodies: The people's bodies.
        scene: Statics, objects and articulated objects.
        settings: What the core is made for.
        held: Name of an object -> how a person holds it; None: nothing is held.
        core: What takes the place of the native stepper; None: a new one.

    Raises:
        InputError: An item of the scene is named like a person.
    """
    from halfphysics import _native

    held = dict(held or {})
    names = Names.of(scene, len(bodies))
    stiffness = stiffness_array(settings.stiffness, "Settings.stiffness")
    model = join_model(bodies, names.people, scene, held, armature_of(stiffness))
    places = _places(model, bodies, scene, names, held)
    core = _native.Stepper() if core is None else core
    shapes = _fill(core, model, scene, settings, names, places)
    shape_name, shape_part, static_name = shapes.arrays
    if settings.self_contact:
        own = [np.where(shape_name == names.index(n), shape_part, -1) for n in names.people]
        set_self_pairs(core, model, places.people, own)
    return World(
        bodies=tuple(bodies),
        scene=scene,
        settings=settings,
        held=held,
        made_of=scene._copied(),
        called=names,
        joined=model,
        stepper=core,
        stiffness=stiffness,
        shape_name=shape_name,
        shape_part=shape_part,
        static_name=static_name,
        **vars(places),
    )


@dataclass(frozen=True)
class _Places:
    """Where everything stands in the coordinates; attributes as those of `World`."""

    people: tuple[Person, ...]
    objects: tuple[FreeObject | HeldObject, ...]
    links: tuple[jointed.LinkPlace, ...]
    joints: tuple[jointed.JointPlace, ...]


def _places(
    model: Any, bodies: Sequence[Body], scene: Scene, names: Names, held: Mapping[str, Hold]
) -> _Places:
    people = tuple(
        Person.of(model, f"{name}/", name, body)
        for name, body in zip(names.people, bodies, strict=True)
    )
    objects = tuple(
        HeldObject(item.name, np.array(item.com), people[held[name].person], held[name])
        if name in held
        else FreeObject.of(model, item)
        for name, item in scene.objects.items()
    )
    found = [jointed.places(model, item) for item in scene.articulated.values()]
    links = tuple(link for links, _ in found for link in links)
    return _Places(people, objects, links, tuple(joint for _, joints in found for joint in joints))


def _fill(
    core: Any, model: Any, scene: Scene, settings: Settings, names: Names, places: _Places
) -> ShapeTable:
    """Give the core its model, shapes, pairs, settings and trajectories.

    The order matters: `finish` makes the drives of the people, which limits belong to.
    """
    core.set_model(**model_arrays(model))
    core.set_joint_forces(**joint_arrays(model))
    shapes = add_shapes(core, model, scene, settings, names, places.people, places.links)
    set_pairings(core, scene, settings, names)
    set_settings(core, settings, scene.gravity)
    core.set_prescribed(int(settings.drive.poses))
    for place, item in zip(places.objects, scene.objects.values(), strict=True):
        body = model.body(f"object/{item.name}").id
        if isinstance(item, KinematicObject):
            core.add_trajectory(body, item.fps, item.loop, item.positions, item.quaternions)
        elif item.start == "asleep" and isinstance(place, FreeObject):
            core.start_asleep(body)
    core.finish([person.root for person in places.people])
    set_limits(core, settings, places.people)
    set_footing(core, settings, places.people)
    return shapes
