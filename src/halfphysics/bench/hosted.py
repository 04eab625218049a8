"""A person in a MuJoCo world of one's own, beside the same world with a person of plain bodies."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any, Literal

import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.baselines.engine.velocity import VelocityDrive
from halfphysics.bench.clips import body, story
from halfphysics.bench.record import Options, Record
from halfphysics.bench.robot_arm import TIMESTEP, robot_arm
from halfphysics.bench.sides import measure
from halfphysics.body.mjcf_person import add_person, addresses
from halfphysics.motion.motion import Motion
from halfphysics.motion.pose import Pose
from halfphysics.mujoco.attach import attach
from halfphysics.mujoco.control import Control
from halfphysics.mujoco.worlds import step_worlds
from halfphysics.settings import Settings

Contact = Literal["skin", "parts"]

WORLDS = 8
#: Where the arm begins and how far it swings [rad].
START, SWING = -0.5 * np.pi, 0.8


def hosted(options: Options) -> Iterator[Record]:
    """An arm and a person: far from each other, and pressing on each other."""
    walk, still = options.short(story().motions[0]), options.short(_arms_out(45))
    for name, motion, place in (
        ("nothing near", walk, "9 9 1"),
        ("an arm presses on the person", still, _beside(still)),
    ):
        frames, real = len(motion) - 1, 1.0 / motion.fps
        done = measure(
            "hosted",
            name,
            frames,
            options,
            ours=_ours(motion, place, "skin"),
            parts=_ours(motion, place, "parts"),
            peer=_peer(motion, place),
        )
        times = {"times real time": (done.record.middle * real, _times(done.record, real))}
        yield replace(done.record, checks=times | {"touched [frames]": (float(done.ours), None)})


def _times(record: Record, real: float) -> float | None:
    return None if record.peer_middle is None else record.peer_middle * real


def worlds(options: Options) -> Iterator[Record]:
    """Processor time of worlds stepped by one call; and by the clock."""
    motion = options.short(_arms_out(45))
    place, frames = _beside(motion), WORLDS * (len(motion) - 1)
    controls = [_control(motion, place, "skin") for _ in range(WORLDS)]
    poses, dt = _poses(motion), 1.0 / motion.fps

    def play(threads: int) -> Callable[[], int]:
        def run() -> int:
            for control, data in controls:
                data.qpos[:2] = START, 0.0
                data.qvel[:] = 0.0
                control.reset(poses[0])
            for t, pose in enumerate(poses[1:], 1):
                for _, data in controls:
                    data.ctrl[0] = _aim(t, len(poses))
                step_worlds([c for c, _ in controls], [pose] * WORLDS, dt, threads=threads)
            return 0

        return run

    def in_turn() -> int:
        for control, data in controls:
            _play(control, data, poses, dt)
        return 0

    for threads in (1, 2):
        done = measure(
            "hosted-worlds",
            f"{WORLDS} worlds, {threads} thread{'s' * (threads > 1)}",
            frames,
            options,
            ours=play(threads),
            peer=in_turn,
        )
        clock = {
            "by the clock [frames/s]": (_clock(play(threads), frames), _clock(in_turn, frames))
        }
        yield replace(done.record, checks=clock)


def _clock(work: Callable[[], object], frames: int) -> float:
    start = time.perf_counter()
    work()
    return frames / (time.perf_counter() - start)


def _arms_out(frames: int, fps: float = 30.0) -> Motion:
    """Upright, arms out along x."""
    rotations = np.zeros((frames, 55, 3))
    rotations[:, 0] = (0.5 * np.pi, 0.0, 0.0)
    height = body().variant.standing_height + 0.01
    path = np.tile(np.array([0.0, 0.0, height]) - body().rest_joints[0], (frames, 1))
    return Motion(path, rotations, fps)


def _poses(motion: Motion) -> list[Pose]:
    return [motion[t] for t in range(len(motion))]


def _beside(motion: Motion) -> str:
    """The arm's base: its forearm meets the right forearm of the first pose in the swing."""
    return f"-1.1 -0.45 {motion.translation[0, 2] + body().rest_joints[0, 2] + 0.48:.4f}"


def _aim(t: int, frames: int) -> float:
    return START + SWING * min(1.0, 2.0 * t / frames)


def _world(place: str) -> Any:
    import mujoco

    return mujoco.MjSpec.from_string(robot_arm(place))


def _control(motion: Motion, place: str, contact: Contact) -> tuple[Control, Any]:
    import mujoco

    spec = _world(place)
    human = attach(spec, body())
    model = spec.compile()
    data = mujoco.MjData(model)
    return human.bind(model, data, settings=Settings(contact=contact)), data


def _play(control: Control, data: Any, poses: Sequence[Pose], dt: float) -> int:
    """Frames at whose end the person was touched."""
    data.qpos[:2] = START, 0.0
    data.qvel[:] = 0.0
    control.reset(poses[0])
    touched = 0
    for t, pose in enumerate(poses[1:], 1):
        data.ctrl[0] = _aim(t, len(poses))
        control.step(pose, dt=dt)
        touched += bool(data.xfrc_applied.any())
    return touched


def _ours(motion: Motion, place: str, contact: Contact) -> Callable[[], int]:
    control, data = _control(motion, place, contact)
    poses = _poses(motion)
    return lambda: _play(control, data, poses, 1.0 / motion.fps)


def _peer(motion: Motion, place: str) -> Callable[[], object]:
    """The person as 55 bodies with joints, driven by velocities as one would write it by hand."""
    import mujoco

    spec = mujoco.MjSpec()
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.timestep = TIMESTEP
    add_person(spec, body().variant)
    world = _world(place)
    spec.attach(world, prefix="robot/", frame=spec.worldbody.add_frame())
    steps = int(np.ceil(1.0 / motion.fps / TIMESTEP - 1e-6))
    model = spec.compile()
    model.opt.timestep = 1.0 / motion.fps / steps
    data = mujoco.MjData(model)
    at = addresses(model)
    drive = VelocityDrive(model, data, [at], steps, 1.0 / motion.fps)
    person = _coordinates(model, at, motion)

    def play() -> int:
        mujoco.mj_resetData(model, data)
        data.qpos[:] = person[0]
        data.qpos[model.joint("robot/yaw").qposadr[0]] = START
        for t in range(1, len(motion)):
            data.ctrl[0] = _aim(t, len(motion))
            drive.frame(person[t - 1], person[t])
        return 0

    return play


def _coordinates(model: Any, at: Any, motion: Motion) -> Any:
    """Model coordinates (T, nq) of the motion; the arm's are 0."""
    qpos = np.tile(model.qpos0, (len(motion), 1))
    pelvis = motion.axes @ body().rest_joints[0]
    for row, place, turns in zip(qpos, motion.translation, rot.exp(motion.rotations), strict=True):
        at.write(row, place + pelvis, turns)
    return qpos
