"""Pressure on a person's skin, at every vertex and in every frame.

A sample of the skin stands for the area around it: its force is spread over the vertices nearby, in
the rest pose, where hands are away from the trunk. The force is kept: the sum over the vertices of
pressure times the vertex's area is that of the samples.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.validation import is_whole, shown
from halfphysics.body.skin_samples import vertex_areas
from halfphysics.errors import InputError
from halfphysics.results.pressure_maps import checked_contacts

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.results.result import Result
    from halfphysics.results.soft_contacts import SoftContacts

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

# Width of a sample, as a share of the side of its area, and its least [m].
_WIDTH, _LEAST = 0.55, 0.004
# Samples are spread this far [widths].
_SPREAD = 3.0


def skin_pressure(result: Result, person: int = 0) -> NDArray[np.float32]:
    """Pressure on the skin of a person of a result.

    Args:
        result: The result.
        person: Index into `Result.people`.

    Returns:
        (T, V) [Pa], float32: of every vertex of the body's skin in every frame.

    Raises:
        InputError: Nothing soft is pressed, there is no such person, or the pressures are of a body
            with more vertices.
    """
    contacts = checked_contacts(result)
    count = len(result.people)
    if not is_whole(person, plain=False) or not 0 <= person < count:
        raise InputError(f"person: found {shown(person)}, expected 0 to {count - 1}")
    body = result.people[person].body
    frame, vertex, force, area = _on_skin(result, contacts, int(person))
    own, place = np.unique(checked_vertices(result, person, vertex), return_inverse=True)
    out = np.zeros((len(result), len(body.rest_vertices)), dtype=np.float32)
    if not len(own):
        return out
    from scipy.sparse import coo_array

    largest = np.zeros(len(own))
    np.maximum.at(largest, place, area)
    spread = _spreading(body, own, np.maximum(_WIDTH * np.sqrt(largest), _LEAST))
    forces = coo_array((force, (place, frame)), shape=(len(own), len(result))).tocsc()
    touched = np.flatnonzero(np.asarray(spread.sum(axis=1)).ravel() > 0.0)
    out[:, touched] = (spread[touched] @ forces).toarray().T
    return out


def checked_vertices(result: Result, person: int, vertex: Ints) -> Ints:
    """Vertices (n,) of a person's skin, as a file of a result names them.

    A file is checked when it is read, but its bodies are loaded when they are needed.

    Raises:
        InputError: The body has no such vertex.
    """
    someone, most = result.people[person], int(vertex.max(initial=-1))
    count = len(someone.body.rest_vertices)
    if most >= count:
        raise InputError(
            f"pressure: found vertex {most}, but the skin of {someone.name!r} has {count} "
            "vertices. Load the result with the body that was simulated"
        )
    return vertex


def _on_skin(
    result: Result, contacts: SoftContacts, person: int
) -> tuple[Ints, Ints, Array, Array]:
    """Frame, vertex, force [N] and area [m^2] of the samples that press on a person (n,)."""
    index = len(result.names) - len(result.people) + person
    force = contacts.pressure * contacts.area
    own = (contacts.other == index) & (contacts.vertex >= 0)
    frames, vertices = [contacts.frame[own]], [contacts.vertex[own]]
    # What presses into soft skin knows no vertex: the one nearest to it.
    into = np.flatnonzero(contacts.layer == index)
    if len(into):
        frames.append(contacts.frame[into])
        vertices.append(_nearest(result, contacts, person, into))
    rows = np.concatenate([np.flatnonzero(own), into])
    return np.concatenate(frames), np.concatenate(vertices), force[rows], contacts.area[rows]


def _nearest(result: Result, contacts: SoftContacts, person: int, rows: Ints) -> Ints:
    """The vertex of a person's skin nearest to each of the samples `rows` (n,)."""
    from scipy.spatial import cKDTree

    someone = result.people[person]
    out = np.zeros(len(rows), dtype=np.int64)
    for frame in np.unique(contacts.frame[rows]).tolist():
        mine = contacts.frame[rows] == frame
        skin = someone.body.vertices(someone.motion, frames=[frame])[0]
        out[mine] = cKDTree(skin).query(contacts.position[rows[mine]])[1]
    return out


def _spreading(body: Body, own: Ints, width: Array) -> Any:
    """Pressure at the vertices by a newton at each of `own` (n,): sparse (V, n) [1/m^2]."""
    from scipy.sparse import coo_array
    from scipy.spatial import cKDTree

    rest = np.asarray(body.rest_vertices, dtype=np.float64)
    area, way = vertex_areas(rest, np.asarray(body.faces))
    normals = way / np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-12)
    near = cKDTree(rest).query_ball_point(rest[own], _SPREAD * width, return_sorted=True)
    column = np.repeat(np.arange(len(own)), [len(found) for found in near])
    row = np.concatenate([np.asarray(found, dtype=np.int64) for found in near])
    distance = np.linalg.norm(rest[row] - rest[own[column]], axis=1)
    # Not through a finger or a lip to the other side.
    same = np.einsum("ni,ni->n", normals[row], normals[own[column]]) > 0.0
    share = np.where(same, np.exp(-0.5 * (distance / width[column]) ** 2), 0.0)
    whole = np.bincount(column, share * area[row], len(own))
    made = coo_array((share / whole[column], (row, column)), shape=(len(rest), len(own)))
    return made.tocsr()
