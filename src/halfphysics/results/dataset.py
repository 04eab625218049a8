"""A result as a labelled dataset of xarray: every array with named axes and units.

Dimensions: time, person, joint, object, contact, inside, breach, pressed (samples under pressure,
where something is soft), and of vectors xyz, of quaternions
wxyz; substep where they were recorded, vertex where it is asked for. Rotations are axis-angle [rad]
as in `Motion.rotations`. Numbers are those of the result, indices are names; what motions
say of holds and stiffness is not in it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.optional_package import optional
from halfphysics.errors import InputError
from halfphysics.motion.skeleton import JOINT_NAMES, N_JOINTS
from halfphysics.results.naming import JOINT_COLUMNS, NAME_COLUMNS, Naming

if TYPE_CHECKING:
    from halfphysics.motion.motion import Motion
    from halfphysics.results.result import ObjectTrack, Result
    from halfphysics.results.table import Table

Array = NDArray[np.float64]
#: Name -> dimensions, values, attributes: as xarray takes variables.
Variables = dict[str, tuple[tuple[str, ...], Any, dict[str, str]]]

#: Joined to the dataset as its description.
_CONVENTIONS = (
    "world z-up; metres, kilograms, seconds; quaternions wxyz; rotations axis-angle in the frame "
    "of the parent joint, the pelvis in the world"
)


def to_dataset(result: Result, *, joints: bool, vertices: bool) -> Any:
    """The work behind `Result.to_xarray`."""
    xarray = optional("xarray", "datasets", "frames")
    data: Variables = {
        "clearance": (
            ("time",),
            result.clearance,
            _unit("m", "minimum distance to static geometry"),
        ),
        "lost_time": (("time",), result.lost_time, _unit("s", "time by which steps were cut")),
    }
    data |= _people(result)
    data |= _objects(result.objects, "", "time")
    data |= {f"diagnostic_{n}": (("time",), v, {}) for n, v in result.diagnostics.items()}
    data |= _articulations(result.joints)
    naming = Naming(result.names, len(result.people), result.fps)
    tables = {"contact": result.contacts, "inside": result.inside, "breach": result.breaches}
    for dimension, table in tables.items():
        data |= _rows(table, naming, dimension)
    if result.soft_contacts is not None:
        data |= _rows(result.soft_contacts, naming, "pressed")
    if result.substeps is not None:
        data |= _motions(result.substeps.motions, "substep_", "substep")
        data |= _objects(result.substeps.objects, "substep_", "substep")
    if joints:
        data["joint_position"] = _skeletons(result)
    if vertices:
        data["vertex_position"] = _skins(result)
    return xarray.Dataset(data, coords=_coordinates(result), attrs=_attributes(result))


def _unit(unit: str, meaning: str = "") -> dict[str, str]:
    found = {"units": unit, "long_name": meaning}
    return {key: value for key, value in found.items() if value}


def _coordinates(result: Result) -> dict[str, Any]:
    found: dict[str, Any] = {
        "time": ("time", np.arange(len(result)) / result.fps, _unit("s")),
        "person": [person.name for person in result.people],
        "joint": list(JOINT_NAMES),
        "xyz": list("xyz"),
        "wxyz": list("wxyz"),
    }
    if result.objects:
        found["object"] = list(result.objects)
    if result.substeps is not None:
        poses = result.substeps.motions[0]
        found["substep"] = ("substep", np.arange(len(poses)) / poses.fps, _unit("s"))
    return found


def _attributes(result: Result) -> dict[str, Any]:
    """Of the whole; lists are text, since netCDF 3 (`to_netcdf` with scipy) has none of text."""
    return {
        "description": _CONVENTIONS,
        "fps": result.fps,
        "names": ", ".join(result.names),
        "settings": repr(result.settings),
        "gender": ", ".join(person.motion.gender for person in result.people),
        "model": ", ".join(person.motion.model for person in result.people),
    }


def _people(result: Result) -> Variables:
    """Motions of the people, and what was found of them."""
    people = result.people
    found = _motions([p.motion for p in people], "", "time")
    found |= _motions([p.reference for p in people], "reference_", "time")
    if any(p.recorded is not p.reference for p in people):
        found |= _motions([p.recorded for p in people], "recorded_", "time")
    per_frame = ("person", "time")
    found["clock"] = (
        per_frame,
        np.stack([np.asarray(p.clock) for p in people]),
        _unit("s", "time of reference"),
    )
    found["corrected"] = per_frame, np.stack([np.asarray(p.corrected) for p in people]), {}
    unknown = np.full((len(result), N_JOINTS, 3), np.nan)
    torques = [unknown if p.torque is None else p.torque for p in people]
    if any(p.torque is not None for p in people):
        found["torque"] = (*per_frame, "joint", "xyz"), np.stack(torques), _unit("N m")
    if any(p.motion.betas is not None for p in people):
        found["betas"] = ("person", "shape"), _padded([p.motion.betas for p in people]), {}
    return found


def _motions(motions: Sequence[Motion], prefix: str, time: str) -> Variables:
    axes = ("person", time)
    places, turns = [m.translation for m in motions], [m.rotations for m in motions]
    return {
        f"{prefix}translation": ((*axes, "xyz"), np.stack(places), _unit("m")),
        f"{prefix}rotation": ((*axes, "joint", "xyz"), np.stack(turns), _unit("rad")),
    }


def _padded(rows: Sequence[Array | None]) -> Array:
    """Rows of different lengths, nan where they have none."""
    out = np.full((len(rows), max(len(row) for row in rows if row is not None)), np.nan)
    for k, row in enumerate(rows):
        if row is not None:
            out[k, : len(row)] = row
    return out


def _objects(tracks: Mapping[str, ObjectTrack], prefix: str, time: str) -> Variables:
    if not tracks:
        return {}
    places = np.stack([track.position for track in tracks.values()])
    turns = np.stack([track.quaternion for track in tracks.values()])
    return {
        f"{prefix}object_position": (("object", time, "xyz"), places, _unit("m")),
        f"{prefix}object_quaternion": (("object", time, "wxyz"), turns, {}),
    }


def _articulations(joints: Mapping[str, Array]) -> Variables:
    """Values of joints of articulated objects; of a free joint its position and quaternion."""
    found: Variables = {}
    for name, values in joints.items():
        key = f"articulation_{name.replace('/', '.')}"
        if values.ndim == 2 and values.shape[1] == 7:
            found[f"{key}_position"] = ("time", "xyz"), values[:, :3], _unit("m")
            found[f"{key}_quaternion"] = ("time", "wxyz"), values[:, 3:], {}
        else:
            found[key] = ("time", "wxyz")[: values.ndim], values, {}
    return found


def _rows(table: Table, naming: Naming, dimension: str) -> Variables:
    """The columns of a table; indices of names as the names, "" for none."""
    found: Variables = {}
    names = {
        "person": naming.persons,
        **dict.fromkeys(JOINT_COLUMNS, JOINT_NAMES),
        **dict.fromkeys(NAME_COLUMNS, naming.names),
    }
    for column in table.columns():
        values = getattr(table, column)
        axes = (dimension, "xyz")[: values.ndim]
        if column in names:  # -1 is the last entry
            values = np.array([*names[column], ""])[values]
        found[f"{dimension}_{column}"] = axes, values, _unit(table.UNITS.get(column, ""))
    frame = getattr(table, "frame")  # noqa: B009  # tables of a result have frames
    found[f"{dimension}_time"] = (dimension,), frame / naming.fps, _unit("s")
    return found


def _skeletons(result: Result) -> tuple[tuple[str, ...], Array, dict[str, str]]:
    joints = np.stack([person.body.joints(person.motion) for person in result.people])
    return ("person", "time", "joint", "xyz"), joints, _unit("m", "joints in the world")


def _skins(result: Result) -> tuple[tuple[str, ...], Array, dict[str, str]]:
    counts = {person.name: len(person.body.rest_vertices) for person in result.people}
    if len(set(counts.values())) > 1:
        raise InputError(
            f"to_xarray: people have skins of different sizes ({counts}), expected one; leave out "
            "vertices=True and use body.vertices(motion) of each"
        )
    skins = np.stack([person.body.vertices(person.motion) for person in result.people])
    return ("person", "time", "vertex", "xyz"), skins, _unit("m", "skin in the world")
