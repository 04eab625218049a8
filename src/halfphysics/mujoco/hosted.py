"""A person in a MuJoCo world of another program, with that program's model and actuators.

`attach` adds the person to a `mujoco.MjSpec`; `Human.bind` makes a `Control` whose `step` replaces
`mujoco.mj_step`. MuJoCo's own step computes the velocities of all other bodies without the person;
the impulses between person and world are added to them (docs/physics.md).
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from numbers import Real
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.copying import Bound
from halfphysics.base.short_repr import counted
from halfphysics.body.mjcf_person import add_person, addresses
from halfphysics.errors import HalfPhysicsWarning, InputError
from halfphysics.motion.joint_groups import stiffness_array
from halfphysics.motion.pose import Pose
from halfphysics.motion.skeleton import N_JOINTS
from halfphysics.mujoco import geoms
from halfphysics.scene.items import PERSON_FRICTION
from halfphysics.settings import Settings
from halfphysics.simulation.compiled_model import armature_of, model_arrays
from halfphysics.simulation.coordinates import Person
from halfphysics.simulation.core_rows import ContactRows, contact_rows
from halfphysics.simulation.core_settings import set_footing, set_limits, set_settings
from halfphysics.simulation.person_shapes import add_person_shapes
from halfphysics.simulation.start_warnings import warn_of_hosted_start

if TYPE_CHECKING:
    from halfphysics.body.body import Body

Array = NDArray[np.float64]

#: Longest step for which the drive is accurate [s] (docs/physics.md, "The drive").
LONGEST_STEP = 1.0 / 240.0
#: Number of degrees of freedom from which MuJoCo chooses a sparse Jacobian.
SPARSE = 60
_WHOLE = 1e-6  # relative tolerance for a step to be a whole number of timesteps
_SAME_MASS = 1e-9


def attach(spec: Any, body: Body | None = None, prefix: str = "human/") -> Human:
    """Add a person to a `mujoco.MjSpec`, to be driven after it is compiled.

    The person's geoms are visible and have no contacts in MuJoCo itself.

    Args:
        spec: The `mujoco.MjSpec` of a world: a robot, a kitchen.
        body: The person's body; None: `Body.default()`.
        prefix: Prefix of the names of bodies, joints, meshes and geoms.

    Raises:
        InputError: `spec` is no MjSpec or has bodies of that prefix already.
    """
    import mujoco

    from halfphysics.body.body import Body

    if not isinstance(spec, mujoco.MjSpec):
        raise InputError(
            f"attach: found {type(spec).__name__}, expected a mujoco.MjSpec "
            "(mujoco.MjSpec.from_file(path) reads one)"
        )
    if body is None:
        body = Body.default()
    if not isinstance(body, Body):
        raise InputError(f"attach: body: found {body!r}, expected a halfphysics.Body")
    if any(b.name.startswith(prefix) for b in spec.bodies):
        raise InputError(
            f"attach: the spec has bodies named {prefix}... already; give another prefix"
        )
    add_person(spec, body.variant, prefix, contype=0, conaffinity=0)
    return Human(body, prefix)


@dataclass(frozen=True, eq=False)
class Human:
    """A person that `attach` added to a spec."""

    body: Body
    prefix: str

    def bind(self, model: Any, data: Any, *, settings: Settings | None = None) -> Control:
        """Take over the person in a compiled model.

        Args:
            model, data: The `mujoco.MjModel` that the spec compiled to, and its `mujoco.MjData`.
            settings: See `Settings`; `substeps` and `record` do not apply (a substep is a timestep
                of the model), friction is that of the geoms.

        Raises:
            InputError: Another model, a person that the compiler has changed, or geoms that
                cannot be touched.
        """
        return Control(self, model, data, settings or Settings())


class Control(Bound):
    """Steps a MuJoCo world with a person in it.

    Attributes:
        names: Names to which contacts refer: the world's geoms, then the person.
    """

    _WHY = (
        "it steps a MuJoCo model and its data, which are yours; bind the person again over there, "
        "and pass on get_state() with the data"
    )

    def __init__(self, human: Human, model: Any, data: Any, settings: Settings) -> None:
        from halfphysics import _native

        _check_settings(settings)
        at = addresses(model, human.prefix)
        _check_masses(model, human, at.body)
        self._model, self._data, self._human = model, data, human
        self.settings = settings
        self._stiffness = stiffness_array(settings.stiffness, "Settings.stiffness")
        name = human.prefix.rstrip("/") or "human"
        self._person = Person.of(model, human.prefix, name, human.body)
        self.people = (self._person,)
        self._mine = model.body_rootid == at.body[0]
        used = [g for g in range(model.ngeom) if geoms.collides(model, g)]
        self._geoms = [g for g in used if not self._mine[model.geom_bodyid[g]]]
        self.names: tuple[str, ...] = (
            *(geoms.geom_name(model, g) for g in self._geoms),
            self._person.name,
        )
        if len(set(self.names)) < len(self.names):
            raise InputError(f"bind: two geoms of one name, or one named {self._person.name!r}")
        self._stepper = _native.Stepper()
        self._set_finger_armature(at.dof)
        self._stepper.set_model(**model_arrays(model))
        self._add_shapes()
        self._set_pairings()
        set_settings(self._stepper, settings, np.array(model.opt.gravity))
        self._stepper.finish([self._person.root])
        set_limits(self._stepper, settings, self.people)
        set_footing(self._stepper, settings, self.people)
        self._dof_of = np.asarray(model.dof_bodyid, dtype=np.int64)
        self._qpos_of = _qpos_bodies(model)
        self._axes = np.eye(3)
        self._started = False
        _keep_jacobian(model, int(self._mine[self._dof_of].sum()))
        if model.opt.timestep > LONGEST_STEP + 1e-12:
            warnings.warn(
                f"bind: the model's timestep is {model.opt.timestep:g} s; the drive wants at most "
                f"{LONGEST_STEP:g} s (model.opt.timestep)",
                HalfPhysicsWarning,
                stacklevel=3,
            )

    def __repr__(self) -> str:
        state = "running" if self._started else "call reset(pose) first"
        return (
            f"Control({self._person.name!r}, {counted(len(self._geoms), 'geom')} around: {state})"
        )

    def reset(self, pose: Pose) -> None:
        """Set the person to a pose, at rest, with `Settings.weight` on what is near under it; warns
        of what of it starts inside the world."""
        import mujoco

        self._axes = self._checked(pose).axes
        data, person = self._data, self._person
        first = person.qpos
        data.qpos[first : first + person.count] = self._coordinates(pose)
        data.qvel[self._mine[self._dof_of]] = 0.0
        mujoco.mj_forward(self._model, data)
        self._stepper.reset(np.array(data.qpos), np.array(data.qvel))
        self._stepper.set_stiffness(self._stiffness[self._person.balls])
        self._write_person()
        mujoco.mj_forward(self._model, data)
        self._started = True
        warn_of_hosted_start(self, self._stepper.inside())

    def step(self, pose: Pose, dt: float | None = None) -> None:
        """Replaces `mujoco.mj_step`: step the world and drive the person to `pose`.

        Args:
            pose: Reference pose at the end of the step.
            dt: Length of the step [s], any number above 0; None: one timestep of the model. It is
                cut into equal timesteps of at most `model.opt.timestep`, so that the world and the
                person both arrive exactly at its end: 17 of 1.961 ms for a thirtieth of a second
                with the default timestep of 2 ms.

        Raises:
            InputError: Before `reset`, or an impossible `dt`.
        """
        if not self._started:
            raise InputError("step: the person has no pose yet; call reset(pose) first")
        count, h = self._steps(dt)
        usual, scale = None, self._checked(pose).stiffness_scale
        if scale is not None:
            usual = np.array(self._stepper.stiffness())
            self._stepper.set_stiffness(usual * scale[self._person.balls])
        self._stepper.begin_hosted(self._coordinates(pose), count * h)
        with _timestep(self._model, h):
            for k in range(count):
                self._substep(k, h)
        self._stepper.end_hosted()
        if usual is not None:
            self._stepper.set_stiffness(usual)
        self._write_person()

    def set_stiffness(self, value: float | Mapping[str, float] | Array) -> None:
        """Change the stiffness lambda of the joints from the next step on.

        `reset` restores `Settings.stiffness`; a saved state keeps its own.

        Args:
            value: A number, numbers by joint group or joint (others: 1), or (55,).

        Raises:
            InputError: Before `reset`; a joint that does not exist, a number below 0.
        """
        if not self._started:
            raise InputError("set_stiffness: the person has no pose yet; call reset(pose) first")
        stiffness = stiffness_array(value, "set_stiffness")
        self._stepper.set_stiffness(stiffness[self._person.balls])

    @property
    def pose(self) -> Pose:
        """The person's simulated pose."""
        return Pose.trusted(*self._person.pose(self._stepper.qpos(), self._axes), self._axes)

    @property
    def contacts(self) -> ContactRows:
        """The person's contacts during the last `step`; `other` indexes `names`."""
        return contact_rows(self, self._stepper.touches())[0]

    @property
    def torque(self) -> Array:
        """Mean torque of the drive on the joints in the last `step` (55, 3) [N m]; row 0 acts on
        the whole body. See `PersonResult.torque`."""
        found, out = self._stepper.torques(), np.zeros((N_JOINTS, 3))
        if len(found):  # empty if all torques are zero
            out[self._person.balls] = found
        return out

    @property
    def clearance(self) -> float:
        """Distance of the person from static geometry [m]; inf beyond
        `Settings.clearance_range`."""
        return float(self._stepper.clearance())

    def get_state(self) -> bytes:
        """The person's state; save MuJoCo's own state with it."""
        return bytes(self._stepper.save().tobytes())

    def set_state(self, state: bytes) -> None:
        """Restore a state of `get_state`; restore `data` first.

        Raises:
            InputError: The state belongs to another model.
        """
        try:
            self._stepper.load(np.frombuffer(state))
        except ValueError as error:
            raise InputError(f"set_state: {error}; expected one that get_state gave") from None
        self._started = True
        self._write_person()

    def _substep(self, k: int, h: float) -> None:
        import mujoco

        data, stepper = self._data, self._stepper
        self._write_person()
        qpos, qvel = np.array(data.qpos), np.array(data.qvel)
        mujoco.mj_step(self._model, data)
        stepper.substep_hosted(
            k, h, qpos, qvel, np.array(data.qvel), np.array(self._model.dof_damping)
        )
        # A kinematic tree without contact keeps MuJoCo's own step bit for bit.
        pushed = stepper.disturbed()[self._model.body_rootid] != 0.0
        if (pushed & ~self._mine).any():
            pushed &= ~self._mine
            places, dofs = pushed[self._qpos_of], pushed[self._dof_of]
            data.qpos[places] = stepper.qpos()[places]
            data.qvel[dofs] = stepper.qvel()[dofs]

    def _write_person(self) -> None:
        places, dofs = self._mine[self._qpos_of], self._mine[self._dof_of]
        self._data.qpos[places] = self._stepper.qpos()[places]
        self._data.qvel[dofs] = self._stepper.qvel()[dofs]

    def _coordinates(self, pose: Pose) -> Array:
        at, turned = pose.translation[None], pose.rotations[None]
        return np.asarray(self._person.coordinates(at, turned, pose.axes)[0])

    def _checked(self, pose: Pose) -> Pose:
        if not isinstance(pose, Pose):
            raise InputError(
                f"pose: found {type(pose).__name__}, expected a halfphysics.Pose (motion[i])"
            )
        return pose

    def _steps(self, dt: float | None) -> tuple[int, float]:
        """Number of timesteps of a step, and their length [s]."""
        longest = float(self._model.opt.timestep)
        if dt is None:
            return 1, longest
        if not isinstance(dt, Real) or not np.isfinite(dt) or dt <= 0.0:
            raise InputError(f"step: dt: found {dt!r}, expected a time above 0 [s]")
        count = max(1, math.ceil(float(dt) / longest * (1.0 - _WHOLE)))
        # A whole number of timesteps keeps their length to the last bit.
        whole = abs(count * longest - dt) <= _WHOLE * dt
        return count, longest if whole else float(dt) / count

    def _set_finger_armature(self, dof: NDArray[np.int64]) -> None:
        # The compiled model has the armature for stiffness 1; other values need another.
        armature = armature_of(self._stiffness)
        fingers = np.flatnonzero(armature)
        self._model.dof_armature[dof[fingers][:, None] + np.arange(3)] = armature[fingers, None]

    def _add_shapes(self) -> None:
        model, person = self._model, self._person
        index = len(self.names) - 1
        parts = add_person_shapes(
            self._stepper,
            model,
            person.body,
            self.settings,
            prefix=self._human.prefix,
            index=0,
            row=lambda _: index,
        )
        shape_name, static_name = [index] * len(parts), []
        rotations, positions = geoms.fixed_poses(model)
        for name, g in enumerate(self._geoms):
            body = int(model.geom_bodyid[g])
            if model.body_weldid[body] == 0:
                self._add_static(name, g, rotations[g], positions[g])
                static_name.append(name)
                continue
            if model.body_mocapid[model.body_rootid[body]] >= 0:
                raise InputError(
                    f"bind: geom '{self.names[name]}' is on a mocap body, which nothing can "
                    "touch; give the body joints, or set contype and conaffinity to 0"
                )
            rotation, position = geoms.pose_in_body(model, g)
            collider = geoms.geom_collider(model, g).moved(rotation, position)
            self._stepper.add_shape(body, name, -1, -1, *collider.arrays)
            shape_name.append(name)
            parts.append(-1)
        self.shape_name = np.array(shape_name, dtype=np.int64)
        self.shape_part = np.array(parts, dtype=np.int64)
        self.static_name = np.array(static_name, dtype=np.int64)

    def _add_static(self, name: int, geom: int, rotation: Array, position: Array) -> None:
        from halfphysics import _native

        kind = geoms.geom_kind(self._model, geom)
        if kind == "plane":
            normal = np.ascontiguousarray(rotation[:, 2])
            self._stepper.add_half_space(name, normal, float(normal @ position))
        elif kind in ("mesh", "hfield"):
            vertices, faces = geoms.mesh_triangles(self._model, geom)
            world = np.ascontiguousarray(vertices @ rotation.T + position)
            self._stepper.add_mesh(name, _native.MeshTree(world, faces))
        else:
            collider = geoms.geom_collider(self._model, geom).moved(rotation, position)
            self._stepper.add_hull(name, *collider.arrays)

    def _set_pairings(self) -> None:
        n = len(self.names)
        friction, ignore = np.zeros((n, n)), np.ones((n, n))
        each = np.minimum(self._model.geom_friction[self._geoms, 0], PERSON_FRICTION)
        friction[-1, :-1] = friction[:-1, -1] = each
        ignore[-1, :-1] = ignore[:-1, -1] = 0.0  # all other pairs are left to MuJoCo
        self._stepper.set_pairings(friction, np.zeros((n, n)), ignore)


@contextmanager
def _timestep(model: Any, h: float) -> Iterator[None]:
    """Step the model by `h` [s]; afterwards its timestep is what it was."""
    before = model.opt.timestep
    model.opt.timestep = h
    try:
        yield
    finally:
        model.opt.timestep = before


def _check_settings(settings: Settings) -> None:
    """Refuse settings that a hosted person does not support."""
    if not isinstance(settings, Settings):
        raise InputError(f"settings: found {settings!r}, expected halfphysics.Settings")
    if settings.self_contact:
        raise InputError(
            "bind: Settings.self_contact is True; a person in a MuJoCo world of one's own has "
            "no contact with itself yet. Leave it False, or use halfphysics.Simulator"
        )
    if settings.drive.poses or settings.drive.follow is not None:
        raise InputError(
            f"bind: found the baseline {type(settings).__name__}; in a MuJoCo world of one's "
            "own a person is driven. Expected other settings, or use halfphysics.Simulator"
        )


def _check_masses(model: Any, human: Human, body: NDArray[np.int64]) -> None:
    """Refuse a person that the compiler changed (inertiafromgeom, settotalmass, ...)."""
    found = np.asarray(model.body_mass)[body]
    wanted = np.array([part.mass for part in human.body.variant.parts])
    if not np.allclose(found, wanted, rtol=_SAME_MASS, atol=0.0):
        raise InputError(
            f"bind: the person weighs {found.sum():g} kg in this model, expected "
            f"{wanted.sum():g} kg; the compiler changed it (inertiafromgeom, settotalmass, "
            "boundmass), or the model is of another spec"
        )


def _keep_jacobian(model: Any, person_dofs: int) -> None:
    """Keep small worlds dense: the person's dofs must not change MuJoCo's choice of Jacobian."""
    import mujoco

    if model.opt.jacobian == mujoco.mjtJacobian.mjJAC_AUTO and model.nv - person_dofs < SPARSE:
        model.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE


def _qpos_bodies(model: Any) -> NDArray[np.int64]:
    """The body of every coordinate (nq,)."""
    owner = np.zeros(model.nq, dtype=np.int64)
    ends: Sequence[int] = [*model.jnt_qposadr[1:], model.nq]
    for first, end, body in zip(model.jnt_qposadr, ends, model.jnt_bodyid, strict=True):
        owner[first:end] = body
    return owner
