"""halfphysics inspect: what a motion file is, how it was read, and three of its poses."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import tyro

from halfphysics.cli.options import BodyOptions, MotionOptions, refuse_options
from halfphysics.cli.shown import OF_RESULT
from halfphysics.cli.wording import spoken
from halfphysics.errors import HalfPhysicsWarning, InputError
from halfphysics.motion import skeleton

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion
    from halfphysics.simulation.sequence import Sequence

EXAMPLES = """\
halfphysics inspect clip.npz
halfphysics inspect hmr4d_results.pt --picture look.png
halfphysics inspect sub3_largebox.p --clip sub3_largebox_003 --assets captured_objects"""

# What of a person may move in a file.
_GROUPS = {
    "body": list(skeleton.BODY_JOINTS),
    "left fingers": list(skeleton.LEFT_HAND_JOINTS),
    "right fingers": list(skeleton.RIGHT_HAND_JOINTS),
    "jaw and eyes": list(skeleton.FACE_JOINTS),
}
# Names of clips or people that are printed.
_NAMED = 12
# Turns below this are the rounding of a file [rad].
_STILL = 1e-5


@dataclass(frozen=True, kw_only=True)
class Command:
    """Say what a motion file is and how it was read, and draw its first, middle and last pose.

    What was assumed (axes, rate, floor, hands) is said as anywhere else; a file that was read the
    wrong way up, mirrored or a hundred times too large is seen at once.
    """

    file: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="FILE")]
    """Motion file, result file, or folder of a data set."""
    picture: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """Also draw the three poses with the skin, as a picture (.png); of a result, key frames."""
    person: tyro.conf.OmitArgPrefixes[BodyOptions] = field(default_factory=BodyOptions)
    motion_file: tyro.conf.OmitArgPrefixes[MotionOptions] = field(default_factory=MotionOptions)

    def run(self) -> None:
        """Print and draw."""
        from halfphysics.cli.options import check_output
        from halfphysics.formats.results.result_file import is_result

        if self.picture is not None:
            check_output(self.picture, self.file)
            if self.picture.suffix.lower() != ".png":
                raise InputError(
                    f"--picture: found {self.picture}, expected a name that ends in .png"
                )
        if is_result(self.file):
            self._result()
            return
        self._identity()
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", HalfPhysicsWarning)
            sequence = self.motion_file.sequence(self.file, ground=False)
        for line in _said(caught, self.file):
            print(f"read with: {spoken(line)}")
        bodies = [
            self.person.instead_of(body, motion)
            for body, motion in zip(sequence.bodies, sequence.motions, strict=True)
        ]
        for number, (motion, body) in enumerate(zip(sequence.motions, bodies, strict=True)):
            if len(bodies) > 1:
                print(f"person {number + 1}")
            _describe(motion, body)
        _describe_scene(sequence)
        if self.picture is not None:
            self._draw(sequence, bodies, self.picture)

    def _identity(self) -> None:
        """The format, and what else is in the file."""
        from halfphysics.formats.format import Source
        from halfphysics.formats.registry import identify, unknown

        source = Source(self.file)
        format = identify(source)
        if format is None:
            raise unknown(source)
        about = f", {format.about}" if format.about else ""
        print(f"{self.file}: {format.name}{about}")
        if source.npz is not None or source.npy is not None or source.is_folder:
            print(f"found: {source.describe()}")
        for names, one, several in (
            (() if format.clips is None else list(format.clips(source)), "clip", "clips"),
            ([t.name for t in format.people(source)] if format.people else (), "person", "people"),
        ):
            if names:
                more = ", ..." if len(names) > _NAMED else ""
                what = one if len(names) == 1 else several
                print(f"{len(names)} {what}: {', '.join(names[:_NAMED])}{more}")

    def _result(self) -> None:
        from halfphysics.results.result import Result

        refuse_options(self.file, OF_RESULT, self.motion_file, self.person)
        result = Result.load(self.file)
        print(f"{self.file}: a result of halfphysics simulate")
        print(result.summary())
        for person in result.people:
            print(f"{person.name}:")
            _describe(person.motion, person.body)
        if self.picture is not None:
            from halfphysics.render.contact_sheet import save_contact_sheet

            save_contact_sheet(result, self.picture)
            print(f"picture: {self.picture}")

    def _draw(self, sequence: Sequence, bodies: list[Body], picture: Path) -> None:
        from halfphysics.baselines import Kinematic
        from halfphysics.render.contact_sheet import save_contact_sheet
        from halfphysics.scene.scene import Scene
        from halfphysics.simulation.simulate import simulate

        result = simulate(
            list(sequence.motions), Scene(), body=bodies, settings=Kinematic(substeps=1)
        )
        frames = _three(len(result))
        save_contact_sheet(result, picture, frames=frames, columns=len(frames))
        print(f"picture: {picture}")


def _said(caught: list[warnings.WarningMessage], path: Path) -> list[str]:
    """The statements of the warnings, without the file's name."""
    found: list[str] = []
    for warning in caught:
        text = str(warning.message).removeprefix(f"{path}: ")
        found += text.split("; ")
    return found


def _three(frames: int) -> list[int]:
    return sorted({0, frames // 2, frames - 1})


def _describe(motion: Motion, body: Body) -> None:
    from halfphysics.cli.stick_figure import stick_figures

    seconds = (len(motion) - 1) / motion.fps
    shape = "no shape" if motion.betas is None else f"{np.size(motion.betas)} betas"
    print(
        f"{len(motion)} frames at {motion.fps:g} fps ({seconds:.2f} s), {motion.model}, "
        f"{motion.gender}, {shape}; body of {body.stature:.2f} m"
    )
    moves = [
        name
        for name, joints in _GROUPS.items()
        if np.ptp(motion.rotations[:, joints], 0).max() > _STILL
    ]
    print(f"moves: {', '.join(moves) or 'nothing'}")
    joints = body.joints(motion)
    low, high = joints[..., 2].min(), joints[..., 2].max()
    way = np.linalg.norm(np.diff(joints[:, 0, :2], axis=0), axis=1).sum()
    print(f"joints from {low:.2f} to {high:.2f} m above z = 0; the pelvis goes {way:.2f} m")
    frames = _three(len(motion))
    for line in stick_figures(
        [joints[frame] for frame in frames],
        captions=[f"{frame / motion.fps:.2f} s" for frame in frames],
    ):
        print(line)


def _describe_scene(sequence: Sequence) -> None:
    scene = sequence.scene
    for what, names in (
        ("objects", [*scene.objects, *scene.articulated]),
        ("static", list(scene.statics)),
    ):
        if names:
            print(f"{what}: {', '.join(names)}")
