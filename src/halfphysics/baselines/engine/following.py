"""Whole motions through plain MuJoCo: `EngineVelocity` and `EngineKinematic`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from halfphysics.baselines.engine.kinematic import MocapDrive, between
from halfphysics.baselines.engine.model import EngineModel
from halfphysics.baselines.engine.velocity import VelocityDrive, Watch
from halfphysics.baselines.engine.watching import Recorder
from halfphysics.baselines.settings import EngineKinematic
from halfphysics.body.mjcf_person import addresses
from halfphysics.errors import InputError
from halfphysics.metrics.part_report import clearances
from halfphysics.results.contacts import Contacts
from halfphysics.results.result import PersonResult, Result
from halfphysics.results.substeps import Substeps
from halfphysics.simulation.core_rows import contact_rows

if TYPE_CHECKING:
    from halfphysics.motion.motion import Motion
    from halfphysics.settings import Settings
    from halfphysics.simulation.world import World

Array = NDArray[np.float64]

#: What MuJoCo watches.
_STATE = ("QPOS", "QVEL", "QACC")


def follow(world: World, motions: Sequence[Motion], done: Callable[[int], Any]) -> Result:
    """Run whole motions, one per person, in MuJoCo.

    Args:
        world: People, scene and settings; of what it compiled, only names and clearances are used.
        motions: One per person, of one length.
        done: Told how many frames were done.

    Raises:
        InputError: What MuJoCo cannot have, see `add_scene`; or it became unstable.
    """
    import mujoco

    settings, count, dt = world.settings, len(motions[0]), 1.0 / motions[0].fps
    substeps = settings.substeps_for(dt)
    mocap = isinstance(settings, EngineKinematic)
    engine = EngineModel(world, dt / substeps, mocap=mocap)
    model, data = engine.model, mujoco.MjData(engine.model)
    recorder = Recorder(engine, data, substeps)
    data.qpos[:], data.qvel[:] = engine.start()
    advance: Callable[[int, Recorder], Any]
    if mocap:
        drive = MocapDrive(model, data, engine.mocap, engine.people, motions, substeps)
        advance = drive.frame
    else:
        advance = by_velocity(engine, data, motions, substeps, dt)
    every = settings.record == "substeps"
    qpos = [np.array(data.qpos)[None]]
    rows, frames = [np.zeros((0, 12))], [np.zeros(0, dtype=np.int64)]
    for t in range(1, count):
        recorder.begin()
        advance(t, recorder)
        _check_stable(data, settings, t, dt)
        qpos.append(recorder.qpos.copy() if every else recorder.qpos[-1:].copy())
        rows.append(recorder.rows())
        frames.append(np.full(len(rows[-1]), t))
        done(1)
    contacts = _Rows(np.concatenate(rows), np.concatenate(frames))
    return _result(world, engine, motions, np.concatenate(qpos), contacts)


class _Rows(NamedTuple):
    """Rows of contacts (n, 12), and the frame of each (n,)."""

    rows: Array
    frame: NDArray[np.int64]


def _result(
    world: World, engine: EngineModel, motions: Sequence[Motion], qpos: Array, contacts: _Rows
) -> Result:
    """The result of coordinates at the frames, or at all substeps (., nq)."""
    settings, count, dt = world.settings, len(motions[0]), 1.0 / motions[0].fps
    substeps, mocap = settings.substeps_for(dt), isinstance(settings, EngineKinematic)
    every = settings.record == "substeps"
    at_frames = qpos[::substeps] if every else qpos
    columns, row = contact_rows(engine, contacts.rows)
    result = Result(
        people=tuple(
            PersonResult(
                motion=motion
                if mocap
                else motion.with_frames(*person.pose(at_frames, motion.axes)),
                reference=motion,
                body=person.body,
                name=person.name,
            )
            for motion, person in zip(motions, engine.people, strict=True)
        ),
        objects=engine.tracks(at_frames, dt * np.arange(count, dtype=np.float64)),
        joints=engine.joints(at_frames),
        scene=world.scene,
        names=world.names,
        contacts=Contacts(frame=contacts.frame[row], **vars(columns)),
        clearance=np.full(count, np.inf),
        lost_time=np.zeros(count),
        settings=settings,
        substeps=_substeps(engine, motions, qpos, substeps, mocap) if every else None,
    )
    return replace(result, clearance=clearances(result)[0].min(axis=(0, 2)))


def _check_stable(data: Any, settings: Settings, t: int, dt: float) -> None:
    """MuJoCo starts all over where numbers are too large; nothing that comes after is a result."""
    import mujoco

    if any(data.warning[getattr(mujoco.mjtWarning, f"mjWARN_BAD{x}")].number for x in _STATE):
        raise InputError(
            f"{type(settings).__name__}: MuJoCo became unstable before frame {t} "
            f"({t * dt:.2f} s), expected forces that {settings.substeps_for(dt)} steps per frame "
            "can follow. Use more substeps=, heavier objects, or another baseline"
        )


def by_velocity(
    engine: EngineModel, data: Any, motions: Sequence[Motion], substeps: int, dt: float
) -> Callable[[int, Watch | None], Any]:
    """Put people where their motions start; the function that takes them to frame t, given t and an
    observer."""
    targets = np.tile(engine.model.qpos0, (len(motions[0]), 1))
    for person, motion in zip(engine.people, motions, strict=True):
        own = slice(person.qpos, person.qpos + person.count)
        targets[:, own] = person.coordinates(motion.translation, motion.rotations, motion.axes)
        data.qpos[own] = targets[0, own]
    places = [addresses(engine.model, f"{person.name}/") for person in engine.people]
    drive = VelocityDrive(engine.model, data, places, substeps, dt)
    return lambda t, watch: drive.frame(targets[t - 1], targets[t], watch)


def _substeps(
    engine: EngineModel, motions: Sequence[Motion], qpos: Array, substeps: int, mocap: bool
) -> Substeps:
    """Every pose there was (S + 1, nq), the start first."""
    fps = motions[0].fps * substeps
    poses = [
        _all_between(motion, substeps) if mocap else person.pose(qpos, motion.axes)
        for motion, person in zip(motions, engine.people, strict=True)
    ]
    return Substeps(
        motions=tuple(m.with_frames(*p, fps=fps) for m, p in zip(motions, poses, strict=True)),
        objects=engine.tracks(qpos, np.arange(len(qpos), dtype=np.float64) / fps),
    )


def _all_between(motion: Motion, substeps: int) -> tuple[Array, Array]:
    ways = [between(motion, t, substeps) for t in range(1, len(motion))]
    translation = np.concatenate([motion.translation[:1], *(way[0] for way in ways)])
    return translation, np.concatenate([motion.rotations[:1], *(way[1] for way in ways)])
