"""Steps a MuJoCo world of another program, with that program's model and actuators.

`bind` makes a `Control`, whose `step` replaces `mujoco.mj_step`. MuJoCo's own step computes the
velocities of all bodies without the people; the impulses between people and world are added to them
(docs/physics.md).
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.copying import Bound
from halfphysics.base.short_repr import counted
from halfphysics.base.validation import real, several
from halfphysics.errors import InputError
from halfphysics.motion.joint_groups import stiffness_array
from halfphysics.motion.pose import Pose
from halfphysics.motion.skeleton import N_JOINTS
from halfphysics.mujoco import engine
from halfphysics.mujoco.contact_data import PersonContacts, person_contacts
from halfphysics.mujoco.host_masses import HostMasses, hangs_on_people
from halfphysics.mujoco.host_model import host_model
from halfphysics.mujoco.sensors import SensorFeed
from halfphysics.simulation.argument_checks import check_person_index
from halfphysics.simulation.coordinates import joints_from_core, joints_to_core
from halfphysics.simulation.core_rows import ContactRows, contact_rows
from halfphysics.simulation.start_warnings import warn_of_hosted_start

if TYPE_CHECKING:
    from halfphysics.mujoco.attach import Human
    from halfphysics.settings import Settings
    from halfphysics.simulation.coordinates import Person

Array = NDArray[np.float64]

_WHOLE = 1e-6  # relative tolerance for a step to be a whole number of timesteps
_MOST = 1e6  # timesteps of one step
_FORCES = 13  # numbers of one of the core's forces among the host's


class Control(Bound):
    """Steps a MuJoCo world with people in it; `bind` makes one.

    Attributes:
        names: Names to which contacts refer: the world's geoms, then the people.
        people: Their names, bodies and places in the core.
    """

    _WHY = (
        "it steps a MuJoCo model and its data, which are yours; bind the person again over there, "
        "and pass on get_state() with the data"
    )

    def __init__(self, model: Any, data: Any, humans: Sequence[Human], settings: Settings) -> None:
        from halfphysics import _native

        self._model, self._data, self.settings = model, data, settings
        self._host = host_model(model, humans, settings)
        self.names: tuple[str, ...] = self._host.names
        self.people: tuple[Person, ...] = self._host.people
        self._stepper = self._host.stepper
        self._world = _native.HostedWorld(self._stepper)
        self._connect()
        self._masses = HostMasses(model, self._host)
        self._sensors = SensorFeed(model, data)
        usual = stiffness_array(settings.stiffness, "Settings.stiffness")
        self._usual = np.tile(usual, (len(humans), 1))
        self._stiffness = self._usual.copy()
        self._axes = [np.eye(3) for _ in humans]
        self._timestep = float(model.opt.timestep)  # of the last step [s]
        self._started = False
        self._moved = False  # since the last reset or set_state

    def __repr__(self) -> str:
        state = "running" if self._started else "call reset(pose) first"
        people = ", ".join(repr(person.name) for person in self.people)
        around = len(self.names) - len(self.people)
        return f"Control({people}, {counted(around, 'geom')} around: {state})"

    def reset(self, pose: Pose | Sequence[Pose]) -> None:
        """Put the people at a pose (one each), at rest.

        With `Settings.weight` they stand on what is near under them. Warns of what of them starts
        inside the world.
        """
        import mujoco

        poses = self._checked(pose)
        self._follow_masses("reset")
        self._axes = [np.array(p.axes) for p in poses]
        still = np.zeros(len(self.people) * (3 * N_JOINTS + 3))
        self._stepper.reset(
            np.concatenate([self._data.qpos, self._targets(poses)]),
            np.concatenate([self._data.qvel, still]),
        )
        self._stiffness = self._usual.copy()
        self._tell_stiffness(self._stiffness)
        self._world.start()
        mujoco.mj_forward(self._model, self._data)
        self._started, self._moved = True, False
        warn_of_hosted_start(self._host, self._stepper.inside())

    def step(self, pose: Pose | Sequence[Pose], dt: float | None = None) -> None:
        """Replaces `mujoco.mj_step`: step the world and drive the people to a pose (one each).

        Args:
            pose: Reference pose at the end of the step.
            dt: Length of the step [s], any number above 0; None: one timestep of the model. It is
                cut into equal timesteps of at most `model.opt.timestep`, so that the world and the
                people both arrive exactly at its end: 17 of 1.961 ms for a thirtieth of a second
                with the default timestep of 2 ms.

        Raises:
            InputError: Before `reset`, for another number of poses, or an impossible `dt`; then
                nothing has changed.
        """
        h = self._aim(pose, dt)
        try:
            with _timestep(self._model, h):
                self._run()
        finally:
            self._relax()
        self._finish()

    def set_stiffness(
        self, value: float | Mapping[str, float] | Array, *, person: int | None = None
    ) -> None:
        """Change the stiffness lambda of the joints from the next step on.

        `reset` restores `Settings.stiffness`; a saved state keeps its own.

        Args:
            value: A number, numbers by joint group or joint (others: 1), or (55,).
            person: Index of the one person whose joints are meant; None: of all people.

        Raises:
            InputError: Before `reset`; a joint that does not exist, a number below 0.
        """
        if not self._started:
            raise InputError("set_stiffness: the person has no pose yet; call reset(pose) first")
        stiffness = stiffness_array(value, "set_stiffness")
        check_person_index("set_stiffness", person, len(self.people))
        self._stiffness[slice(None) if person is None else person] = stiffness
        self._tell_stiffness(self._stiffness)

    @property
    def poses(self) -> tuple[Pose, ...]:
        """The people's simulated poses."""
        qpos = self._stepper.qpos()
        people = zip(self.people, self._axes, strict=True)
        return tuple(Pose.trusted(*person.pose(qpos, axes), axes) for person, axes in people)

    @property
    def pose(self) -> Pose:
        """The first person's simulated pose."""
        return self.poses[0]

    @property
    def contacts(self) -> ContactRows:
        """The people's contacts during the last `step`, summed over its timesteps; `other` indexes
        `names`."""
        return contact_rows(self._host, self._stepper.touches())[0]

    @property
    def contact(self) -> PersonContacts:
        """The people's contact points in the last timestep, as `data.contact` has the others'."""
        return person_contacts(self._host, self._world.points(), self._timestep)

    @property
    def torques(self) -> Array:
        """Mean torque of the drive on the people's joints in the last `step` (people, 55, 3) [N m];
        row 0 acts on the whole body. See `PersonResult.torque`."""
        found = self._stepper.torques() if self._moved else ()
        if not len(found):  # all are zero
            return np.zeros((len(self.people), N_JOINTS, 3))
        return joints_from_core(self.people, np.asarray(found))

    @property
    def torque(self) -> Array:
        """The first person's (55, 3) [N m]."""
        first: Array = self.torques[0]
        return first

    @property
    def clearance(self) -> float:
        """Distance of the people from static geometry [m]; inf beyond
        `Settings.clearance_range`."""
        return float(self._stepper.clearance())

    def get_state(self) -> bytes:
        """The people's state; save MuJoCo's own state with it."""
        forces = self._world.forces()
        end = [self._signature(), len(forces)]
        return bytes(np.concatenate([self._stepper.save(), forces.ravel(), end]).tobytes())

    def set_state(self, state: bytes) -> None:
        """Restore a state of `get_state`; restore `data` first.

        `contacts`, `contact` and `torques` are of the last step: there are none until the next.

        Raises:
            InputError: The state belongs to another model.
        """
        expected = "expected one that get_state gave"
        if not isinstance(state, bytes) or len(state) < 16 or len(state) % 8:
            raise InputError(f"set_state: found {type(state).__name__} of another kind; {expected}")
        numbers = np.frombuffer(state)
        signature, count = numbers[-2:]
        if signature != self._signature():
            raise InputError(
                f"set_state: the state is not whole, or of another world; {expected} with these "
                f"geoms and people: {', '.join(self.names)}"
            )
        if not 0 <= count <= self._model.nbody or _FORCES * count > len(numbers) - 2:
            raise InputError(f"set_state: the state is not whole; {expected}")
        end = len(numbers) - 2 - _FORCES * int(count)
        forces = numbers[end:-2].reshape(-1, _FORCES).copy()
        if not np.isin(forces[:, 0], self._host.bodies).all():
            raise InputError(f"set_state: forces on bodies that are not there; {expected}")
        try:
            self._stepper.load(numbers[:end].copy())
        except ValueError as error:
            raise InputError(f"set_state: {error}; {expected}") from None
        self._stiffness = self._stiffness_from_core()
        self._change_forces(forces)
        self._world.show()
        self._started, self._moved = True, False

    def _change_forces(self, forces: Array) -> None:
        """Have the forces of a state among the world's, in place of people's forces of now.

        Which of the two `data.xfrc_applied` has depends on the user: some of MuJoCo's states bring
        those of then along, others leave those of now. What is of now is taken back.
        """
        applied = self._data.xfrc_applied
        there = applied.copy()
        self._world.start()
        for body, then in zip(forces[:, 0].astype(int), forces[:, 7:], strict=True):
            applied[body] = np.where(there[body] == then, then, applied[body])
        self._world.set_forces(forces)

    def _signature(self) -> float:
        """Differs where geoms or people do."""
        return float(zlib.crc32("\n".join(self.names).encode()))

    def _connect(self) -> None:
        """Hand MuJoCo's arrays to the core; they stay MuJoCo's."""
        model, data = self._model, self._data
        arrays = (
            data.qpos, data.qvel, data.qacc, model.dof_damping, data.xipos, data.xfrc_applied,
            data.mocap_pos, data.mocap_quat,
        )  # fmt: skip
        self._world.set_arrays(*arrays, self._host.bodies, self._host.mirrors.ravel())
        at = engine.Addresses.of(model, data)
        self._alone = at.step != 0
        if self._alone:
            hangs = hangs_on_people(model, self._host)
            self._world.set_engine(at.step, at.model, at.data, hangs)

    def _aim(self, pose: Pose | Sequence[Pose], dt: float | None) -> float:
        """Everything before the timesteps of a step; returns their length [s]."""
        count, h = self._steps(dt)
        poses = self._ready(pose)
        self._follow_masses("step")
        self._tensed = any(p.stiffness_scale is not None for p in poses)
        if self._tensed:
            scales = [1.0 if p.stiffness_scale is None else p.stiffness_scale for p in poses]
            rows = [row * scale for row, scale in zip(self._stiffness, scales, strict=True)]
            self._tell_stiffness(np.stack(rows))
        self._world.aim(self._targets(poses), count, h)
        self._count, self._timestep = count, h
        return h

    def _follow_masses(self, what: str) -> None:
        """MuJoCo reads its model in every step; so do people."""
        try:
            self._masses.follow(self._world)
        except ValueError as error:
            raise InputError(f"{what}: MjModel: {error}") from None

    def _ready(self, pose: Pose | Sequence[Pose]) -> list[Pose]:
        """The poses of a step, which can be made."""
        if not self._started:
            raise InputError("step: the person has no pose yet; call reset(pose) first")
        return self._checked(pose)

    def _run(self) -> None:
        """The timesteps: by the core, or by Python where MuJoCo calls back into it."""
        import mujoco

        world = self._world
        if self._alone and not engine.watched():
            world.run()
            if world.error:
                raise mujoco.FatalError(world.error)
            return
        world.begin()
        for k in range(self._count):
            world.before(k)
            mujoco.mj_step(self._model, self._data)
            world.after(k)
        world.end()

    def _relax(self) -> None:
        """After the timesteps: joints are as stiff as they were before."""
        if self._tensed:
            self._tell_stiffness(self._stiffness)

    def _finish(self) -> None:
        """After the timesteps: MuJoCo's sensors know of the people."""
        self._moved = True
        pushed = self._world.pushes()
        if pushed or self._sensors.pushed:
            self._sensors.update(pushed, lambda: self.contact)

    def _targets(self, poses: Sequence[Pose]) -> Array:
        rows = [
            person.coordinates(pose.translation[None], pose.rotations[None], pose.axes)[0]
            for person, pose in zip(self.people, poses, strict=True)
        ]
        return np.concatenate(rows)

    def _tell_stiffness(self, values: Array) -> None:
        """Give the core the stiffness of all joints (people, 55)."""
        self._stepper.set_stiffness(joints_to_core(self.people, values))

    def _stiffness_from_core(self) -> Array:
        found = np.asarray(self._stepper.stiffness()).reshape(len(self.people), N_JOINTS)
        out = np.empty_like(found)
        for row, person in enumerate(self.people):
            out[row, person.balls] = found[row]
        return out

    def _checked(self, pose: Pose | Sequence[Pose]) -> list[Pose]:
        poses = several(pose)
        for one in poses:
            if not isinstance(one, Pose):
                raise InputError(
                    f"pose: found {type(one).__name__}, expected a halfphysics.Pose (motion[i])"
                )
        if len(poses) != len(self.people):
            raise InputError(
                f"pose: found {counted(len(poses), 'pose')}, expected one per person: "
                f"{', '.join(person.name for person in self.people)}"
            )
        return poses

    def _steps(self, dt: float | None) -> tuple[int, float]:
        """Number of timesteps of a step, and their length [s]."""
        longest = float(self._model.opt.timestep)
        if not (math.isfinite(longest) and longest > 0.0):
            raise InputError(
                f"step: the model's timestep is {longest:g} s, expected one above 0 "
                "(model.opt.timestep)"
            )
        if dt is None:
            return 1, longest
        length = real(dt)
        if length is None or not math.isfinite(length) or length <= 0.0:
            raise InputError(f"step: dt: found {dt!r}, expected a time above 0 [s]")
        if length / longest > _MOST:
            raise InputError(
                f"step: dt: found {length:g} s, expected at most {_MOST:g} timesteps of "
                f"{longest:g} s"
            )
        count = max(1, math.ceil(length / longest * (1.0 - _WHOLE)))
        # A whole number of timesteps keeps their length to the last bit.
        whole = abs(count * longest - length) <= _WHOLE * length
        return count, longest if whole else length / count


@contextmanager
def _timestep(model: Any, h: float) -> Iterator[None]:
    """Step the model by `h` [s]; afterwards its timestep is what it was."""
    before = model.opt.timestep
    model.opt.timestep = h
    try:
        yield
    finally:
        model.opt.timestep = before
