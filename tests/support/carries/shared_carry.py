"""Two people who face each other and carry one thing: lift, walk, put down.

The first walks ahead along +x, the second backwards. A table is borne by palms below its ends, a
crate between the palms of each at its sides.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass, replace

import numpy as np

from halfphysics.motion.easing import ease
from halfphysics.results.result import ObjectTrack
from halfphysics.scenarios.acting.gait import walk
from halfphysics.scenarios.acting.legs import about
from halfphysics.scenarios.acting.walk_plan import Walk
from support.carries import takes
from support.carries.acting import Way, acted, parts_of, without_gaps
from support.carries.people import person
from support.carries.recordings import is_hand
from support.carries.takes import Hold, Take, moved, without_fingers
from support.carries.things import REST, Grasp, Solid, Thing

FPS = 30.0
#: Time line [s]: hands come, are near, touch; rest, lift, lower; leave, and what is after.
COME, REACH, TOUCH = 0.8, 0.8, 0.4
PAUSE, LIFT, LOWER = 0.2, 1.2, 1.2
AWAY, END = 0.4, 1.6
SPEED = 0.7
#: Shifts of the thing against a hand [m]; the slow part of it as a share.
NOISE, SLOW = (0.010, 0.030), 0.3
#: Trunk and legs stay this far from the thing [m]; wrists bend by at most this [rad].
CLEAR, WRIST = 0.012, np.radians(75.0)
_AHEADS = np.arange(0.16, 0.60, 0.03)


def _legs(x, y, length, side=0.05):
    return tuple(
        Solid("box", (side, side, length), (i * x, j * y, -0.015 - 0.5 * length))
        for i in (-1, 1)
        for j in (-1, 1)
    )


def _under(x, y):
    """Palms below an end: fingers ahead, a little inwards."""
    out = {}
    for side, left in (("left", 1.0), ("right", -1.0)):
        turns = np.radians([0.0, 20.0, -20.0, 40.0])
        fingers = tuple((float(np.cos(a)), float(-left * np.sin(a)), 0.0) for a in turns)
        out[side] = Grasp((-x, left * y, -0.015), (0.0, 0.0, 1.0), fingers, (-0.12, 0.0, -0.06))
    return out


def _beside(x, y, z):
    """Palms on the left and the right side, near an end."""
    out = {}
    for side, left in (("left", 1.0), ("right", -1.0)):
        turns = np.radians([-10.0, 10.0, 30.0, 50.0])
        fingers = tuple((float(np.cos(a)), 0.0, float(-np.sin(a))) for a in turns)
        out[side] = Grasp((-x, left * y, z), (0.0, -left, 0.0), fingers, (-0.05, 0.11 * left, 0.1))
    return out


@dataclass(frozen=True)
class Load:
    """What two people carry: its grasps are those of the person behind it, who looks along +x."""

    thing: Thing
    mass: float
    lift: tuple[float, float]
    near: float


LOADS = {
    "table": Load(
        Thing(
            "table",
            (Solid("box", (1.30, 0.60, 0.03)), *_legs(0.45, 0.25, 0.72)),
            _under(0.615, 0.19),
        ),
        14.0,
        (0.10, 0.22),
        0.65,
    ),
    "bench": Load(
        Thing(
            "bench",
            (Solid("box", (1.50, 0.45, 0.03)), *_legs(0.50, 0.18, 0.60)),
            _under(0.715, 0.14),
        ),
        10.0,
        (0.12, 0.25),
        0.75,
    ),
    "crate": Load(
        Thing(
            "crate",
            (Solid("box", (0.90, 0.36, 0.70)),),
            _beside(0.37, 0.18, 0.22),
        ),
        10.0,
        (0.20, 0.35),
        0.45,
    ),
}


@dataclass(frozen=True)
class SharedCase:
    """One shared carry.

    Attributes:
        load: A key of `LOADS`.
        distance: How far they walk [m].
        noise: "none", "gap", "aside" or "inside".
        fingers: Whether fingers are recorded.
        statures: Of the one who walks ahead and of the other [m].
        seed: Of noise and lift.
    """

    load: str
    distance: float = 1.0
    noise: str = "none"
    fingers: bool = True
    statures: tuple[float, float] = (1.75, 1.75)
    seed: int = 0

    @property
    def id(self) -> str:
        a, b = self.statures
        hands = "fingers" if self.fingers else "flat"
        return f"shared-{self.load}-{self.distance:g}m-{self.noise}-{hands}-{a:g}+{b:g}-{self.seed}"


def shared(case: SharedCase) -> Take:
    """The take of a case, each person as near to the thing as is clear."""
    load = LOADS[case.load]
    times, plans = _times(case)
    rng = np.random.default_rng([case.seed, zlib.crc32(case.load.encode())])
    lift = float(rng.uniform(*load.lift))
    first = COME + REACH + TOUCH
    up, last = first + PAUSE, times[-1] - END
    down = last - PAUSE - LOWER
    lifted = ease((times - up) / LIFT) - ease((times - down) / LOWER)
    gone = np.mean([_gone(plan, times, back) for plan, back in zip(plans, (0, 1), strict=True)], 0)
    rest = -load.thing.low + REST
    hold = (int(np.ceil(first * FPS - 1e-6)), int(np.floor(last * FPS + 1e-6)))
    made = [_person(case, k, times, plans[k], gone, rest + lift * lifted, hold) for k in range(2)]
    # The first person's frame is the world's; the other looks back from beyond the thing.
    (body_a, motion_a, x_a, shift), (body_b, motion_b, x_b, _) = made
    turn = about(2, np.pi)
    motion_b = moved(motion_b, body_b, turn, np.array([x_a + x_b, 0.0, 0.0]))
    position = np.stack([x_a + gone, 0.0 * gone, rest + lift * lifted], axis=1) + shift
    quaternion = np.tile([1.0, 0.0, 0.0, 0.0], (len(times), 1))
    motions = (motion_a, motion_b)
    if not case.fingers:
        motions = tuple(without_fingers(motion) for motion in motions)
    holds = tuple(Hold(k, f"{side}_wrist", *hold) for k in range(2) for side in ("left", "right"))
    return Take(
        id=case.id,
        kind="shared",
        name=case.load,
        solids=load.thing.solids,
        mass=load.mass,
        bodies=(body_a, body_b),
        motions=motions,
        track=ObjectTrack(position=position, quaternion=quaternion),
        holds=holds,
        noise=case.noise,
    )


def _times(case):
    """Times of the frames, and the walks: ahead, and what played backwards goes back."""
    begin = COME + REACH + TOUCH + PAUSE + LIFT
    plan = Walk(distance=case.distance, speed=SPEED, before=begin, after=LOWER + PAUSE + END)
    end = plan.clock()[0][-1]
    times = np.arange(int(np.floor(end * FPS + 1e-9)) + 1) / FPS
    back = replace(
        plan, start=(-case.distance, 0.0), before=times[-1] - (end - plan.after), after=begin
    )
    return times, (plan, back)


def _gone(plan, times, back):
    """How far along +x the world's thing has gone with a walk by time (T,) [m]."""
    clock, phases = plan.clock()
    at = clock[-1] - times if back else times
    travelled = plan.travelled(np.interp(at, clock, phases))
    return plan.distance - travelled if back else travelled


def _person(case, k, times, plan, gone, height, hold):
    """Body, motion in the person's own frame, and the thing's first x there; its shift (T, 3)."""
    body = person(case.statures[k])
    load = LOADS[case.load]
    base = walk(body, plan, FPS)
    if k == 1:
        base = base.with_frames(base.translation[::-1], base.rotations[::-1])
    base = base[: len(times)]
    pelvis = body.joints(base[0])[0]
    offsets, shift = _offsets(case, k, load, times, hold)
    faults = {}
    for ahead in _AHEADS:
        x = float(pelvis[0] + ahead + load.near)
        position = np.stack([x + (-gone if k else gone), 0.0 * gone, height], axis=1)
        way = Way(position, np.broadcast_to(np.eye(3), (len(times), 3, 3)), np.zeros(len(times)))
        closed = np.zeros(len(base))
        made = without_gaps(acted(body, base, load.thing, way, offsets, closed, hold, WRIST))
        if made is None:
            faults[round(float(ahead), 2)] = "out of reach"
            continue
        names = [n for n in set(parts_of(body)) if not is_hand(n) and not n.endswith("_elbow")]
        own = np.flatnonzero(np.isin(parts_of(body), names))
        frames = np.arange(0, len(times), 4)
        points = body.vertices(made, frames=frames, indices=own) - position[frames][:, None]
        gap = takes.distance(load.thing.solids, points).min()
        if gap > CLEAR:
            return body, made, x, shift
        faults[round(float(ahead), 2)] = f"the body {1000 * gap:.0f} mm from the thing"
    raise ValueError(f"{case.id}: no place is right for person {k}: {faults}")


def _offsets(case, k, load, times, hold):
    """How far the hands are from their places (T, 3), and the shift of the thing's track."""
    near = ease((times - COME) / REACH)
    touch = ease((times - COME - REACH) / TOUCH)
    last = hold[1] / FPS
    touch = touch * (1.0 - ease((times - last) / AWAY))
    near = near * (1.0 - ease((times - last - AWAY) / 0.8))
    rng = np.random.default_rng([case.seed, k, zlib.crc32(case.id.encode())])
    out = {}
    for side, grasp in load.thing.grasps.items():
        waits = -0.05 * np.asarray(grasp.facing)
        open_ = (1.0 - near)[:, None] * np.asarray(grasp.ready) + near[:, None] * waits
        out[side] = (1.0 - touch)[:, None] * open_
        if case.noise in ("gap", "inside"):
            sign = -1.0 if case.noise == "gap" else 1.0
            low, high = NOISE
            constant = rng.uniform(low / (1.0 - SLOW), high / (1.0 + SLOW))
            amount = takes.shake(rng, constant * (1.0 - SLOW), constant * (1.0 + SLOW), times)
            out[side] = out[side] + sign * amount[:, None] * np.asarray(grasp.facing)
    shift = np.zeros((len(times), 3))
    if case.noise == "aside":
        # The track of the thing as it is carried, not where it rests.
        rng = np.random.default_rng([case.seed, zlib.crc32(case.id.encode())])
        fade = ease((times - hold[0] / FPS - PAUSE) / 0.5) * ease((last - PAUSE - times) / 0.5)
        shift[:, 1] = rng.choice([-1.0, 1.0]) * fade * takes.shake(rng, *NOISE, times)
    return out, shift
