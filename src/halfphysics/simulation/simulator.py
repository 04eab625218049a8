"""One frame at a time: the stateful simulator. `simulate` runs it over a whole motion."""

from __future__ import annotations

import logging
import os
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.base.atomic import atomic_path
from halfphysics.base.in_notebook import InNotebook
from halfphysics.base.short_repr import counted
from halfphysics.base.stopwatch import Stopwatch
from halfphysics.base.validation import real, several, shown, within
from halfphysics.errors import InputError
from halfphysics.motion.joint_groups import stiffness_array
from halfphysics.motion.pose import Pose
from halfphysics.results.argument_checks import checked_bodies, checked_scene, checked_settings
from halfphysics.results.moment import Figure, Moment, at_start, standing_still, tracks
from halfphysics.results.overview import scene_lines
from halfphysics.simulation import holding, live_edits
from halfphysics.simulation.argument_checks import check_person_index
from halfphysics.simulation.build_world import build_world
from halfphysics.simulation.compile_world import compiled_again
from halfphysics.simulation.frame import Frame, State
from halfphysics.simulation.soft_rows import rows_of

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.scene.rays import Hit
    from halfphysics.scene.scene import Scene
    from halfphysics.settings import Settings

logger = logging.getLogger(__name__)

Array = NDArray[np.float64]


#: The longest frame of a step [s], as the C library has it.
LONGEST_FRAME = 10.0

#: What a simulator is made of; copies also have what a subclass or its user has added.
_OWN = frozenset({"settings", "dt", "world", "_axes", "_started", "_firmness"})


class Simulator(InNotebook):
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
        bodies = checked_bodies(body)
        scene, self.settings = checked_scene(scene), checked_settings(settings)
        self.dt = 1.0 / _positive("fps", fps)
        _check_length("fps: a frame", self.dt)
        clock = Stopwatch(logger)
        self.world = build_world(bodies, scene, self.settings)
        clock.done("built the world of a simulator of %d items", len(self.world.names))
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
        self._must_be_native()
        poses = self._checked(pose)
        if self.world.held:
            self.world = build_world(self.bodies, self.world.made_of, self.settings)
        self._axes = tuple(np.array(p.axes, dtype=np.float64) for p in poses)
        self.world.reset(poses)
        self._firmness = np.tile(self.world.stiffness, (len(poses), 1))
        self._started = True
        return self._frame(np.zeros((0, self.world.nq)), poses, moved=False)

    def step(self, pose: Pose | Sequence[Pose], dt: float | None = None) -> Frame:
        """Drive the people towards a pose (one each) for one frame of `dt` [s] (None: 1/fps).

        Raises:
            InputError: Before `reset`, for another number of poses, or an impossible `dt`.
        """
        poses = self._checked(pose)
        if not self._started:
            raise InputError("step: the simulator has no pose yet; call reset(pose) first")
        dt = self.dt if dt is None else _positive("dt", dt)
        _check_length("step: dt", dt)
        with self._tensed(poses):
            substeps = self._move(self.world.targets(poses), dt)
        return self._frame(substeps, poses)

    @contextmanager
    def _tensed(self, poses: list[Pose]) -> Iterator[None]:
        """Within it, joints are as stiff as `Pose.stiffness_scale` of the poses says."""
        if all(pose.stiffness_scale is None for pose in poses):
            yield
            return
        scales = [1.0 if (its := pose.stiffness_scale) is None else its for pose in poses]
        rows = [row * scale for row, scale in zip(self._firmness, scales, strict=True)]
        self.world.stepper.set_stiffness(self.world.stiffness_to_core(np.stack(rows)))
        try:
            yield
        finally:
            self.world.stepper.set_stiffness(self.world.stiffness_to_core(self._firmness))

    def _move(self, targets: Array, dt: float) -> Array:
        """One frame of the core; what `Settings.record` asks to keep of it (., nq)."""
        count = self.settings.substeps_for(dt)
        record = self.settings.record == "substeps"
        result: Array = self.world.stepper.frame(targets, dt, count, record)
        return result

    def set_stiffness(
        self, value: float | Mapping[str, float] | Array, *, person: int | None = None
    ) -> None:
        """Change the stiffness lambda of the joints from the next step on.

        `reset` goes back to `Settings.stiffness`; a state keeps what it had.

        Args:
            value: A number, numbers by joint group or joint (those not named: 1), or (55,).
            person: Index of the one person whose joints are meant; None: of all people.

        Raises:
            InputError: Before `reset`; a joint that does not exist, a number below 0.
        """
        if not self._started:
            raise InputError("set_stiffness: the simulator has no pose yet; call reset(pose) first")
        firmness = stiffness_array(value, "set_stiffness")
        people = len(self.world.people)
        check_person_index("set_stiffness", person, people)
        chosen = slice(None) if person is None else person
        self._firmness[chosen] = firmness
        self.world.stepper.set_stiffness(self.world.stiffness_to_core(self._firmness))

    def get_state(self) -> State:
        """Everything the simulation remembers: continue from it with `set_state`, bit for bit."""
        if not self._started:
            raise InputError("get_state: the simulator has no pose yet; call reset(pose) first")
        world = self.world
        return State(world.stepper.save().tobytes(), self._axes, world.signature, world.held)

    def set_state(self, state: State) -> None:
        """Return to a state of this simulator or of one with the same people and items.

        What was held then is held again, nothing else is. The settings stay those of this
        simulator: from one state several may be tried.

        Raises:
            InputError: The state belongs to another model.
        """
        self._must_be_native()
        if not isinstance(state, State) or state.signature != self.world.signature:
            raise InputError(
                "set_state: the state is of another simulator; expected one with the same people "
                f"and items: {', '.join(self.names)}"
            )
        world = self.world
        if state.held != world.held:
            world = build_world(world.bodies, world.made_of, world.settings, state.held)
        try:
            world.stepper.load(np.frombuffer(state.numbers))
        except ValueError as error:
            raise InputError(f"set_state: {error}; expected one that get_state gave") from None
        self.world = world
        self._axes = state.axes
        self._firmness = self.world.stiffness_from_core(self.world.stepper.stiffness())
        self._started = True

    def save_world(self, path: str | os.PathLike[str]) -> None:
        """Write the world to a file for programs without Python (docs/c-api.md): `*.hpw`.

        People, scene and settings as they are now, with what is held; not where things are: the
        file's reader resets it. It contains the skin of each person's body: share that of a
        licensed body model only as its licence allows.

        Raises:
            InputError: A baseline that runs in Python. FileError: It cannot be written.
        """
        self._must_be_native()
        data = compiled_again(self.world, self._axes)
        with atomic_path(path) as temporary:
            temporary.write_bytes(data)

    def velocity(self, name: str) -> tuple[Array, Array]:
        """An object's velocity (3,) [m/s] of its origin and angular (3,) [rad/s], in the world."""
        self._must_run("velocity")
        return live_edits.velocity(self.world, name)

    def set_velocity(
        self, name: str, velocity: ArrayLike, angular_velocity: ArrayLike | None = None
    ) -> None:
        """Give an object a velocity; what is asleep wakes.

        Args:
            name: Of an object.
            velocity: Of its origin (3,), in the world [m/s].
            angular_velocity: In the world (3,) [rad/s]; None: as it is.

        Raises:
            InputError: Before `reset`, another name, something that moves on a trajectory, or
                what is no vector.
        """
        self._must_run("set_velocity")
        live_edits.set_velocity(self.world, name, velocity, angular_velocity)

    def apply_impulse(
        self,
        name: str,
        impulse: ArrayLike,
        point: ArrayLike | None = None,
        angular: ArrayLike | None = None,
    ) -> None:
        """Push an object, now: its velocities change at once; what is asleep wakes.

        Args:
            name: Of an object.
            impulse: In the world (3,) [N s].
            point: Where in the world it acts (3,) [m]; None: at the centre of mass.
            angular: A turning impulse besides, in the world (3,) [N m s].

        Raises:
            InputError: As for `set_velocity`.
        """
        self._must_run("apply_impulse")
        live_edits.apply_impulse(self.world, name, impulse, point, angular)

    def add_object(self, name: str, shape: Any, **options: Any) -> None:
        """Bring in an object, where and as fast as its options say; all else goes on.

        Arguments are those of `Scene.add_object`. The simulator's scene is one of its own from
        then on (the one it was made with stays as it is), `names` has the new name, and states
        from before do not fit any more.

        Raises:
            InputError: As `Scene.add_object` does. FileError: A mesh file that cannot be used.
        """
        scene = self.world.made_of._copied()
        scene.add_object(name, shape, **options)
        self.world = live_edits.rebuilt(self.world, scene, self._started)

    def remove_object(self, name: str) -> None:
        """Take an object away; all else goes on. See `add_object`.

        Raises:
            InputError: There is none of this name.
        """
        live_edits.removable(self.world, name)
        scene = self.world.made_of._copied(without=name)
        self.world = live_edits.rebuilt(self.world, scene, self._started)

    def attach(self, name: str, part: str = "right_wrist", person: int = 0) -> None:
        """Tie an object to a part of a person, where it is at this moment.

        From then on it moves with the part as one rigid body: the part has its mass and inertia,
        and what it meets acts on the person. It meets everything but its holder and what the same
        person holds. It takes over the part's velocity; what is asleep wakes. `reset` lets go.

        Args:
            name: Of an object.
            part: Name of a joint; `"right_wrist"` is the right hand.
            person: Index of the person that holds it.

        Raises:
            InputError: Before `reset`; another name, part or person; something held already, on a
                trajectory or articulated; a baseline's settings.
        """
        self._must_run("attach")
        held = holding.with_held(self.world, name, part, person)
        self.world = live_edits.rebuilt(self.world, self.world.made_of, True, held)

    def release(self, name: str) -> None:
        """Let go of what `attach` tied: a free object again, with the velocity that it has.

        Raises:
            InputError: Before `reset`, another name, or an object that is not held.
        """
        self._must_run("release")
        held = holding.without_held(self.world, name)
        self.world = live_edits.rebuilt(self.world, self.world.made_of, True, held)

    @property
    def held(self) -> Mapping[str, tuple[int, str]]:
        """Name of what is held -> index of the person and name of the part."""
        return {name: (hold.person, hold.part) for name, hold in self.world.held.items()}

    def ray(
        self, origin: ArrayLike, direction: ArrayLike, *, ignore: Collection[str] = ()
    ) -> Hit | None:
        """What a ray from `origin` (3,) [m] along `direction` (3,) meets first now; None: nothing.

        Like `Scene.ray`, with objects and links where they are and the people's skin. `ignore`:
        names to pass through, as in `names`.

        Raises:
            InputError: Before `reset`, no vector, a direction of no length, an unknown name.
        """
        self._must_run("ray")
        return live_edits.ray(self.world, self._axes, origin, direction, ignore)

    def __getstate__(self) -> dict[str, Any]:
        """For copies and other processes: what the world is made of, and the state it is in."""
        return {
            "bodies": self.bodies,
            "scene": self.world.made_of,
            "settings": self.settings,
            "dt": self.dt,
            "axes": self._axes,
            "state": self.get_state() if self._started else None,
            "more": {name: v for name, v in vars(self).items() if name not in _OWN},
        }

    def __setstate__(self, given: dict[str, Any]) -> None:
        self.settings, self.dt, self._axes = given["settings"], given["dt"], given["axes"]
        self.world = build_world(given["bodies"], given["scene"], given["settings"])
        self._started = False
        vars(self).update(given["more"])
        if given["state"] is not None:
            self.set_state(given["state"])

    def __repr__(self) -> str:
        world = self.world
        statics = len(world.made_of.statics)
        return (
            f"Simulator({counted(len(self.bodies), 'person', 'people')}, "
            f"{counted(statics, 'static')}, {counted(len(world.tracked), 'object')}, "
            f"{1.0 / self.dt:g} fps: "
            f"{'running' if self._started else 'call reset(pose) first'})"
        )

    def _notebook_moment(self) -> Moment:
        """People and things where they are now; before `reset` the scene alone, at its start."""
        scene = self.world.made_of
        if not self._started:
            return Moment(scene=scene, objects=at_start(scene))
        qpos = self.world.stepper.qpos()
        people = tuple(
            Figure(body, standing_still(Pose(*person.pose(qpos, axes), axes)))
            for body, person, axes in zip(self.bodies, self.world.people, self._axes, strict=True)
        )
        poses = {place.name: place.pose(qpos) for place in self.world.tracked}
        return Moment(people=people, scene=scene, objects=tracks(poses))

    def _notebook_lines(self) -> list[str]:
        held = [f"{name}: held by {part}" for name, (_, part) in self.held.items()]
        return [*scene_lines(self.world.made_of), *held]

    # -- inside ----------------------------------------------------------------------------

    def _must_run(self, what: str) -> None:
        if not self._started:
            raise InputError(f"{what}: the simulator has no pose yet; call reset(pose) first")

    def _must_be_native(self) -> None:
        if self.settings.drive.follow is not None:
            raise InputError(
                f"the baseline {type(self.settings).__name__} follows whole motions only; expected "
                "other settings here. Use halfphysics.simulate"
            )

    def _checked(self, pose: Pose | Sequence[Pose]) -> list[Pose]:
        poses = several(pose)
        if len(poses) != len(self.world.people) or not all(isinstance(p, Pose) for p in poses):
            found = ", ".join(type(p).__name__ for p in poses) or "none"
            raise InputError(
                f"pose: found {found}; expected one halfphysics.Pose per person, "
                f"{len(self.world.people)} in all (motion[i] gives one)"
            )
        return poses

    def _frame(self, substeps: Array, poses: list[Pose], moved: bool = True) -> Frame:
        stepper = self.world.stepper
        numbers = stepper.diagnostics() if moved else {"lost_time": 0.0}
        return Frame(
            clearance=stepper.clearance(),
            lost_time=numbers.pop("lost_time"),
            corrected=stepper.footing()[:, 1] != 0.0,
            diagnostics=numbers,
            substeps=substeps,
            _world=self.world,
            _qpos=stepper.qpos(),
            _axes=self._axes,
            _set=tuple(poses) if self.settings.drive.poses else None,
            _contacts=stepper.touches(),
            _inside=stepper.inside(),
            _breaches=stepper.breaches() if moved else np.zeros((0, 4)),
            _torques=stepper.torques() if moved else np.zeros((0, 3)),
            _soft=rows_of(stepper) if self.world.soft else None,
        )


def _check_length(what: str, dt: float) -> None:
    if dt > LONGEST_FRAME:
        raise InputError(f"{what}: found {dt:g} s, expected at most {LONGEST_FRAME:g} s")


def _positive(name: str, value: float) -> float:
    number = real(value)
    if number is None or not within(number, above=0.0):
        raise InputError(f"{name}: found {shown(value)}, expected a positive number")
    return number
