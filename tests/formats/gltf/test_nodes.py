"""Nodes of glTF files: a matrix says what translation, rotation and scale say."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.errors import FileError
from halfphysics.formats.gltf.container import Container
from halfphysics.formats.gltf.nodes import Nodes, matrices
from support.files.gltf_rigs import Builder

TURN = [0.1, -0.5, 0.3, 0.8]
#: Rounding of rotations to quaternions and back.
SAME = 1e-12


def nodes_of(tmp_path, **fields) -> Nodes:
    builder = Builder()
    builder.node(**fields)
    return Nodes(Container(builder.glb(tmp_path / "a.glb")))


@pytest.mark.parametrize("scale", [[1.0, 2.0, 3.0], [-1.0, 2.0, 3.0], [0.1, 0.2, -9.0], [-1.0] * 3])
def test_a_matrix_is_the_same_transform(tmp_path, scale):
    """As Sketchfab writes all nodes; a copy may be mirrored."""
    said = nodes_of(tmp_path, translation=[1.0, 2.0, 3.0], rotation=TURN, scale=scale)
    asked = matrices(said.local(0))
    again = nodes_of(tmp_path, matrix=asked.T.reshape(-1).tolist())
    assert np.abs(matrices(again.local(0)) - asked).max() < SAME


@pytest.mark.parametrize("column", [0, 2])
def test_a_matrix_without_extent_is_refused(tmp_path, column):
    flat = np.eye(4)
    flat[column, column] = 0.0
    nodes = nodes_of(tmp_path, matrix=flat.reshape(-1).tolist(), name="flat")
    with pytest.raises(FileError, match="node 'flat': its matrix has no extent"):
        nodes.local(0)
