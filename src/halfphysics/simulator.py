"""One frame at a time: the stateful simulator. `simulate` runs it over a whole motion."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from halfphysics.errors import InputError
from halfphysics.inside import Depths, inside_of
from halfphysics.pose import Pose
from halfphysics.settings import Settings

if TYPE_CHECKING:
    from halfphysics.body import Body
    from halfphysics.scene import Scene
    from halfphysics.world import World

Array = NDArray[np.float64]
T = TypeVar("T")


@dataclass(frozen=True)
class Touches:
    """What touched what in one frame; arrays of one length n, one row per pair and side.

    Attributes:
        person: Index of the person (n,), -1 where an object touches something that is no person.
        part: Joint index of the part (n,), -1 for objects.
        subject: Index into the names of the object that plays the part's role (n,), else -1.
        other: Index into the names of what was touched (n,).
        other_part: Joint index on the other, where that is a person (n,), else -1.
        position: In the world (n, 3) [m].
        normal: Unit vector from the other into the part (n, 3).
        impulse: On the part, summed over the frame (n, 3) [N s].
    """

    person: NDArray[np.int64]
    part: NDArray[np.int64]
    subject: NDArray[np.int64]
    other: NDArray[np.int64]
    other_part: NDArray[np.int64]
    position: Array
    normal: Array
    impulse: Array


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Frame:
    """The state after one `Simulator.step`.

    Poses, objects, contacts and what is inside are worked out when first read: stepping pays for
    none of them.

    Attributes:
        poses: The people's corrected poses.
        objects: Name -> (position (3,) [m], quaternion (4,)); links of articulated objects too.
        joints: Name of an articulated object's joint -> its value () [rad or m], (4,) of a ball.
        contacts: What touched during the frame.
        inside: Which parts and objects are inside what, and how deep.
        clearance: Smallest distance of the people from the statics [m]; inf beyond
            `Settings.clearance_range`, negative where they penetrate.
        lost_time: Time by which blocked steps were shortened [s].
        diagnostics: Numbers of the frame, see `halfphysics.result.DIAGNOSTICS`.
        substeps: With `Settings.record="substeps"`: model coordinates (N, nq) after every
            substep, else (0, nq).
    """

    clearance: float
    lost_time: float
    diagnostics: Mapping[str, float]
    substeps: Array
    _world: World
    _qpos: Array
    _axes: tuple[Array, ...]
    _touches: Array
    _inside: Array

    @cached_property
    def poses(self) -> tuple[Pose, ...]:
        people = zip(self._world.people, self._axes, strict=True)
        return tuple(Pose.trusted(*person.pose(self._qpos, axes), axes) for person, axes in people)

    @cached_property
    def objects(self) -> Mapping[str, tuple[Array, Array]]:
        return {thing.name: thing.pose(self._qpos) for thing in self._world.tracked}

    @cached_property
    def joints(self) -> Mapping[str, Array]:
        return {joint.name: joint.values(self._qpos) for joint in self._world.joints}

    @cached_property
    def contacts(self) -> Touches:
        return touches(self._world, self._touches)[0]

    @cached_property
    def inside(self) -> Depths:
        return inside_of(self._world, self._inside, np.zeros(len(self._inside), dtype=int)).at(0)

    @property
    def pose(self) -> Pose:
        """The first person's pose."""
        return self.poses[0]

    def __getstate__(self) -> dict[str, Any]:
        """For copies and other processes: everything worked out, the simulator left behind."""
        done = {
            "poses": self.poses,
            "objects": self.objects,
            "joints": self.joints,
            "contacts": self.contacts,
            "inside": self.inside,
        }
        return done | {name: v for name, v in vars(self).items() if not name.startswith("_")}

    def __repr__(self) -> str:
        return (
            f"Frame({len(self.poses)} people, {len(self.objects)} objects, "
            f"{len(self.contacts.part)} contacts, clearance {self.clearance:g} m)"
        )


@dataclass(frozen=True)
class State:
    """All that a simulation remembers between frames; `Simulator.set_state` resumes bit-exactly."""

    numbers: bytes
    axes: tuple[Array, ...]
    signature: str


class Simulator:
    """Half-physics, one frame at a time; the numbers are those of `simulate`.

    Args:
        scene: Statics and objects; None: an empty one.
        body: The person's body, or a sequence for several people (empty: objects alone); None:
            `Body.default()`.
        settings: See `Settings`.
        fps: Frame rate that `step` assumes where it is given no `dt`.

    Raises:
        InputError: An impossible value.
    """

    def __init__(
        self,
        scene: Scene | None = None,
        *,
        body: Body | Sequence[Body] | None = None,
        settings: Settings | None = None,
        fps: float = 30.0,
    ) -> None:
        from halfphysics.body import Body
        from halfphysics.scene import Scene
        from halfphysics.world import World

        if body is None:
            body = Body.default()
        bodies = several(body)
        for one in bodies:
            if not isinstance(one, Body):
                raise InputError(f"body: found {one!r}, expected a halfphysics.Body")
        if scene is not None and not isinstance(scene, Scene):
            raise InputError(f"scene: found {scene!r}, expected a halfphysics.Scene")
        if settings is not None and not isinstance(settings, Settings):
            raise InputError(f"settings: found {settings!r}, expected halfphysics.Settings")
        self.settings = settings or Settings()
        self.dt = 1.0 / _positive("fps", fps)
        self.world = World(bodies, scene or Scene(), self.settings)
        self._axes: tuple[Array, ...] = tuple(np.eye(3) for _ in bodies)
        self._started = False

    @property
    def names(self) -> tuple[str, ...]:
        """What contacts refer to: statics, objects, people."""
        return self.world.names

    @property
    def bodies(self) -> tuple[Body, ...]:
        """The people's bodies."""
        return self.world.bodies

    def reset(self, pose: Pose | Sequence[Pose]) -> Frame:
        """Put the people at a pose (one each), objects at their start; everything forgets."""
        poses = self._checked(pose)
        self._axes = tuple(np.array(p.axes, dtype=np.float64) for p in poses)
        self.world.stepper.reset(*self.world.start(poses))
        self._started = True
        return self._frame(np.zeros((0, self.world.nq)), moved=False)

    def step(self, pose: Pose | Sequence[Pose], dt: float | None = None) -> Frame:
        """Drive the people towards a pose (one each) for one frame of `dt` [s] (None: 1/fps).

        Raises:
            InputError: Before `reset`, for another number of poses, or an impossible `dt`.
        """
        poses = self._checked(pose)
        if not self._started:
            raise InputError("step: the simulator has no pose yet; call reset(pose) first")
        dt = self.dt if dt is None else _positive("dt", dt)
        return self._advance(self.world.targets(poses), dt)

    def _advance(self, targets: Array, dt: float) -> Frame:
        return self._frame(self._move(targets, dt))

    def _move(self, targets: Array, dt: float) -> Array:
        """One frame of the core; what `Settings.record` asks to keep of it (., nq)."""
        count = self.settings.substeps_for(dt)
        record = self.settings.record == "substeps"
        return self.world.stepper.frame(targets, dt, count, record)

    def get_state(self) -> State:
        """Everything the simulation remembers: continue from it with `set_state`, bit for bit."""
        if not self._started:
            raise InputError("get_state: the simulator has no pose yet; call reset(pose) first")
        return State(self.world.stepper.save().tobytes(), self._axes, self.world.signature)

    def set_state(self, state: State) -> None:
        """Return to a state of this simulator or of one with the same people, scene and settings.

        Raises:
            InputError: The state belongs to another model.
        """
        if not isinstance(state, State) or state.signature != self.world.signature:
            raise InputError(
                "set_state: the state is of another simulator; expected one with the same people "
                f"and things: {', '.join(self.names)}"
            )
        try:
            self.world.stepper.load(np.frombuffer(state.numbers))
        except ValueError as error:
            raise InputError(f"set_state: {error}; expected one that get_state gave") from None
        self._axes = state.axes
        self._started = True

    # -- inside ----------------------------------------------------------------------------

    def _checked(self, pose: Pose | Sequence[Pose]) -> list[Pose]:
        poses = several(pose)
        if len(poses) != len(self.world.people) or not all(isinstance(p, Pose) for p in poses):
            found = ", ".join(type(p).__name__ for p in poses) or "none"
            raise InputError(
                f"pose: found {found}; expected one halfphysics.Pose per person, "
                f"{len(self.world.people)} in all (motion[i] gives one)"
            )
        return poses

    def _frame(self, substeps: Array, moved: bool = True) -> Frame:
        stepper = self.world.stepper
        numbers = stepper.diagnostics() if moved else {"lost_time": 0.0}
        return Frame(
            clearance=stepper.clearance(),
            lost_time=numbers.pop("lost_time"),
            diagnostics=numbers,
            substeps=substeps,
            _world=self.world,
            _qpos=stepper.qpos(),
            _axes=self._axes,
            _touches=stepper.touches(),
            _inside=stepper.inside(),
        )


def touches(world: World, rows: Array) -> tuple[Touches, NDArray[np.int64]]:
    """Contacts in terms of people and names, from the core's rows (n, 12).

    Where two people touch, each has a row of its own, with opposite normal and impulse.

    Returns:
        The contacts (m,), and for each the row it comes from (m,).
    """
    mover, static, mover2 = rows[:, :3].astype(np.int64).T
    # One more entry for index -1: the core's rows have either a static or a second mover.
    static_name = np.append(world.static_name, -1)
    mover_name = np.append(world.mover_name, -1)
    mover_part = np.append(world.mover_part, -1)
    first_person = len(world.names) - len(world.people)
    name, part = mover_name[mover], mover_part[mover]
    fixed = static >= 0
    other = np.where(fixed, static_name[static], mover_name[mover2])
    other_part = np.where(fixed, -1, mover_part[mover2])
    human = name >= first_person
    both = human & (other >= first_person)

    row = np.repeat(np.arange(len(rows)), 1 + both)
    twin = np.zeros(len(row), dtype=bool)
    twin[1:] = row[1:] == row[:-1]
    mine, its = np.where(twin, other[row], name[row]), np.where(twin, name[row], other[row])
    human = human[row]
    sign = np.where(twin, -1.0, 1.0)[:, None]
    return Touches(
        person=np.where(human, mine - first_person, -1),
        part=np.where(twin, other_part[row], part[row]),
        subject=np.where(human, -1, mine),
        other=its,
        other_part=np.where(twin, part[row], other_part[row]),
        position=rows[row, 3:6],
        normal=sign * rows[row, 6:9],
        impulse=sign * rows[row, 9:12],
    ), row


def _positive(name: str, value: float) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = math.nan
    if not (math.isfinite(number) and number > 0.0):
        raise InputError(f"{name}: found {value!r}, expected a positive number")
    return number


def several(value: T | Sequence[T]) -> list[T]:
    """One thing, or a list or tuple of them, as a list."""
    return list(value) if isinstance(value, list | tuple) else [cast(T, value)]
