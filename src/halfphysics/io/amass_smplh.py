"""AMASS npz, SMPL-H layout: `poses (T, 156)` = root, body 21, left hand 15, right hand 15."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from halfphysics.io import amass
from halfphysics.io.formats import Format, Options, Source
from halfphysics.io.npz import write_npz
from halfphysics.motion import Motion

if TYPE_CHECKING:
    from halfphysics.body import Body

NAME = "amass-smplh"
WIDTH = 156
FPS_KEY = "mocap_framerate"


def _sniff(source: Source) -> bool:
    return amass.width_of(source) == WIDTH


def _load(source: Source, options: Options) -> Motion:
    return amass.load(source, options, NAME)


def encode(motion: Motion) -> amass.Fields:
    """The arrays that `Motion.save` writes, by key."""
    return amass.encode(motion, NAME, WIDTH, FPS_KEY)


def _save(motion: Motion, path: Path, body: Body | None) -> None:
    write_npz(path, encode(motion))


FORMAT = Format(
    name=NAME,
    expects=f"npz with trans (T, 3), poses (T, {WIDTH}), betas, gender, {FPS_KEY}",
    sniff=_sniff,
    load=_load,
    save=_save,
)
