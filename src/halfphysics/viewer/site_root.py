"""The folder that a viser server serves: viser's page with our script, and files of data."""

from __future__ import annotations

import contextlib
import shutil
import tempfile
import threading
from collections.abc import Iterator
from functools import partial
from pathlib import Path

from halfphysics.viewer.guard import Uploads, guard
from halfphysics.viewer.player_script import served_head

_PATCHING = threading.Lock()


class SiteRoot:
    """A temporary folder with viser's page, to which our script is added.

    Attributes:
        folder: The folder, removed by `close`.
        uploads: What browsers are sending; None: no server serves the folder.
    """

    uploads: Uploads | None = None

    def __init__(self) -> None:
        import viser

        self.folder = Path(tempfile.mkdtemp(prefix="halfphysics-"))
        self._files = 0
        theirs = Path(viser.__file__).parent / "client" / "build" / "index.html"
        page = theirs.read_text(encoding="utf-8")
        page = page.replace("<title>Viser</title>", "<title>halfphysics</title>", 1)
        page = page.replace("<head>", f"<head>{served_head()}", 1)
        (self.folder / "index.html").write_text(page, encoding="utf-8")

    @contextlib.contextmanager
    def serving(self) -> Iterator[None]:
        """A viser server that is made meanwhile serves this folder.

        viser has no option for the folder: the class of its web server is replaced for the time. A
        viser that makes its web server in another way serves its own page, without our script.
        """
        import viser.infra

        with _PATCHING:
            theirs = viser.infra.WebsockServer
            ours = partial(_with_root, theirs, self)
            viser.infra.WebsockServer = ours  # type: ignore[misc, assignment]
            try:
                yield
            finally:
                viser.infra.WebsockServer = theirs  # type: ignore[misc]

    def publish(self, text: str) -> str:
        """Write a file of data under a new name, which is returned: the server keeps old ones."""
        self._files += 1
        name = f"data-{self._files}.json"
        (self.folder / name).write_text(text, encoding="utf-8")
        return name

    def close(self) -> None:
        """Remove the folder."""
        shutil.rmtree(self.folder, ignore_errors=True)


def _with_root(server: type, root: SiteRoot, host: str, *args: object, **options: object) -> object:
    made = server(host, *args, **{**options, "http_server_root": root.folder})
    root.uploads = guard(made, host)
    return made
