"""EMAGE and BEAT2 npz: AMASS's SMPL-X keys with y up and a face; 30 fps.

`betas (300,), poses (T, 165), expressions (T, 100), trans (T, 3), model "smplx2020", gender,
mocap_frame_rate`. The root's rotation is none where a person stands upright, facing z. AMASS has
the same keys and z up: `model` and `expressions` tell them apart. Nothing tells what zero fingers
mean: AMASS's are a flat hand, the `smplx` package poses the relaxed one unless told otherwise.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from halfphysics.base.npz import write_npz
from halfphysics.formats.amass import fields as amass
from halfphysics.formats.format import Format, Options, Source
from halfphysics.formats.motion_builder import lost_model, warn_of_hands
from halfphysics.motion.motion import Motion

if TYPE_CHECKING:
    from halfphysics.body.body import Body

NAME = "emage"
FPS = 30.0
WIDTH, FACE = 165, 100
_MODEL, _EXPRESSIONS = "smplx2020", "expressions"


def _sniff(source: Source) -> bool:
    npz = source.npz
    if npz is None or "poses" not in npz or npz.header("poses")[0][1:] != (WIDTH,):
        return False
    if _EXPRESSIONS in npz:
        return True
    if "model" not in npz or npz.header("model")[1].hasobject:
        return False
    said = npz["model"]
    return said.size == 1 and str(said.reshape(-1)[0]) == _MODEL


def _load(source: Source, options: Options) -> Motion:
    motion = amass.load(source, options, NAME, up="y", fps=FPS)
    warn_of_hands(str(source.path), options)
    return motion


def _save(motion: Motion, path: Path, body: Body | None) -> None:
    fields = amass.encode(motion, NAME, WIDTH, "mocap_frame_rate")
    if motion.origin is None or motion.origin.format != NAME:
        fields = {key: fields[key] for key in ("betas", "poses", "trans", "gender")} | {
            _EXPRESSIONS: np.zeros((len(motion), FACE)),
            "model": np.array(_MODEL),
            "mocap_frame_rate": fields["mocap_frame_rate"],
        }
    write_npz(path, fields)


FORMAT = Format(
    name=NAME,
    about="EMAGE and BEAT2: people who speak, of generators and their data set",
    invents="flat or relaxed hands",
    expects=f"npz with trans (T, 3), poses (T, {WIDTH}), expressions (T, {FACE}), model",
    sniff=_sniff,
    load=_load,
    save=_save,
    up="y",
    loses=lost_model,
)
