"""Actors in a scene: what they want, what they see and what physics makes of it, frame by frame."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.actors.actor import Actor
from halfphysics.actors.seen import Seen
from halfphysics.base.validation import is_whole, number, shown
from halfphysics.errors import InputError
from halfphysics.motion.motion import MODELS, Motion
from halfphysics.settings import Settings
from halfphysics.simulation.recorded_result import recorded_result
from halfphysics.simulation.recording import Recorder, core_firmness
from halfphysics.simulation.simulator import Simulator

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.pose import Pose
    from halfphysics.results.result import Result
    from halfphysics.scene.scene import Scene

Array = NDArray[np.float64]

#: The default settings, but for who waits where somebody is blocked: an actor sees that it is
#: blocked and waits itself. If the simulator did as well, it would do late what the actor wants.
SETTINGS = Settings(blocked="continue")


class _Recorded(Simulator):
    """A simulator that keeps all that a result needs."""

    recorder: Recorder

    def start(self, poses: list[Pose], count: int) -> Any:
        frame = self.reset(poses)
        core = self.world.stepper
        self.recorder = Recorder(self.world, count, self.dt)
        self.recorder.start(core.qpos(), core.clearance(), core.inside(), core.footing())
        self._recorded = self.world
        return frame

    def _move(self, targets: Array, dt: float) -> Array:
        if self.world is not self._recorded:
            raise InputError(
                "play: the people and objects of the scene changed while it ran, which no result "
                "can hold; expected a scene that keeps them"
            )
        settings = self.settings
        got = self.world.stepper.run(
            targets[None],
            dt,
            settings.substeps_for(dt),
            settings.record == "substeps",
            1.0,
            core_firmness(self.world, None),
            self.recorder.rest[:1],
        )
        self.recorder.add(got)
        substeps: Array = got["substeps"]
        return substeps


def play(
    actors: Actor | Sequence[Actor],
    scene: Scene | None = None,
    *,
    seconds: float,
    body: Body | Sequence[Body] | None = None,
    fps: float = 30.0,
    settings: Settings | None = None,
    seed: int = 0,
    each: Callable[[Simulator, float], Any] | None = None,
) -> Result:
    """Let actors act in a scene for a time.

    Args:
        actors: One person's actor, or several; each is reset first.
        scene: Statics and objects; None: an empty one.
        seconds: How long [s].
        body: Their bodies, as for `halfphysics.Simulator`; None: those that actors say they have
            (as a `Person` and a `Clip` do), else the default body.
        fps: Frames per second.
        settings: As for `halfphysics.simulate`; None: `SETTINGS`.
        seed: Of the first actor; the others have the next ones.
        each: Called before every frame with the simulator and the time [s]: to push objects.

    Returns:
        The `Result`: what the actors wanted is the reference, what they did the motion.

    Raises:
        InputError: An impossible value.
    """
    cast = list(actors) if isinstance(actors, Sequence) else [actors]
    if not cast or not all(isinstance(actor, Actor) for actor in cast):
        raise InputError(f"play: expected actors, with reset and next; found {shown(actors)}")
    if len({id(actor) for actor in cast}) < len(cast):
        raise InputError("play: found one actor twice, expected one for each person")
    number(seconds, "play: seconds", above=0.0, unit="s")
    if not is_whole(seed, least=0, plain=False):
        raise InputError(f"play: expected a seed of at least 0, found {shown(seed)}")
    if body is None:
        body = _bodies(cast)
    sim = _Recorded(scene, body=body, settings=settings or SETTINGS, fps=fps)
    count = max(2, round(seconds * fps) + 1)
    poses = [[actor.reset(seed + i) for i, actor in enumerate(cast)]]
    frame = sim.start(poses[0], count)
    for i in range(count - 1):
        time = i * sim.dt
        if each is not None:
            each(sim, time)
        sights = [Seen.of(sim, frame, person, time=time) for person in range(len(cast))]
        both = zip(cast, sights, strict=True)
        poses.append([actor.next(sim.dt, seen) for actor, seen in both])
        frame = sim.step(poses[-1])
    people = zip(zip(*poses, strict=True), sim.bodies, strict=True)
    motions = [as_motion(list(own), its, fps) for own, its in people]
    return recorded_result(sim.world, motions, sim.recorder.recording())


def as_motion(poses: Sequence[Pose], body: Body, fps: float) -> Motion:
    """Poses of a body, at least two, as a motion."""
    smpl = body.model in MODELS
    return Motion(
        np.stack([pose.translation for pose in poses]),
        np.stack([pose.rotations for pose in poses]),
        fps,
        betas=body.betas if smpl else None,
        gender=body.gender if smpl else "neutral",
        model=body.model if smpl else "smplx",
        axes=poses[0].axes,
    )


def _bodies(cast: Sequence[Actor]) -> list[Body]:
    from halfphysics.body.body import Body

    return [getattr(actor, "body", None) or Body.default() for actor in cast]
