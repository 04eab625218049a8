"""HeldDoor: a robot holds a door for a person who wants through, and shuts it again.

The door swings towards the robot's side and closes by itself. The robot's fork is around the
handle: it can pull the door open and bring it back. The person comes on the other side. Some people
wait in front of a closed door, some push it with a hand, and so the robot; others only walk past,
and for them the door stays shut. The robot has done well when the person is through or past, the
door is shut and the handle still in the fork.
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.envs.bases import Bases, into
from halfphysics.envs.channels import COS_SIN, XY, Channel, Layout
from halfphysics.envs.robots import BASE_EFFORT, FORK, HOLDER_XML, efforts, model_of
from halfphysics.envs.task import Flags, Outcome, Task, View
from halfphysics.envs.walkers import FASTEST, Walkers
from halfphysics.envs.worlds import PERSON, Plan, add_walls, room

Array = NDArray[np.float64]

#: Of the hinge (x, y), and of the handle from it in the door's frame, where the door is closed [m].
HINGE, HANDLE = np.array([0.06, 0.46]), np.array([0.09, -0.78])
#: A point of the panel where people push it, in the door's frame (3,) [m].
PUSHED = np.array([-0.03, -0.62, 1.15])
#: Open enough to walk through [rad].
OPEN = 1.0
#: Shut, if less open than this [rad].
SHUT = 0.12
#: The person is through beyond this x, or past beyond this far along the wall [m].
THROUGH, PAST = 1.1, 1.3
#: Part of the people who walk past, and of the others who push a shut door.
PASSING, PUSHING = 0.3, 0.5
#: The door stands ajar at first by this at most [rad].
AJAR = 0.3
#: Fastest motion of the base [m/s], [rad/s].
SPEED, TURN = 0.6, 1.0
#: The handle is out of the fork farther than this from its middle [m].
LOST = 0.07
#: More than this on the person ends the episode [N].
HURT = 250.0
#: The door slams when it closes faster than this [rad/s] in its last part [rad].
SLAM, LAST = 0.5, 0.2
#: Largest turn of the person's way from straight ahead [rad].
_SWERVE = 0.9

_DOOR = """
<mujoco model="door"><compiler angle="radian"/><worldbody>
<body name="panel">
 <joint name="hinge" axis="0 0 1" range="0 1.9" damping="2.5" stiffness="5" springref="-.25"/>
 <geom type="box" size=".02 .43 1.0" pos="0 -.45 1.02" mass="18"/>
 <geom type="capsule" fromto=".09 -.78 .82 .09 -.78 1.18" size=".015" mass=".4"/>
 <geom type="capsule" fromto=".02 -.78 .82 .09 -.78 .82" size=".01" mass=".1"/>
 <geom type="capsule" fromto=".02 -.78 1.18 .09 -.78 1.18" size=".01" mass=".1"/>
</body></worldbody></mujoco>"""


class HeldDoor(Task):
    """See the module."""

    steps = 300
    view = View((3.9, -2.0, 2.7), (0.1, 0.15, 0.85), 42.0)
    observed: ClassVar = Layout(
        Channel("opening of the door", "rad", -0.1, 2.0),
        Channel("its velocity", "rad/s", -5.0, 5.0),
        Channel("handle from the middle of the fork, in the robot's frame", "m", -1.0, 1.0, XY),
        Channel(
            "heading of the robot less that of a closed door: cosine, sine", "", -1, 1, COS_SIN
        ),
        Channel("velocity of the robot, in its frame", "m/s", -2.0, 2.0, XY),
        Channel("turning of the robot", "rad/s", -4.0, 4.0),
        Channel("person's pelvis, in the robot's frame", "m", -6.0, 6.0, XY),
        Channel("person's pelvis: before (negative) or behind the wall", "m", -4.0, 4.0),
        Channel("velocity of the person, in the robot's frame", "m/s", -3.0, 3.0, XY),
        Channel("where the person faces, from straight through: cosine, sine", "", -1, 1, COS_SIN),
        Channel("force of the person on the door", "100 N", 0.0, 5.0),
        Channel("contact force on the person by robot and door", "100 N", 0.0, 5.0),
        Channel("part of the longest episode that has passed", "", 0.0, 1.0),
    )
    actions: ClassVar = Layout(
        Channel(f"velocity in the robot's frame (x ahead), times {SPEED} m/s", "", -1, 1, XY),
        Channel(f"turning to the left, times {TURN} rad/s", "", -1, 1),
    )
    human_observed: ClassVar = Layout(
        Channel("place of the pelvis, x through the door, y to the left", "m", -6.0, 6.0, XY),
        Channel("velocity", "m/s", -3.0, 3.0, XY),
        Channel("opening of the door", "rad", -0.1, 2.0),
        Channel("its velocity", "rad/s", -5.0, 5.0),
        Channel("robot from the pelvis", "m", -6.0, 6.0, XY),
        Channel("its way: 1, 0 through the door; 0, 1 or 0, -1 past it", "", -1, 1, XY),
        Channel("force on the person by robot and door", "100 N", 0.0, 5.0),
        Channel("part of the longest episode that has passed", "", 0.0, 1.0),
    )
    human_actions: ClassVar = Layout(
        Channel(f"speed: 1 is {FASTEST} m/s, -1 stands; below 0.2 m/s it stands", "", -1, 1),
        Channel(f"direction: to the left of its way, times {_SWERVE} rad", "", -1, 1),
        Channel("above 0 the right hand goes to the door", "", -1, 1),
    )
    rewards: ClassVar = {
        "progress": "1 per metre that the person gets ahead on its way, through or past",
        "push": "-0.002 per newton with which the person has to push the door, each step",
        "force": "-0.01 per newton of contact force on the person by the robot, each step",
        "open": "-0.02 per radian of opening, each step, for a person who walks past or is through",
        "slam": "-0.5 per rad/s by which the door closes faster than 0.5 rad/s in its last 0.2 rad",
        "lost": "-0.03 each step in which the handle is out of the fork",
        "time": "-0.01 each step",
        "done": "5 when the person is through or past, the door shut, the handle in the fork",
        "hurt": "-5 when robot and door push the person with more than 250 N",
    }

    def plan(self) -> Plan:
        self.body = Body.default()
        scene = room()
        add_walls(scene, (0.10, 1.0, 2.1), 0.98)
        scene.add_articulated("door", model_of(_DOOR), position=(*HINGE, 0.0), friction=0.4)
        scene.add_articulated("robot", model_of(HOLDER_XML), friction=0.4)
        return Plan(
            scene=scene,
            bodies=(self.body,),
            motors=efforts("robot", BASE_EFFORT),
            watched=("robot/base", "person/pelvis", "door/panel"),
            groups={"robot": ("robot/*",), "door": ("door/*",), **PERSON},
        )

    def prepare(self) -> None:
        n = self.count
        self.people, self.bases = Walkers(self.body, self.worlds), Bases(n)
        self._way, self._lane, self._pace = np.zeros(n), np.zeros((n, 2)), np.ones(n)
        self._pushes = np.zeros(n, dtype=bool)
        self._angle, self._rate, self._along = np.zeros(n), np.zeros(n), np.zeros(n)

    def start(self, i: int, chance: np.random.Generator) -> None:
        kind, side, seed = chance.random(), chance.choice([-1.0, 1.0]), int(chance.integers(2**31))
        passes = kind < PASSING
        self._pushes[i] = not passes and kind < PASSING + PUSHING * (1.0 - PASSING)
        self._pace[i] = chance.uniform(0.8, 1.2)
        far, off = chance.uniform(1.5, 2.4), chance.uniform(-0.2, 0.2)
        if passes:
            self._way[i], self._lane[i] = side * 0.5 * np.pi, (chance.uniform(-1.3, -0.95), 0.0)
            place = np.array([self._lane[i, 0] + 0.5 * off, -side * far])
        else:
            self._way[i], self._lane[i] = 0.0, (0.0, chance.uniform(-0.20, -0.05))
            place = np.array([-far, self._lane[i, 1] + off])
        pose = self.people.start(i, place, float(self._way[i]), seed)
        ajar = chance.uniform(0.0, AJAR)
        reach = np.add(HANDLE, [FORK, 0.0]) + chance.uniform(-0.004, 0.004, 2)
        at = HINGE + into(reach[None], np.array([-ajar]))[0]
        joints = {**self.bases.start(i, at, np.pi + ajar), "door/hinge": ajar}
        self.worlds.start(i, [pose], joints)
        self.people.settle(i)
        self._angle[i], self._rate[i] = self._opening()[i], 0.0
        self._along[i] = self._ahead()[i]

    # -- one step --------------------------------------------------------------------------

    def human(self) -> Array:
        """Walks past, or through an open door; at a closed one it waits, or pushes."""
        place, comes = self.people.place, self._comes
        shut = comes & (self._angle < OPEN)
        near = (place[:, 0] > -1.0) & (place[:, 0] < 0.35)
        swerve = np.arctan2(into(self._lane - place, self._way)[:, 1], 1.0) / _SWERVE
        before_it = shut & (place[:, 0] > -1.25) & (place[:, 0] < 0.35)
        speed = np.where(before_it, np.where(self._pushes, 0.4, 0.0), self._pace)
        speed = np.where(self._ahead() > self._goal + 1.0, 0.0, speed)
        hand = np.where(near & shut & self._pushes, 1.0, -1.0)
        told = np.stack([2.0 * speed / FASTEST - 1.0, swerve, hand], axis=1)
        out: Array = np.clip(told, -1.0, 1.0)
        return out

    def act(self, actions: Array, commands: Array, active: Flags) -> tuple[Array, Array]:
        now = self.worlds.motors[:, 0]
        linear = into(SPEED * actions[:, :2], -now[:, 2])
        velocity = np.concatenate([linear, TURN * actions[:, 2:]], axis=1)
        rests = self.bases.drive(now, velocity, self.worlds.dt, active)
        speed = 0.5 * FASTEST * (commands[:, 0] + 1.0)
        point = np.concatenate(
            [
                HINGE + into(np.tile(PUSHED[:2], (self.count, 1)), -self._angle),
                np.full((self.count, 1), PUSHED[2]),
            ],
            axis=1,
        )
        self.people.hands(np.where(commands[:, 2:] > 0.0, point, np.nan), active)
        return self.people.tell(speed, self._way + _SWERVE * commands[:, 1], active), rests

    def judge(self, active: Flags) -> Outcome:
        before = self._angle
        self.people.look(active)
        self._angle = np.where(active, self._opening(), before)
        moved = (self._angle - before) / self.worlds.dt
        self._rate = np.where(active, moved, self._rate)
        along = np.minimum(self._ahead(), self._goal)
        by_robot, by_door = self._force("robot"), self._force("door")
        there, lost = along >= self._goal, _length(self._in_fork()) > LOST
        done, hurt = there & (self._angle < SHUT) & ~lost, by_robot + by_door > HURT
        too_fast = np.where(self._angle < LAST, np.maximum(-self._rate - SLAM, 0.0), 0.0)
        terms = {
            "progress": along - self._along,
            "push": -0.002 * by_door,
            "force": -0.01 * by_robot,
            "open": -0.02 * np.maximum(self._angle, 0.0) * (there | ~self._comes),
            "slam": -0.5 * too_fast,
            "lost": -0.03 * lost,
            "time": np.full(self.count, -0.01),
            "done": 5.0 * done,
            "hurt": -5.0 * hurt,
        }
        self._along = np.where(active, along, self._along)
        info = {
            **terms,
            "success": 1.0 * (done & ~hurt),
            "force_on_person": by_robot + by_door,
            "opening": self._angle,
        }
        human = terms["progress"] + terms["time"] + terms["done"] + terms["hurt"]
        reward = sum(terms.values(), np.zeros(self.count))
        return Outcome(reward, human, done | hurt, info)

    def observe(self) -> NDArray[np.float32]:
        at, moving = self.worlds.motors[:, 0], self.worlds.motors[:, 1]
        yaw = at[:, 2]
        return self.observed.cut(
            self._angle,
            self._rate,
            self._in_fork(),
            -np.cos(yaw),
            -np.sin(yaw),
            into(moving[:, :2], yaw),
            moving[:, 2],
            into(self.people.place - at[:, :2], yaw),
            self.people.place[:, 0],
            into(self.people.velocity, yaw),
            self._facing(),
            self._force("door") / 100.0,
            (self._force("door") + self._force("robot")) / 100.0,
            self.time * self.fps / self.steps,
        )

    def observe_human(self) -> NDArray[np.float32]:
        place = self.people.place
        return self.human_observed.cut(
            place,
            self.people.velocity,
            self._angle,
            self._rate,
            self.worlds.motors[:, 0, :2] - place,
            np.cos(self._way),
            np.sin(self._way),
            (self._force("door") + self._force("robot")) / 100.0,
            self.time * self.fps / self.steps,
        )

    # -- inside ----------------------------------------------------------------------------

    @property
    def _comes(self) -> Flags:
        """Who wants through (N,)."""
        comes: Flags = self._way == 0.0
        return comes

    @property
    def _goal(self) -> Array:
        """How far people want to be on their ways (N,) [m]."""
        return np.where(self._comes, THROUGH, PAST)

    def _ahead(self) -> Array:
        """How far people are on their ways, 0 beside the middle of the door (N,) [m]."""
        return into(self.people.place, self._way)[:, 0]

    def _facing(self) -> Array:
        """Where people face, level: cosine and sine from straight through (N, 2)."""
        forward = rot.rotate(self.worlds.place("person/pelvis")[:, 3:], np.array([0.0, 0.0, 1.0]))
        level: Array = forward[:, :2] / np.maximum(_length(forward[:, :2]), 1e-9)[:, None]
        return level

    def _opening(self) -> Array:
        """Of the doors (N,) [rad]."""
        quat = self.worlds.place("door/panel")[:, 3:]
        opening: Array = 2.0 * np.arctan2(quat[:, 3], quat[:, 0])
        return opening

    def _in_fork(self) -> Array:
        """The handles from the middles of the forks, in the robots' frames (N, 2) [m]."""
        at = self.worlds.motors[:, 0]
        handle = HINGE + into(np.tile(HANDLE, (self.count, 1)), -self._angle)
        return into(handle - at[:, :2], at[:, 2]) - [FORK, 0.0]

    def _force(self, by: str) -> Array:
        """On the people by robots or doors, feet included (N,) [N]."""
        return _length(self.worlds.force("person", by) + self.worlds.force("feet", by))


def _length(vectors: Array) -> Array:
    """Lengths (N,) of vectors (N, k)."""
    out: Array = np.sqrt(np.sum(vectors * vectors, axis=1))
    return out
