"""The skeletons of a glTF file: the joints of its skins, and how they stand at the bind pose.

A skin has for each joint the inverse of its transform at the bind pose, in which the mesh was made:
a T or an A pose, as a rule. There, joint frames may be turned in any way. For retargeting they are
replaced by frames that are parallel at the bind pose: with B the rotation of a joint at the bind
pose and R(t) that in the world, the frame has the rotation ``R(t) B^T``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.validation import shown
from halfphysics.formats.gltf.accessors import rows
from halfphysics.formats.gltf.animation import Animation
from halfphysics.formats.gltf.container import Container, is_index
from halfphysics.formats.gltf.nodes import PATHS, Nodes, matrices
from halfphysics.formats.skeletons.animated_skeleton import AnimatedSkeleton

Array = NDArray[np.float64]

#: Poses of all nodes that are computed at most: bounds the memory [frames times nodes].
_MOST_POSES = 8_000_000
#: Frames that are computed at once: bounds the memory of their matrices.
_CHUNK = 4096
#: Joints of all skins, and nodes of one skeleton: far above any scene of people.
_MOST_JOINTS, _MOST_IN_ONE = 5_000, 2_000
#: Columns of a matrix that are a rotation times scales are square to each other to this.
_SQUARE = 0.02
#: Bones shorter than this part of the skeleton do not tell its scale.
_SHORT = 0.02


@dataclass(frozen=True, eq=False)
class Rig:
    """A skeleton.

    Attributes:
        name: Of the node above its root, or of the root.
        nodes: Its joints and the nodes between, parents before children.
        bind: Transforms (J, 4, 4) of these at the bind pose.
    """

    name: str
    nodes: tuple[int, ...]
    bind: Array


def rigs(container: Container, nodes: Nodes) -> list[Rig]:
    """The skeletons of all skins; skins of one skeleton are one.

    Raises:
        FileError: A skin names what is not there, or its matrices are impossible.
    """
    known: dict[int, Array] = {}  # joint -> transform at the bind pose
    groups: list[tuple[int, set[int]]] = []  # the node above all joints, and the joints
    total = 0
    for number in range(len(container.entries("skins"))):
        joints, bind = bind_poses(container, number, nodes)
        total += len(joints)
        if total > _MOST_JOINTS:
            raise container.error(f"skins of over {_MOST_JOINTS} joints, expected those of people")
        for joint, matrix in zip(joints, bind, strict=True):
            known.setdefault(joint, matrix)
        root = _meeting(nodes, joints)
        if root is not None:
            _join(groups, root, set(joints), nodes)
    return [_rig(nodes, root, joints, known) for root, joints in groups]


def bare_rig(nodes: Nodes, animation: Animation) -> list[Rig]:
    """The skeleton of all turning nodes, in a file without skins: at the pose of its nodes."""
    joints = {node for node, path in animation.keys if path == "rotation"}
    root = _meeting(nodes, sorted(joints)) if joints else None
    return [] if root is None else [_rig(nodes, root, joints, {})]


def _join(groups: list[tuple[int, set[int]]], root: int, joints: set[int], nodes: Nodes) -> None:
    """Add a skin; groups whose root is above or below its own become one with it."""
    for other, theirs in list(groups):
        if root in nodes.above(other) or other in nodes.above(root):
            groups.remove((other, theirs))
            root = root if nodes.depths[root] < nodes.depths[other] else other
            joints = joints | theirs
    groups.append((root, joints))


def _meeting(nodes: Nodes, joints: list[int]) -> int | None:
    """The lowest node that is, or is above, all of these; None: they hang on no one node."""
    path = nodes.above(joints[0])
    common = set(path)
    for joint in joints[1:]:
        common &= set(nodes.above(joint))
    return next((node for node in path if node in common), None)


def bind_poses(container: Container, number: Any, nodes: Nodes) -> tuple[list[int], Array]:
    """Joints of a skin, and their transforms (J, 4, 4) at the bind pose.

    Raises:
        FileError: It names what is not there, or its matrices are impossible.
    """
    skin = container.entry("skins", number)
    joints = skin.get("joints")
    if not isinstance(joints, list) or not joints:
        raise container.error(f"skin {number}: joints: found {shown(joints)}")
    if not all(is_index(joint, len(nodes.names)) for joint in joints):
        raise container.error(f"skin {number}: joints: found an index of no node")
    if skin.get("inverseBindMatrices") is None:
        return joints, np.stack([nodes.at_rest(joint) for joint in joints])
    what = f"skin {number}, inverseBindMatrices"
    flat = rows(container, skin["inverseBindMatrices"], "MAT4", what)
    if len(flat) != len(joints):
        raise container.error(f"{what}: found {len(flat)}, expected {len(joints)}, one a joint")
    inverse = np.swapaxes(flat.reshape(-1, 4, 4), 1, 2)
    size = np.abs(np.linalg.det(inverse[:, :3, :3]))
    if not ((size > 1e-18) & (size < 1e18)).all():
        raise container.error(f"{what}: a matrix has no inverse")
    return joints, np.asarray(np.linalg.inv(inverse), dtype=np.float64)


def _rig(nodes: Nodes, root: int, joints: set[int], known: dict[int, Array]) -> Rig:
    """The skeleton from `root` down to the joints."""
    wanted = {root}
    for joint in joints:
        for node in nodes.above(joint):
            wanted.add(node)
            if node == root:
                break
    if len(wanted) > _MOST_IN_ONE:
        raise nodes.container.error(
            f"a skeleton of {len(wanted)} nodes, expected a person's, of at most {_MOST_IN_ONE}"
        )
    order = tuple(node for node in nodes.order if node in wanted)
    bind: dict[int, Array] = {}
    for node in order:
        parent = nodes.parents[node]
        if node in known:
            bind[node] = known[node]
        elif parent in bind:
            bind[node] = bind[parent] @ matrices(nodes.local(node))
        else:
            bind[node] = _above_known(nodes, node, known)
    named = nodes.parents[root] if nodes.parents[root] >= 0 else root
    return Rig(nodes.names[named], order, np.stack([bind[node] for node in order]))


def _above_known(nodes: Nodes, node: int, known: dict[int, Array]) -> Array:
    """The bind pose of a root without one, from the first joint below it that has one."""
    for joint in nodes.order:
        path = nodes.above(joint)
        if joint in known and node in path:
            below = np.eye(4)
            for between in path[: path.index(node)]:
                below = matrices(nodes.local(between)) @ below
            return np.asarray(known[joint] @ np.linalg.inv(below))
    return nodes.at_rest(node)


def world(nodes: Nodes, animation: Animation, wanted: tuple[int, ...], times: Array) -> Array:
    """World transforms (T, n, 4, 4) of nodes at times [s].

    Raises:
        FileError: These are more poses than fit in the memory.
    """
    needed = {above for node in wanted for above in nodes.above(node)}
    check_poses(nodes, len(times), needed)
    found: dict[int, Array] = {}
    for node in nodes.order:
        if node not in needed:
            continue
        local = nodes.local(node)
        for path in PATHS:
            keys = animation.keys.get((node, path))
            if keys is None:
                continue
            values = keys.at(times, turns=path == "rotation")
            local[path] = values[:, [1, 2, 3, 0]] if path == "rotation" else values
        matrix = matrices(local)
        parent = nodes.parents[node]
        found[node] = matrix if parent < 0 else found[parent] @ matrix
    shape = (len(times), 4, 4)
    return np.stack([np.broadcast_to(found[node], shape) for node in wanted], axis=1)


def check_poses(nodes: Nodes, frames: int, needed: set[int]) -> None:
    """Raise FileError for more poses than fit in the memory."""
    if len(needed) * frames > _MOST_POSES:
        raise nodes.container.error(
            f"{frames} frames of {len(needed)} nodes, expected at most {_MOST_POSES} poses. Read a "
            "part with frames=(start, stop)"
        )


def rotations_of_matrices(transforms: Array) -> tuple[Array, Array]:
    """Quaternions (..., 4) and scales (...) of transforms (..., 4, 4).

    Raises:
        ValueError: They mirror, shear, or have no extent.
    """
    linear = transforms[..., :3, :3]
    sizes = np.linalg.norm(linear, axis=-2)
    if not ((sizes > 1e-9) & (sizes < 1e9)).all():
        raise ValueError("have no extent")
    turn = linear / sizes[..., None, :]
    if (np.linalg.det(turn) < 0.0).any():
        raise ValueError("mirror")
    if np.abs(np.swapaxes(turn, -1, -2) @ turn - np.eye(3)).max() > _SQUARE:
        raise ValueError("shear")
    return rot.from_matrix(turn), np.cbrt(sizes.prod(axis=-1))


def animated(nodes: Nodes, rig: Rig, animation: Animation, times: Array) -> AnimatedSkeleton:
    """A skeleton at times [s], in the world of the file, y-up.

    Raises:
        FileError: Transforms mirror or shear the body.
    """
    places = np.empty((len(times), len(rig.nodes), 3))
    own = np.empty((len(times), len(rig.nodes), 4))
    try:
        bind, _ = rotations_of_matrices(rig.bind)
        for start in range(0, len(times), _CHUNK):
            rows = slice(start, start + _CHUNK)
            transforms = world(nodes, animation, rig.nodes, times[rows])
            own[rows], places[rows] = rotations_of_matrices(transforms)[0], transforms[..., :3, 3]
    except ValueError as error:
        raise nodes.container.error(
            f"skeleton {rig.name!r}: transforms {error}, expected rotations and even scales. Apply "
            "the scale (Blender: Object > Apply > Scale) and export it again"
        ) from None
    index = {node: k for k, node in enumerate(rig.nodes)}
    parents = tuple(index.get(nodes.parents[node], -1) for node in rig.nodes)
    parents = (-1, *parents[1:])
    offsets = rig.bind[:, :3, 3] - rig.bind[[max(p, 0) for p in parents], :3, 3]
    offsets[0] = rig.bind[0, :3, 3]
    return AnimatedSkeleton(
        names=tuple(nodes.names[node] for node in rig.nodes),
        parents=parents,
        offsets=offsets * _scale(places[0], offsets, parents),
        ends={},
        positions=places,
        quaternions=rot.multiply(own, rot.conjugate(bind)),
    )


def _scale(places: Array, offsets: Array, parents: tuple[int, ...]) -> float:
    """Units of the world per unit of the bind pose: the median of the bones' lengths."""
    above = [max(parent, 0) for parent in parents]
    lengths = np.linalg.norm(offsets, axis=1)
    now = np.linalg.norm(places - places[above], axis=1)
    lengths[0] = 0.0
    counted = lengths > _SHORT * lengths.max(initial=0.0)
    ratio = now[counted] / lengths[counted]
    return float(np.median(ratio)) if counted.any() and np.median(ratio) > 0.0 else 1.0
