"""Articulated objects in a result, checked independently: links by MuJoCo, distances by coal.

The simulator supplies only the joints' values, the people's motions and the contacts.
"""

from __future__ import annotations

from dataclasses import dataclass

import coal
import mujoco
import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.metrics import penetration
from halfphysics.results.result import ObjectTrack
from support.judges.coal_shapes import coal_hull, coal_shape
from support.judges.posed_skin import Skinner

#: Pairs beyond this distance are skipped [m].
NEAR = 0.03


@dataclass(frozen=True)
class Jointed:
    """One articulated object of a result at all T frames.

    Attributes:
        result: The result.
        name: The articulated object's name.
    """

    result: object
    name: str

    @property
    def thing(self):
        return self.result.scene.articulated[self.name]

    def values(self):
        """MuJoCo's own model of the same text, and the values (T, ...) of every joint."""
        own = {n.split("/", 1)[1]: v for n, v in self.result.joints.items()}
        model = mujoco.MjModel.from_xml_string(self.thing.xml)
        return model, [own[model.joint(j).name] for j in range(model.njnt)]

    def poses(self):
        """Link -> its pose by MuJoCo: positions (T, 3), rotations (T, 3, 3)."""
        model, values = self.values()
        data = mujoco.MjData(model)
        out = {}
        base, origin = rot.to_matrix(self.thing.quaternion), self.thing.position
        free = [j for j in range(model.njnt) if model.jnt_type[j] == mujoco.mjtJoint.mjJNT_FREE]
        # A free joint's coordinates are in the world, all others in the object's frame.
        loose = {int(model.body_rootid[model.jnt_bodyid[j]]) for j in free}
        for t in range(len(values[0])):
            data.qpos[:] = np.concatenate([np.atleast_1d(v[t]) for v in values])
            mujoco.mj_kinematics(model, data)
            for b in range(model.nbody):
                x, m = data.xpos[b].copy(), data.xmat[b].reshape(3, 3).copy()
                if int(model.body_rootid[b]) not in loose:
                    x, m = base @ x + origin, base @ m
                out.setdefault(model.body(b).name, []).append((x, m))
        return {
            name: (np.array([p for p, _ in places]), np.array([m for _, m in places]))
            for name, places in out.items()
        }

    def off(self):
        """Deviation of links from their joints' poses: [m], and as matrices."""
        worst = [0.0, 0.0]
        for name, (position, turn) in self.poses().items():
            track = self.result.objects.get(f"{self.name}/{name}")
            if track is None:
                continue
            worst[0] = max(worst[0], np.abs(track.position - position).max())
            worst[1] = max(worst[1], np.abs(rot.to_matrix(track.quaternion) - turn).max())
        return tuple(worst)

    def beyond(self):
        """How far joints are past their limits at most, by MuJoCo's model [rad or m]."""
        model, values = self.values()
        limited = [j for j in range(model.njnt) if model.jnt_limited[j]]
        low = [model.jnt_range[j, 0] - values[j].min() for j in limited]
        high = [values[j].max() - model.jnt_range[j, 1] for j in limited]
        return max(*low, *high)

    def gap(self, frames, links=None, motion=None):
        """Smallest distances of the person's skin hulls from solids of links [m], (frames,).

        `motion`: in place of the result's; negative where it is inside.
        """
        person = self.result.people[0]
        hulls = person.body.skin_corners
        motion = person.motion if motion is None else motion
        skin = Skinner(person.body, samples=0).vertices(
            motion.translation[frames], motion.rotations[frames], np.eye(3)
        )[:, hulls.vertex]
        poses, request = self.poses(), coal.DistanceRequest()
        solids = [
            (link.name, coal_shape(g.shape, solid=True), g)
            for link in self.thing.links
            for g in link.geoms
            if links is None or link.name in links
        ]
        out = np.full(len(frames), np.inf)
        for k, t in enumerate(frames):
            low = np.minimum.reduceat(skin[k], hulls.first[:-1])
            high = np.maximum.reduceat(skin[k], hulls.first[:-1])
            made = {}
            for link, solid, geom in solids:
                position, turn = poses[link][0][t], poses[link][1][t]
                at = turn @ geom.position + position
                axes = turn @ rot.to_matrix(geom.quaternion)
                solid.computeLocalAABB()
                box = solid.aabb_local
                middle = axes @ (0.5 * (box.max_ + box.min_)) + at
                half = np.abs(axes) @ (0.5 * (box.max_ - box.min_))
                apart = np.maximum(low - middle - half, middle - half - high).max(axis=1)
                for h in np.flatnonzero(apart < NEAR):
                    if h not in made:
                        made[h] = coal_hull(skin[k][hulls.first[h] : hulls.first[h + 1]])
                    found = coal.DistanceResult()
                    there = coal.Transform3s(axes, at)
                    coal.distance(made[h], coal.Transform3s(), solid, there, request, found)
                    out[k] = min(out[k], found.min_distance)
        return out

    def penetration(self, motion, every=4):
        """`metrics.penetration` of a motion at some frames, objects posed as in the result."""
        objects = {
            name: ObjectTrack(
                position=track.position[::every], quaternion=track.quaternion[::every]
            )
            for name, track in self.result.objects.items()
        }
        body, scene = self.result.people[0].body, self.result.scene
        return penetration(motion[::every], body, scene, objects=objects)

    def force(self, link):
        """The person's force on a link, mean over each frame [N], (T, 3)."""
        contacts, fps = self.result.contacts, self.result.fps
        rows = self.rows(link)
        out = np.zeros((len(self.result.people[0].motion), 3))
        np.add.at(out, contacts.frame[rows], -contacts.impulse[rows] * fps)
        return out

    def rows(self, link):
        """Which contacts are between the person and a link."""
        contacts = self.result.contacts
        other = self.result.names.index(f"{self.name}/{link}")
        return (contacts.person == 0) & (contacts.other == other)
