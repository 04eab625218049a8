"""EMDB: a person before a moving camera, in the world; SMPL, 30 fps.

`P0/SEQUENCE/P0_SEQUENCE_data.pkl` is a dict of `gender`, `n_frames`, `good_frames_mask (T,)`,
`camera {intrinsics, extrinsics (T, 4, 4)}` and `smpl {poses_root (T, 3), poses_body (T, 69),
trans (T, 3), betas (10,)}`. Which axis is up is not documented: it is found by how the person
stands. Frames that the mask calls bad (out of view) are kept, and counted in a warning.
"""

from __future__ import annotations

from halfphysics.base.reader_warnings import warn
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.datasets.median_shape import median_shape
from halfphysics.formats.datasets.standing_axis import standing_axis
from halfphysics.formats.format import Format, Options, Source
from halfphysics.formats.gender_names import said_gender
from halfphysics.formats.motion_builder import motion_of, rotations_of, same_length
from halfphysics.motion import skeleton
from halfphysics.motion.motion import Motion

NAME = "emdb"
FPS = 30.0
_KEYS = ("poses_root", "poses_body", "trans")
_BODY = 63  # of 69: SMPL's two rigid hands are last


def _sniff(source: Source) -> bool:
    data = source.data
    smpl = data.get("smpl") if isinstance(data, dict) else None
    return isinstance(smpl, dict) and bool({"poses_root", "poses_body"} & smpl.keys())


def _load(source: Source, options: Options) -> Motion:
    whole = Record(source.path, source.data)
    record = Record(f"{source.path}, smpl", source.data["smpl"])
    root = record.array("poses_root", None, 3, frames=options.frames)
    body = record.array("poses_body", None, 69, frames=options.frames)
    translation = record.array("trans", None, 3, frames=options.frames)
    frames = same_length(str(source.path), {key: len(record.raw(key)) for key in _KEYS})
    if "good_frames_mask" in whole:
        mask = whole.flat("good_frames_mask")
        same_length(str(source.path), {"trans": frames, "good_frames_mask": len(mask)})
        bad = int((~mask[options.frames].astype(bool)).sum())
        if bad:
            warn(
                f"{source.path}: in {bad} of {len(root)} frames nobody is in view "
                "(good_frames_mask): their poses are the data set's guess"
            )
    return motion_of(
        str(source.path),
        options,
        format=NAME,
        translation=translation,
        rotations=rotations_of({(0,): root, skeleton.BODY_JOINTS: body[:, :_BODY]}),
        fps=FPS,
        up=standing_axis(str(source.path), root, options, rule="y", others=("z", "-y"), of="EMDB"),
        model="smpl",
        gender=said_gender(whole),
        betas=median_shape(record, frames),
        hands=None,
    )


FORMAT = Format(
    name=NAME,
    about="EMDB: a person before a moving camera, in the world",
    invents="fingers, the up axis, the frame rate (30)",
    expects="pkl with smpl: a dict of poses_root (T, 3), poses_body (T, 69), trans (T, 3)",
    sniff=_sniff,
    load=_load,
)
