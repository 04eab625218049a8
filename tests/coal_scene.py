"""A run looked at from outside: distances by coal, kinematics by the bodies' own joints."""

from __future__ import annotations

import coal
import numpy as np

from halfphysics import rotations as rot
from halfphysics.shapes import Box, Capsule, Cylinder, Plane, Sphere

#: Farther than this two things are not looked at [m].
NEAR = 0.02


def _corners(points):
    out = coal.StdVec_Vec3s()
    for p in points:
        out.append(np.asarray(p, dtype=float))
    return out


def _triangles(faces):
    out = coal.StdVec_Triangle()
    for f in faces:
        out.append(coal.Triangle(*(int(i) for i in f)))
    return out


def coal_hull(points):
    """The convex hull of points (n, 3), its triangles outward."""
    from scipy.spatial import ConvexHull

    hull = ConvexHull(points)
    corners = points[hull.vertices]
    index = {int(v): i for i, v in enumerate(hull.vertices)}
    faces = np.array([[index[int(v)] for v in simplex] for simplex in hull.simplices])
    a, b, c = (corners[faces[:, k]] for k in range(3))
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), a - corners.mean(axis=0)) < 0
    faces[inward] = faces[inward][:, ::-1]
    return coal.Convex(_corners(corners), _triangles(faces))


def coal_shape(shape, solid):
    """A coal geometry: `solid` meshes are their hulls, others triangles."""
    if isinstance(shape, Plane):
        return coal.Halfspace(np.array(shape.normal, dtype=float), float(shape.offset))
    if isinstance(shape, Box):
        return coal.Box(*shape.size)
    if isinstance(shape, Sphere):
        return coal.Sphere(shape.radius)
    if isinstance(shape, Capsule):
        return coal.Capsule(shape.radius, shape.length)
    if isinstance(shape, Cylinder):
        return coal.Cylinder(shape.radius, shape.length)
    if solid:
        return coal_hull(np.asarray(shape.vertices))
    model = coal.BVHModelOBBRSS()
    model.beginModel(len(shape.faces), len(shape.vertices))
    model.addSubModel(_corners(shape.vertices), _triangles(shape.faces))
    model.endModel()
    return model


class Watch:
    """Distances between all that a simulator moves and all that stands there."""

    def __init__(self, simulator):
        self.simulator = simulator
        world = simulator.world
        self.statics = []
        for s in world.scene.statics.values():
            shape = coal_shape(s.shape, solid=False)
            pose = coal.Transform3s(rot.to_matrix(s.quaternion), np.asarray(s.position, float))
            self.statics.append((s.name, shape, pose, s.shape))
        self.parts = []  # name, body id, vertices, geometry
        for person in world.people:
            for part in person.body.variant.parts:
                if len(part.vertices) < 4:
                    continue
                body = world.model.body(f"{person.name}/{part.name}").id
                self.parts.append((person.name, body, part.vertices, coal_hull(part.vertices)))
        self.things = [
            (t.name, t, coal_shape(world.scene.objects[t.name].shape, solid=True))
            for t in world.things
        ]
        self.request = coal.DistanceRequest()

    def _movers(self, qpos):
        x, q = self.simulator.world.stepper.body_frames(qpos)
        out = []
        for name, body, vertices, shape in self.parts:
            radius = np.linalg.norm(vertices, axis=1).max()
            out.append((name, shape, rot.to_matrix(rot.normalize(q[body])), x[body], radius))
        for name, thing, shape in self.things:
            position, quat = thing.pose(qpos)
            box = shape.computeLocalAABB() or shape.aabb_local
            radius = float(np.linalg.norm(np.maximum(np.abs(box.min_), np.abs(box.max_))))
            turn = rot.to_matrix(rot.normalize(quat))
            out.append((name, shape, turn, position, radius))
        return out

    def _distance(self, a, b):
        result = coal.DistanceResult()
        return coal.distance(a[0], a[1], b[0], b[1], self.request, result)

    def gap(self, qpos, against_objects=True, statics="all"):
        """Smallest distance at one pose (inf: beyond `NEAR`), and between which two.

        statics: Whose distance from them counts: "all", "things" (not the people's) or "none".
        """
        best, pair = np.inf, ("", "")
        movers = self._movers(qpos)
        scene = self.simulator.world.scene
        for i, (name, shape, turn, position, radius) in enumerate(movers):
            pose = coal.Transform3s(turn, position)
            human = name.startswith("person")
            skipped = statics == "none" or (statics == "things" and human)
            for other, geometry, place, given in [] if skipped else self.statics:
                if scene.ignores("person" if human else name, other):
                    continue
                if isinstance(given, Plane):
                    normal = place.getRotation() @ np.asarray(given.normal, float)
                    offset = given.offset + normal @ place.getTranslation()
                    if normal @ position - offset > radius + NEAR:
                        continue
                d = self._distance((shape, pose), (geometry, place))
                if d < min(best, NEAR):
                    best, pair = d, (name, other)
            if not against_objects:
                continue
            for name2, shape2, turn2, position2, radius2 in movers[i + 1 :]:
                if name == name2:
                    continue
                if np.linalg.norm(position - position2) > radius + radius2 + NEAR:
                    continue
                pose2 = coal.Transform3s(turn2, position2)
                d = self._distance((shape, pose), (shape2, pose2))
                if d < min(best, NEAR):
                    best, pair = d, (name, name2)
        return best, pair

    def smallest_gap(self, frames, every=1, against_objects=True):
        """Over all recorded substeps of `frames`: distance, pair, frame, substep."""
        worst = (np.inf, ("", ""), -1, -1)
        count = 0
        for f, frame in enumerate(frames):
            for k, qpos in enumerate(frame.substeps):
                count += 1
                if count % every:
                    continue
                d, pair = self.gap(qpos, against_objects)
                if d < worst[0]:
                    worst = (d, pair, f, k)
        return worst
