"""Thin and thick barriers across a person's way, to be jumped over or gone around."""

from __future__ import annotations

import pytest

from halfphysics.geometry.shapes import Box, Cylinder

trimesh = pytest.importorskip("trimesh")

BARRIERS = ("sheet", "pole", "plate", "mesh pole", "box")


def sheet(half=2.0):
    """A square across x, without thickness."""
    corners = [[0, -half, -half], [0, half, -half], [0, half, half], [0, -half, half]]
    return trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]], process=False)


def barrier(name):
    """One of `BARRIERS`, 4 m high."""
    if name == "sheet":
        return sheet()
    if name == "mesh pole":
        return trimesh.creation.cylinder(0.01, height=4.0)
    sizes = {"plate": Box((0.001, 4.0, 4.0)), "box": Box((0.1, 4.0, 4.0))}
    return sizes.get(name) or Cylinder(0.01, 4.0)
