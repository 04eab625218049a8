"""What holds people up, in the scene: pressure on the skin, forces, and where the weight is.

All of it comes from `PersonResult.support`, which needs the whole motion: it is worked out once,
when the overlay is first shown, and a running simulation has none.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.render.rasterizer import Color
from halfphysics.support.skin_grid import PITCH
from halfphysics.support.support import UNSUPPORTED, Support
from halfphysics.viewer.batches import Arrows, Batch, Copies, ball, disc
from halfphysics.viewer.coloring import RAMP

if TYPE_CHECKING:
    from halfphysics.viewer.stage import Stage

Array = NDArray[np.float64]

#: Pressures at which a disc on the skin changes its colour, one of `coloring.RAMP` [Pa].
BOUNDS = (2e3, 8e3, 30e3)
#: Colours of forces that surfaces exert, of what nothing supplies, of the centre of pressure and of
#: the centre of mass.
FORCE: Color = (0.10, 0.16, 0.50)
MISSING: Color = (0.88, 0.10, 0.10)
PRESSURE: Color = (1.00, 0.78, 0.05)
MASS: Color = (0.08, 0.08, 0.10)

#: Length of an arrow per force [m/N], its shortest and its longest [m]. Linear, unlike the arrows
#: of contacts: a foot that carries 60 kg has an arrow of 59 cm, one that carries half of 29 cm.
SCALE, SHORTEST, LONGEST = 1e-3, 0.06, 2.0
#: Smaller forces have no arrow [N].
LEAST = 5.0

#: Meanings of the colours, as the legends have them.
KEY: tuple[tuple[Color, str], ...] = (
    (FORCE, "supporting force"),
    (MISSING, "force that nothing supplies"),
    (PRESSURE, "centre of pressure"),
    (MASS, "centre of mass"),
)

# Radius and height of a disc, for one of the skin's squares; distance from the surface [m].
_DISC, _HEIGHT, _ABOVE = 0.45 * PITCH, 0.002, 0.002
_THICK = 1.6  # arrows, compared with those of contacts
_COP, _COM, _PLUMB = 0.018, 0.03, 0.022  # radii [m]


@dataclass(frozen=True, kw_only=True, eq=False)
class FrameSupport:
    """What holds people up in one frame, in the world frame.

    Attributes:
        position: Points where surfaces press on the skin (n, 3) [m].
        normal: Unit vectors from the surface into the body (n, 3).
        pressure: Pressure there (n,) [Pa].
        forces: Starts (centres of pressure) and ends of arrows, one per surface and person
            (m, 2, 3) [m].
        missing: Starts (centres of mass) and ends of arrows of what nothing supplies (k, 2, 3) [m].
        cop: Centre of pressure of each person who has one (a, 3) [m].
        com: Centre of mass of each person (p, 3) [m].
        plumb: The point under (over) the centre of mass at the height of the centre of pressure,
            while in flight between the last and the next (b, 3) [m].
    """

    position: Array
    normal: Array
    pressure: Array
    forces: Array
    missing: Array
    cop: Array
    com: Array
    plumb: Array


class SupportFrames:
    """The support of all people of a result by frame.

    Args:
        supports: The support of each person.
    """

    def __init__(self, supports: Sequence[Support]) -> None:
        self._supports = supports
        self._rows = [
            np.searchsorted(support.pressure.frame, np.arange(len(support) + 1))
            for support in supports
        ]
        self._plumb = [_plumb(support) for support in supports]

    def at(self, frame: int) -> FrameSupport:
        """The support at a frame."""
        forces, starts, residuals, masses = [], [], [], []
        for support in self._supports:
            forces.append(support.force[frame])
            starts.append(support.cop[frame])
            residual = support.residual[frame, :3]
            if np.linalg.norm(residual) > UNSUPPORTED * support.weight:
                residuals.append(residual)
                masses.append(support.com[frame])
        position, normal, force = (self._pressed(name, frame) for name in _COLUMNS)
        return FrameSupport(
            position=position,
            normal=normal,
            pressure=np.maximum(np.einsum("ni,ni->n", force, normal), 0.0) / PITCH**2,
            forces=_arrows(np.concatenate(starts), np.concatenate(forces)),
            missing=_arrows(np.reshape(masses, (-1, 3)), np.reshape(residuals, (-1, 3))),
            cop=_known([support.total_cop[frame] for support in self._supports]),
            com=np.array([support.com[frame] for support in self._supports]),
            plumb=_known([points[frame] for points in self._plumb]),
        )

    def _pressed(self, column: str, frame: int) -> Array:
        """A column of the pressure tables of all people at a frame."""
        return np.concatenate(
            [
                getattr(support.pressure, column)[rows[frame] : rows[frame + 1]]
                for support, rows in zip(self._supports, self._rows, strict=True)
            ]
        )


_COLUMNS = ("position", "normal", "force")


def level(pressure: Array) -> Any:
    """Index into `RAMP` for pressures [Pa]."""
    return np.searchsorted(BOUNDS, pressure, side="right")


def _arrows(starts: Array, forces: Array) -> Array:
    """Arrows (m, 2, 3) [m] of the forces (n, 3) [N] that are large enough and have a start."""
    size = np.linalg.norm(forces, axis=1)
    some = (size >= LEAST) & np.isfinite(starts).all(axis=1)
    length = np.clip(SCALE * size[some], SHORTEST, LONGEST)
    along = forces[some] / size[some, None] * length[:, None]
    return np.stack([starts[some], starts[some] + along], axis=1)


def _known(points: Sequence[Array]) -> Array:
    """Of points (3,) those that exist (n, 3)."""
    stacked = np.reshape(points, (-1, 3))
    return stacked[np.isfinite(stacked).all(axis=1)]


def _plumb(support: Support) -> Array:
    """Centres of mass moved to the height of the centre of pressure (T, 3) [m]; nan: no height."""
    up = support.up
    height = support.total_cop @ up
    there = np.flatnonzero(np.isfinite(height))
    if not len(there):
        return np.full((len(support), 3), np.nan)
    ground = np.interp(np.arange(len(support)), there, height[there])
    result: Array = support.com + (ground - support.com @ up)[:, None] * up
    return result


class SupportOverlay:
    """Nodes of the support of a result; hidden until it is made visible.

    Args:
        server: The viser server.
        stage: The stage of the result; it calls `show` from then on.

    Attributes:
        frames: The support by frame; None: not worked out yet.
        discs: Discs on the skin, one node per colour of `RAMP`.
        forces, missing: Arrows of what surfaces supply, and of what nothing supplies.
        points: Balls and discs at the centres of pressure and of mass, and plumb of the latter.
    """

    def __init__(self, server: Any, stage: Stage) -> None:
        self._result = stage.drawing.result
        self.frames: SupportFrames | None = None

        def path(name: str) -> str:
            return stage.path(f"support/{name}")

        pressed = disc(_DISC, _HEIGHT)
        self.discs = [
            Copies(server, path(f"pressure-{k}"), pressed, color) for k, color in enumerate(RAMP)
        ]
        self.forces = Arrows(server, path("forces"), FORCE, _THICK)
        self.missing = Arrows(server, path("missing"), MISSING, _THICK)
        self.points = {
            "cop": Copies(server, path("centre-of-pressure"), ball(_COP), PRESSURE),
            "com": Copies(server, path("centre-of-mass"), ball(_COM), MASS),
            "plumb": Copies(server, path("plumb"), disc(_PLUMB, 0.004), MASS),
        }
        self._visible = False
        self._frame = -1
        stage.followers.append(self.show)

    @property
    def visible(self) -> bool:
        """Whether the support is drawn. If not, nothing is sent."""
        return self._visible

    @visible.setter
    def visible(self, visible: bool) -> None:
        if visible and self.frames is None:
            self.frames = SupportFrames([person.support for person in self._result.people])
        self._visible = visible
        if visible and self._frame >= 0:
            self.show(self._frame)
        elif not visible:
            nodes: list[Batch] = [*self.discs, self.forces, self.missing, *self.points.values()]
            for node in nodes:
                node.hide()

    def show(self, frame: int) -> None:
        """Draw the support at a frame."""
        self._frame = frame
        if not self._visible or self.frames is None:
            return
        here = self.frames.at(frame)
        steps, turns = level(here.pressure), _facing(here.normal)
        # On the side of the skin, or the surface would hide it.
        position = here.position + _ABOVE * here.normal
        for step, discs in enumerate(self.discs):
            discs.show(position[steps == step], turns[steps == step])
        self.forces.show(here.forces)
        self.missing.show(here.missing)
        self.points["cop"].show(here.cop)
        self.points["com"].show(here.com)
        self.points["plumb"].show(here.plumb)


def _facing(normals: Array) -> Array:
    """Quaternions wxyz (n, 4) that turn the z axis to unit vectors (n, 3), the shortest way."""
    quaternions = np.stack(
        [1.0 + normals[:, 2], -normals[:, 1], normals[:, 0], np.zeros(len(normals))], axis=1
    )
    # Straight down there is no shortest way: half a turn about the x axis.
    down = quaternions[:, 0] < 1e-9
    quaternions[down] = [0.0, 1.0, 0.0, 0.0]
    result: Array = quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True)
    return result
