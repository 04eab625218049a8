# Written by tools/make_stubs.py. Arrays are C-contiguous; their shapes are
# noted where they are fixed: `*` is any length.
"""Rasteriser of halfphysics."""

from typing import Annotated, Any

import numpy
from numpy.typing import NDArray


def picture(
    vertices: Annotated[NDArray[numpy.float64], "(*, 3)"],
    faces: Annotated[NDArray[numpy.int32], "(*, 3)"],
    mesh_of_face: Annotated[NDArray[numpy.int32], "(*,)"],
    styles: Annotated[NDArray[numpy.float64], "(*, *)"],
    flags: Annotated[NDArray[numpy.int32], "(*, 3)"],
    camera: Annotated[NDArray[numpy.float64], "(17,)"],
    look: Annotated[NDArray[numpy.float64], "(*, *)"],
    lights: Annotated[NDArray[numpy.float64], "(*, *)"],
    width: int,
    height: int,
    samples: int,
    threads: int,
) -> NDArray[numpy.uint8]:
    """
    Picture (height, width, 3) uint8 of indexed meshes; halfphysics.render packs the tables.
    """

def visible(
    vertices: Annotated[NDArray[numpy.float64], "(*, 3)"],
    faces: Annotated[NDArray[numpy.int32], "(*, 3)"],
    mesh_of_face: Annotated[NDArray[numpy.int32], "(*,)"],
    styles: Annotated[NDArray[numpy.float64], "(*, *)"],
    flags: Annotated[NDArray[numpy.int32], "(*, 3)"],
    camera: Annotated[NDArray[numpy.float64], "(17,)"],
    width: int,
    height: int,
) -> tuple[Any, ...]:
    """
    Nearest mesh (height, width) int32, -1 for none, and its depth (height, width) [m].
    """
