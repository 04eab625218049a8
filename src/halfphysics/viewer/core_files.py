"""The core for browsers, as it goes into a page: its program, its script, a compiled world."""

from __future__ import annotations

import base64
import re
import zlib
from collections.abc import Sequence
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING

from halfphysics.errors import FileError
from halfphysics.simulation.compile_world import compiled_again

if TYPE_CHECKING:
    from halfphysics.motion.motion import Motion
    from halfphysics.simulation.simulator import Simulator

#: The core in WebAssembly and the script that loads it, in the package's assets.
PROGRAM, SCRIPT = "core/halfphysics.wasm", "core/halfphysics.js"


@cache
def core_script() -> str:
    """The script that defines `HalfPhysics`, to be put into a script of a page.

    Raises:
        FileError: It is not installed.
    """
    text = _asset(SCRIPT).decode("utf-8")
    # A page opened from disk cannot load modules: what the module exports is in scope here.
    return re.sub(r"^export .*$", "", text, flags=re.M)


@cache
def core_program() -> str:
    """The core in WebAssembly, deflated, in base64.

    Raises:
        FileError: It is not installed.
    """
    return deflated(_asset(PROGRAM))


def compiled_world(simulator: Simulator, motions: Sequence[Motion]) -> str:
    """A simulator's world as a world file, deflated, in base64.

    Raises:
        InputError: A baseline that runs in Python.
    """
    return deflated(compiled_again(simulator.world, [motion.axes for motion in motions]))


def deflated(data: bytes) -> str:
    """Bytes as the scripts of a page inflate them."""
    return base64.b64encode(zlib.compress(data, 9)).decode("ascii")


def _asset(name: str) -> bytes:
    file = files("halfphysics").joinpath("assets", *name.split("/"))
    try:
        return file.read_bytes()
    except OSError:
        raise FileError(
            f"{file}: the core for browsers is not installed. Install halfphysics from a wheel, or "
            "build it with tools/build_wasm.sh"
        ) from None
