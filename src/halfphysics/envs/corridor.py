"""Corridor: a robot passes a person who walks towards it in a corridor.

The robot has to get to the far end. The person walks the other way in a lane of its own; some
people step aside for a robot in their way, some do not. The robot has done well when it is there
and nobody was pushed, stopped or crowded.
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from halfphysics.body.body import Body
from halfphysics.envs.bases import Bases, ahead, into, wrapped
from halfphysics.envs.channels import COS_SIN, XY, Channel, Layout
from halfphysics.envs.robots import BASE_EFFORT, BASE_XML, efforts, model_of
from halfphysics.envs.task import Flags, Outcome, Task, View
from halfphysics.envs.walkers import FASTEST, Walkers
from halfphysics.envs.worlds import PERSON, Plan, add_walls, room

Array = NDArray[np.float64]

#: Half the width of the corridor, between the walls, and half its length [m].
HALF_WIDTH, HALF_LENGTH = 1.15, 5.0
#: Where the robot starts and where it has to get, along x [m]; how near [m].
START, GOAL, NEAR = -2.5, 2.5, 0.30
#: Fastest forward and backward [m/s], and turning [rad/s].
SPEED, BACK, TURN = 1.2, 0.4, 2.0
#: Nearer than this to the person's middle is too near [m].
CROWDED = 0.90
#: More than this on the person ends the episode [N].
HURT = 100.0
#: Largest turn of a person's way from straight along the corridor [rad].
_SWERVE = 0.9


class Corridor(Task):
    """See the module."""

    steps = 360
    view = View((-2.2, -3.4, 4.4), (0.3, 0.0, 0.4), 52.0)
    observed: ClassVar = Layout(
        Channel("goal, in the robot's frame (x ahead, y left)", "m", -6.0, 6.0, XY),
        Channel("heading of the robot: cosine, sine", "", -1.0, 1.0, COS_SIN),
        Channel("y of the robot: 0 in the middle of the corridor", "m", -1.5, 1.5),
        Channel("velocity of the robot, in its frame", "m/s", -2.0, 2.0, XY),
        Channel("turning of the robot", "rad/s", -4.0, 4.0),
        Channel("person's pelvis, in the robot's frame", "m", -8.0, 8.0, XY),
        Channel("velocity of the person, in the robot's frame", "m/s", -3.0, 3.0, XY),
        Channel("contact force on the person by the robot", "100 N", 0.0, 5.0),
        Channel("the robot touches a wall", "", 0.0, 1.0),
        Channel("part of the longest episode that has passed", "", 0.0, 1.0),
    )
    actions: ClassVar = Layout(
        Channel(f"speed: 1 is {SPEED} m/s ahead, -1 is {BACK} m/s back", "", -1, 1),
        Channel(f"turning to the left, times {TURN} rad/s", "", -1, 1),
    )
    human_observed: ClassVar = Layout(
        Channel(
            "place of the pelvis: along its way, and to the left of the middle", "m", -6, 6, XY
        ),
        Channel("velocity, along its way and to the left", "m/s", -3.0, 3.0, XY),
        Channel("robot from the pelvis, along its way and to the left", "m", -8.0, 8.0, XY),
        Channel("velocity of the robot, likewise", "m/s", -3.0, 3.0, XY),
        Channel("part of the longest episode that has passed", "", 0.0, 1.0),
    )
    human_actions: ClassVar = Layout(
        Channel(f"speed: 1 is {FASTEST} m/s, -1 stands; below 0.2 m/s it stands", "", -1, 1),
        Channel(f"direction: to the left of its way, times {_SWERVE} rad", "", -1, 1),
    )
    rewards: ClassVar = {
        "progress": "1 per metre nearer to the goal",
        "crowding": "-0.15 per metre that is missing to 0.9 m between robot and person, each step",
        "hindrance": "-0.03 per m/s by which the person is slower than it wants, within 1.5 m of "
        "the robot, each step",
        "force": "-0.01 per newton of contact force on the person, each step",
        "wall": "-0.05 each step in which the robot touches a wall",
        "time": "-0.01 each step",
        "done": "5 within 30 cm of the goal",
        "hurt": "-5 when more than 100 N act on the person",
    }

    def plan(self) -> Plan:
        self.body = Body.default()
        scene = room()
        add_walls(scene, (2.0 * HALF_LENGTH, 0.1, 0.9), HALF_WIDTH + 0.05)
        scene.add_articulated("robot", model_of(BASE_XML), friction=0.3)
        return Plan(
            scene=scene,
            bodies=(self.body,),
            motors=efforts("robot", BASE_EFFORT),
            watched=("robot/base", "person/pelvis"),
            groups={"robot": ("robot/*",), "walls": ("*_wall",), **PERSON},
        )

    def prepare(self) -> None:
        n = self.count
        self.people, self.bases = Walkers(self.body, self.worlds), Bases(n)
        self._lane, self._pace, self._yields = np.zeros(n), np.ones(n), np.zeros(n, dtype=bool)
        self._wanted, self._far = np.zeros(n), np.zeros(n)
        self._goal = np.tile([GOAL, 0.0], (n, 1))

    def start(self, i: int, chance: np.random.Generator) -> None:
        self._lane[i], self._pace[i] = chance.uniform(-0.45, 0.45), chance.uniform(0.8, 1.35)
        self._yields[i] = chance.random() < 0.5
        place = np.array([chance.uniform(2.6, 3.6), self._lane[i]])
        pose = self.people.start(i, place, np.pi, int(chance.integers(2**31)))
        joints = self.bases.start(
            i, np.array([START, chance.uniform(-0.5, 0.5)]), chance.uniform(-0.3, 0.3)
        )
        self.worlds.start(i, [pose], joints)
        self.people.settle(i)
        self._wanted[i], self._far[i] = 0.0, self._distance()[i]

    # -- one step --------------------------------------------------------------------------

    def human(self) -> Array:
        """Walks along its lane; who yields gives way to a robot in its way, on its side."""
        place, robot = self.people.place, self.worlds.motors[:, 0, :2]
        between = place - robot
        in_way = (between[:, 0] > -0.3) & (between[:, 0] < 2.5) & (np.abs(between[:, 1]) < 0.8)
        # In the middle it goes to its right, which is y: it walks against x.
        side = np.where(between[:, 1] > -0.15, 0.9, -0.9)
        lane = np.where(self._yields & in_way, robot[:, 1] + side, self._lane)
        lane = np.clip(lane, -HALF_WIDTH + 0.35, HALF_WIDTH - 0.35)
        swerve = np.arctan2(place[:, 1] - lane, 1.0) / _SWERVE
        arrived = place[:, 0] < -HALF_LENGTH + 0.8
        speed = np.where(arrived, 0.0, self._pace)
        return np.clip(np.stack([2.0 * speed / FASTEST - 1.0, swerve], axis=1), -1.0, 1.0)

    def act(self, actions: Array, commands: Array, active: Flags) -> tuple[Array, Array]:
        now = self.worlds.motors[:, 0]
        forward = np.where(actions[:, 0] > 0.0, SPEED, BACK) * actions[:, 0]
        x, y = ahead(forward, now[:, 2])
        velocity = np.stack([x, y, TURN * actions[:, 1]], axis=1)
        rests = self.bases.drive(now, velocity, self.worlds.dt, active)
        speed = 0.5 * FASTEST * (commands[:, 0] + 1.0)
        self._wanted = np.where(active, speed, self._wanted)
        heading = np.pi + _SWERVE * commands[:, 1]
        return self.people.tell(speed, heading, active), rests

    def judge(self, active: Flags) -> Outcome:
        self.people.look(active)
        far, near = self._distance(), self._between()
        force = self._force()
        slow = np.clip(self._wanted - _length(self.people.velocity), 0.0, 1.5)
        starting = self.time < 1.5
        terms = {
            "progress": self._far - far,
            "crowding": -0.15 * np.clip(CROWDED - near, 0.0, None),
            "hindrance": -0.03 * np.where((near < 1.5) & ~starting, slow, 0.0),
            "force": -0.01 * force,
            "wall": -0.05 * self._at_wall(),
            "time": np.full(self.count, -0.01),
            "done": 5.0 * (far < NEAR),
            "hurt": -5.0 * (force > HURT),
        }
        self._far = far
        done, hurt = far < NEAR, force > HURT
        info = {**terms, "success": 1.0 * (done & ~hurt), "force_on_person": force}
        way = -self.people.velocity[:, 0] * self.worlds.dt
        human = way + terms["force"] + terms["hurt"]
        reward = sum(terms.values(), np.zeros(self.count))
        return Outcome(reward, human, done | hurt, info)

    def observe(self) -> NDArray[np.float32]:
        at, moving = self.worlds.motors[:, 0], self.worlds.motors[:, 1]
        yaw = at[:, 2]
        return self.observed.cut(
            into(self._goal - at[:, :2], yaw),
            np.cos(yaw),
            np.sin(yaw),
            at[:, 1],
            into(moving[:, :2], yaw),
            moving[:, 2],
            into(self.people.place - at[:, :2], yaw),
            into(self.people.velocity, yaw),
            self._force() / 100.0,
            self._at_wall(),
            self.time * self.fps / self.steps,
        )

    def observe_human(self) -> NDArray[np.float32]:
        at, moving = self.worlds.motors[:, 0, :2], self.worlds.motors[:, 1, :2]
        place, velocity = self.people.place, self.people.velocity
        return self.human_observed.cut(
            -place, -velocity, place - at, -moving, self.time * self.fps / self.steps
        )

    # -- inside ----------------------------------------------------------------------------

    def _distance(self) -> Array:
        """Of the robots from their goals (N,) [m]."""
        return _length(self._goal - self.worlds.motors[:, 0, :2])

    def _between(self) -> Array:
        """Between robots and people (N,) [m]."""
        return _length(self.people.place - self.worlds.motors[:, 0, :2])

    def _force(self) -> Array:
        """On the people by the robots, feet included (N,) [N]."""
        force = self.worlds.force("person", "robot") + self.worlds.force("feet", "robot")
        return _length(force)

    def _at_wall(self) -> Array:
        touches: Array = np.where(self.worlds.load("robot", "walls") > 0.0, 1.0, 0.0)
        return touches

    def turn_to(self, direction: Array) -> Array:
        """How far the robots would have to turn to face directions (N, 2) [rad]."""
        return wrapped(np.arctan2(direction[:, 1], direction[:, 0]) - self.worlds.motors[:, 0, 2])


def _length(vectors: Array) -> Array:
    """Lengths (N,) of vectors (N, k)."""
    out: Array = np.sqrt(np.sum(vectors * vectors, axis=1))
    return out
