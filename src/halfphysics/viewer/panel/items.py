"""The part of the panel with the knobs of a scene's objects: mass and friction."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from halfphysics.scene.changed import mass_of, movable
from halfphysics.viewer import session as do
from halfphysics.viewer.panel.controls import LIVE, Controls, turn


class ItemKnobs:
    """Knobs of one object of the scene, and the choice of the object if there are several.

    Attributes:
        folder: The folder of these controls in the panel.
        mass, friction: Handles of viser, for the last scenario with objects.
    """

    def __init__(
        self,
        gui: Any,
        session: do.Session,
        controls: Controls,
        choose: Callable[[Callable[[], None]], None],
    ) -> None:
        """`choose` runs a task in the playground's thread and rebuilds the controls."""
        self._gui, self._session, self._controls = gui, session, controls
        self._choose = choose
        self._name = ""
        self.folder = gui.add_folder("Objects")

    def add(self) -> list[Any]:
        """Build the controls of the present scene; returns their handles."""
        objects = movable(self._session.sequence.scene)
        names = tuple(objects)
        self.folder.visible = bool(names)
        self.folder.label = "Objects" if len(names) != 1 else f"Object: {names[0]}"
        if not names:
            return []
        if self._name not in names:
            self._name = names[0]
        item = objects[self._name]
        mass, handles = mass_of(item), []
        with self.folder:
            if len(names) > 1:
                which = self._gui.add_dropdown("Which", names, initial_value=self._name)
                which.on_update(self._other)
                handles.append(which)
            self.mass = self._gui.add_slider(
                "Mass [kg]",
                min(0.01, mass),
                max(200.0, 20.0 * mass),
                0.01,
                mass,
                hint="Type small ones. " + LIVE,
            )
            self._controls.bind(self.mass, self._mass, turn("masses", self._name))
            self.friction = self._gui.add_slider(
                "Friction", 0.0, 2.0, 0.01, min(item.friction, 2.0), hint=LIVE
            )
            self._controls.bind(self.friction, self._friction, turn("frictions", self._name))
        return [*handles, self.mass, self.friction]

    def _other(self, event: Any) -> None:
        def task() -> None:
            self._name = event.target.value

        if event.client_id is not None:
            self._choose(task)

    def _mass(self) -> float:
        return mass_of(movable(self._session.simulator.world.scene)[self._name])

    def _friction(self) -> float:
        return float(movable(self._session.simulator.world.scene)[self._name].friction)
