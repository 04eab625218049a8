"""The lights of a viser scene: a sky, a key light with soft shadows that follows people, a fill."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.render.look import FILL, KEY, Direction, turned
from halfphysics.viewer.bones import GRAIN

Array = NDArray[np.float64]

#: Node at the people's middle: the key light hangs on it, and a page's camera follows it.
SUBJECT = "/subject"

# viser's environment map bleaches colours, and its own lights draw three shadow maps a frame: a
# browser without a graphics card needs seconds for the first picture.
_SKY, _GROUND, _SKY_STRENGTH = (255, 255, 255), (150, 146, 142), 2.2
_KEY_COLOR, _KEY_STRENGTH = (255, 248, 238), 3.7
_FILL_COLOR, _FILL_STRENGTH = (226, 236, 255), 0.55
# Distance of the key light from the people, radius of its pool of light [m], and the part of that
# radius in which the light fades. A shadow's texel is a 512th of the radius.
_AWAY, _POOL, _SOFT = 8.0, 7.5, 0.5


class Lights:
    """Lights that stand to the sides of a camera.

    Args:
        server: The viser server.
        direction: From the scene to the camera; only its horizontal part counts.
        reach: Largest horizontal distance of a person from the people's middle [m].
    """

    def __init__(
        self, server: Any, direction: Direction = (0.0, -1.0, 0.0), reach: float = 0.0
    ) -> None:
        towards = (float(direction[0]), float(direction[1]))
        scene = server.scene
        scene.configure_environment_map(hdri=None)
        scene.configure_default_lights(enabled=False)
        scene.add_light_hemisphere(
            "/light/sky",
            sky_color=_SKY,
            ground_color=_GROUND,
            intensity=_SKY_STRENGTH,
            position=(0.0, 0.0, 1.0),
        )
        scene.add_light_directional(
            "/light/fill",
            color=_FILL_COLOR,
            intensity=_FILL_STRENGTH,
            position=tuple(10.0 * c for c in turned(FILL, towards)),
        )
        self._subject = scene.add_frame(SUBJECT, show_axes=False)
        key = np.array(turned(KEY, towards))
        key /= np.linalg.norm(key)
        scene.add_light_spot(
            f"{SUBJECT}/key",
            color=_KEY_COLOR,
            intensity=_KEY_STRENGTH,
            position=tuple(_AWAY * key),
            direction=tuple(-key),
            angle=math.atan2(_POOL + reach, _AWAY),
            penumbra=_SOFT,
            decay=0.0,
            cast_shadow=True,
        )

    def follow(self, point: Array) -> None:
        """Move the key light to people around a point (3,) [m]."""
        now = np.round(np.asarray(point) / GRAIN) * GRAIN
        if (now != self._subject.position).any():
            self._subject.position = now
