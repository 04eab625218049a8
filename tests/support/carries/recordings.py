"""Recordings as data sets have them: a person's motion, a thing's track and shape, its stand."""

from __future__ import annotations

import zlib
from dataclasses import dataclass, replace

import numpy as np
import trimesh

from halfphysics.base import rotations as rot
from halfphysics.geometry.mesh import Mesh
from halfphysics.geometry.shapes import Box
from halfphysics.motion.easing import ease
from halfphysics.results.result import ObjectTrack
from halfphysics.scenarios.acting.gait import walk
from halfphysics.scenarios.acting.legs import about
from halfphysics.scenarios.acting.walk_plan import Walk
from halfphysics.scenarios.props import stage
from halfphysics.simulation.sequence import Sequence
from support.carries.acting import Way, acted, parts_of
from support.carries.people import person
from support.carries.things import NEAR, REST, THINGS, Solid

FPS = 30.0
#: Time line [s]: when hands come, how long until they are near, until palms touch, until fingers
#: are closed; rests before and after, lift and putting down; hands leave, and what is after.
COME, REACH, TOUCH, CLOSE = 1.0, 0.8, 0.4, 0.3
PAUSE, LIFT, LOWER = 0.2, 1.2, 1.2
AWAY, END = 0.4, 2.0
#: How long a turn takes, and how long a thing is carried in the air at the end [s].
TURN, AIR = 1.6, 0.7
#: Least and most turn of the trunk [rad].
TURNED = np.radians([50.0, 85.0])
#: Of a walk [m/s].
SPEED = 0.8
#: Carried with the hands at this part of the stature; lifted by at least and at most so much [m].
CARRY_HEIGHT, LIFTS = 0.60, {2: (0.30, 0.80), 1: (0.15, 0.30)}
#: Shifts of the thing against the hands, by how many hands hold it [m].
NOISE = {2: (0.010, 0.030), 1: (0.010, 0.020)}
#: The slowly varying part, as a part of the constant one.
SLOW = 0.3
#: The thing and its stands stay this far from trunk, legs and head [m].
CLEAR = 0.012
#: Wrists bend by at most so much [rad].
WRIST = np.radians(70.0)
_AHEADS = np.arange(0.24, 0.74, 0.03)


@dataclass(frozen=True)
class Case:
    """Which recording. Rows of a log are told apart by its `id`.

    Attributes:
        thing: Name of the thing.
        way: "walk" ahead, "back" away from the stand, "turn" of the trunk, or "up" only.
        ends: "down" put down again, or in the "air".
        noise: "none", "gap" (hands outside), "aside" or "inside".
        fingers: Whether the fingers are recorded.
        stature, arms: Of the person [m], and the length of the arms as a factor.
        seed: Of the noise, the distance and the lift.
    """

    thing: str
    way: str = "turn"
    ends: str = "down"
    noise: str = "none"
    fingers: bool = True
    stature: float = 1.75
    arms: float = 1.0
    seed: int = 0

    @property
    def id(self) -> str:
        hands = "fingers" if self.fingers else "flat"
        size = f"{self.stature:g}x{self.arms:g}"
        return f"{self.thing}-{self.way}-{self.ends}-{self.noise}-{hands}-{size}-{self.seed}"


@dataclass(frozen=True, eq=False)
class Recording:
    """What a data set has of one carry, and what it does not say: when hands hold.

    Attributes:
        case: The case it was made for.
        body: Of the recorded person.
        motion: Of the recorded person, 30 fps.
        track: Recorded poses of the thing.
        stands: Name -> size (3,), position (3,), quaternion (4,) of boxes on the floor.
        hold: First and last frame in which the hands hold the thing.
        bend: How far the body bends by frame, 0 to 1; nan where the hands cannot reach.
    """

    case: Case
    body: object
    motion: object
    track: ObjectTrack
    stands: dict
    hold: tuple[int, int]
    bend: np.ndarray

    @property
    def thing(self):
        return THINGS[self.case.thing]

    def sequence(self) -> Sequence:
        """As `load_sequence` has it, with the stands and the body that it does not know."""
        scene = stage.floor()
        for name, (size, position, quaternion) in self.stands.items():
            scene.add_static(name, Box(size), position=position, quaternion=quaternion)
        parts = [solid.mesh for solid in self.thing.solids]
        scene.add_object(
            self.case.thing,
            Mesh(self.thing.mesh.vertices, self.thing.mesh.faces),
            mass=self.thing.mass,
            position=self.track.position[0],
            quaternion=self.track.quaternion[0],
            pieces=[Mesh(m.vertices, m.faces) for m in parts] if len(parts) > 1 else "auto",
        )
        return Sequence(self.motion, scene, self.body, recorded={self.case.thing: self.track})

    def in_thing(self, points, frames):
        """World points (T, n, 3) in the thing's frame of `frames`."""
        quaternion = self.track.quaternion[frames][:, None]
        return rot.rotate(rot.conjugate(quaternion), points - self.track.position[frames][:, None])

    def distances(self, names, frames):
        """Signed distances of the skin of some parts to the recorded thing (T, n) [m]."""
        own = np.flatnonzero(np.isin(parts_of(self.body), names))
        points = self.body.vertices(self.motion, frames=frames, indices=own)
        return self.thing.distance(self.in_thing(points, frames))


def recording(case: Case) -> Recording:
    """The recording of a case: the thing at the nearest place at which all is clear, in reach."""
    body = person(case.stature, case.arms)
    faults = {}
    for ahead in _AHEADS:
        made = _at(case, body, float(ahead))
        if isinstance(made, str):
            faults[round(float(ahead), 2)] = made
            continue
        fault = _fault(made)
        if fault is None:
            made = _at(case, body, float(ahead), noise=True)
            if isinstance(made, Recording) and not np.isnan(made.bend).any():
                return made
            fault = "out of reach with noise"
        faults[round(float(ahead), 2)] = fault
    raise ValueError(f"{case.id}: no place is right: {faults}")


def _rng(case):
    return np.random.default_rng([case.seed, zlib.crc32(case.thing.encode())])


def _at(case, body, ahead, noise=False):
    """The recording with the thing so far ahead of the pelvis [m]; a text: what is wrong."""
    thing, rng = THINGS[case.thing], _rng(case)
    hands = len(thing.grasps)
    size = case.stature / 1.75
    stand = thing.stand * size
    rest = stand - thing.low + REST
    height = rest + np.mean([g.point[2] for g in thing.grasps.values()])
    least, most = LIFTS[hands]
    wanted = rng.uniform(0.95, 1.05) * CARRY_HEIGHT * case.stature - height
    rise = float(np.clip(wanted, least, most)) if hands == 2 else float(rng.uniform(least, most))
    distance = float(rng.uniform(0.5, 2.0))
    # When things happen.
    round_ = next(iter(thing.grasps.values())).radius is not None
    first = COME + REACH + TOUCH + (CLOSE if round_ else 0.0)
    up = first + PAUSE
    begin = up + LIFT
    plan = Walk(distance=max(distance, 0.5), speed=SPEED, before=begin, after=5.0)
    clock, phases = plan.clock()
    spans = {"walk": clock[-2] - begin, "back": clock[-2] - begin, "turn": TURN, "up": 0.3}
    then = begin + spans[case.way]
    last = then + (LOWER + PAUSE if case.ends == "down" else AIR)
    total = last + (END + AWAY if case.ends == "down" else 0.0)
    times = np.arange(int(np.floor(total * FPS + 1e-9)) + 1) / FPS
    going = case.way in ("walk", "back")
    travelled = np.zeros(len(times))
    if case.way == "walk":
        base = walk(body, plan, FPS)[: len(times)]
        travelled = plan.travelled(np.interp(times, clock, phases))
    elif case.way == "back":
        # A walk toward the stand, played backwards.
        whole = replace(plan, start=(-plan.distance, 0.0), before=total - then, after=begin)
        base = walk(body, whole, FPS)
        base = base.with_frames(base.translation[::-1], base.rotations[::-1])[: len(times)]
        back_clock, back_phases = whole.clock()
        there = back_clock[-1] - times
        travelled = whole.travelled(np.interp(there, back_clock, back_phases)) - whole.distance
    else:
        base = walk(body, replace(plan, before=total + 1.0), FPS)[: len(times)]
    if len(base) < len(times):
        times, travelled = times[: len(base)], travelled[: len(base)]
    pelvis = body.joints(base[0])[0]
    share = ease((times - begin) / TURN) if case.way == "turn" else 0.0 * times
    lifted = ease((times - up) / LIFT)
    if case.ends == "down":
        lifted = lifted - ease((times - then) / LOWER)
    turn = _turned(thing, ahead) * share  # to the left: a right hand carries before the person
    place = about(2, turn) @ np.array([ahead, thing.lateral * size, 0.0])
    position = np.stack(
        [pelvis[0] + travelled + place[:, 0], place[:, 1], rest + rise * lifted], axis=1
    )
    way = Way(position, about(2, turn), turn)
    # The hands come and go.
    near = ease((times - COME) / REACH)
    touch = ease((times - COME - REACH) / TOUCH)
    closed = ease((times - COME - REACH - TOUCH) / CLOSE)
    if case.ends == "down":
        touch = touch * (1.0 - ease((times - last - (CLOSE if round_ else 0.0)) / AWAY))
        near = near * (1.0 - ease((times - last - AWAY - (CLOSE if round_ else 0.0)) / 0.8))
        closed = closed * (1.0 - ease((times - last) / CLOSE))
    offsets = {}
    for name, grasp in thing.grasps.items():
        waits = -np.asarray(grasp.facing) * (NEAR + (0.02 if round_ else 0.0))
        open_ = (1.0 - near)[:, None] * np.asarray(grasp.ready) + near[:, None] * waits
        offsets[name] = (1.0 - touch)[:, None] * open_
    hold = (int(np.ceil(first * FPS - 1e-6)), min(int(np.floor(last * FPS + 1e-6)), len(times) - 1))
    shift = np.zeros_like(position)
    if noise and case.noise != "none":
        for name, grasp in thing.grasps.items():
            own, shift = _noise(case, thing, grasp, name, times, hold)
            offsets[name] = offsets[name] + own
    made = acted(body, base, thing, way, offsets, closed, hold, WRIST)
    if made is None:
        return "out of reach"
    motion, bend = made
    if not case.fingers and noise:
        rotations = np.array(motion.rotations)
        rotations[:, 25:] = 0.0
        motion = motion.with_frames(motion.translation, rotations)
    track = ObjectTrack(
        position=position + np.einsum("tij,tj->ti", way.matrix, shift),
        quaternion=rot.continuous(rot.from_matrix(way.matrix)),
    )
    stands = _stands(thing, track, (0,) if going or case.way == "up" else (0, -1), stand)
    return Recording(case, body, motion, track, stands, hold, bend)


def _turned(thing, ahead):
    """Turn to a second stand that is clear of the thing on the first one [rad]."""
    out = np.hypot(*np.ptp(thing.mesh.vertices[:, :2], axis=0))
    its = max(
        (np.hypot(x + 2.0 * abs(u), y + 2.0 * abs(v)) for x, y, u, v in thing.boxes), default=0.0
    )
    apart = 0.5 * (out + its) + 0.02 if its else 0.0
    return np.clip(2.0 * np.arcsin(min(1.0, 0.5 * apart / np.hypot(ahead, thing.lateral))), *TURNED)


def _stands(thing, track, frames, height):
    """The boxes under the thing where it is at first and where it ends."""
    out = {}
    for k, frame in enumerate(frames):
        for i, (x, y, at_x, at_y) in enumerate(thing.boxes):
            quaternion = track.quaternion[frame]
            at = track.position[frame] + rot.rotate(quaternion, [at_x, at_y, 0.0])
            at = np.array([at[0], at[1], 0.5 * height])
            out[f"stand{k}{i}"] = ((x, y, height), at, quaternion)
    return out


def _noise(case, thing, grasp, name, times, hold):
    """Offsets of a hand, and of the thing's track, in its frame (T, 3) [m]; their sum is within
    `NOISE`. The track's own part fades out where the thing rests."""
    rng = np.random.default_rng([case.seed, zlib.crc32(case.id.encode()), name == "left"])
    low, high = NOISE[len(thing.grasps)]
    facing = np.asarray(grasp.facing)
    if case.noise == "aside":  # one shift of the thing, the same against both hands
        rng = np.random.default_rng([case.seed, zlib.crc32(case.id.encode())])
        axis = np.array([0.0, 1.0, 0.0]) if facing[2] == 0.0 else np.array([1.0, 0.0, 0.0])
        direction = axis * rng.choice([-1.0, 1.0])
    else:
        direction = -facing if case.noise == "gap" else facing
    constant = rng.uniform(low / (1.0 - SLOW), high / (1.0 + SLOW))
    period, phase = rng.uniform(2.0, 4.0), rng.uniform(0.0, 2.0 * np.pi)
    slow = SLOW * constant * np.sin(2.0 * np.pi * times / period + phase)
    own = constant + (0.0 * slow if case.noise == "aside" else slow)
    shift = np.zeros((len(times), 3))
    if case.noise == "aside":
        first, last = times[hold[0]] + PAUSE, times[hold[1]] - PAUSE
        fade = ease((times - first) / 0.5)
        if case.ends == "down":
            fade = fade * ease((last - times) / 0.5)
        shift = -(fade * slow)[:, None] * direction
    return own[:, None] * direction, shift


def _fault(made) -> str | None:
    """What is wrong with a recording without noise; None: nothing."""
    if np.isnan(made.bend).any():
        return f"out of reach in {int(np.isnan(made.bend).sum())} frames"
    frames = np.arange(0, len(made.motion), 4)
    hands = [
        n for n in set(parts_of(made.body)) if is_hand(n) and n.split("_")[0] in made.thing.grasps
    ]
    rest = [n for n in set(parts_of(made.body)) if n not in hands]
    near = [n for n in rest if n.split("_")[0] in made.thing.grasps and n.endswith("_elbow")]
    far = [n for n in rest if n not in near]
    gap = made.distances(far, frames).min()
    if gap < CLEAR:
        return f"the body {1000 * gap:.0f} mm from the thing"
    if near and (gap := made.distances(near, frames).min()) < 0.0:
        return f"a forearm {1000 * gap:.0f} mm from the thing"
    skin = made.body.vertices(made.motion, frames=frames)[:, ::3]
    surface = surface_points(made)[::2]
    for stand in made.stands.values():
        if (gap := stand_distance(stand, skin).min()) < 0.5 * CLEAR:
            return f"the body {1000 * gap:.0f} mm from a stand"
        if (gap := stand_distance(stand, surface).min()) < 0.5 * REST:
            return f"the thing {1000 * gap:.0f} mm from a stand"
    return None


def surface_points(made):
    """Points of the thing's surface by frame, in the world (T, n, 3) [m]."""
    mesh = made.thing.mesh
    vertices, _ = trimesh.remesh.subdivide_to_size(mesh.vertices, mesh.faces, 0.05)
    return rot.rotate(made.track.quaternion[:, None], vertices) + made.track.position[:, None]


def stand_distance(stand, points):
    """Signed distances of points (..., 3) to a box of `Recording.stands` [m]."""
    size, at, quaternion = stand
    return Solid("box", size).distance(rot.rotate(rot.conjugate(quaternion), points - at))


def is_hand(name: str) -> bool:
    """Whether a part is of a hand: the wrist's or a finger's."""
    fingers = ("wrist", "index", "middle", "ring", "pinky", "thumb")
    return any(f"_{finger}" in name for finger in fingers)
