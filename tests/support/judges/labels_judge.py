"""Contact labels judged independently: coal computes every distance."""

from __future__ import annotations

from dataclasses import dataclass

import coal
import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.geometry.shapes import Mesh, Plane
from support.judges.coal_shapes import coal_shape

#: Accuracy of the other library's distances [m].
ROUNDING = 1e-6
_DOT = 1e-7


@dataclass
class Verdict:
    """Results for one result's labels.

    `vertices`, `points`: checked labelled vertices of skins and objects, `farthest` of
    them [m]; `unlabelled`: vertices without a label that are nearer than the threshold;
    `impulses`: contacts of people with an impulse; `bare`: those of a part without any label;
    `with_vertex`: those with a label at a vertex of either side in the frame; `gaps`: the
    distances of both sides of the others [m]; `between`: contacts between people, whose vertices
    have no labels.
    """

    vertices: int = 0
    points: int = 0
    farthest: float = 0.0
    unlabelled: int = 0
    impulses: int = 0
    bare: int = 0
    with_vertex: int = 0
    between: int = 0
    gaps: np.ndarray | None = None


def solids(scene):
    """Name -> [(coal geometry or Plane, position (3,), turn (3, 3))] in the item's frame."""
    found = {}
    for name, static in scene.statics.items():
        found[name] = [(static.shape, not isinstance(static.shape, Mesh), np.zeros(3), np.eye(3))]
    for name, thing in scene.objects.items():
        found[name] = [(piece, True, np.zeros(3), np.eye(3)) for piece in thing.pieces]
    for whole in scene.articulated.values():
        for name, link in zip(whole.link_names, whole.links, strict=True):
            found[name] = [
                (g.shape, True, np.array(g.position), rot.to_matrix(g.quaternion))
                for g in link.geoms
            ]
    return {
        name: [
            (shape if isinstance(shape, Plane) else coal_shape(shape, solid), position, turn)
            for shape, solid, position, turn in every
        ]
        for name, every in found.items()
    }


def pose(result, name, frame):
    """Pose of an item: position (3,), turn (3, 3)."""
    if name in result.scene.statics:
        static = result.scene.statics[name]
        return np.array(static.position), rot.to_matrix(static.quaternion)
    track = result.objects[name]
    return track.position[frame], rot.to_matrix(rot.normalize(track.quaternion[frame]))


def from_thing(geometry, position, turn, points):
    """Distances (n,) [m] of points (n, 3) to an item at a pose; 0 or less inside."""
    out = np.full(len(points), np.inf)
    for shape, own, own_turn in geometry:
        place, way = position + turn @ own, turn @ own_turn
        if isinstance(shape, Plane):
            local = (points - place) @ way
            out = np.minimum(out, local @ np.asarray(shape.normal) - shape.offset)
            continue
        at, dot = coal.Transform3s(way, place), coal.Sphere(_DOT)
        for i, point in enumerate(points):
            found, where = coal.DistanceResult(), coal.Transform3s(np.eye(3), point)
            distance = coal.distance(shape, at, dot, where, coal.DistanceRequest(), found)
            out[i] = min(out[i], distance + _DOT)
    return out


def judge(result, labels, *, most=60, seed=0):
    """Checks at most `most` vertices of each kind, person and item, drawn evenly."""
    rng, verdict = np.random.default_rng(seed), Verdict()
    geometry, names = solids(result.scene), [item.name for item in labels.objects]
    standing = [name for name in geometry if name not in names]
    for index, (person, who) in enumerate(zip(result.people, labels.people, strict=True)):
        groups = [(k, [name], who.body(k)) for k, name in enumerate(names)]
        groups.append((None, standing, who.scene))
        for item, things, ids in groups:
            frame, vertex = _some(rng, *np.nonzero(ids), most)
            assert (ids[frame, vertex] - 1 == person.body.weights.argmax(axis=1)[vertex]).all()
            apart = _apart(result, person, geometry, things, frame, vertex)
            verdict.vertices += len(apart)
            verdict.farthest = max(verdict.farthest, apart.max(initial=0.0))
            # No other vertex in the same frames may be as near.
            other = rng.integers(0, ids.shape[1], len(frame) + most)
            when = (
                rng.choice(frame, len(other))
                if len(frame)
                else rng.integers(0, len(ids), len(other))
            )
            bare = ids[when, other] == 0
            apart = _apart(result, person, geometry, things, when[bare], other[bare])
            verdict.unlabelled += int((apart < labels.threshold_m - ROUNDING).sum())
            if item is not None:
                _judge_points(rng, verdict, result, labels, index, item, most)
    _judge_impulses(verdict, result, labels)
    return verdict


def _apart(result, person, geometry, things, frame, vertex):
    out = np.full(len(frame), np.inf)
    for t in np.unique(frame):
        here = frame == t
        points = person.body.vertices(person.motion, int(t), indices=vertex[here])
        for name in things:
            found = from_thing(geometry[name], *pose(result, name, t), points)
            out[here] = np.minimum(out[here], found)
    return out


def _judge_points(rng, verdict, result, labels, index, item, most):
    """An object's vertices against the skin's triangles, by trimesh."""
    person, surface = result.people[index], labels.objects[item]
    ids = labels.object_ids(index, item)
    frame, vertex = _some(rng, *np.nonzero(ids), most)
    chosen = np.unique(frame)
    chosen = (
        rng.choice(chosen, min(max(3, most // 20), len(chosen)), replace=False)
        if len(chosen)
        else chosen
    )
    for t in chosen:
        vertex = rng.permutation(np.flatnonzero(ids[t]))[:most]
        bare = rng.permutation(np.flatnonzero(ids[t] == 0))[: most // 2]
        position, turn = pose(result, surface.name, t)
        skin = person.body.vertices(person.motion, int(t))
        mesh = coal_shape(Mesh(skin, person.body.faces), solid=False)
        points = surface.vertices @ turn.T + position
        apart, face = _from_mesh(mesh, points[np.r_[vertex, bare]])
        verdict.points += len(vertex)
        verdict.farthest = max(verdict.farthest, apart[: len(vertex)].max(initial=0.0))
        verdict.unlabelled += int((apart[len(vertex) :] < labels.threshold_m - ROUNDING).sum())
        corners = person.body.faces[face[: len(vertex)]]
        parts = person.body.weights[corners].argmax(axis=2)
        # The label is the part of one of the nearest triangle's corners.
        assert (parts == ids[t, vertex][:, None] - 1).any(axis=1).all()


def _from_mesh(mesh, points):
    """Distances (n,) [m] of points (n, 3) from triangles, and which is nearest (n,)."""
    apart, face = np.empty(len(points)), np.empty(len(points), dtype=int)
    here, dot = coal.Transform3s(), coal.Sphere(_DOT)
    for i, point in enumerate(points):
        found, at = coal.DistanceResult(), coal.Transform3s(np.eye(3), point)
        apart[i] = coal.distance(mesh, here, dot, at, coal.DistanceRequest(), found) + _DOT
        face[i] = found.b1
    return apart, face


def _judge_impulses(verdict, result, labels):
    contacts, names = result.contacts, {o.name: k for k, o in enumerate(labels.objects)}
    gaps = []
    first_person = len(result.names) - len(result.people)
    dense = [(who.scene, [who.body(k) for k in range(len(names))]) for who in labels.people]
    points = [
        [labels.object_ids(i, k) for k in range(len(names))] for i in range(len(labels.people))
    ]
    for row in np.flatnonzero((contacts.person >= 0) & (contacts.strength > 0.0)):
        who = labels.people[contacts.person[row]]
        frame, part, other = contacts.frame[row], contacts.part[row], contacts.other[row]
        name = result.names[other]
        verdict.impulses += 1
        if other >= first_person:
            verdict.bare += not who.people_parts[frame, part]
            verdict.between += 1
            continue
        item = names.get(name)
        parts = who.scene_parts if item is None else who.human_parts
        verdict.bare += not parts[frame, part]
        scene, bodies = dense[contacts.person[row]]
        ids = scene if item is None else bodies[item]
        hulls = result.people[contacts.person[row]].body.skin_hulls
        corners = np.concatenate(
            [
                hulls.vertex[hulls.first[h] : hulls.first[h + 1]]
                for h in np.flatnonzero(hulls.part == part)
            ]
        )
        touched = ids[frame, corners].any()
        if item is not None:
            touched |= (points[contacts.person[row]][item][frame] == part + 1).any()
        verdict.with_vertex += bool(touched)
        if not touched:
            gaps.append(labels.contacts.distance[row])
    verdict.gaps = np.array(gaps)


def _some(rng, frame, vertex, most):
    chosen = np.sort(rng.permutation(len(frame))[:most])
    return frame[chosen], vertex[chosen]
