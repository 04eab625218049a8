"""One call for what estimators and generators make: the floor found, feet on it, nothing inside.

    clip -> smoothed (if asked) -> on its ground -> no common slide -> soles planted and put down
         -> physics

The first steps are kinematic and small: what a camera or a network got wrong is a height, a tilt, a
drift, feet that slide. What they leave (feet in the floor or over it, arms in the trunk, a person
in a table) is what the simulation is for. A step that finds nothing wrong changes no bit, and where
none does, and nothing is inside or over anything, the clip comes back as it is.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.short_repr import short_repr
from halfphysics.errors import InputError
from halfphysics.repair.ground_fit import Ground, fit_ground
from halfphysics.repair.insides import DEEP, insides, told
from halfphysics.repair.levelled import levelled
from halfphysics.repair.limbs import simulated
from halfphysics.repair.planted import planted
from halfphysics.repair.settled import settled
from halfphysics.repair.sliding import common_slide, without_slide
from halfphysics.repair.smoothing import low_passed
from halfphysics.repair.soles import REACH, Soles

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.metrics.penetration import PenetrationReport
    from halfphysics.motion.motion import Motion
    from halfphysics.results.result import Result
    from halfphysics.scene.scene import Scene
    from halfphysics.settings import Settings

Array = NDArray[np.float64]

_UP = np.array([0.0, 0.0, 1.0])
#: Name of the floor of a clip without a scene.
FLOOR = "floor"
#: Skin this high above the ground floats [m]: recorded feet roll and tip by less.
HIGH = 0.02
#: A clip floats where it does so in more than this share of its frames more than the simulated one:
#: jumps that no measure takes for jumps float in both [%].
FLOATS = 5.0
#: Where feet are kept in place, others rest for longer than before: they are looked at again, at
#: most this many times.
_ROUNDS = 4


@dataclass(frozen=True, eq=False)
class Repair:
    """What became of one or several people's motion.

    Attributes:
        motions: The motions put right, one a person, each with the motion as it came as
            `Motion.recorded`.
        originals: The motions as they came.
        result: The simulation of them: contacts, forces, support, pictures. Its measures compare
            with the motions as they came.
        done: What was found and done, a line each, in order; empty: the clip was right.
        left: What was found and left as it is, a line each.
        level_floor: Whether the scene is a floor at z = 0 alone.
    """

    motions: tuple[Motion, ...]
    originals: tuple[Motion, ...]
    result: Result
    done: tuple[str, ...]
    left: tuple[str, ...]
    level_floor: bool

    __repr__ = short_repr

    @property
    def motion(self) -> Motion:
        """The motion of the first person."""
        return self.motions[0]

    @property
    def lines(self) -> tuple[str, ...]:
        """What was done and what was left, in words, never empty."""
        return (*self.done, *self.left) or ("nothing was wrong: as it came",)


def fix(
    motion: Motion | Sequence[Motion],
    scene: Scene | None = None,
    *,
    body: Body | Sequence[Body] | None = None,
    smooth: float | None = None,
    level: bool = True,
    plant: bool = True,
    settings: Settings | None = None,
) -> Repair:
    """Put the motion of a video estimator or a generator right.

    Args:
        motion: The motion, or one a person, of the same frames.
        scene: What stands around; it is respected. None: a floor at z = 0.
        body: The person's body, or one each; None: the default body.
        smooth: Cutoff of a low pass that takes off jitter [Hz], such as 6; None: none.
        level: Put the clip on its ground: height, tilt, drift and common slide. False: its place
            and axes are right.
        plant: Keep resting soles in place. False: only what is inside something or floats is
            changed.
        settings: How it is simulated; None: the defaults, with `self_contact`, and nobody waits.

    Returns:
        A `Repair`. A clip that needs nothing comes back with the same bytes.

    Raises:
        InputError: No motion, motions of different length or rate, an impossible `smooth`, or what
            `simulate` raises.
    """
    from halfphysics.geometry.shapes import Plane
    from halfphysics.results.argument_checks import checked_scene, checked_settings
    from halfphysics.scene.scene import Scene
    from halfphysics.simulation.simulate import simulate

    people = _people(motion, body)
    checked_scene(scene)
    checked_settings(settings)
    originals = tuple(m for m, _ in people)
    done: list[str] = []
    left: list[str] = []
    known = scene is not None
    if scene is None:
        scene = Scene()
        scene.add_static(FLOOR, Plane())
    if smooth is not None:
        smoother = [(low_passed(m, smooth), b) for m, b in people]
        if any(m is not its for (m, _), (its, _) in zip(people, smoother, strict=True)):
            done.append(f"low-passed at {smooth:g} Hz")
        people = smoother
    if level:
        people = _on_ground(people, scene, known, done, left)
    if plant:
        people = _planted(people, scene, done)
    # Without its file no clip is warned of for what is put right here.
    asked = [
        dataclasses.replace(m, recorded=o, origin=None)
        for (m, _), o in zip(people, originals, strict=True)
    ]
    bodies = [b for _, b in people]
    if settings is None:
        result = simulated(asked, scene, bodies, done, left)
    else:
        result = simulate(asked, scene, body=bodies, settings=settings)
    motions = _kept_if_right(result, originals, done)
    return Repair(motions, originals, result, tuple(done), tuple(left), not known)


def _people(
    motion: Motion | Sequence[Motion], body: Body | Sequence[Body] | None
) -> list[tuple[Motion, Body]]:
    """Each person's motion, without what it was adapted to, and body."""
    from halfphysics.body.body import Body
    from halfphysics.results.argument_checks import checked_bodies, checked_motion

    motions: list[Any]
    if isinstance(motion, Iterable) and not isinstance(motion, str):
        motions = list(motion)
    else:
        motions = [motion]
    if not motions:
        raise InputError("motion: found none, expected a Motion, or a list of one a person")
    for one in motions:
        checked_motion(one)
    alone = body is None or isinstance(body, Body | str) or not isinstance(body, Iterable)
    bodies: list[Any] = [body] * len(motions) if alone else list(body)  # type: ignore[arg-type]
    checked_bodies([one for one in bodies if one is not None])
    if len(bodies) != len(motions):
        raise InputError(
            f"body: found {len(bodies)}, expected one for each of {len(motions)} people"
        )
    for m in motions[1:]:
        if len(m) != len(motions[0]) or m.fps != motions[0].fps:
            raise InputError(
                f"motion: found {len(m)} frames at {m.fps:g} fps beside {len(motions[0])} at "
                f"{motions[0].fps:g}, expected the same of everybody"
            )
    default = Body.default()
    return [((m.recorded or m).bare(), b or default) for m, b in zip(motions, bodies, strict=True)]


def _on_ground(
    people: list[tuple[Motion, Body]],
    scene: Scene,
    known: bool,
    done: list[str],
    left: list[str],
) -> list[tuple[Motion, Body]]:
    """Everybody on the ground, by what their soles have in common; `done` says what was done, and
    `left` that nothing is known."""
    found = [Soles.of(m, b, scene) for m, b in people]
    far = 0.0 if known else _far_off(found)
    near = [(_lifted(m, -far), b) for m, b in people] if far else people
    soles = [Soles.of(m, b, scene) for m, b in near] if far else found
    ground = fit_ground(soles)
    if ground is None:
        left.append("no sole rests on anything: the ground is not known, height and axes stay")
        return people
    people = near
    if not ground.level:
        people = [(levelled(m, b, ground), b) for m, b in people]
        soles = [Soles.of(m, b, scene) for m, b in people]
    done += _told(ground, ground.height + far)
    velocity = common_slide(soles)
    if velocity.any():
        people = [(without_slide(m, velocity), b) for m, b in people]
        speed = 100.0 * float(np.linalg.norm(velocity))
        done.append(f"slid as a whole by {speed:.1f} cm/s: taken off")
    return people


def _far_off(soles: list[Soles]) -> float:
    """How far soles are from z = 0 [m] where that is beyond where surfaces are looked for, or 0."""
    lowest = np.median(np.concatenate([s.lowest.min(axis=1) for s in soles]))
    return float(lowest) if abs(lowest) > 0.5 * REACH else 0.0


def _lifted(motion: Motion, by: float) -> Motion:
    return motion.with_frames(motion.translation + by * _UP, motion.rotations)


def _told(ground: Ground, height: float) -> list[str]:
    """What was wrong with the ground, in words; `height`: how far the clip floated in all [m]."""
    lines = []
    if ground.tilt:
        lines.append(f"tilted by {np.rad2deg(ground.tilt):.1f} degrees: turned level")
    if ground.drift:
        way = "up" if ground.drift > 0.0 else "down"
        lines.append(f"drifted {way} by {100.0 * abs(ground.drift):.1f} cm/s: taken off")
    if height:
        how = "floated" if height > 0.0 else "sunk"
        lines.append(f"{how} by {100.0 * abs(height):.1f} cm: put on the ground")
    return lines


def _planted(
    people: list[tuple[Motion, Body]], scene: Scene, done: list[str]
) -> list[tuple[Motion, Body]]:
    """Everybody with resting soles in place; `done` says by how much they were shifted."""
    made, sizes = [], [0.0]
    for motion, body in people:
        for _ in range(_ROUNDS):
            motion, held, size = planted(motion, body, Soles.of(motion, body, scene))
            if not held.any():
                break
            motion = settled(motion, body, Soles.of(motion, body, scene), held)
            sizes.append(size)
        made.append((motion, body))
    if len(sizes) > 1:
        done.append(f"resting feet slid: kept in place, by {1000.0 * max(sizes):.0f} mm")
    return made


def _kept_if_right(
    result: Result, originals: tuple[Motion, ...], done: list[str]
) -> tuple[Motion, ...]:
    """What the simulation made; the originals where nothing was wrong with them."""
    inside = insides([person.reference for person in result.people], result)
    if not done and _right(result, inside):
        return originals
    done += told(inside, result)
    if not done:
        done.append("what was inside or over something: moved by the simulation")
    return tuple(
        dataclasses.replace(person.motion, recorded=None, origin=original.origin)
        for person, original in zip(result.people, originals, strict=True)
    )


def _right(result: Result, inside: Sequence[PenetrationReport]) -> bool:
    """Whether the motions as they came are inside nothing and over nothing."""
    from halfphysics.metrics.floating import floating

    if any(report.depth_max_mm > DEEP for report in inside):
        return False
    for person in result.people:
        before, after = (
            floating(
                motion,
                person.body,
                result.scene,
                objects=result.objects,
                reference=person.recorded,
                tolerance=HIGH,
            ).percent
            for motion in (person.recorded, person.motion)
        )
        if before > after + FLOATS:
            return False
    return True
