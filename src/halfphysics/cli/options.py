"""Options that several commands share, and what they stand for."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from halfphysics.errors import FileError, InputError
from halfphysics.io.asked import betas_for, furnished, model_for
from halfphysics.validation import file_path

if TYPE_CHECKING:
    from halfphysics.body import Body
    from halfphysics.motion import Motion
    from halfphysics.scene import Scene
    from halfphysics.sequence import Sequence

#: A file that may be left out, and things that are said once each.
File = Annotated[Path | None, tyro.conf.arg(metavar="FILE")]
Things = Annotated[
    tuple[str, ...], tyro.conf.UseAppendAction, tyro.conf.arg(metavar="NAME=SHAPE,...")
]


def progress() -> bool:
    """Whether to show progress bars: only to a person at a terminal."""
    return sys.stderr.isatty()


@dataclass(frozen=True, kw_only=True)
class MotionOptions:
    """What a motion file cannot say itself."""

    fps: float | None = None
    """Frames per second of the motion file, where it does not say."""
    up: Literal["y", "z"] | None = None
    """The axis that is up in the motion file, where it is not what its format prescribes."""
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
    assets: Annotated[tuple[Path, ...], tyro.conf.UseAppendAction] = ()
    """Folder of the data set's other files (object meshes, templates); may be said repeatedly."""

    objects: Literal["free", "replayed", "none"] = "free"
    """Objects that the data set recorded: free from their first pose on, moved as recorded, or left
    out with the scene around them."""

    def load(self, path: Path) -> Motion:
        """The motion in a file."""
        from halfphysics.io import load_motion

        return load_motion(path, **self._said())

    def sequence(self, path: Path) -> Sequence:
        """The motion in a file with the objects and the scene that were recorded around it."""
        from halfphysics.io import load_sequence
        from halfphysics.scene import Scene
        from halfphysics.sequence import Sequence

        if self.objects == "none":
            return Sequence(self.load(path), Scene())
        return load_sequence(path, objects=self.objects, **self._said())

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
        }

    def frame_range(self) -> tuple[int | None, int | None] | None:
        """The first frame to read and the one after the last; raises `InputError`."""
        if self.frames is None:
            return None
        ends = self.frames.split(":")
        try:
            start, stop = (int(end) if end.strip() else None for end in ends)
        except ValueError:
            raise InputError(
                f"--frames: found {self.frames!r}, expected START:STOP, such as 0:90 or 30:"
            ) from None
        return start, stop


@dataclass(frozen=True, kw_only=True)
class BodyOptions:
    """Whose body."""

    body: File = None
    """Body model: an SMPL-X, SMPL-H or SMPL file, or a folder of them; the default body if not
    given."""
    stature: float | None = None
    """Height of the default body [m]."""
    allow_mismatch: bool = False
    """Take a body of another gender or model than the motion's, with its mean shape."""

    @property
    def given(self) -> bool:
        """Whether any body was asked for."""
        return self.body is not None or self.stature is not None

    def load(self, motion: Motion) -> Body:
        """The body for a motion: with its betas, where they are that model's."""
        from halfphysics.body import Body

        if self.body is None:
            return Body.default(stature=self.stature)
        if self.stature is not None:
            raise InputError(
                "--stature is for the default body; the shape of a model comes from the motion's "
                "betas. Leave out --stature or --body"
            )
        space = model_for(motion, self.body)
        return Body.shaped(space, betas_for(motion, space))


@dataclass(frozen=True, kw_only=True)
class SceneOptions:
    """What stands and lies around."""

    scene: File = None
    """Scene file (.yaml or .json)."""
    static: Things = ()
    """Something that never moves, such as wall=box:0.1:2:2.5,at=1:0:1.25 or room=room.glb.
    Shapes: plane, sphere:R, box:X:Y:Z, capsule:R:L, cylinder:R:L or a mesh file; keys: at, quat,
    friction, restitution, scale, up."""
    object: Things = ()
    """Something that moves, such as ball=sphere:0.11,mass=0.43,at=1:0:0.11; also the keys mass
    or density, velocity, and for meshes pieces (auto, hull), threshold and max_pieces."""
    ground: bool = True
    """A floor at z = 0, where the scene brings no plane of its own."""

    def load(self, base: Scene | None = None) -> Scene:
        """The scene described: added to `base`, which a file takes the place of."""
        return furnished(base, self.scene, self.static, self.object, self.ground)

    @property
    def given(self) -> bool:
        """Whether any of it was said."""
        return self.scene is not None or bool(self.static) or bool(self.object)


def check_output(path: Path, *inputs: Path | None) -> None:
    """Refuse, before the work, a file that could not be written after it.

    Raises:
        FileError: No such folder, a folder, or one of the inputs.
    """
    path = file_path(path)
    if path.is_dir():
        raise FileError(f"{path}: cannot write, this is a folder. Give a file name")
    if not path.parent.is_dir():
        raise FileError(
            f"{path}: cannot write, the folder {path.parent} does not exist. Create it first"
        )
    for given in inputs:
        if (
            given is not None
            and file_path(given).exists()
            and path.exists()
            and path.samefile(given)
        ):
            raise FileError(f"{path}: this is the input. Give another name for the output")
