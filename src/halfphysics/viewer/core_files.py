"""The core for browsers, as it goes into a page."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from halfphysics.simulation.simulator import Simulator


def core_script() -> str:
    """The script that defines `HalfPhysics`."""
    raise NotImplementedError


def world_data(simulator: Simulator) -> dict[str, Any]:
    """WebAssembly and compiled world, deflated, in base64."""
    raise NotImplementedError
