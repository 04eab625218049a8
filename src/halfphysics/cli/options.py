"""Options that several commands share, and the objects they describe."""

from __future__ import annotations

import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from halfphysics.base.atomic import linked, reason
from halfphysics.base.validation import file_path
from halfphysics.baselines.options import Mode, with_options
from halfphysics.cli.loudness import is_quiet
from halfphysics.errors import FileError, InputError
from halfphysics.formats import loading
from halfphysics.formats.loading import betas_for, furnished, model_for

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion
    from halfphysics.scene.scene import Scene
    from halfphysics.settings import Settings

#: Types of an optional file and of options that are repeated, one value each.
File = Annotated[Path | None, tyro.conf.arg(metavar="FILE")]
Things = Annotated[
    tuple[str, ...], tyro.conf.UseAppendAction, tyro.conf.arg(metavar="NAME=SHAPE,...")
]


#: What an output folder must have room for [bytes]: the smallest results.
_ROOM = 2**20


def progress() -> bool:
    """Whether to show progress bars: only at a terminal, and not with --quiet."""
    return sys.stderr is not None and sys.stderr.isatty() and not is_quiet()


@dataclass(frozen=True, kw_only=True)
class MotionOptions(loading.MotionOptions):
    """What a motion file cannot say itself."""

    model: Annotated[str | None, tyro.conf.arg(metavar="smplx|smplh|smpl|FILE")] = None
    """Body model of the motion file, where it does not say; or a model file (for mean hands)."""
    frames: Annotated[str | None, tyro.conf.arg(metavar="START:STOP")] = None
    """Frames to read, counted from 0, STOP left out; either may be missing."""
    assets: Annotated[
        tuple[Path, ...], tyro.conf.UseAppendAction, tyro.conf.arg(metavar="FOLDER")
    ] = ()
    """Folder of the data set's other files (object meshes, templates)."""


@dataclass(frozen=True, kw_only=True)
class BodyOptions:
    """Which body the person has."""

    body: File = None
    """Body model: an SMPL-X, SMPL-H or SMPL file, or a folder of them; the default body if not
    given."""
    stature: float | None = None
    """Height of the default body [m]."""
    mass: float | None = None
    """Mass of the person [kg]; by the body's volume if not given."""
    allow_mismatch: bool = False
    """Take a body of another gender or model than the motion's, with its mean shape."""

    @property
    def given(self) -> bool:
        """Whether another body than the motion's own is asked for."""
        return self.body is not None or self.stature is not None

    def instead_of(self, own: Body | None, motion: Motion) -> Body:
        """The body asked for, or else the motion's own, with the mass asked for."""
        return self.load(motion) if own is None or self.given else own.weighing(self.mass)

    def load(self, motion: Motion) -> Body:
        """The body for a motion, with the motion's betas if they fit the model."""
        from halfphysics.body.body import Body

        if self.body is None:
            return Body.default(stature=self.stature, mass=self.mass)
        if self.stature is not None:
            raise InputError(
                "--stature is for the default body; the shape of a model comes from the motion's "
                "betas. Leave out --stature or --body"
            )
        space = model_for(motion, self.body)
        return Body.shaped(space, betas_for(motion, space)).weighing(self.mass)


@dataclass(frozen=True, kw_only=True)
class SceneOptions:
    """Static geometry and objects."""

    scene: File = None
    """Scene file (.yaml or .json)."""
    static: Things = ()
    """Static geometry, such as wall=box:0.1:2:2.5,position=1:0:1.25 or room=room.glb. Shapes:
    plane, sphere:R, box:X:Y:Z, capsule:R:L, cylinder:R:L [m] or a mesh file; keys: position,
    quaternion, friction, restitution, soft (sofa, mattress, pillow, mat), and of meshes scale and
    up."""
    object: Things = ()
    """An object that moves, such as ball=sphere:0.11,mass=0.43,position=1:0:0.11; keys as of
    --static, mass or density, velocity, and of meshes pieces (auto, hull), threshold and
    max_pieces."""
    ground: bool = True
    """A floor at z = 0, where the scene brings no plane of its own."""

    def load(self, base: Scene | None = None) -> Scene:
        """The scene of the options, added to `base`; a scene file replaces `base`."""
        return furnished(base, self.scene, self.static, self.object, self.ground)

    @property
    def given(self) -> bool:
        """Whether any of these options was given."""
        return self.scene is not None or bool(self.static) or bool(self.object)


@dataclass(frozen=True, kw_only=True)
class BaselineOptions:
    """What moves the body, to compare with: docs/physics.md, "Baselines"."""

    mode: Mode = "velocity"
    """How the motion moves the body: by velocity (half-physics), or as one of the baselines."""
    internal_forces: bool = False
    """Coriolis, centrifugal and gyroscopic forces act on the person (velocity and torque)."""
    joint_damping: float = 0.0
    """Viscous damping of the person's joints [N m s/rad] (velocity and torque)."""
    torque_frequency: float = 100.0
    """With --mode torque: natural frequency of the joints' PD control [rad/s]."""
    torque_damping: float = 1.0
    """With --mode torque: damping ratio of the joints' PD control."""

    def applied(self, settings: Settings) -> Settings:
        """Settings with these options."""
        chosen = vars(self)
        return settings if self == BaselineOptions() else with_options(settings, chosen)


def refuse_options(what: object, why: str, *options: object) -> None:
    """Refuse options that would have no effect.

    Args:
        what: What they were given for.
        why: What it has of its own, what the options are for, and the way out.
        options: Groups of options, which may say nothing.

    Raises:
        InputError: One of the groups says something.
    """
    if any(group != type(group)() for group in options):
        raise InputError(f"{what}: {why}")


def check_output(path: Path, *inputs: Path | None) -> None:
    """Refuse, before the work, an output file that cannot be written.

    Raises:
        FileError: The folder does not exist, cannot be written or is full, or the path is a folder,
            a device or an input file.
    """
    path = linked(file_path(path))
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
    if path.exists() and not path.is_file():
        raise FileError(f"{path}: cannot write, this is a pipe or a device. Give a file name")
    check_room(path.parent, path)


def check_room(folder: Path, path: Path) -> None:
    """Refuse a folder in which no file can be made, by making one of a megabyte.

    Raises:
        FileError: It may not be written, or is full; the message begins with `path`.
    """
    try:
        with tempfile.TemporaryFile(dir=folder) as probe:
            probe.write(bytes(_ROOM))
            probe.flush()
    except OSError as error:
        raise FileError(f"{path}: cannot write in {folder}: {reason(error)}") from None
