"""Support labels of a result: forces, pressure, joint torques and what nothing supplies."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.metrics.argument_checks import check_result
from halfphysics.results.result import PersonResult, Result

Fields = dict[str, NDArray[Any]]

#: Attributes of `Support` that are written under their own name, as float32.
_VALUES = (
    "force",
    "cop",
    "torque",
    "power",
    "required",
    "residual",
    "com",
    "momentum",
    "angular_momentum",
)
#: Kinds of the columns of the table of pressures; all others are float32.
_INDICES = {"frame": np.int32, "vertex": np.int32, "part": np.int8, "surface": np.int16}
_VECTORS = ("position", "normal", "force")


def support_labels(result: Result) -> Fields:
    """The arrays of a support.npz: docs/labels.md has every key.

    They are those of `PersonResult.support`, in the units there. The first person's arrays are
    under the plain keys, those of another person have "PERSON/" before the key.

    Args:
        result: The result of a simulation.

    Raises:
        InputError: No result.
        FileError: In a result from a file: a body or the scene is missing.
    """
    check_result(result)
    found: Fields = {
        "fps": np.array(result.fps),
        "people": np.array([person.name for person in result.people], dtype=str),
    }
    for index, person in enumerate(result.people):
        before = "" if index == 0 else f"{person.name}/"
        found |= {before + key: values for key, values in _of(person).items()}
    return found


def _of(person: PersonResult) -> Fields:
    support = person.support
    fields: Fields = {
        "surfaces": np.array(support.names, dtype=str),
        "mass": np.array(support.mass),
        "gravity": np.array(support.gravity),
        "airborne": support.airborne,
        "unsupported": support.unsupported,
    }
    fields |= {name: getattr(support, name).astype(np.float32) for name in _VALUES}
    pressure = support.pressure
    for name, kind in _INDICES.items():
        fields[f"pressure/{name}"] = getattr(pressure, name).astype(kind)
    for name in _VECTORS:
        fields[f"pressure/{name}"] = getattr(pressure, name).astype(np.float32)
    return fields
