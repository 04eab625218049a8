"""Loads the motion, body and scene of a command line or a sweep from their options."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from halfphysics.base.reader_warnings import one_warning
from halfphysics.base.validation import file_path
from halfphysics.errors import InputError

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.body.shape_space import ShapeSpace
    from halfphysics.motion.motion import Motion
    from halfphysics.scene.scene import Scene
    from halfphysics.settings import Settings
    from halfphysics.simulation.sequence import Sequence

#: Name of the static that is added as a floor.
GROUND = "ground"


@dataclass(frozen=True, kw_only=True)
class MotionOptions:
    """Options that a motion file may not state itself."""

    fps: float | None = None
    """Frames per second of the motion file, where it does not say."""
    up: Literal["y", "z", "-y", "x", "-x", "-z"] | None = None
    """The axis that is up in the motion file, where neither its format nor its content says so
    (--up=-y: y is down)."""
    floor: float | Literal["lowest"] | None = None
    """Height of the floor in the motion file [m], put at z = 0; lowest: that of the lowest
    skin."""
    hands: Literal["flat", "mean"] | None = None
    """What zero fingers mean in the motion file: a flat hand, or the model's relaxed one."""
    model: str | None = None
    """smplx, smplh or smpl, where the file does not say; or a model file (for mean hands)."""
    gender: Literal["neutral", "male", "female"] | None = None
    """Gender of the motion's shape, where the file does not say."""
    frames: str | None = None
    """Frames to read, START:STOP (counted from 0, STOP left out); either may be missing."""

    clip: str | None = None
    """Name of the clip to read, where the file holds several."""
    assets: tuple[Path, ...] = ()
    """Folder of the data set's other files (object meshes, templates); may be said repeatedly."""

    objects: Literal["free", "replayed", "none"] = "free"
    """Objects that the data set recorded: free from their first pose on, moved as recorded, or left
    out with the scene around them."""

    adapt: bool = True
    """Bring recorded hands onto the free objects that they hold; otherwise the motion stays as it
    was recorded."""
    grip: bool = True
    """Let these hands press with what the object's weight needs; otherwise they only touch."""

    def load(self, path: Path) -> Motion:
        """The motion in a file."""
        from halfphysics.formats import load_motion

        return load_motion(path, **self._said())

    def sequence(
        self,
        path: Path,
        *,
        body: Callable[[Body | None, Motion], Body] | None = None,
        settings: Settings | None = None,
        ground: bool = True,
    ) -> Sequence:
        """The motion in a file with the recorded objects and scene.

        Args:
            path: The file.
            body: Makes the body of each person of the one of the data set (None: it has none) and
                the motion; None: those of the data set. Hands are adapted to this body.
            settings: How it will be simulated, which the force of hands depends on; None: as the
                data set says.
            ground: As of `load_sequence`.
        """
        from halfphysics.formats.floor import on_floor
        from halfphysics.formats.registry import adapted, load_sequence
        from halfphysics.scene.scene import Scene
        from halfphysics.simulation.sequence import Sequence

        with one_warning(path):
            if self.objects == "none":
                found = Sequence(self.load(path), Scene())
            else:
                found = load_sequence(
                    path, objects=self.objects, adapt=False, ground=ground, **self._said()
                )
            if body is not None:
                pairs = zip(found.bodies, found.motions, strict=True)
                bodies = tuple(body(own, motion) for own, motion in pairs)
                found = replace(found, body=bodies if len(bodies) > 1 else bodies[0])
                if self.floor == "lowest":  # of these bodies
                    found = on_floor(found, self.floor, keep=(GROUND,))
            if settings is not None:
                found = replace(found, settings=settings)
            if not self.adapt or self.objects != "free" or not found.recorded:
                return found
            return adapted(found, path, grip=self.grip)

    def _said(self) -> dict[str, Any]:
        return {
            "fps": self.fps,
            "up": self.up,
            "hands": self.hands,
            "model": self.model,
            "gender": self.gender,
            "frames": self.frame_range(),
            "clip": self.clip,
            "assets": self.assets,
            "floor": self.floor,
        }

    def frame_range(self) -> tuple[int | None, int | None] | None:
        """The first frame to read and the frame after the last; raises `InputError`."""
        if self.frames is None:
            return None
        ends = self.frames.split(":")
        try:
            start, stop = (int(end) if end.strip() else None for end in ends)
        except ValueError:
            raise InputError(
                f"frames: found {self.frames!r}, expected START:STOP, such as 0:90 or 30:"
            ) from None
        return start, stop


def model_for(
    motion: Motion,
    path: str | os.PathLike[str],
    read: Callable[..., ShapeSpace] | None = None,
) -> ShapeSpace:
    """The body model for a motion: in a folder of models, the one of its model and gender.

    `read` replaces `read_model`, for example by a reader with a cache.
    """
    from halfphysics.body.model_files import read_model

    folder = file_path(path).is_dir()
    return (read or read_model)(
        path,
        gender=motion.gender if folder else None,
        model=motion.model if folder else None,
    )


def betas_for(motion: Motion, space: ShapeSpace) -> Any:
    """The motion's betas if they belong to that model, else None."""
    own = space.model == motion.model and space.gender in (motion.gender, "unknown")
    return motion.betas if own else None


def is_furnished(scene: Scene) -> bool:
    """Whether a scene has statics or objects."""
    return bool(scene.statics or scene.objects or scene.articulated)


def furnished(
    base: Scene | None,
    file: str | os.PathLike[str] | None,
    statics: Iterable[str],
    objects: Iterable[str],
    ground: bool,
    *,
    words: tuple[str, str, str] = ("--scene", "--objects none", "--no-ground"),
) -> Scene:
    """The scene of a file, else a copy of `base`, with the statics and objects added to it.

    Args:
        base: The scene of a data set; `file` replaces it if it is empty.
        file: Scene file, or None.
        statics: Static items, as `item_spec.parse_static` reads them.
        objects: Objects, as `item_spec.parse_object` reads them.
        ground: Whether a floor at z = 0 is added if the scene has no plane.
        words: The options in messages: the scene file, no recorded objects, no floor.

    Raises:
        InputError: Two scenes, or an impossible item. FileError: A file that cannot be used.
    """
    from halfphysics.geometry.shapes import Plane
    from halfphysics.scene.item_spec import parse_object, parse_static
    from halfphysics.scene.scene import Scene

    if file is not None and base is not None and is_furnished(base):
        raise InputError(
            f"{words[0]} {file}: the motion's data set brings a scene of its own. Leave out "
            f"{words[0]}, or say {words[1]}"
        )
    own = Scene() if base is None else base._copied()
    scene = own if file is None else Scene.load(file)
    for text in statics:
        name, shape, options = parse_static(text)
        scene.add_static(name, shape, **options)
    for text in objects:
        name, shape, options = parse_object(text)
        scene.add_object(name, shape, **options)
    planes = any(isinstance(static.shape, Plane) for static in scene.statics.values())
    if ground and not planes:
        if GROUND in (*scene.statics, *scene.objects):
            raise InputError(
                f"the scene has something called {GROUND!r} that is no plane, the name of the "
                f"floor that is added. Rename it, or say {words[2]}"
            )
        scene.add_static(GROUND, Plane())
    return scene
