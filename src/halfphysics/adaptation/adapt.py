"""Adapt a recorded motion to the things that it held: contact kept, and a grip that bears the load.

A recording is off by centimetres between hand and thing, and knows no forces. Played in a physics
simulation, its hands slip along things or push them away. Where recorded hands hold a recorded
thing, they are moved onto its surface, smoothly, and press with what the load needs. The thing's
own motion is never touched: friction lifts it, or does not.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.adaptation import feet, handles, loads, one_hand, press, sharing
from halfphysics.adaptation.feet import Foot
from halfphysics.adaptation.grips import fingers_at, fingers_known, places
from halfphysics.adaptation.hands import SIDES, Hand
from halfphysics.adaptation.parts import Seat, told
from halfphysics.adaptation.recorded_holds import RecordedHold, recorded_holds
from halfphysics.adaptation.thing import Thing
from halfphysics.adaptation.timing import Timing
from halfphysics.base.short_repr import short_repr
from halfphysics.base.validation import shown
from halfphysics.errors import InputError
from halfphysics.motion.adapted_hold import AdaptedHold
from halfphysics.motion.skeleton import N_JOINTS
from halfphysics.scene.material_pairs import PERSON

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion
    from halfphysics.results.result import ObjectTrack
    from halfphysics.scene.scene import Scene
    from halfphysics.settings import Settings

Array = NDArray[np.float64]

#: Fingers that hold a thing alone flex by this beyond where they touch [rad].
_SQUEEZE = 0.1
#: Nothing is held where something is farther from the origin than this [m]: a damaged file.
_FAR = 1e5


@dataclass(frozen=True, eq=False)
class Adaptation:
    """A motion that holds what it was recorded with.

    Attributes:
        motion: The adapted motion, with its `Motion.holds` and `Motion.recorded`; the motion that
            was given where nothing is held.
    """

    motion: Motion

    __repr__ = short_repr

    @property
    def recorded(self) -> Motion:
        """The motion as recorded."""
        return self.motion if self.motion.recorded is None else self.motion.recorded

    @property
    def holds(self) -> tuple[AdaptedHold, ...]:
        """What is held, in the order of time."""
        return self.motion.holds

    def summary(self) -> str:
        """What was adapted and by how much, in one line."""
        if not self.holds:
            return "nothing is held: the motion is as recorded"
        told_of = []
        for hold in self.holds:
            away = " and ".join(f"{100.0 * moved:.1f}" for moved in hold.moved)
            told_of.append(
                f"{hold.object} from {hold.first / self.motion.fps:.1f} to "
                f"{hold.last / self.motion.fps:.1f} s {told(hold.parts)}, moved by {away} cm"
                + (f" and pressing with {hold.force:.0f} N" if hold.force else "")
            )
        return f"adapted to what is held: {'; '.join(told_of)}"


def adapt(
    motion: Motion,
    scene: Scene,
    body: Body | None = None,
    recorded: Mapping[str, ObjectTrack] | None = None,
    *,
    settings: Settings | None = None,
    grip: bool = True,
    others: Sequence[tuple[Motion, Body | None]] = (),
) -> Adaptation:
    """Adapt a recorded motion to the things that it held.

    Args:
        motion: The recorded motion, T frames. Of one that was adapted, what it was recorded as.
        scene: With the recorded things as objects.
        body: The person's body; None: the default body.
        recorded: Name of an object -> its recorded poses, T frames.
        settings: How it will be simulated: the drive that presses. None: the defaults.
        grip: Hands press with what the load needs. False: they touch.
        others: Recorded motions and bodies (None: the default one) of other people in the scene:
            what their hands hold, too, they bear together.

    Raises:
        InputError: A track, or a motion of the others, of another length than the motion; or
            something of another kind.
    """
    from halfphysics.body.body import Body
    from halfphysics.results.argument_checks import (
        checked_body,
        checked_motion,
        checked_settings,
        given_scene,
    )

    motion, scene = checked_motion(motion), given_scene(scene)
    body, settings = checked_body(body), checked_settings(settings)
    _check(recorded, others)
    motion = motion if motion.recorded is None else motion.recorded
    for number, (other, _) in enumerate(others):
        if len(other) != len(motion):
            raise InputError(
                f"others: motion {number} has {len(other)} frames, expected {len(motion)} as the "
                "motion that is adapted"
            )
    people = [(m, Body.default() if b is None else b) for m, b in others]
    how = _How(motion, scene, body, settings, grip, people)
    hands = [hand for side in SIDES if (hand := Hand.of(body, side)) is not None]
    out, holds = motion, []
    for name, track in (recorded or {}).items():
        if len(track) != len(motion):
            raise InputError(
                f"recorded: {name!r} has {len(track)} frames, expected {len(motion)} as the motion"
            )
        far = max(np.abs(track.position).max(), np.abs(motion.translation).max())
        if name not in scene.objects or far > _FAR:
            continue
        thing = Thing.of(scene.objects[name], track)
        found = []
        for hold in recorded_holds(motion, body, hands, thing):
            out, held = _in_hands(out, hold, how)
            found.append(held)
        out, more = _without_hands(out, thing, found, how)
        holds += [*found, *more]
    if not holds:
        return Adaptation(motion)
    holds.sort(key=lambda h: h.first)
    return Adaptation(replace(out, holds=tuple(holds), recorded=motion))


def _check(recorded: object, others: object) -> None:
    """Refuse tracks and other people of another kind."""
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion

    def is_person(value: object) -> bool:
        if not isinstance(value, list | tuple) or len(value) != 2:
            return False
        return isinstance(value[0], Motion) and isinstance(value[1], Body | None)

    if not isinstance(recorded, Mapping | None):
        raise InputError(
            f"adapt: recorded: found {shown(recorded)}, expected object names and tracks"
        )
    if not isinstance(others, list | tuple) or not all(map(is_person, others)):
        raise InputError(
            f"adapt: others: found {shown(others)}, expected a list of motions with bodies: "
            "[(motion, body)]"
        )


@dataclass(frozen=True, eq=False)
class _How:
    """What is known beside a hold: the recorded motion, and the arguments of `adapt`."""

    motion: Motion
    scene: Scene
    body: Body
    settings: Settings
    grip: bool
    people: Sequence[tuple[Motion, Body]]


def _in_hands(out: Motion, hold: RecordedHold, how: _How) -> tuple[Motion, AdaptedHold]:
    """A motion whose hands hold a thing, and how."""
    motion, body, thing = how.motion, how.body, hold.thing
    friction, gravity = how.scene.friction_of(PERSON, thing.name), how.scene.gravity
    its = places(motion, body, hold, friction)
    pulls = len(its) == 1 and how.grip and handles.slides(hold)
    if pulls:
        # Recorded fingers are kept: they close around what they pull.
        known = fingers_known(motion, its[0].hand)
        recorded = fingers_at(motion, its[0], hold.middle) if known else None
        hook = handles.hook_of(body, hold, its[0], recorded)
        if hook is not None and known:
            its = (handles.taut(its[0], hook),)
        elif hook is not None:
            out, away = handles.held(out, body, hold, hook, hold.arrives[0])
            return out, _adapted(hold, (hook.hand.name,), 0.0, (away,))
    theirs = sharing.others_places(how.people, thing, hold, friction) if how.grip else ()
    load = loads.load(hold, motion.fps, gravity)
    both = sharing.shared(its, theirs, thing, load, friction) if theirs else None
    if both is None:
        force = loads.between_palms(hold, its, load, friction) if how.grip else 0.0
        forces: tuple[float, ...] = (force,) * len(its)
    else:
        its, forces = both
        # What lies on a palm needs no grip: the drive holds the palm where it is.
        below = [sharing.bears(place, load) for place in its]
        forces = tuple(0.0 if b else f for b, f in zip(below, forces, strict=True))
    moved = []
    for place, arrives, force in zip(its, hold.arrives, forces, strict=True):
        timing = Timing.of(
            *(hold, arrives, len(motion), motion.fps),
            grasps=place.grasps,
            unseen=not fingers_known(motion, place.hand),
        )
        squeeze = _SQUEEZE if how.grip and (both is None or force > 0.0) else 0.0
        out, away = one_hand.held(out, body, hold, place, timing, force, squeeze, how.settings)
        if how.grip:
            firmer = press.firmer(place.hand, timing.presses, pulls=pulls)
            out = _tensed(out, motion, firmer)
        moved.append(away)
    names = tuple(place.hand.name for place in its)
    return out, _adapted(hold, names, max(forces), tuple(moved))


def _without_hands(
    out: Motion, thing: Thing, held: Sequence[AdaptedHold], how: _How
) -> tuple[Motion, list[AdaptedHold]]:
    """A motion whose feet are kept on what they push, and how; who sits is only told.

    Where hands hold the thing they move it; where a person sits on it feet are below it.
    """
    body, settings = how.body, how.settings
    found: list[AdaptedHold] = []
    for hold in _free(recorded_holds(how.motion, body, [Seat(body)], thing), held):
        found.append(_adapted(hold, (hold.parts[0].name,), 0.0, (0.0,)))
    both = [foot for side in SIDES if (foot := Foot.of(body, side)) is not None]
    for hold in _free(recorded_holds(how.motion, body, both, thing), [*held, *found]):
        pushing = [foot for foot in both if foot in hold.parts]
        out, moved = feet.kept_all(out, body, pushing, hold)
        force = 0.0
        if how.grip and settings.drive_time is not None and moved:
            force = min(feet.friction_below(how.scene, thing) / len(moved), loads.MOST)
        for foot in [f for f in pushing if force and f.name in moved]:
            out = feet.pushed(
                out, body, foot, hold, force,
                stiffness=press.stiffness_of(settings, foot), time=settings.drive_time or 0.0,
            )  # fmt: skip
        if moved:
            found.append(_adapted(hold, tuple(moved), force, tuple(moved.values())))
    return out, found


def _adapted(
    hold: RecordedHold, parts: tuple[str, ...], force: float, moved: tuple[float, ...]
) -> AdaptedHold:
    record = hold.thing.position, hold.thing.quaternion
    return AdaptedHold(hold.thing.name, parts, hold.first, hold.last, force, moved, *record)


def _free(holds: Sequence[RecordedHold], held: Sequence[AdaptedHold]) -> list[RecordedHold]:
    """Holds that share no frame with those that are adapted already."""
    return [h for h in holds if all(h.first > o.last or h.last < o.first for o in held)]


def _tensed(out: Motion, recorded: Motion, firmer: Array) -> Motion:
    """The motion with joints that are stiffer (T, 55) while it holds, by the most of all holds."""
    usual = np.ones((len(out), N_JOINTS))
    if recorded.stiffness_scale is not None:
        usual = recorded.stiffness_scale
    before = usual if out.stiffness_scale is None else out.stiffness_scale
    scale = np.maximum(before, usual * firmer)
    return replace(out, stiffness_scale=scale)
