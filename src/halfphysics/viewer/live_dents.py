"""Dents of soft things in a running simulation, frame by frame.

Nobody knows yet where something will press, so the whole of a soft thing has short edges from the
start; in a playground they are longer than in a recorded result, so that a frame takes few
milliseconds.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.results.dents import LEAST, Dent, Recovery, layer_of
from halfphysics.results.layer_rows import rows_of
from halfphysics.results.result import ObjectTrack
from halfphysics.viewer.dents import own_vertices

if TYPE_CHECKING:
    from halfphysics.results.soft_contacts import SoftContacts
    from halfphysics.scene.items import Object, Static
    from halfphysics.scene.scene import Scene
    from halfphysics.viewer.stage import Stage

Array = NDArray[np.float64]

#: Most vertices of a soft thing: some 10 ms a frame on one core.
MOST_VERTICES = 5_000


def unpressed(scene: Scene) -> dict[str, Dent]:
    """Name -> dent of every soft static and object of a scene, with nothing pressed."""
    found = {}
    items: dict[str, Static | Object] = {**scene.statics, **scene.objects}
    for name, item in items.items():
        if item.soft is not None:
            layer = layer_of(item, item.soft).finer(None, MOST_VERTICES)
            every = np.arange(len(layer.surface))
            depth = np.zeros((1, len(every)), dtype=np.float32)
            found[name] = Dent(name=name, layer=layer, vertices=every, depth=depth)
    return found


class LiveDents:
    """The soft things of a stage, which dent as a simulation goes on.

    Args:
        stage: The stage of a drawing whose result has the dents of `unpressed`, without followers
            of its own for them (`dents=False`).
        scene: The scene.
        names: Statics, objects, people, as in `Result.names`.
        seconds: From one frame to the next [s].
    """

    def __init__(self, stage: Stage, scene: Scene, names: tuple[str, ...], seconds: float) -> None:
        self._scene, self._names = scene, names
        self._things: list[tuple[int, Dent, Any, Any, Recovery]] = []
        items: dict[str, Static | Object] = {**scene.statics, **scene.objects}
        for node in stage.soft_items():
            layer = items[node.dent.name].soft
            if layer is not None:
                back = Recovery(layer, seconds, len(node.dent.vertices))
                own = own_vertices(node.surface, node.handle)
                index = names.index(node.dent.name)
                self._things.append((index, node.dent, own, node.handle, back))
        self._flat = [True] * len(self._things)

    def __len__(self) -> int:
        """Number of soft things."""
        return len(self._things)

    def show(
        self,
        contacts: SoftContacts | None,
        objects: Mapping[str, tuple[Array, Array]],
        frames: int = 1,
    ) -> None:
        """Show what presses now.

        Args:
            contacts: Of the frame, as `Frame.soft_contacts`.
            objects: Name -> position (3,) [m] and quaternion (4,), as `Frame.objects`.
            frames: Frames since the last one that was shown.
        """
        if contacts is None:
            return
        now = dataclasses.replace(contacts, frame=np.zeros(len(contacts), dtype=np.int64))
        tracks = {
            name: ObjectTrack(position=np.asarray(p)[None], quaternion=np.asarray(q)[None])
            for name, (p, q) in objects.items()
        }
        moment: Any = SimpleNamespace(scene=self._scene, names=self._names, objects=tracks)
        for k, (index, dent, own, handle, back) in enumerate(self._things):
            rows = rows_of(moment, now, index)
            layer = dent.layer
            some = (rows.depth > 0.0) & layer.facing(rows.position, rows.normal)
            rows = rows[some]
            pressed = layer.pressed(rows.position, rows.normal, rows.depth)
            w = back.after(layer.depths(pressed), frames)
            flat = bool((w < LEAST).all())
            if not (flat and self._flat[k]):
                depth = np.where(w < LEAST, 0.0, w)
                handle.vertices = layer.at(depth)[own].astype(np.float32)
            self._flat[k] = flat
