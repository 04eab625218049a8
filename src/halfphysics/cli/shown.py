"""The files of a command that shows: results, or any motions that the readers take."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from halfphysics.cli.options import BodyOptions, MotionOptions, refuse_options

if TYPE_CHECKING:
    from halfphysics.results.result import Result


#: Why options for motions are refused for a result.
OF_RESULT = (
    "a result has its own bodies and frames. The options for bodies and motion files are for "
    "motions; leave them out"
)


def opened(files: Sequence[Path], motion: MotionOptions, person: BodyOptions) -> list[Result]:
    """The results in files, motions as results that nothing touches.

    Args:
        files: The files.
        motion: What motion files cannot say themselves.
        person: The body of motions: their own or the default one if nothing is said.

    Raises:
        InputError: An option for motion files, and all files are results.
        FileError: A file that cannot be read.
    """
    from dataclasses import replace

    from halfphysics.formats.results.result_file import is_result
    from halfphysics.viewer.motions import open_result

    if all(map(is_result, files)):
        refuse_options(files[0], OF_RESULT, motion, person)
    own = person == BodyOptions()
    return [
        open_result(path, replace(motion, adapt=False), None if own else person.instead_of)
        for path in files
    ]
