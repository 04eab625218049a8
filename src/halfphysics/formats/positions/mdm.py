"""MDM `results.npy`: the clips of one run of a generator, as positions or as rotations.

numpy.save of a dict: `motion` (N, J, 3, T) joint positions [m], y up (J = 22 of HumanML3D at
20 fps, 21 of KIT-ML at 12.5), `lengths` (N,): only so many frames of a clip are valid, `text` [N],
`num_samples`, `num_repetitions`. Clip i is sample ``i % num_samples`` of repetition
``i // num_samples``: its name is "sample01_rep00", as that of the film beside it. Models of UESTC
and HumanAct12 write `motion` (N, 25, 6, T): see `mdm_smpl`.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from halfphysics.formats.checked_fields import Record
from halfphysics.formats.format import Format, Options, Source
from halfphysics.formats.motion_builder import own_fields
from halfphysics.formats.positions.layouts import LAYOUTS
from halfphysics.formats.positions.mdm_smpl import turned_parts
from halfphysics.formats.positions.posed import Found, as_motion, as_sequence
from halfphysics.formats.positions.written_joints import (
    lost_without_twist,
    places_of,
    write_array,
)
from halfphysics.motion.motion import Motion
from halfphysics.scene.scene import Scene
from halfphysics.simulation.sequence import Sequence

if TYPE_CHECKING:
    from halfphysics.body.body import Body

NAME = "mdm"
_KEYS = {"motion", "lengths"}


def _sniff(source: Source) -> bool:
    data = source.data
    return isinstance(data, dict) and data.keys() >= _KEYS


def _shape(record: Record) -> tuple[int, ...]:
    shape: tuple[int, ...] = record.shape("motion")
    places = len(shape) == 4 and shape[2] == 3 and shape[1] in LAYOUTS
    if not places and not (len(shape) == 4 and shape[1:3] == (25, 6)):
        raise record.error(
            "motion",
            f"found shape {shape}, expected (N, 22, 3, T) positions of HumanML3D's joints, "
            "(N, 21, 3, T) of KIT's, or (N, 25, 6, T) rotations",
        )
    return shape


def _clips(source: Source) -> list[str]:
    record = Record(source.path, source.data)
    count = _shape(record)[0]
    samples = _samples(record) if "num_samples" in record else count
    return [f"sample{i % samples:02d}_rep{i // samples:02d}" for i in range(count)]


def _samples(record: Record) -> int:
    """How many samples are in each repetition."""
    said = record.number("num_samples")
    if said < 1.0 or said % 1.0:
        raise record.error("num_samples", f"found {said:g}, expected a whole number above 0")
    return int(said)


def _clip(source: Source, options: Options) -> tuple[Record, tuple[int, ...], dict[str, Any]]:
    """One clip as (T, J, 3 or 6), cut to its length and the caller's frames, and its text."""
    whole = Record(source.path, source.data)
    index = _clips(source).index(options.clip)
    shape = _shape(whole)
    lengths = np.ravel(whole.array("lengths", shape[0]))
    length = int(lengths[index])
    if not 0 < length <= shape[3]:
        raise whole.error(
            "lengths",
            f"found {length} for clip {index}, expected 1 to {shape[3]}, the frames of 'motion'",
        )
    array = np.moveaxis(np.asarray(whole.raw("motion"))[index], -1, 0)[:length]
    where = f"{source.path}, clip {options.clip!r}"
    texts = np.ravel(np.asarray(whole.raw("text"), dtype=object)) if "text" in whole else ()
    fields = {"text": str(texts[index])} if index < len(texts) else {}
    return Record(where, {"motion": array}), shape, fields


def _found(source: Source, options: Options) -> Found | None:
    """The positions of a clip; None: the file has rotations."""
    record, shape, fields = _clip(source, options)
    if shape[2] != 3:
        return None
    positions = record.array("motion", None, shape[1], 3, frames=options.frames)
    return Found(record.where, positions, fields=fields)


def _turned(source: Source, options: Options) -> Motion:
    record, _, fields = _clip(source, options)
    parts = record.array("motion", None, 25, 6, frames=options.frames)
    return turned_parts(
        record.where, options, parts[:, :24], parts[:, 24, :3], format=NAME, fields=fields
    )


def _load(source: Source, options: Options) -> Motion:
    found = _found(source, options)
    return _turned(source, options) if found is None else as_motion(found, options, NAME)


def _load_sequence(source: Source, options: Options) -> Sequence:
    found = _found(source, options)
    if found is None:
        return Sequence(_turned(source, options), Scene())
    return as_sequence(found, options, NAME)


def _save(motion: Motion, path: Path, body: Body | None) -> None:
    places = places_of(motion, body, NAME).astype(np.float32)
    said = own_fields(motion) if motion.origin and motion.origin.format == NAME else {}
    run = {"text": [said.get("text", "")], "num_samples": 1, "num_repetitions": 1}
    moved = np.moveaxis(places, 0, -1)[None]
    write_array(path, {"motion": moved, "lengths": np.array([len(motion)]), **run})


FORMAT = Format(
    name=NAME,
    about="results.npy of MDM and what is built on it: all clips of a run",
    expects="pickled .npy with motion (N, 22, 3, T) and lengths (N,)",
    invents="turns of bones about themselves, hands, shape, frame rate (20; KIT 12.5)",
    sniff=_sniff,
    load=_load,
    load_sequence=_load_sequence,
    clips=_clips,
    save=_save,
    tells_bones=True,
    suffixes=(".npy",),
    loses=lost_without_twist,
    up="y",
)
