"""halfphysics convert: write a motion or a result in another format or at another frame rate."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from halfphysics.cli.options import BodyOptions, MotionOptions, check_output
from halfphysics.cli.wording import spoken
from halfphysics.errors import InputError

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion
    from halfphysics.results.result import Result

EXAMPLES = """\
halfphysics convert result.npz corrected.npz
halfphysics convert walk.npz walk60.npz --to-fps 60
halfphysics convert result.npz isaac.usd --colliders
halfphysics convert walk_smpl.npz walk_smplx.npz --format amass-smplx"""


@dataclass(frozen=True, kw_only=True)
class Command:
    """Read a motion (or the corrected motion of a result) and write it.

    Written are the keys of the file it came from, those of --format, or what the suffix of OUT
    says. What such a file cannot hold is printed.
    """

    source: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="IN")]
    """Motion or result file."""
    target: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="OUT")]
    """File to write."""
    format: str | None = None
    """Format to write, where the suffix does not say which."""
    to_fps: float | None = None
    """Frame rate to write; rotations are interpolated along the shortest arc."""
    colliders: bool = False
    """Write bodies that physics engines collide with, too (.usd): people's parts as kinematic
    hulls that follow the animation, the room, the objects."""
    person: tyro.conf.OmitArgPrefixes[BodyOptions] = field(default_factory=BodyOptions)
    motion_file: tyro.conf.OmitArgPrefixes[MotionOptions] = field(default_factory=MotionOptions)

    def run(self) -> None:
        """Read, convert and write the file."""
        from halfphysics.formats import losses, writer_of
        from halfphysics.formats.results.result_file import is_result
        from halfphysics.results.result import Result
        from halfphysics.simulation.sequence import Sequence
        from halfphysics.writers import export, is_kind

        check_output(self.target, self.source)
        scene = is_kind(self.target)
        if scene and self.format is not None:
            raise InputError(
                f"--format: {self.target.suffix} files are of one format. Leave out --format"
            )
        if self.colliders and not scene:
            raise InputError(
                f"--colliders: found {self.target}, which is a motion file. Write .usd, or leave "
                "out --colliders"
            )
        result = Result.load(self.source) if is_result(self.source) else None
        read_otherwise = self.motion_file != MotionOptions()
        if scene:
            if result is not None and read_otherwise:
                raise InputError(
                    f"{self.source}: a result is written to {self.target.suffix} files whole, as "
                    "it is. Leave out what says how to read a motion file, or write a motion first"
                )
            what = self.motion_file.sequence(self.source) if result is None else result
            motion = what.motions[0] if isinstance(what, Sequence) else what.motion
            with self._rate_said():
                body = self._body(motion, None)
                export(what, self.target, body=body, fps=self.to_fps, colliders=self.colliders)
                if self.to_fps is not None:  # what is said at the end is what was written
                    motion = motion.resample(self.to_fps)
        elif self._finishes():
            motion = _finished(self.source, self.target)
        else:
            if result is None or read_otherwise:
                motion = self.motion_file.load(self.source)
            else:
                motion = result.motion
            writer = writer_of(motion, self.target, self.format)  # before the work
            if self.to_fps is not None:
                with self._rate_said():
                    motion = motion.resample(self.to_fps)
            body = self._body(motion, result, writer.needs_body)
            motion.save(self.target, format=self.format, body=body)
            for loss in [*losses(motion, self.target, self.format, body), *_left_behind(result)]:
                print(f"not in the file: {spoken(loss)}")
        print(
            f"{len(motion)} frames at {motion.fps:g} fps, {motion.model} {motion.gender}\n"
            f"written: {self.target}"
        )

    def _finishes(self) -> bool:
        """Whether a live recording that was cut off is to become a result file."""
        from halfphysics.formats.results.unfinished import is_unfinished

        plain = self.target.suffix == ".npz" and self.format is None and self.to_fps is None
        return plain and is_unfinished(self.source)

    @contextlib.contextmanager
    def _rate_said(self) -> Iterator[None]:
        """Mistakes of the frame rate to write, which Python calls fps, as of --to-fps."""
        try:
            yield
        except InputError as error:
            if not str(error).startswith("fps:"):
                raise
            raise InputError(f"--to-{error}") from None

    def _body(self, motion: Motion, result: Result | None, needed: bool = False) -> Body | None:
        """The body of the motion if it is known; the default body if one is needed."""
        said = self.person.given
        if not said and result is not None:
            return result.people[0].body
        from halfphysics.formats.skeletons.skeleton_motion import DEFAULT_BODY

        metadata = motion.origin
        retargeted = metadata is not None and bool(metadata.fields.get(DEFAULT_BODY))
        return self.person.load(motion) if said or needed or retargeted else None


def _left_behind(result: Result | None) -> list[str]:
    """What of a result a motion file, which has one person, does not keep."""
    if result is None:
        return []
    others, objects = [person.name for person in result.people[1:]], list(result.objects)
    found = [f"the other people ({', '.join(others)})"] if others else []
    return found + ([f"the objects ({', '.join(objects)})"] if objects else [])


def _finished(source: Path, target: Path) -> Motion:
    """Write the result of a live recording that was cut off; returns its first motion."""
    from halfphysics.results.result import Result

    result = Result.load(source)
    result.save(target)
    return result.motion
