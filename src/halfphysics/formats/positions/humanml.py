"""Features of HumanML3D (T, 263) and KIT-ML (T, 251): what most generators of motion work on.

For J joints (22, 21), y up, [m]: [0] yaw velocity of the root, of half the angle; [1:3] its x, z
velocity in its own frame; [3] its height; [4 : 3J + 1] positions of joints 1 to J - 1 against
the root, in its frame but above the floor; then 6 (J - 1) rotations, 3 J velocities and 4
contacts of heels and toes, 0 to 1. With a_t the sum of [0] before frame t and
q_t = (cos a, 0, sin a, 0)::

    p_t = sum over s <= t of q_s^-1 (v_(s-1))        x and z; y is [3]
    joint = q_t^-1 (its three numbers) + (p.x, 0, p.z)

The rotations are of a skeleton that never twists, not SMPL's: positions are read and the body is
fitted to them. Generators work on normalized numbers: such a file is un-normalized with Mean.npy
and Std.npy in its folder, the two above, or `assets=`. 20 fps, KIT-ML 12.5; (N, T, 263) holds
clips.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.npy import Npy
from halfphysics.errors import FileError
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.format import Format, Options, Source
from halfphysics.formats.positions import joint_array
from halfphysics.formats.positions.bones import change, leg
from halfphysics.formats.positions.clip_array import clip_names, clip_of
from halfphysics.formats.positions.layouts import in_order
from halfphysics.formats.positions.posed import Found, loaders

Array = NDArray[np.float64]

NAME = "humanml3d"
#: Number of features -> of joints.
JOINTS = {263: 22, 251: 21}
_FIELD = "features"
#: Contacts of a network's output are near 0 and 1, bones nearly rigid; of normalized ones neither.
_CONTACTS, _RIGID = (-0.6, 1.6), 0.35
_STATISTICS = (("Mean.npy", "Std.npy"), ("mean.npy", "std.npy"))


def positions_of(features: Array) -> Array:
    """Joint positions (T, J, 3) of features (T, 263) or (T, 251)."""
    count = JOINTS[features.shape[1]]
    half = np.concatenate([[0.0], np.cumsum(features[:-1, 0])])
    back = rot.exp(np.stack([0.0 * half, -2.0 * half, 0.0 * half], axis=1))
    steps = np.zeros((len(features), 3))
    steps[1:, [0, 2]] = features[:-1, 1:3]
    root = np.cumsum(rot.rotate(back, steps), axis=0)
    joints = features[:, 4 : 4 + 3 * (count - 1)].reshape(-1, count - 1, 3)
    joints = rot.rotate(back[:, None], joints) + root[:, None] * [1.0, 0.0, 1.0]
    root[:, 1] = features[:, 3]
    return np.concatenate([root[:, None], joints], axis=1)


def _plain(features: Array) -> bool:
    """Whether these are features, not normalized ones."""
    from halfphysics.body.body import Body

    contacts = features[:, -4:]
    if np.mean((contacts < _CONTACTS[0]) | (contacts > _CONTACTS[1])) > 0.02:
        return False
    positions = positions_of(features)
    places = in_order(positions, np.asarray(Body.default().rest_joints)).all
    height = float(np.median(positions[:, 0, 1]))
    return height > 0.0 and leg(places) > 0.2 * height and change(places) < _RIGID


def _unnormalized(where: str, source: Source, options: Options, features: Array) -> Array:
    """Normalized features with the mean and the spread of a data set."""
    own = source.path.resolve().parent
    folders = [*options.assets, own, *own.parents[:2]]
    for folder in folders:
        for names in _STATISTICS:
            files = [folder / name for name in names]
            if not all(file.is_file() for file in files):
                continue
            width = features.shape[1]
            mean, spread = (
                Record(file, {"array": Npy(file).array}).array("array", width) for file in files
            )
            plain = features * spread + mean
            if not _plain(plain):
                raise FileError(
                    f"{where}: no features of HumanML3D, neither as they are nor with {files[0]} "
                    "and Std.npy. Are these the statistics that the model was trained with?"
                )
            return plain
    raise FileError(
        f"{where}: no root height, bones or foot contacts of a person: these features look "
        "normalized. Un-normalize them (x * Std + Mean), or put Mean.npy and Std.npy of the data "
        "set beside the file or in assets="
    )


def _sniff(source: Source) -> bool:
    npy = source.npy
    if npy is None or npy.dtype.kind != "f" or len(npy.shape) not in (2, 3):
        return False
    return npy.shape[-1] in JOINTS


def _clips(source: Source) -> list[str]:
    return clip_names(source, 2)


def _found(source: Source, options: Options) -> Found:
    where, array = clip_of(source, options, 2)
    # The root's way is a sum from the first frame: frames are cut after it.
    features = Record(where, {_FIELD: array}).array(_FIELD, None, array.shape[1])
    said = ""
    if not len(features):
        raise FileError(f"{where}: found no frames, expected at least 2")
    if not _plain(features):
        features = _unnormalized(where, source, options, features)
        said = "normalized features, un-normalized with Mean.npy and Std.npy"
    return Found(where, positions_of(features)[options.frames], said=said)


_load, _load_sequence = loaders(NAME, _found)

FORMAT = Format(
    name=NAME,
    about="features of HumanML3D and KIT-ML, normalized or not",
    expects=".npy of features (T, 263) of HumanML3D or (T, 251) of KIT-ML, or (N, T, 263)",
    invents="turns of bones about themselves, hands, shape, frame rate (20; KIT 12.5)",
    sniff=_sniff,
    load=_load,
    load_sequence=_load_sequence,
    clips=_clips,
    instead=joint_array.NAME,
    up="y",
)
