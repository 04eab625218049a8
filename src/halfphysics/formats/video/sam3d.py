"""SAM 3D Body: people of images on another skeleton, which is recognised and not read.

`process_one_image` gives a list of dicts, one for each person, which people save as npz, pickle or
JSON: `pred_keypoints_3d` (70, 3), `pred_joint_coords` (127, 3), `pred_global_rots` (127, 3, 3),
`mhr_model_params` (204,), `pred_cam_t` (3,), ... They pose MHR, whose 127 joints have other axes
and other places than those of SMPL-X. MHR's own tools fit SMPL-X to them.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from halfphysics.errors import FileError
from halfphysics.formats.format import Source

_KEYS = {
    *("pred_joint_coords", "pred_keypoints_3d", "pred_global_rots", "mhr_model_params"),
    *("body_pose_params", "pred_pose_raw"),
}
#: Lists within lists (people within frames) that are looked into.
_DEPTH = 4


def refusal(source: Source) -> FileError | None:
    """The message for such a file; None: it is another."""
    if source.is_folder or not _is_output(_content(source), _DEPTH):
        return None
    return FileError(
        f"{source.path}: this is an output of SAM 3D Body: a pose of MHR, whose skeleton is not "
        "that of SMPL-X. Convert it with convert_sam3d_output_to_smplx of MHR's repository "
        "(tools/mhr_smpl_conversion), save the parameters it returns as .npz, and load those"
    )


def _content(source: Source) -> Any:
    for found in (source.npz, source.document, source.data):
        if found is not None:
            return found
    return None


def _is_output(content: Any, depth: int) -> bool:
    """Whether these are the fields of a person, or a list or dict that begins with such fields."""
    if isinstance(content, Mapping):
        if len(_KEYS & {key for key in content if isinstance(key, str)}) >= 2:
            return True
        return depth > 0 and any(
            _is_output(content[key], depth - 1)
            for key in list(content)[:4]
            if isinstance(content, dict)
        )
    if isinstance(content, list | tuple) and content and depth > 0:
        return any(_is_output(item, depth - 1) for item in content[:4])
    return False
