"""Files that are dropped onto the page of `view`: read as the command line reads them."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from halfphysics.errors import HalfPhysicsError, InputError
from halfphysics.viewer.motions import open_result

if TYPE_CHECKING:
    from halfphysics.results.result import Result

#: Largest file [bytes]; the page refuses larger ones, too.
LIMIT = 256 * 2**20


class Dropped:
    """Keeps the files until `close`: results read some of their content when it is needed."""

    def __init__(self) -> None:
        self._folder: Path | None = None
        self._count = 0

    def read(self, name: str, content: bytes) -> Result:
        """The result or motion in a file.

        Args:
            name: The name that the file had; only its last part counts.
            content: Its bytes.

        Raises:
            InputError: It is too large, or no result and no motion that the readers take; the
                message has the name.
        """
        plain = Path(name.replace("\\", "/")).name or "file"
        if len(content) > LIMIT:
            raise InputError(
                f"{plain}: {len(content) / 2**20:.0f} MB, expected up to {LIMIT / 2**20:.0f} MB. "
                "Give it to halfphysics view instead"
            )
        if self._folder is None:
            self._folder = Path(tempfile.mkdtemp(prefix="halfphysics-dropped-"))
        self._count += 1
        folder = self._folder / str(self._count)
        folder.mkdir()
        path = folder / plain
        path.write_bytes(content)
        try:
            return open_result(path)
        except HalfPhysicsError as error:
            shutil.rmtree(folder, ignore_errors=True)
            raise InputError(_shortened(str(error).replace(f"{folder}/", ""))) from None

    def close(self) -> None:
        """Remove the files."""
        if self._folder is not None:
            shutil.rmtree(self._folder, ignore_errors=True)
            self._folder = None


def _shortened(message: str) -> str:
    """A message that fits over the scene: without the list of all formats."""
    found, said, _ = message.partition(" Expected one of: ")
    return f"{found} Formats that are read: halfphysics formats" if said else message
