"""An AMASS layout as a motion format: a name, the columns of `poses`, the key of the frame rate."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from halfphysics.base.npz import write_npz
from halfphysics.formats.amass import fields as amass
from halfphysics.formats.format import Format, Options, Source
from halfphysics.motion.motion import Motion

if TYPE_CHECKING:
    from halfphysics.body.body import Body


@dataclass(frozen=True, kw_only=True)
class Layout:
    """A layout that writes `poses (T, width)` and reads `width` or `also` columns."""

    name: str
    width: int
    fps_key: str
    also: tuple[int, ...] = ()
    about: str
    invents: str = ""

    def encode(self, motion: Motion) -> amass.Fields:
        """The arrays that `Motion.save` writes, by key."""
        return amass.encode(motion, self.name, self.width, self.fps_key)

    @property
    def format(self) -> Format:
        """The layout as an entry of the format registry."""
        return Format(
            name=self.name,
            about=self.about,
            invents=self.invents,
            expects=f"npz with trans (T, 3), poses (T, {self.width}), betas, gender, "
            f"{self.fps_key}",
            sniff=self._sniff,
            load=self._load,
            save=self._save,
        )

    def _sniff(self, source: Source) -> bool:
        return amass.width_of(source) in (self.width, *self.also)

    def _load(self, source: Source, options: Options) -> Motion:
        return amass.load(source, options, self.name)

    def _save(self, motion: Motion, path: Path, body: Body | None) -> None:
        write_npz(path, self.encode(motion))
