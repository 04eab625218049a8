"""HandOver: a robot arm hands a standing person a cup.

The robot holds a cup between its fingers. The person comes to take it once it is offered within
reach and slowly: the palm goes under the cup and, once there, holds it. The robot lets go, and has
done well when the person has the cup alone. A cup that falls and a person who is pushed hard end
the episode.
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from halfphysics.body.body import Body
from halfphysics.envs.channels import XYZ, Channel, Layout
from halfphysics.envs.reachers import Reachers
from halfphysics.envs.robots import ARM, ARM_XML, efforts, model_of
from halfphysics.envs.task import Flags, Outcome, Task, View
from halfphysics.envs.worlds import PERSON, Plan, room
from halfphysics.geometry.shapes import Cylinder
from halfphysics.settings import Settings

Array = NDArray[np.float64]

#: Where the robot stands, facing the person (against x) [m].
ROBOT_AT = np.array([1.15, 0.0, 0.0])
#: The cup: radius, height [m], mass [kg].
RADIUS, HEIGHT, MASS = 0.035, 0.12, 0.25
#: Fastest motion of the fingers' middle [m/s], and of a finger [m/s].
SPEED, FINGER_SPEED = 0.8, 0.12
#: Fastest wrist of the person [m/s].
WRIST_SPEED = 1.2
#: Where people like to be given things, in their frame (3,) [m].
COMFORT = np.array([0.46, -0.14, 1.12])
#: Nearer than this to that place the person comes to take [m], from a cup slower than this [m/s].
OFFERED, SLOW = 0.22, 0.30
#: The palm holds a cup whose bottom is nearer than this [m] and slower than this against it [m/s].
GRASP, GENTLE = 0.045, 0.40
#: More than this on the person ends the episode [N]: about what hands and arms bear without pain.
HURT = 150.0
#: Lower than this a cup has been dropped [m].
DROPPED = 0.60
#: How far the fingers are to be from a cup that was handed over [m].
APART = 0.10
#: Box in the robot's frame in which the fingers' middle may be told to be [m].
_WORKSPACE = np.array([[0.30, -0.55, 0.60], [0.92, 0.55, 1.50]])
#: The palm's middle below the cup's middle [m].
_UNDER = 0.5 * HEIGHT + 0.012
# Where a hand that has the cup draws back to, the wrist in the person's frame (3,) [m].
_HOME = COMFORT - np.array([0.14, 0.0, 0.02 + _UNDER])
_TURN = np.array([-1.0, -1.0, 1.0])  # between the world's axes and those of the robot


class HandOver(Task):
    """See the module."""

    steps = 240
    view = View((0.55, -2.6, 1.75), (0.55, 0.0, 0.95))
    observed: ClassVar = Layout(
        Channel("angles of pan, lift, elbow, wrist", "rad", -3.2, 3.2, tuple(ARM.joints)),
        Channel("their velocities", "rad/s", -10.0, 10.0, tuple(ARM.joints)),
        Channel("mean opening of the fingers", "m", 0.0, 0.07),
        Channel("middle between the fingers, in the world", "m", -3.0, 3.0, XYZ),
        Channel("cup from that middle", "m", -2.0, 2.0, XYZ),
        Channel("velocity of the cup", "m/s", -5.0, 5.0, XYZ),
        Channel("palm of the person from the cup", "m", -3.0, 3.0, XYZ),
        Channel("velocity of the palm", "m/s", -5.0, 5.0, XYZ),
        Channel("the person's comfortable place from the cup", "m", -3.0, 3.0, XYZ),
        Channel("the person holds the cup", "", 0.0, 1.0),
        Channel("the fingers touch the cup", "", 0.0, 1.0),
        Channel("contact force on the person and the cup it holds", "100 N", 0.0, 5.0),
        Channel("part of the longest episode that has passed", "", 0.0, 1.0),
    )
    actions: ClassVar = Layout(
        Channel(f"velocity of the fingers' middle in the world, times {SPEED} m/s", "", -1, 1, XYZ),
        Channel(f"opening of the fingers, times {FINGER_SPEED} m/s", "", -1, 1),
    )
    human_observed: ClassVar = Layout(
        Channel("palm, in the person's frame", "m", -3.0, 3.0, XYZ),
        Channel("velocity of the palm", "m/s", -5.0, 5.0, XYZ),
        Channel("cup from the palm", "m", -3.0, 3.0, XYZ),
        Channel("velocity of the cup", "m/s", -5.0, 5.0, XYZ),
        Channel("middle between the fingers from the palm", "m", -3.0, 3.0, XYZ),
        Channel("the hand holds the cup", "", 0.0, 1.0),
        Channel("the fingers touch the cup", "", 0.0, 1.0),
        Channel("part of the longest episode that has passed", "", 0.0, 1.0),
    )
    human_actions: ClassVar = Layout(
        Channel("velocity of the wrist in the person's frame, times 1.2 m/s", "", -1, 1, XYZ),
        Channel("above 0 the hand takes what lies on it", "", -1, 1),
    )
    rewards: ClassVar = {
        "offer": "3 per metre by which the cup comes nearer to the comfortable place, in the "
        "robot's hand",
        "take": "1 when the person takes the cup",
        "let_go": "2 per metre by which the fingers open while the person holds the cup",
        "force": "-0.002 per newton of contact force on the person and the cup it holds, each step",
        "time": "-0.01 each step",
        "done": "5 when the person has the cup alone, 10 cm away from the fingers",
        "dropped": "-3 when the cup is lower than 60 cm",
        "hurt": "-3 when more than 150 N act on the person",
    }

    def plan(self) -> Plan:
        self.body = Body.default()
        scene = room()
        scene.add_articulated(
            "robot",
            model_of(ARM_XML),
            position=ROBOT_AT,
            quaternion=(0.0, 0.0, 0.0, 1.0),
            friction=1.0,
        )
        scene.add_object("cup", Cylinder(RADIUS, HEIGHT), mass=MASS, position=(0.6, 0.0, 1.1))
        scene.friction("cup", "robot", 1.0)
        return Plan(
            scene=scene,
            bodies=(self.body,),
            motors=efforts("robot", ARM.effort),
            watched=("robot/hand", "cup", "person/right_wrist"),
            groups={
                "fingers": ("robot/left", "robot/right"),
                "robot": ("robot/*",),
                "cup": ("cup",),
                **PERSON,
            },
        )

    def settings(self) -> Settings:
        """Half as many substeps as usual: hands and arm are slow, and the motors are implicit."""
        return Settings(substeps=4)

    def prepare(self) -> None:
        n = self.count
        self.people = Reachers(self.body, self.worlds)
        self._point, self._opening = np.zeros((n, 3)), np.zeros(n)
        self._held, self._waited = np.zeros(n, dtype=bool), np.zeros(n)
        self._reaction, self._pace = np.zeros(n), np.ones(n)
        self._seen = {name: np.zeros((n, 3)) for name in ("cup", "palm", "middle")}
        self._moving = {name: np.zeros((n, 3)) for name in ("cup", "palm")}
        self._far, self._spread = np.zeros(n), np.zeros(n)

    def start(self, i: int, chance: np.random.Generator) -> None:
        place = chance.uniform([-0.10, -0.15], [0.05, 0.15])
        pose = self.people.start(i, place, chance.uniform(-0.25, 0.25))
        self._reaction[i], self._pace[i] = chance.uniform(0.10, 0.45), chance.uniform(0.7, 1.2)
        self._point[i] = chance.uniform([0.42, -0.35, 0.85], [0.55, 0.35, 1.25])
        self._opening[i], self._held[i], self._waited[i] = 0.0, False, 0.0
        middle = ROBOT_AT + _TURN * self._point[i]
        angles = ARM.reach(self._point[i : i + 1])[0]
        joints = {f"robot/{name}": float(a) for name, a in zip(ARM.joints, angles, strict=True)}
        joints |= {f"robot/{side}": RADIUS + 0.0015 for side in ("left", "right")}
        yaw = np.pi + angles[0]
        turn = (np.cos(0.5 * yaw), 0.0, 0.0, np.sin(0.5 * yaw))
        self.worlds.start(i, [pose], joints, {"cup": (middle - [0.0, 0.0, 0.02], turn)})
        self._look()
        for name in self._moving:
            self._moving[name][i] = 0.0
        self._far[i] = self._distance()[i]
        self._spread[i] = self._fingers()[i]

    # -- one step --------------------------------------------------------------------------

    def human(self) -> Array:
        """Waits until the cup is offered, puts the palm under it, takes it, draws it near."""
        n, people = self.count, self.people
        away = self._distance()
        slow = _length(self._moving["cup"]) < SLOW
        ready = self._waited >= self._reaction
        wants = ready & ((away < OFFERED) & slow | self._held)
        under = self._seen["cup"] - [0.0, 0.0, _UNDER]
        near = people.from_world(under - self._seen["palm"])
        home = np.broadcast_to(_HOME, (n, 3))
        # Not while the fingers are on the cup: pulled aside it would jam between them.
        alone = self.worlds.load("cup", "fingers") == 0.0
        back = np.where(alone[:, None], 0.6 * (home - people.wrist), 0.0)
        goal = np.where(self._held[:, None], back, near)
        rest = people.hangs - people.wrist
        goal = np.where(wants[:, None], goal, np.where((away < 2.0 * OFFERED)[:, None], 0.0, rest))
        velocity = 5.0 * goal / WRIST_SPEED
        size = np.maximum(_length(velocity), 1e-9)
        velocity = velocity * np.minimum(1.0, 0.8 * self._pace / size)[:, None]
        return np.concatenate([velocity, np.where(wants, 1.0, -1.0)[:, None]], axis=1)

    def act(self, actions: Array, commands: Array, active: Flags) -> tuple[Array, Array]:
        dt, go = self.worlds.dt, active[:, None]
        told = self._point + dt * SPEED * _TURN * actions[:, :3]
        self._point = np.where(go, np.clip(told, *_WORKSPACE), self._point)
        opening = np.clip(self._opening + dt * FINGER_SPEED * actions[:, 3], 0.0, 0.06)
        self._opening = np.where(active, opening, self._opening)
        fingers = np.repeat(self._opening[:, None], 2, axis=1)
        rests = np.concatenate([ARM.reach(self._point), fingers], axis=1)
        self._grasp(commands[:, 3] > 0.0, active)
        self.people.tell(WRIST_SPEED * commands[:, :3], 1.0 * self._held, dt, active)
        return self.people.targets(), rests

    def judge(self, active: Flags) -> Outcome:
        dt = self.worlds.dt
        before = {name: self._seen[name] for name in self._moving}
        self._look()
        for name, was in before.items():
            self._moving[name] = np.where(
                active[:, None], (self._seen[name] - was) / dt, self._moving[name]
            )
        far, spread = self._distance(), self._fingers()
        offered = (far < OFFERED) & (_length(self._moving["cup"]) < SLOW)
        self._waited = np.where(offered, self._waited + dt, np.where(self._held, self._waited, 0.0))
        force = self._pressed()
        apart = _length(self._seen["cup"] - self._seen["middle"])
        alone = self._held & (self.worlds.load("cup", "fingers") == 0.0) & (apart > APART)
        terms = {
            "offer": 3.0 * np.where(self._held, 0.0, self._far - far),
            "take": 1.0 * self._took,
            "let_go": 2.0 * np.where(self._held, spread - self._spread, 0.0),
            "force": -0.002 * force,
            "time": np.full(self.count, -0.01),
            "done": 5.0 * alone,
            "dropped": -3.0 * (self._seen["cup"][:, 2] < DROPPED),
            "hurt": -3.0 * (force > HURT),
        }
        self._far, self._spread = far, spread
        harm = (terms["dropped"] < 0.0) | (terms["hurt"] < 0.0)
        info = {**terms, "success": 1.0 * (alone & ~harm), "force_on_person": force}
        mine = ("take", "force", "time", "done", "dropped", "hurt")
        reach = -0.01 * _length(self._seen["cup"] - self._seen["palm"])
        human = sum((terms[name] for name in mine), reach)
        reward = sum(terms.values(), np.zeros(self.count))
        return Outcome(reward, human, alone | harm, info)

    def observe(self) -> NDArray[np.float32]:
        seen, moving, motors = self._seen, self._moving, self.worlds.motors
        return self.observed.cut(
            motors[:, 0, :4],
            motors[:, 1, :4],
            self._fingers(),
            seen["middle"],
            seen["cup"] - seen["middle"],
            moving["cup"],
            seen["palm"] - seen["cup"],
            moving["palm"],
            self._comfort() - seen["cup"],
            np.where(self._held, 1.0, 0.0),
            np.where(self.worlds.load("cup", "fingers") > 0.0, 1.0, 0.0),
            self._pressed() / 100.0,
            self.time * self.fps / self.steps,
        )

    def observe_human(self) -> NDArray[np.float32]:
        seen, moving, own = self._seen, self._moving, self.people.from_world
        palm = seen["palm"].copy()
        palm[:, :2] -= self.people.place
        return self.human_observed.cut(
            own(palm),
            own(moving["palm"]),
            own(seen["cup"] - seen["palm"]),
            own(moving["cup"]),
            own(seen["middle"] - seen["palm"]),
            np.where(self._held, 1.0, 0.0),
            np.where(self.worlds.load("cup", "fingers") > 0.0, 1.0, 0.0),
            self.time * self.fps / self.steps,
        )

    # -- inside ----------------------------------------------------------------------------

    def _look(self) -> None:
        hand, wrist = self.worlds.place("robot/hand"), self.worlds.place("person/right_wrist")
        w, x, y, z = hand[:, 3:].T
        ahead = np.stack(
            [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)], axis=1
        )
        self._seen = {
            "middle": hand[:, :3] + ARM.hand * ahead,
            "cup": self.worlds.place("cup")[:, :3].copy(),
            "palm": self.people.palms(wrist),
        }

    def _comfort(self) -> Array:
        return self.people.point_to_world(np.broadcast_to(COMFORT, (self.count, 3)))

    def _distance(self) -> Array:
        """Of the cups from the comfortable places (N,) [m]."""
        return _length(self._comfort() - self._seen["cup"])

    def _fingers(self) -> Array:
        """Mean opening of the fingers (N,) [m]."""
        motors = self.worlds.motors
        return 0.5 * (motors[:, 0, 4] + motors[:, 0, 5])

    def _pressed(self) -> Array:
        """Force on the people and what they hold, by robot and cup (N,) [N]."""
        force = self.worlds.force
        direct = force("person", "robot") + force("person", "fingers") + force("person", "cup")
        through = force("cup", "robot") + force("cup", "fingers")
        return _length(direct + np.where(self._held[:, None], through, 0.0))

    def _grasp(self, takes: Flags, active: Flags) -> None:
        """Hands that take what lies on them hold it from now on."""
        gap = self._seen["cup"] - [0.0, 0.0, _UNDER] - self._seen["palm"]
        gentle = _length(self._moving["cup"] - self._moving["palm"]) < GENTLE
        self._took = takes & active & ~self._held & gentle & (_length(gap) < GRASP)
        for i in np.flatnonzero(self._took):
            self.worlds.attach(int(i), "cup", "right_wrist")
        self._held = self._held | self._took


def _length(vectors: Array) -> Array:
    """Lengths (N,) of vectors (N, 3)."""
    out: Array = np.sqrt(np.sum(vectors * vectors, axis=1))
    return out
