"""Files that are dropped onto the page of `view`: read as the command line reads them."""

from __future__ import annotations

import os
import re
import shutil
import tempfile
from pathlib import Path

from halfphysics.errors import HalfPhysicsError, InputError
from halfphysics.render.result_meshes import Drawing
from halfphysics.viewer.motions import open_result

#: Largest file [bytes]; the page refuses larger ones, too.
LIMIT = 256 * 2**20
#: Largest total of the files that are kept [bytes].
TOTAL = 2048 * 2**20
#: Letters that are kept of a name, from its end: no system's files have names of over 255 bytes.
_LETTERS = 60
#: What a file's name cannot have on some system.
_REFUSED = re.compile(r'[\x00-\x1f\x7f<>:"|?*]')


class Dropped:
    """Keeps the files until `close`: results read some of their content when it is needed."""

    def __init__(self) -> None:
        self._folder: Path | None = None
        self._count = self._bytes = 0

    def read(self, name: str, content: bytes) -> Drawing:
        """The result or motion in a file, with the meshes that it names.

        Args:
            name: The name that the file had; only its last part counts.
            content: Its bytes.

        Raises:
            InputError: It is too large, cannot be kept, or is no result and no motion that the
                readers take; the message has the name.
        """
        plain = plain_name(name)
        if len(content) > LIMIT:
            raise InputError(
                f"{plain}: {len(content) / 2**20:.0f} MB, expected up to {LIMIT / 2**20:.0f} MB. "
                "Give it to halfphysics view instead"
            )
        if self._bytes + len(content) > TOTAL:
            raise InputError(
                f"{plain}: {TOTAL // 2**20} MB of files were dropped already. Start halfphysics "
                "view again"
            )
        if self._folder is None:
            self._folder = Path(tempfile.mkdtemp(prefix="halfphysics-dropped-"))
        self._count += 1
        folder = self._folder / str(self._count)
        path = folder / plain
        try:
            folder.mkdir()
            path.write_bytes(content)
            drawing = Drawing(open_result(path))
            self._bytes += len(content)
            return drawing
        except OSError as error:
            shutil.rmtree(folder, ignore_errors=True)
            raise InputError(f"{plain}: cannot be kept: {error.strerror or error}") from None
        except HalfPhysicsError as error:
            shutil.rmtree(folder, ignore_errors=True)
            message = str(error).replace(f"{folder}{os.sep}", "")
            raise InputError(_shortened(message)) from None

    def close(self) -> None:
        """Remove the files."""
        if self._folder is not None:
            shutil.rmtree(self._folder, ignore_errors=True)
            self._folder = None


def plain_name(name: str) -> str:
    """The last part of a name that a browser sent, as a file of any system may be called."""
    last = name.replace("\\", "/").rpartition("/")[2]
    plain = _REFUSED.sub("_", last)[-_LETTERS:]
    return plain if plain.strip(". ") else "file"


def _shortened(message: str) -> str:
    """A message that fits over the scene: without the list of all formats."""
    found, said, _ = message.partition(" Expected one of: ")
    return f"{found} Formats that are read: halfphysics formats" if said else message
