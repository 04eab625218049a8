"""People in self-contact, and their self-penetration depth by `coal`.

Poses are made by two-bone kinematics on a body's own rest joints: a hand or foot is put at a point,
the elbow or knee points to a side. Only the coordinates come from the core.
"""

from __future__ import annotations

from itertools import combinations

import coal
import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.motion.motion import Motion
from halfphysics.motion.pose import Pose
from halfphysics.motion.skeleton import JOINT_INDEX, JOINT_NAMES, N_JOINTS, PARENTS
from halfphysics.simulation.simulator import Simulator
from support.judges.person_hulls import pieces_of

#: Parts of the default body whose hulls overlap in its rest pose.
REST = [{"spine2", f"{side}_shoulder"} for side in ("left", "right")]
CHAINS = {"arm": ("shoulder", "elbow", "wrist"), "leg": ("hip", "knee", "ankle")}


def _turn(a, b):
    """The smallest rotation matrix that takes direction a to b."""
    a, b = a / np.linalg.norm(a), b / np.linalg.norm(b)
    axis = np.cross(a, b)
    sine = np.linalg.norm(axis)
    if sine < 1e-12:
        return np.eye(3)
    return rot.rotvec_to_matrix(axis / sine * np.arctan2(sine, a @ b))


def reach(body, rotations, side, limb, target, bend, twist=0.0):
    """Puts a wrist or ankle at a point of the rest frame (x left, y up, z ahead) [m].

    Args:
        rotations: (55, 3), changed; trunk and collars must be at rest.
        bend: Direction to which elbow or knee points.
        twist: Of the lower limb about itself [rad].
    """
    upper, middle, lower = (JOINT_INDEX[f"{side}_{name}"] for name in CHAINS[limb])
    s, e, w = (np.asarray(body.rest_joints)[j] for j in (upper, middle, lower))
    a, b = np.linalg.norm(e - s), np.linalg.norm(w - e)
    way = np.asarray(target, float) - s
    d = min(np.linalg.norm(way), 0.999 * (a + b))
    way = way / np.linalg.norm(way)
    along = (a * a - b * b + d * d) / (2 * d)
    out = np.asarray(bend, float) - (np.asarray(bend, float) @ way) * way
    elbow = s + along * way + np.sqrt(max(0.0, a * a - along * along)) * out / np.linalg.norm(out)
    first = _turn(e - s, elbow - s)
    axis = s + d * way - elbow
    second = rot.rotvec_to_matrix(twist * axis / np.linalg.norm(axis)) @ _turn(w - e, axis)
    rotations[upper] = rot.matrix_to_rotvec(first)
    rotations[middle] = rot.matrix_to_rotvec(first.T @ second)


def front(body, x, y, parts=("pelvis", "spine1", "spine2", "spine3", "head"), radius=0.03):
    """Reach of the trunk's or head's skin ahead at (x, y) of the rest frame [m]."""
    v = np.asarray(body.rest_vertices)
    own = np.isin(np.asarray(body.weights).argmax(axis=1), [JOINT_INDEX[name] for name in parts])
    near = own & (np.hypot(v[:, 0] - x, v[:, 1] - y) < radius)
    return v[near, 2].max()


def relaxed(body):
    """Arms down and a hand's breadth off: clear of all other parts."""
    r = np.zeros((N_JOINTS, 3))
    for side, sign in (("left", 1.0), ("right", -1.0)):
        shoulder = np.asarray(body.rest_joints)[JOINT_INDEX[f"{side}_shoulder"]]
        down = shoulder + np.array([sign * 0.28, -0.36, 0.12])
        reach(body, r, side, "arm", down, (sign * 0.5, 0, -1))
    return r


def arms_crossed(body, depth=0.04):
    """Forearms on the chest, one over the other, `depth` [m] inside of it."""
    r = np.zeros((N_JOINTS, 3))
    y = np.asarray(body.rest_joints)[JOINT_INDEX["spine3"], 1]
    for side, sign, up, ahead in (("left", 1.0, 0.0, 0.03), ("right", -1.0, -0.04, 0.095)):
        target = [-sign * 0.09, y + up, front(body, -sign * 0.09, y + up) + ahead - depth]
        reach(body, r, side, "arm", target, (sign * 1.0, -1.0, 0.4))
    return r


def hands_on_hips(body, depth=0.04):
    """Wrists at the sides of the pelvis, elbows out."""
    r = np.zeros((N_JOINTS, 3))
    y = np.asarray(body.rest_joints)[JOINT_INDEX["pelvis"], 1] + 0.08
    v = np.asarray(body.rest_vertices)
    for side, sign in (("left", 1.0), ("right", -1.0)):
        level = (np.abs(v[:, 1] - y) < 0.03) & (np.abs(v[:, 0]) < 0.3)
        out = (sign * v[level, 0]).max()
        reach(body, r, side, "arm", [sign * (out + 0.03 - depth), y, 0.02], (sign, 0.1, -0.6))
    return r


def hand_on_face(body, depth=0.04):
    """The left hand before the face, its wrist before the chin."""
    r = relaxed(body)
    head = np.asarray(body.rest_joints)[JOINT_INDEX["head"]]
    z = front(body, 0.0, head[1], radius=0.05)
    reach(body, r, "left", "arm", [0.02, head[1], z + 0.03 - depth], (0.8, -1.0, 0.3))
    return r


def leg_over_leg(body, depth=0.04):
    """Sits; the left shin across the right thigh."""
    r = relaxed(body)
    joints = np.asarray(body.rest_joints)
    hip, knee = joints[JOINT_INDEX["right_hip"]], joints[JOINT_INDEX["right_knee"]]
    long = np.linalg.norm(knee - hip)
    reach(body, r, "right", "leg", hip + np.array([0.0, -long, long]), (0, 0.3, 1))
    reach(body, r, "left", "leg", hip + np.array([-0.1, 0.11 - depth, 0.8 * long]), (1.0, 0.2, 0.6))
    return r


def clap(body, depth=0.03):
    """Both hands at one place before the chest."""
    r = np.zeros((N_JOINTS, 3))
    y = np.asarray(body.rest_joints)[JOINT_INDEX["spine3"], 1]
    for side, sign in (("left", 1.0), ("right", -1.0)):
        target = [sign * (0.02 - depth), y, 0.4]
        reach(body, r, side, "arm", target, (sign, -1.0, 0.0))
    return r


def between(keys, frames, fps=30.0):
    """A motion through poses (55, 3), `frames[k]` frames from key k to the next, in place."""
    rows = [keys[0]]
    for a, b, n in zip(keys[:-1], keys[1:], frames, strict=True):
        p, q = rot.exp(a), rot.exp(b)
        way = rot.log(rot.multiply(rot.conjugate(p), q))
        rows += [rot.log(rot.multiply(p, rot.exp((k + 1.0) / n * way))) for k in range(n)]
    rotations = np.array(rows)
    return Motion(np.zeros((len(rotations), 3)), rotations, fps)


def run(motion, body, settings, scene=None):
    """Coordinates (T, nq) of the frames, the frames themselves and the simulator."""
    simulator = Simulator(scene, body=body, settings=settings, fps=motion.fps)
    frames = [simulator.reset(motion[0])]
    frames += [simulator.step(motion[t]) for t in range(1, len(motion))]
    return np.array([f._qpos for f in frames]), frames, simulator


class SelfJudge:
    """Depth of the first person's pieces in each other, without neighbours.

    Args:
        simulator: Of one person.
        neighbours: Joints so many bones apart are left out, as are one hand's, and upper arm and
            flank, which overlap at rest.
    """

    def __init__(self, simulator, neighbours=2):
        self.pieces = pieces_of(simulator)[0]
        joint = [JOINT_INDEX[name.split("/")[1]] for name in self.pieces.names]
        roots = []
        for j in range(N_JOINTS):
            line = [j]
            while PARENTS[line[-1]] >= 0:
                line.append(int(PARENTS[line[-1]]))
            roots.append(set(line))

        def hand(j):
            side, _, what = JOINT_NAMES[j].partition("_")
            names = ("wrist", "thumb", "index", "middle", "ring", "pinky")
            return side if what.startswith(names) else None

        def strangers(a, b):
            bones = len(roots[a] ^ roots[b])
            return (
                bones > neighbours
                and (hand(a) is None or hand(a) != hand(b))
                and {JOINT_NAMES[a], JOINT_NAMES[b]} not in REST
            )

        pairs = combinations(range(len(joint)), 2)
        self.pairs = np.array([(i, j) for i, j in pairs if strangers(joint[i], joint[j])])

    def _depths(self, qpos, near=0.0):
        """By pair of pieces the depth at one pose (1, nq) [m]; negative: distances up to `near`."""
        posed = self.pieces.at(qpos)
        i, j = self.pairs.T
        low, high = posed.low[0] - near / 2, posed.high[0] + near / 2
        meet = ((low[i] <= high[j]) & (low[j] <= high[i])).all(axis=1)
        found = {}
        solids = {}
        for a, b in self.pairs[meet]:
            for k in (a, b):
                if k not in solids:
                    solids[k] = posed.solid(k, 0)
            request, result = coal.DistanceRequest(), coal.DistanceResult()
            d = coal.distance(*solids[a], *solids[b], request, result)
            if d <= near:
                found[int(a), int(b)] = -d
        return found

    def deepest(self, qpos):
        """Depth (T,) of the worst pair at poses (T, nq) [m], 0 where all are clear."""
        return np.array([max(self._depths(q[None]).values(), default=0.0) for q in qpos])

    def worst(self, q):
        """The worst pair of one pose (nq,): depth [m] and names."""
        depths = self._depths(q[None])
        if not depths:
            return 0.0, "", ""
        i, j = max(depths, key=depths.get)
        return max(depths[i, j], 0.0), self.pieces.names[i], self.pieces.names[j]


def targets(motion, simulator):
    """Coordinates (T, nq) of a motion itself."""
    person = simulator.world.people[0]
    return person.coordinates(motion.translation, motion.rotations, motion.axes)


def pose(rotations):
    return Pose(np.zeros(3), rotations)
