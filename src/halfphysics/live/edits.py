"""Changes of a scene while it runs: what clients ask for, done between two steps."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from halfphysics.errors import InputError
from halfphysics.live import bounds, schema
from halfphysics.scene.changed import changed
from halfphysics.scene.item_spec import parse_object
from halfphysics.simulation.dragging import Drag
from halfphysics.simulation.live_edits import rebuilt
from halfphysics.simulation.simulator import Simulator

Vector = tuple[float, float, float]

#: Shapes that clients may add: files are never read for them.
SHAPES = ("sphere", "box", "capsule", "cylinder")


@dataclass
class Editor:
    """Carries out edits of one simulator; used by the thread that steps.

    Attributes:
        simulator: The simulator.
        people: The people's names, as the simulator counts them.
        drags: (client, name of the object) -> its drag.
        added: Names of the objects that clients have added.
    """

    simulator: Simulator
    people: tuple[str, ...]
    drags: dict[tuple[str, str], Drag] = field(default_factory=dict)
    added: set[str] = field(default_factory=set)

    def do(self, action: schema.Action, source: str) -> bool:
        """Carry out an action of a client.

        Returns:
            Whether the items of the scene are others now.

        Raises:
            HalfPhysicsError: It is impossible; nothing has changed.
        """
        match action:
            case schema.Add():
                self._add(action)
            case schema.Remove(name=name):
                self.simulator.remove_object(name)
                self.drags = {key: drag for key, drag in self.drags.items() if key[1] != name}
                self.added.discard(name)
            case schema.Mass(name=name, value=value):
                bounds.check_mass(value, f"mass of {name!r}")
                self._change({name: value}, {})
            case schema.Friction(name=name, value=value):
                bounds.check_friction(value, f"friction of {name!r}")
                self._change({}, {name: value})
            case schema.Impulse(name=name, impulse=impulse, point=point):
                self._push(name, impulse, point)
                return False
            case schema.Stiffness(value=value, person=person):
                self.simulator.set_stiffness(value, person=self._index(person))
                return False
            case schema.Drag():
                self._drag(action, source)
                return False
        return True

    def let_go(self, source: str) -> None:
        """A client has gone: what it dragged is free."""
        self.drags = {key: drag for key, drag in self.drags.items() if key[0] != source}

    def pull(self) -> None:
        """Set the velocities of what is dragged, for the next step."""
        for drag in self.drags.values():
            drag.pull(self.simulator, self.simulator.dt)

    def _add(self, action: schema.Add) -> None:
        if len(self.simulator.world.made_of.objects) >= bounds.MOST_OBJECTS:
            raise InputError(
                f"add: found {bounds.MOST_OBJECTS} objects, expected fewer. Remove some first"
            )
        if len(self.added) >= bounds.MOST_ADDED:
            raise InputError(
                f"add: found {bounds.MOST_ADDED} objects that clients added, expected fewer. "
                "Remove some of them first"
            )
        word = action.shape.partition(":")[0].strip()
        if word not in SHAPES or "," in action.shape:
            raise InputError(
                f"add: found shape {action.shape!r}, expected one of {', '.join(SHAPES)} with its "
                "sizes, such as box:0.4:0.3:0.2"
            )
        _, shape, _ = parse_object(f"new={action.shape},mass=1")
        bounds.check_size(shape)
        bounds.check_mass(action.mass, "add: mass")
        bounds.check_place(action.position, "add: position")
        bounds.check_speed(action.velocity, "add: velocity")
        if action.friction is not None:
            bounds.check_friction(action.friction, "add: friction")
        options: dict[str, Any] = {"friction": action.friction, "restitution": action.restitution}
        world = self.simulator.world
        scene = world.made_of._copied()
        scene.add_object(
            action.name,
            shape,
            mass=action.mass,
            position=action.position,
            quaternion=action.quaternion,
            velocity=action.velocity,
            **{name: value for name, value in options.items() if value is not None},
        )
        new = rebuilt(world, scene, True)
        bounds.check_clear(new, action.name)
        self.simulator.world = new
        self.added.add(action.name)

    def _push(self, name: str, impulse: Vector, point: Vector | None) -> None:
        simulator = self.simulator
        if point is not None:
            bounds.check_place(point, "impulse: point")
        bounds.check_impulse(impulse)
        speed, spin = simulator.velocity(name)
        simulator.apply_impulse(name, impulse, point)
        fast, turning = simulator.velocity(name)
        try:
            bounds.check_speed(fast, f"impulse: speed of {name!r} after it")
            bounds.check_spin(turning, f"impulse: spin of {name!r} after it")
        except InputError:
            simulator.set_velocity(name, speed, spin)
            raise

    def _change(self, masses: dict[str, float], frictions: dict[str, float]) -> None:
        world = self.simulator.world
        self.simulator.world = rebuilt(world, changed(world.made_of, masses, frictions), True)

    def _drag(self, action: schema.Drag, source: str) -> None:
        key = (source, action.name)
        for place in (action.pointer, action.grip):
            if place is not None:
                bounds.check_place(place, "drag: position")
        if action.pointer is None:
            self.drags.pop(key, None)
        elif key in self.drags:
            self.drags[key].follow(action.pointer)
        else:
            grip = action.pointer if action.grip is None else action.grip
            self.drags[key] = Drag.begin(self.simulator, action.name, grip, action.pointer)

    def _index(self, person: str | None) -> int | None:
        if person is None:
            return None
        if person not in self.people:
            raise InputError(
                f"stiffness: found person {person!r}, expected one of {', '.join(self.people)}"
            )
        return self.people.index(person)
