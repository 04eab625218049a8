"""Several actors in turn: each goes on from where the one before was, at its pose and speed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from halfphysics.actors.foot_lock import FootLock
from halfphysics.actors.inertia import Inertia, State
from halfphysics.actors.limbs import vec
from halfphysics.actors.seen import Seen, pelvis_of
from halfphysics.base import rotations as rot
from halfphysics.base.suggestions import did_you_mean
from halfphysics.base.validation import number, shown
from halfphysics.errors import InputError
from halfphysics.motion.pose import Pose

if TYPE_CHECKING:
    from halfphysics.body.body import Body

Array = NDArray[np.float64]


class Restartable(Protocol):
    """An actor that can begin anywhere: a `Clip`, a `Person`."""

    def reset(self, seed: int = 0) -> Pose: ...
    def next(self, dt: float, seen: Seen) -> Pose: ...
    def restart(self, pose: Pose) -> Pose:
        """Begin again where a pose is, and facing as it does."""
        ...


class Mixed:
    """An actor that plays one of several, and changes between them.

    A change keeps pose and velocity: what is between the old and the new motion decays within its
    `fade`. Feet that stand stay where they are.

    Args:
        body: Whose motion it is.
        actors: Name -> `Clip`, `Person`, or another that has `restart`; the first one begins.
        lock: Whether standing feet are held.

    Raises:
        InputError: No actors, or one that cannot begin anywhere.
    """

    def __init__(self, body: Body, actors: Mapping[str, Restartable], *, lock: bool = True) -> None:
        if not actors or not all(hasattr(actor, "restart") for actor in actors.values()):
            raise InputError(
                "Mixed: expected a mapping from names to actors that can begin anywhere (Clip, "
                f"Person, or another with restart(pose)); found {shown(actors)}"
            )
        self.body, self.actors = body, dict(actors)
        self._lock = FootLock(body) if lock else None
        self.reset()

    def reset(self, seed: int = 0) -> Pose:
        """Begin with the first actor; all get the seed."""
        poses = {name: actor.reset(seed) for name, actor in self.actors.items()}
        self.name = next(iter(self.actors))
        self._inertia: Inertia | None = None
        self._since, self._wanted = 0.0, (self.name, 0.0)
        if self._lock is not None:
            self._lock.begin()
        self._shown = self._before = poses[self.name]
        return self._shown

    @property
    def current(self) -> Restartable:
        """The actor that plays now."""
        return self.actors[self.name]

    def play(self, name: str, *, fade: float = 0.35) -> None:
        """Change to another actor in the next frame.

        Args:
            name: One of `actors`.
            fade: After which nothing is left of the motion before [s]: over 0.

        Raises:
            InputError: No actor of that name, or an impossible time.
        """
        if name not in self.actors:
            hint = did_you_mean(name, self.actors, form=repr)
            raise InputError(
                f"Mixed: there is no actor {name!r}{hint}; there are {', '.join(self.actors)}"
            )
        self._wanted = (name, number(fade, "Mixed: fade", above=0.0, unit="s"))

    def next(self, dt: float, seen: Seen) -> Pose:
        """The pose `dt` [s] later."""
        name, fade = self._wanted
        if name != self.name:
            first = self._state(self.actors[name].restart(self._shown))
            pose = self.actors[name].next(dt, seen)
            # As the last two frames went on.
            last = self._state(self._shown)
            going = last.on(self._state(self._before))
            self._inertia = Inertia((last, going), (first, self._state(pose)), dt, fade)
            self.name, self._since = name, 0.0
        else:
            pose = self.current.next(dt, seen)
        self._since += dt
        self._before, self._shown = self._shown, self._posed(dt, pose)
        return self._shown

    def _state(self, pose: Pose) -> State:
        return State(pelvis_of(pose, self.body), rot.exp(pose.rotations))

    def _posed(self, dt: float, pose: Pose) -> Pose:
        """A pose with what is left of the motion before, and its feet locked."""
        root, rotations = pelvis_of(pose, self.body), pose.rotations
        lock, inertia = self._lock, self._inertia
        source = {} if lock is None else lock.toes(vec(root), rotations)
        shown = source
        if inertia is not None:
            state = inertia.at(self._since, State(root, rot.exp(rotations)))
            root, rotations = state.root, rot.log(state.quats)
            if lock is not None:
                shown = lock.toes(vec(root), rotations)
            if self._since >= inertia.seconds:
                self._inertia = None
        if lock is not None:
            rotations = lock.locked(dt, source, shown, vec(rotations[0]), rotations)
        offset = pose.axes @ np.asarray(self.body.rest_joints)[0]
        return Pose.trusted(root - offset, np.array(rotations), np.array(pose.axes))
