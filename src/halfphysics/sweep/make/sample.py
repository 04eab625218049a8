"""A sample: the files of a simulation in a data set, named as in InterAct and GRAB.

The first person and the first object have no number, others are ``human.1.npz``, ``object.1.npz``
and so on, in the order of `Result.people` and `Result.objects`. docs/sweeps.md lists the content
of each file. All values are in one world frame, z-up, in metres, radians, newtons and seconds.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.json_files import text_of
from halfphysics.base.npz_bytes import npz_bytes
from halfphysics.motion.skeleton import SMPLH_JOINTS

if TYPE_CHECKING:
    from halfphysics.results.result import PersonResult, Result

Fields = dict[str, NDArray[Any]]
_JAW, _EYES = 22, (23, 24)


class Labels(Protocol):
    """The part of `labels.ContactLabels` that a sample needs."""

    def arrays(self) -> Mapping[str, NDArray[Any]]:
        """The arrays of ``contact.npz``."""


def files_of(
    result: Result,
    labels: Labels,
    card: Mapping[str, Any],
    *,
    whole: bool = False,
    support: bool = False,
) -> dict[str, bytes]:
    """The files of a sample by name; the same values give the same bytes.

    Motions are float64: float32 has a resolution of only 0.5 micrometres at ten metres, and a
    simulation from a rounded motion would not repeat bit by bit.

    Args:
        result: Result of the simulation.
        labels: Its contact labels.
        card: The card of the sample, JSON values.
        whole: Also write ``result.npz``, the result file (`Result.save`).
        support: Also write ``support.npz``, the arrays of `labels.support_labels`.
    """
    files = {"card.json": text_of(card).encode() + b"\n"}
    for index, person in enumerate(result.people):
        files[_numbered("human", index)] = npz_bytes(human(person))
    for index, name in enumerate(result.objects):
        files[_numbered("object", index)] = npz_bytes(item(result, name))
    files["contact.npz"] = npz_bytes(labels.arrays())
    if support:
        from halfphysics.labels.support_labels import support_labels

        files["support.npz"] = npz_bytes(support_labels(result))
    if whole:
        from halfphysics.formats.results.result_writer import result_fields

        files["result.npz"] = npz_bytes(result_fields(result))
    return files


def _numbered(name: str, index: int) -> str:
    return f"{name}.npz" if index == 0 else f"{name}.{index}.npz"


def human(person: PersonResult) -> Fields:
    """The arrays of ``human.npz``: the corrected motion, with the simulated shape.

    ``poses`` (T, 156) is root, body, left hand, right hand, as in all of InterAct and in AMASS's
    SMPL-H files; hand poses are relative to the flat hand. ``pose_jaw`` (T, 3) and ``pose_eye``
    (T, 6) are separate. The pelvis is at the model's rest pelvis, for these betas, plus
    ``trans`` (T, 3).
    """
    body, motion = person.body, person.motion.rebased(person.body)
    gender = motion.gender if body.gender == "unknown" else body.gender
    frames, turned = len(motion), motion.rotations
    return {
        "poses": turned[:, list(SMPLH_JOINTS)].reshape(frames, -1),
        "betas": body.betas,
        "trans": motion.translation,
        "gender": np.array(gender),
        "pose_jaw": turned[:, _JAW],
        "pose_eye": turned[:, list(_EYES)].reshape(frames, -1),
        "fps": np.array(motion.fps),
        "surface_model_type": np.array(motion.model),
        "body_model": np.array(body.model),
    }


def item(result: Result, name: str) -> Fields:
    """The arrays of ``object.npz``: ``angles`` (T, 3) axis-angle, ``trans`` (T, 3), ``name``.

    A link of an articulated object also has ``arti``, the values of all joints of the object with
    one degree of freedom [rad or m]: (T,) for one joint, (T, n) for several, with their names in
    ``joints``.
    """
    track = result.objects[name]
    fields = {
        "angles": rot.log(track.quaternion),
        "trans": track.position,
        "name": np.array(name),
    }
    owner = name.rpartition("/")[0]
    values = {
        key: value
        for key, value in result.joints.items()
        if owner and key.rpartition("/")[0] == owner and value.ndim == 1
    }
    if values:
        columns = np.stack(list(values.values()), axis=1)
        fields["arti"] = columns[:, 0] if len(values) == 1 else columns
        fields["joints"] = np.array(list(values))
    return fields
