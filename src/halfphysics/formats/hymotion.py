"""HY-Motion npz: AMASS's SMPL-H keys with y up, and the root's rotation twice; 30 fps.

`gender, Rh (T, 3), trans (T, 3), poses (T, 156), betas (1, 16)`. `Rh` is the rotation of the root,
which `poses` have too (zero in files of the tools from which the name comes: then `Rh` is taken).
The fingers are written out: where the model makes none, they are those of its relaxed hand. Newer
files have a frame rate. The lowest vertex of the clip is at y = 0.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from halfphysics.base.npz import write_npz
from halfphysics.errors import FileError
from halfphysics.formats.amass import fields as amass
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.format import Format, Options, Source
from halfphysics.formats.motion_builder import same_length
from halfphysics.motion.motion import Motion

if TYPE_CHECKING:
    from halfphysics.body.body import Body

NAME = "hy-motion"
FPS = 30.0
WIDTH, BETAS = 156, 16
_ROOT = "Rh"


def _sniff(source: Source) -> bool:
    npz = source.npz
    if npz is None or not {_ROOT, "poses", "trans"} <= set(npz):
        return False
    return npz.header("poses")[0][1:] == (WIDTH,)


def _load(source: Source, options: Options) -> Motion:
    if source.npz is None:
        raise FileError(f"{source.path}: not a file of HY-Motion")
    record = Record(source.path, source.npz)
    root = record.array(_ROOT, None, 3)
    poses = record.array("poses", None, WIDTH)
    same_length(record.where, {_ROOT: len(root), "poses": len(poses)})
    instead = None if poses[:, :3].any() else root
    return amass.load(source, options, NAME, up="y", fps=FPS, root=instead)


def _save(motion: Motion, path: Path, body: Body | None) -> None:
    fields = amass.encode(motion, NAME, WIDTH, "mocap_framerate")
    fields[_ROOT] = fields["poses"][:, :3]
    write_npz(path, fields)


FORMAT = Format(
    name=NAME,
    about="HY-Motion: a generator",
    invents="the frame rate (30) in older files",
    expects=f"npz with Rh (T, 3), trans (T, 3), poses (T, {WIDTH}), betas (1, {BETAS})",
    sniff=_sniff,
    load=_load,
    save=_save,
    up="y",
)
