"""The interface of a motion format, and the source and options that it reads with."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from collections.abc import Sequence as Listing
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from halfphysics.base import foreign_json
from halfphysics.base import stored_objects as stored
from halfphysics.base.npy import Npy
from halfphysics.base.npz import Npz
from halfphysics.base.suggestions import closest
from halfphysics.base.validation import file_path, shown
from halfphysics.errors import FileError
from halfphysics.formats.checked_fields import Record
from halfphysics.motion.motion import Motion

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.formats.people import Track
    from halfphysics.scene.scene import Scene
    from halfphysics.simulation.sequence import Sequence

_HEAD = 4096
#: Suffix of glTF in text, which is JSON.
_GLTF = ".gltf"


class Source:
    """A motion file or folder, opened as far as a sniffer needs.

    The loading functions take a `Source` in place of a path: data already read is not read again.

    Raises:
        FileError: The file does not exist, is empty or cannot be read.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = file_path(path)
        if not self.path.exists():
            near = self._near()
            raise FileError(f"{self.path}: no such file.{near}")
        #: Whether the path is a folder: some data sets are folders.
        self.is_folder = self.path.is_dir()
        #: The first 4096 bytes of a file.
        self.head = b""
        if self.is_folder:
            return
        if not self.path.is_file():
            raise FileError(
                f"{self.path}: this is a pipe or a device, expected a file. Copy what comes out of "
                "it to a file first"
            )
        try:
            with self.path.open("rb") as handle:
                self.head = handle.read(_HEAD)
        except OSError as error:
            raise FileError(f"{self.path}: cannot read: {error.strerror}") from None
        if not self.head:
            raise FileError(f"{self.path}: the file is empty, expected a motion")

    def __fspath__(self) -> str:
        return str(self.path)

    def _near(self) -> str:
        if not self.path.parent.is_dir():
            return f" The folder {self.path.parent} does not exist either"
        if not os.access(self.path.parent, os.R_OK):
            return ""
        names = [entry.name for entry in self.path.parent.iterdir() if entry.is_file()]
        near = closest(self.path.name, names, count=3)
        return f" In that folder: {', '.join(near)}" if near else ""

    @cached_property
    def npz(self) -> Npz | None:
        """The arrays of an npz file (recognized by content), else None."""
        if self.head[:2] != b"PK":
            return None
        npz = Npz(self.path)
        return npz if len(npz) else None

    @cached_property
    def npy(self) -> Npy | None:
        """Header and memory-mapped numbers of an npy file (recognized by content), else None."""
        return Npy(self.path) if self.head[:6] == b"\x93NUMPY" else None

    @cached_property
    def data(self) -> Any:
        """The content of a pickle, a joblib dump, a pickled npy or a torch file; else None.

        The restricted unpickler reads it: arrays, numbers, strings and containers only.
        """
        return stored.read(self.path) if stored.is_stored(self.path, self.head) else None

    @cached_property
    def document(self) -> Any:
        """The content of a JSON file (recognized by its first character), else None; None of glTF,
        which has a reader of its own for larger files."""
        if not foreign_json.is_json(self.head) or self.path.suffix.lower() == _GLTF:
            return None
        return foreign_json.read(self.path)

    def describe(self) -> str:
        """The content in words, for the message that no format fits."""
        if self.is_folder:
            names = sorted(entry.name for entry in self.path.iterdir())
            return f"a folder with {', '.join(names[:12]) or 'nothing in it'}"
        if self.npz is not None:
            return f"an .npz with {self.npz.describe()}"
        if self.npy is not None and not self.npy.dtype.hasobject:
            return f"an .npy of shape {self.npy.shape}, {self.npy.dtype}"
        if self.data is not None:
            if isinstance(self.data, dict):
                return f"a pickle with {Record(self.path, self.data).describe()}"
            return f"a pickle of a {type(self.data).__name__}"
        if isinstance(self.document, dict):
            return f"JSON with {Record(self.path, self.document).describe()}"
        if self.head[:2] == b"PK":
            return "a zip archive without arrays. If it holds motion files, unpack it first"
        return f"a file that begins with {shown(self.head[:24])}"


#: Folders of assets that a caller passes.
Assets: TypeAlias = str | os.PathLike[str] | Iterable[str | os.PathLike[str]] | None


@dataclass(frozen=True, kw_only=True)
class Options:
    """The options of `Motion.load` and `load_sequence`; None: the file gives the value.

    `clip` is "" for a file that holds one motion only; else the name of a clip or a person.
    `objects` is "free" (dynamic from their poses at the first frame) or "replayed" (kinematic
    along the recorded trajectory). `floor`: the height in the file that becomes z = 0 [m], or
    "lowest": that of the lowest skin.
    """

    fps: float | None = None
    up: str | None = None
    hands: str | None = None
    model: str | os.PathLike[str] | None = None
    gender: str | None = None
    frames: slice = field(default_factory=lambda: slice(None))
    clip: str = ""
    assets: tuple[Path, ...] = ()
    objects: str = "free"
    floor: float | Literal["lowest"] | None = None
    #: Metres per unit of the translations: no option of a caller, `units_check` finds it.
    unit: float = 1.0


def nothing(motion: Motion) -> tuple[str, ...]:
    """`Format.loses` of a format that holds all of a motion."""
    return ()


def alone(
    save_people: Callable[[Listing[Motion], Path, Listing[Body | None]], None],
) -> Callable[[Motion, Path, Body | None], None]:
    """`Format.save` of a format whose files hold several people: a file with one."""
    return lambda motion, path, body: save_people([motion], path, [body])


@dataclass(frozen=True, kw_only=True)
class Format:
    """One motion file format: one module of this package and one line in the registry."""

    #: Name by which `Motion.save(format=)` and the command line know it.
    name: str
    #: The content of its files, for the message that no format fits.
    expects: str
    #: What it is and where it comes from, in a few words.
    about: str = ""
    #: What its files do not say and the reader assumes or finds otherwise, in words.
    invents: str = ""
    #: Whether the content of a file is of this format. May raise FileError to explain a near
    #: miss that no other format could claim either. None: the sniff of another format finds them.
    sniff: Callable[[Source], bool] | None
    load: Callable[[Source, Options], Motion]
    #: Motion and scene if the data set has objects; None: the motion with an empty scene.
    load_sequence: Callable[[Source, Options], Sequence] | None = None
    #: The clip names in a file with several clips; `load` reads the clip `Options.clip`.
    clips: Callable[[Source], Iterable[str]] | None = None
    #: The people of a file that tracks several; `load` reads the one whom `Options.clip` names, and
    #: `Options.frames` count from that person's first frame. None: one person, or `load_sequence`
    #: knows of the others.
    people: Callable[[Source], Listing[Track]] | None = None
    #: One of these people with the body that they have in the file, for `load_sequence`; None:
    #: `load`, and the default body.
    load_person: Callable[[Source, Options], tuple[Motion, Body]] | None = None
    #: What stands around these people; None: nothing is known of it.
    scene: Callable[[Source, Options], Scene] | None = None
    #: Writes a motion in the axes of its file or of `up`; None: the format is read-only.
    save: Callable[[Motion, Path, Body | None], None] | None = None
    #: Writes people who were read from one file into one; None: a file holds one person.
    save_people: Callable[[Listing[Motion], Path, Listing[Body | None]], None] | None = None
    #: Name of the format that is written instead of this one, which is read-only.
    instead: str = ""
    #: Suffixes of the files written, the preferred one first.
    suffixes: tuple[str, ...] = (".npz",)
    #: The up axis of the files written; None: the file states its up axis.
    up: str | None = "z"
    #: Whether its files hold the joints of a body, so that `save` needs one.
    needs_body: bool = False
    #: Whether its files tell the bones of the person: of others only the motion comes back.
    tells_bones: bool = False
    #: The parts of a motion that a file of this format cannot hold, one line each.
    loses: Callable[[Motion], tuple[str, ...]] = nothing
