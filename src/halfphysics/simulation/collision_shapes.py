"""Collision shapes of people and scene, handed to the core.

The core numbers the shapes that move (of people, objects, links) and those of static geometry in
the order in which they are added; the table says what each of them belongs to.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.geometry.colliders import convex_collider
from halfphysics.geometry.shapes import Mesh, Plane
from halfphysics.simulation.mesh_trees import mesh_tree
from halfphysics.simulation.person_shapes import add_person_shapes
from halfphysics.simulation.soft_shapes import (
    anything_soft,
    set_link_samples,
    set_soft_piece,
    set_soft_static,
)

if TYPE_CHECKING:
    from halfphysics.scene.articulated import Articulated, LinkPlace
    from halfphysics.scene.items import Object, Static
    from halfphysics.scene.scene import Scene
    from halfphysics.settings import Settings
    from halfphysics.simulation.coordinates import Person
    from halfphysics.simulation.names import Names

Ints = NDArray[np.int64]


@dataclass
class ShapeTable:
    """What the core's shapes belong to.

    Attributes:
        name: Of every shape that moves: index into the names of everything.
        part: Of every shape that moves: joint index of a person's part, else -1.
        static_name: Of every shape of static geometry: index into the names of everything.
    """

    name: list[int] = field(default_factory=list)
    part: list[int] = field(default_factory=list)
    static_name: list[int] = field(default_factory=list)

    @property
    def arrays(self) -> tuple[Ints, Ints, Ints]:
        """`name`, `part` and `static_name` as arrays."""
        name, part, static = (
            np.array(column, dtype=np.int64) for column in (self.name, self.part, self.static_name)
        )
        return name, part, static


def add_shapes(
    core: Any,
    model: Any,
    scene: Scene,
    settings: Settings,
    names: Names,
    people: Sequence[Person],
    links: Sequence[LinkPlace],
) -> ShapeTable:
    """Add all shapes to the core: of people, objects and links, then of static geometry."""
    table, soft = ShapeTable(), anything_soft(scene, settings)
    for index, person in enumerate(people):
        parts = add_person_shapes(
            core,
            model,
            person.body,
            settings,
            prefix=f"{person.name}/",
            index=index,
            row=partial(names.row_of_part, person.name),
            sampled=soft,
        )
        table.name += [names.index(person.name)] * len(parts)
        table.part += parts
    for item in scene.objects.values():
        _add_object(core, model, item, names.index(item.name), table, soft)
    for articulated in scene.articulated.values():
        _add_links(core, model, articulated, names, table, soft)
    for index, static in enumerate(scene.statics.values()):
        _add_static(core, static, index)
        set_soft_static(core, static)
        table.static_name.append(index)
    places = {link.name: link for link in links}
    for articulated in scene.articulated.values():
        _add_fixed_links(core, model, articulated, names, places, table)
    return table


def _add_object(
    core: Any, model: Any, item: Object, index: int, table: ShapeTable, soft: bool
) -> None:
    body, cut = model.body(f"object/{item.name}").id, item.decomposition
    for number, piece in enumerate(item.pieces):
        collider = convex_collider(piece).moved(np.eye(3), -np.array(item.com))
        core.add_shape(body, index, -1, -1, *collider.arrays)
        if cut is not None:
            core.set_slack(1e-3 * cut.outside_mm)
        if soft:
            set_soft_piece(core, item, number)
        table.name.append(index)
        table.part.append(-1)


def _add_links(
    core: Any,
    model: Any,
    articulated: Articulated,
    names: Names,
    table: ShapeTable,
    soft: bool,
) -> None:
    for i, link in enumerate(articulated.links):
        body = model.body(f"articulated/{articulated.name}/{i}").id
        index = names.index(articulated.link_names[i])
        for geom in () if link.fixed else link.geoms:
            core.add_shape(body, index, -1, -1, *geom.collider().arrays)
            if soft:
                set_link_samples(core, geom)
            table.name.append(index)
            table.part.append(-1)


def _add_static(core: Any, static: Static, index: int) -> None:
    rotation = rot.to_matrix(static.quaternion)
    position = np.asarray(static.position, dtype=np.float64)
    shape = static.frame
    if isinstance(shape, Plane):
        normal = rotation @ np.asarray(shape.normal, dtype=np.float64)
        core.add_half_space(index, normal, shape.offset + float(normal @ position))
    elif isinstance(shape, Mesh):
        core.add_mesh(index, mesh_tree(static, rotation, position))
    else:
        core.add_hull(index, *convex_collider(shape).moved(rotation, position).arrays)


def _add_fixed_links(
    core: Any,
    model: Any,
    articulated: Articulated,
    names: Names,
    places: dict[str, LinkPlace],
    table: ShapeTable,
) -> None:
    """Links that no joint moves are static geometry."""
    for link, name in zip(articulated.links, articulated.link_names, strict=True):
        if not link.fixed:
            continue
        position, quaternion = places[name].pose(np.zeros(model.nq))
        rotation = rot.to_matrix(quaternion)
        for geom in link.geoms:
            collider = geom.collider().moved(rotation, position)
            core.add_hull(names.index(name), *collider.arrays)
            table.static_name.append(names.index(name))
