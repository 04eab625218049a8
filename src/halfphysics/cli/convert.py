"""halfphysics convert: write a motion in another format or at another frame rate."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import tyro

from halfphysics.cli.options import MotionOptions, check_output
from halfphysics.errors import InputError

EXAMPLES = """\
halfphysics convert result.npz corrected.npz
halfphysics convert walk.npz walk60.npz --to-fps 60
halfphysics convert walk_smpl.npz walk_smplx.npz --format amass-smplx"""


@dataclass(frozen=True, kw_only=True)
class Command:
    """Read a motion (or the corrected motion of a result) and write it.

    Written are the keys of the file it came from, or those of --format.
    """

    source: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="IN")]
    """Motion or result file."""
    target: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="OUT")]
    """File to write (.npz)."""
    format: str | None = None
    """Format to write: amass-smplx, amass-smplh or amass-smpl."""
    to_fps: float | None = None
    """Frame rate to write; rotations are interpolated along the shortest arc."""
    motion_file: tyro.conf.OmitArgPrefixes[MotionOptions] = field(default_factory=MotionOptions)

    def run(self) -> None:
        """Convert."""
        if self.target.suffix.lower() != ".npz":
            raise InputError(
                f"{self.target}: found suffix {self.target.suffix!r}, expected .npz: all formats "
                "that can be written are npz archives"
            )
        check_output(self.target, self.source)
        motion = self.motion_file.load(self.source)
        if self.to_fps is not None:
            motion = motion.resample(self.to_fps)
        motion.save(self.target, format=self.format)
        print(f"{motion}\nwritten: {self.target}")
